"""Somebody who draws on the board with a pointer and a keyboard, and counts both."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from tests.explore.test_page import PATIENCE


@contextmanager
def served(
    scene: Path, *command: str, folder: Path | None = None, late: float = 0.0
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """The address of a served board, and its server, which is killed at the end.

    Args:
        scene: scene file that is drawn on.
        command: arguments of Python that serve it; none for a board with a made-up session.
        folder: folder that the command runs in.
        late: time that the made-up server takes for each action, s.
    """
    made_up = ("-m", "tests.explore.made_up_board", str(scene), str(late))
    with subprocess.Popen(
        [sys.executable, *(command or made_up)], stdout=subprocess.PIPE, text=True, cwd=folder
    ) as server:
        assert server.stdout
        try:
            yield server.stdout.readline().split()[0], server
        finally:
            server.send_signal(signal.SIGKILL)
            server.wait(60)


@contextmanager
def stopped(server: subprocess.Popen[str]) -> Iterator[None]:
    """The time in which a server does nothing, after which all that it was sent arrives at once."""
    server.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        server.send_signal(signal.SIGCONT)


class User:
    """A page of the board, and somebody at it.

    Args:
        page: page of a browser.
        address: address of the board.
    """

    def __init__(self, page: Page, address: str) -> None:
        self.page = page
        self.clicks = self.keys = 0
        self.begun = time.monotonic()  # s
        self.asked: list[str] = []
        self.complaints: list[str] = []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("websocket", lambda socket: self.asked.append(socket.url))
        page.on("console", lambda message: self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.set_default_timeout(PATIENCE)
        expect.set_options(timeout=PATIENCE)
        page.goto(address)
        page.wait_for_selector(".sheet .grid", state="attached")
        # the page that took over begins to act once it is connected
        page.wait_for_function("() => window.socket === undefined || window.socket.connected")
        page.wait_for_timeout(300)

    @property
    def effort(self) -> str:
        """Clicks, keys and seconds so far, in words."""
        seconds = time.monotonic() - self.begun
        return f"{self.clicks} clicks, {self.keys} keys, {seconds:.0f} s"

    @property
    def title(self) -> Locator:
        """The title with the name of the file."""
        return self.page.locator(".top .title")

    def use(self, tool: str) -> None:
        """Take a tool."""
        self.clicks += 1
        self.page.locator(f'[data-tool="{tool}"]').click()

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a place on the ground is on the screen."""
        matrix = self.page.locator("g.world").get_attribute("transform") or ""
        s, _, _, _, ox, oy = map(float, re.findall(r"[-+.e0-9]+", matrix.removeprefix("matrix")))
        box = self.page.locator(".sheet").bounding_box()
        assert box
        return box["x"] + ox + s * x, box["y"] + oy - s * y

    def click(self, x: float, y: float) -> None:
        """Click a place on the ground."""
        self.clicks += 1
        self.page.mouse.click(*self.pixel(x, y))

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag from a place on the ground to another."""
        self.clicks += 1
        self.page.mouse.move(*self.pixel(*start))
        self.page.mouse.down()
        x, y = self.pixel(*start)
        to_x, to_y = self.pixel(*end)
        for step in range(1, 6):
            self.page.mouse.move(x + step * (to_x - x) / 5, y + step * (to_y - y) / 5)
        self.page.mouse.up()

    def press(self, *keys: str) -> None:
        """Press keys on the sheet."""
        for key in keys:
            self.keys += 1
            self.page.locator(".sheet").press(key)

    def tab(self, name: str) -> None:
        """Open a panel."""
        self.clicks += 1
        self.page.get_by_role("tab", name=name, exact=True).click()

    def row(self, key: str) -> Locator:
        """The input of a quantity."""
        return self.page.locator(f'[data-key="{key}"] input')

    def write(self, key: str, text: str) -> None:
        """Type a quantity."""
        self.clicks += 1
        self.keys += len(text) + 1
        row = self.row(key)
        row.fill(text)
        row.press("Enter")

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        self.clicks += 2
        self.page.get_by_label(label, exact=True).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def needs(self) -> list[str]:
        """What is missing for an answer."""
        return self.page.locator(".need").all_inner_texts()
