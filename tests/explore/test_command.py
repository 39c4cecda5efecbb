"""The command: where the page is, why it is not, and how it ends."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from tests.explore.made_up import BRACH
from tests.explore.test_page import BROWSER, SPEED

RETRODICT = Path(sys.executable).with_name("retrodict")
PATIENCE = 1_800_000  # ms: programs compile before the first answer, and others may use the machine


@contextmanager
def explored(out: Path) -> Iterator[str]:
    """The address of a page, whose command ends well when it is interrupted."""
    options = ["--no-browser", "--quiet", "--model", "planar-moment+wheels", "--out", out]
    # JAX sets it where it is imported, as in this process; a user's shell does not
    environment = {k: v for k, v in os.environ.items() if k != "TF_CPP_MIN_LOG_LEVEL"}
    with subprocess.Popen(
        [RETRODICT, "explore", BRACH, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as command:
        assert command.stdout
        assert command.stderr
        yield command.stdout.readline().split()[0]
        command.send_signal(signal.SIGINT)
        assert command.wait(60) == 0
        assert command.stderr.read() == ""


@pytest.mark.slow
def test_control_c_ends_the_command_well(tmp_path: Path) -> None:
    with explored(tmp_path) as address, urllib.request.urlopen(address, timeout=60) as page:
        assert "SAE 770014" in page.read().decode()


def test_a_port_that_is_taken_is_one_line_and_status_1() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        done = subprocess.run(
            [RETRODICT, "explore", BRACH, "--no-browser", "--quiet", "--port", port],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith(f"--port {port}: ")
    assert len(done.stderr.splitlines()) == 1


def test_without_the_extra_one_line_says_how_to_install_it() -> None:
    program = (
        "import sys; sys.modules['nicegui'] = None\n"
        "from retrodict.cli import app; app(['explore', sys.argv[1], '--quiet'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, BRACH], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "pip install 'nicegui" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.slow  # the programs of a scene compile
@pytest.mark.skipif(BROWSER is None, reason="no browser is installed")
def test_a_slider_moves_the_posterior_of_a_real_scene(tmp_path: Path) -> None:
    with explored(tmp_path) as address, sync_playwright() as playwright:
        expect.set_options(timeout=PATIENCE)
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = browser.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(f"{address}sliders")
        median = page.locator('tr[data-name="speed_b"] td').first
        expect(median).to_contain_text("19.")
        slider = page.locator(f"{SPEED} .q-slider").first
        slider.scroll_into_view_if_needed()
        at = slider.bounding_box()
        assert at
        y = at["y"] + at["height"] / 2
        page.mouse.move(at["x"] + 0.5 * at["width"], y)
        page.mouse.down()
        medians = [median.inner_text()]
        for step in range(10):
            page.mouse.move(at["x"] + (0.46 - 0.04 * step) * at["width"], y)
            expect(median).not_to_have_text(medians[-1])
            medians.append(median.inner_text())
        page.mouse.up()
        assert len(set(medians)) == 11
        # the slower A was, the slower B
        assert float(medians[-1].split()[0]) < float(medians[0].split()[0]) - 1
        page.get_by_role("button", name="Confirm by NUTS").click()
        expect(page.get_by_role("link", name="Open the report")).to_be_visible()
        assert (tmp_path / "report.html").stat().st_size > 100_000
        browser.close()
