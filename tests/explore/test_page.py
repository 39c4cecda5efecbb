"""The page in a real browser, at the width of a desk and of a telephone."""

from __future__ import annotations

import http.client
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Locator, Page, expect, sync_playwright

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no browser is installed")
SIZES = {"desk": (1280, 900), "telephone": (390, 844)}
SPEED = '[data-key="vehicles.A.approach.speed"]'
PATIENCE = 30_000  # ms: a busy machine is slow, not wrong


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("explored")


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    """Of a served page, whose server ends when it is interrupted."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.explore.made_up", str(folder)],
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as server:
        assert server.stdout
        yield server.stdout.readline().strip()
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield launched
        launched.close()


class Opened:
    """A page of a certain size, with all that it asked for and complained of."""

    def __init__(self, page: Page, address: str) -> None:
        self.page = page
        self.asked: list[str] = []
        self.complaints: list[str] = []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("websocket", lambda socket: self.asked.append(socket.url))
        page.on("console", lambda message: self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        page.wait_for_selector("[data-answer], [data-failed]")
        self.reset()

    @property
    def median(self) -> Locator:
        return self.page.locator('tr[data-name="speed_b"] td').first

    @property
    def text(self) -> Locator:
        return self.page.locator(f"{SPEED} input")

    def reset(self) -> None:
        self.page.get_by_role("button", name="Reset all").click()
        expect(self.text).to_have_value("45 ± 2 mph")
        expect(self.median).to_contain_text("20.")

    def write(self, text: str) -> None:
        self.text.fill(text)
        self.text.press("Enter")


@pytest.fixture(params=["desk", pytest.param("telephone", marks=pytest.mark.slow)])
def opened(request: pytest.FixtureRequest, browser: Browser, address: str) -> Iterator[Opened]:
    expect.set_options(timeout=PATIENCE)
    width, height = SIZES[request.param]
    page = browser.new_page(viewport={"width": width, "height": height})
    yield Opened(page, address)
    page.close()


def test_a_slider_dragged_through_ten_positions_shows_ten_answers(opened: Opened) -> None:
    page = opened.page
    box = page.locator(f"{SPEED} .q-slider").first
    box.scroll_into_view_if_needed()
    at = box.bounding_box()
    assert at
    y = at["y"] + at["height"] / 2
    page.mouse.move(at["x"] + 0.5 * at["width"], y)
    page.mouse.down()
    texts, medians = [opened.text.input_value()], [opened.median.inner_text()]
    for step in range(10):
        page.mouse.move(at["x"] + (0.54 + 0.04 * step) * at["width"], y)
        expect(opened.text).not_to_have_value(texts[-1])
        expect(opened.median).not_to_have_text(medians[-1])
        texts.append(opened.text.input_value())
        medians.append(opened.median.inner_text())
    page.mouse.up()
    assert len(set(texts)) == len(set(medians)) == 11
    # the last answer is that of the slider's last position
    mph, shown = (float(each[-1].split()[0]) for each in (texts, medians))
    assert shown == pytest.approx(0.44704 * mph, rel=0.02)
    # a number stays in sight with the verdict beside it while the slider is dragged
    expect(opened.median).to_be_in_viewport()
    verdict = page.locator('tr[data-name="speed_b"] td').last
    expect(verdict).to_be_in_viewport()
    expect(verdict).to_have_text("passed")
    assert not opened.complaints
    assert len(opened.asked) > 10
    assert {urlsplit(url).hostname for url in opened.asked} == {"127.0.0.1"}
    # nothing is wider than the screen
    wide = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    assert wide <= 0


@pytest.mark.slow
def test_a_bad_value_is_refused_with_the_message_of_the_schema(opened: Opened) -> None:
    opened.write("500 ± 2 mph")
    fault = opened.page.locator(f"{SPEED} .fault")
    expect(fault).to_have_text(
        'vehicles.A.approach.speed = "500 ± 2 mph": not plausible; '
        "write a speed between 0 and 335.5 mph"
    )
    expect(opened.median).to_contain_text("20.")
    opened.write("50 ± 1 mph")
    expect(fault).to_be_empty()
    expect(opened.median).to_contain_text("22.")


@pytest.mark.slow
def test_numbers_whose_checks_fail_are_withheld_with_the_reason(opened: Opened) -> None:
    opened.write("45 ± 4 mph")
    expect(opened.median).to_have_text("withheld")
    answer = opened.page.locator(".answer")
    expect(answer).to_contain_text("NOT TO BE RELIED ON")
    expect(answer).to_contain_text("Pareto k is 0.90")
    expect(opened.page.locator('tr[data-name="e"] td').first).to_contain_text("†")
    opened.write("70 ± 2 mph")
    expect(answer).to_contain_text("no motion leads there")
    expect(opened.page.locator("tr[data-name]")).to_have_count(0)


def test_text_of_a_scene_is_shown_and_not_run(opened: Opened) -> None:
    page = opened.page
    expect(page.locator(".title")).to_contain_text("<img src=x")
    opened.write("45 ± 4 mph")
    expect(page.locator(".answer")).to_contain_text("<b>bold</b>")
    opened.write("70 ± 2 mph")
    expect(page.locator(".answer")).to_contain_text("<b>bold</b>")
    assert page.evaluate("window.ran") is None
    assert page.locator("img").count() == 0


@pytest.mark.slow
def test_units_and_model_are_chosen_on_the_page(opened: Opened) -> None:
    page = opened.page
    for label, choice in (("units", "mph"), ("model", "planar+spin")):
        page.get_by_label(label, exact=True).click()
        page.get_by_role("option", name=choice).click()
    expect(opened.median).to_contain_text("mph")
    expect(page.locator(".answer .small").first).to_contain_text("planar+spin")
    page.get_by_text("Priors", exact=True).click()
    expect(page.locator('[data-key="priors.speed_b.scale"] input')).to_have_value("30 m/s")
    page.get_by_label("model", exact=True).click()
    page.get_by_role("option", name="auto").click()


@pytest.mark.slow
def test_a_changed_scene_is_saved_and_the_report_is_written(opened: Opened, folder: Path) -> None:
    page, before = opened.page, (folder / "scene.toml").read_text()
    opened.write("50 ± 1 mph")
    expect(opened.median).to_contain_text("22.")
    name = page.get_by_label("save as")
    name.fill("scene.toml")
    save = page.get_by_role("button", name="Save the changed scene")
    save.click()
    expect(page.get_by_text("there is such a file")).to_be_visible()
    name.fill(f"changed-{page.viewport_size['width']}.toml")  # type: ignore[index]
    save.click()
    expect(page.get_by_text("Saved:")).to_be_visible()
    saved = folder / f"changed-{page.viewport_size['width']}.toml"  # type: ignore[index]
    assert '"50 ± 1 mph"' in saved.read_text("utf-8")
    assert (folder / "scene.toml").read_text() == before
    page.get_by_role("button", name="Confirm by NUTS").click()
    with page.expect_popup() as popup:
        page.get_by_role("link", name="Open the report").click()
    expect(popup.value.locator("body")).to_have_text("The report.")


@pytest.mark.slow
def test_a_second_page_takes_over(opened: Opened, browser: Browser, address: str) -> None:
    page = browser.new_page()
    other = Opened(page, address)
    expect(opened.page.get_by_text("was opened on another page")).to_be_visible()
    other.write("50 ± 1 mph")
    expect(other.median).to_contain_text("22.")
    page.close()


@pytest.mark.parametrize(
    "headers",
    [{"Host": "example.org"}, {"Host": "127.0.0.1"}, {"Origin": "http://example.org"}],
    ids=str,
)
def test_what_comes_from_elsewhere_is_refused(address: str, headers: dict[str, str]) -> None:
    place = urlsplit(address)
    assert place.hostname == "127.0.0.1"
    for path in ("/", "/report", "/_nicegui_ws/socket.io/?EIO=4&transport=polling"):
        connection = http.client.HTTPConnection(place.netloc, timeout=30)
        connection.request("GET", path, headers=headers)
        assert connection.getresponse().status == 403
        connection.close()


def test_nothing_listens_beyond_the_loopback_address(address: str) -> None:
    port = f"{urlsplit(address).port:04X}"
    tables = [Path(f"/proc/net/{name}") for name in ("tcp", "tcp6")]
    if not tables[0].is_file():
        pytest.skip("only Linux lists its sockets there")
    listening = [
        fields[1]
        for table in tables
        for fields in map(str.split, table.read_text().splitlines()[1:])
        if fields[1].endswith(f":{port}") and fields[3] == "0A"
    ]
    assert listening == [f"0100007F:{port}"]
