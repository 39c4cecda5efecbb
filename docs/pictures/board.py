"""Draws docs/pictures/board-*.png: the drawing board at three stages, in the browser of this machine.

    python docs/pictures/board.py

It needs the extra `explore`, Playwright and Chromium.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
from matplotlib.patches import Rectangle
from playwright.sync_api import Page, expect, sync_playwright

HERE = Path(__file__).parent
SCENE = HERE.parents[1] / "examples" / "brach-1977" / "scene.toml"
PATIENCE = 1_800_000  # ms
MODEL = "planar-moment+wheels"


def photograph(path: Path) -> None:
    """Render a crossing from above, 40 m by 30 m, 20 pixels a metre."""
    figure = plt.figure(figsize=(8, 6), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-20, 20), ylim=(-15, 15))
    axes.axis("off")
    axes.add_patch(Rectangle((-20, -15), 40, 30, color="#7d9168"))
    for x, y, w, h in ((-20, -4, 40, 8), (-4, -15, 8, 30)):
        axes.add_patch(Rectangle((x, y), w, h, color="#77777a"))
    for at in range(-20, 20, 3):
        if abs(at) > 4:
            axes.plot([at, at + 1.5], [0, 0], color="white", lw=2)
            axes.plot([0, 0], [at, at + 1.5], color="white", lw=2)
    figure.savefig(path)
    plt.close(figure)


@contextmanager
def page_of(folder: Path, *scene: str) -> Iterator[Page]:
    """A page of the board in a folder."""
    command = [sys.executable, "-m", "retrodict", "explore", *scene, "--no-browser", "--quiet"]
    with (
        subprocess.Popen(
            [*command, "--model", MODEL], stdout=subprocess.PIPE, text=True, cwd=folder
        ) as server,
        sync_playwright() as playwright,
    ):
        assert server.stdout
        address = server.stdout.readline().split()[0]
        found = shutil.which("chromium") or shutil.which("google-chrome")
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 860})
        page.set_default_timeout(PATIENCE)
        expect.set_options(timeout=PATIENCE)
        page.goto(address)
        page.wait_for_selector(".sheet .grid", state="attached")
        page.wait_for_timeout(1000)
        try:
            yield page
        finally:
            browser.close()
            server.kill()


def click(page: Page, tool: str, *places: tuple[float, float]) -> None:
    """Take a tool, and click places on the ground."""
    page.locator(f'[data-tool="{tool}"]').click()
    for x, y in places:
        matrix = page.locator("g.world").get_attribute("transform") or ""
        s, _, _, _, ox, oy = map(float, re.findall(r"[-+.e0-9]+", matrix.removeprefix("matrix")))
        box = page.locator(".sheet").bounding_box()
        assert box
        page.mouse.click(box["x"] + ox + s * x, box["y"] + oy - s * y)
        page.wait_for_timeout(400)


def choose(page: Page, label: str, option: str) -> None:
    """Choose from a list."""
    page.get_by_label(label, exact=True).click()
    page.get_by_role("option", name=option, exact=True).click()
    page.wait_for_timeout(300)


def write(page: Page, key: str, text: str) -> None:
    """Type a quantity."""
    row = page.locator(f'[data-key="{key}"] input')
    row.fill(text)
    row.press("Enter")
    page.wait_for_timeout(300)


def main() -> None:
    """Draw the three pictures."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        photograph(folder / "crossing.png")
        with page_of(folder) as page:
            page.get_by_role("tab", name="Photograph", exact=True).click()
            page.locator("input[type=file]").first.set_input_files(folder / "crossing.png")
            expect(page.locator("img.ground")).to_be_visible()
            page.wait_for_timeout(1000)
            click(page, "scale", (-6, 0), (6, 0))
            page.get_by_label("Distance between the two points").fill("8 m")
            page.get_by_label("Distance between the two points").press("Enter")
            expect(page.get_by_text("20.0 pixels a metre")).to_be_visible()
            page.locator(".sheet").press("0")
            page.wait_for_timeout(500)
            page.screenshot(path=HERE / "board-ground.png")
            click(page, "put:A:impact", (-2, -1.6))
            choose(page, "class or model of A", "compact car")
            click(page, "put:B:impact", (1.6, -0.6))
            choose(page, "class or model of B", "full-size car")
            write(page, "vehicles.B.impact.heading", "75 deg")
            click(page, "point", (0.5, -1.1))
            click(page, "put:A:rest", (6, 4))
            for _ in range(4):
                page.locator(".sheet").press("Shift+Q")
            page.get_by_role("tab", name="Impact", exact=True).click()
            page.wait_for_timeout(500)
            page.screenshot(path=HERE / "board-vehicles.png")
        shutil.copy(SCENE, folder / "scene.toml")
        with page_of(folder, "scene.toml") as page:
            expect(page.locator(".verdict.passed")).to_be_visible()
            expect(page.locator(".q-linear-progress")).to_be_hidden()
            click(page, "select", (8.968, -12.896))
            page.wait_for_timeout(500)
            page.screenshot(path=HERE / "board-answer.png")


if __name__ == "__main__":
    main()
