"""Serving the page to browsers of this machine alone."""

from __future__ import annotations

import socket
import threading
import webbrowser
from typing import TYPE_CHECKING

from retrodict.report.libraries import imported
from retrodict.scene.units import LENGTH, read_quantity

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from retrodict.explore.board.board import Board
    from retrodict.explore.explorer import Explorer, Setting

HOST = "127.0.0.1"
_ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 8 8"><path fill="#0072B2" d="M0 1h5v2H0z"/>'
    '<path fill="#D55E00" d="M3 5h5v2H3z"/></svg>'
)
# nothing is loaded from elsewhere, whatever a library or a scene's text may ask for
_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; "
    "frame-ancestors 'none'; form-action 'none'; base-uri 'none'"
)


def listen(port: int) -> socket.socket:
    """A socket that listens on the loopback address.

    Args:
        port: number of the port; 0 for any free port.

    Returns:
        The socket.

    Raises:
        OSError: the port is taken, or may not be used.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        listening.listen()
    except OSError:
        listening.close()
        raise
    return listening


def address(listening: socket.socket) -> str:
    """Address of the page that is served at a socket."""
    return f"http://{HOST}:{listening.getsockname()[1]}/"


def load_libraries() -> None:
    """Import the libraries that a page's handlers and its threads first use beside each other.

    Two threads that import packages which import each other, as xarray, pint and dask do, may see one
    of them half made: the handler then fails, and its text is neither written nor refused.
    """
    import xarray  # noqa: F401

    read_quantity("1 fathom", LENGTH, "1 m")  # a unit that only pint knows


def serve(
    explorer: Explorer,
    setting: Setting,
    listening: socket.socket,
    *,
    board: Board | None = None,
    browser: bool = False,
) -> None:
    """Serve the pages until the process is interrupted; once in a process.

    Args:
        explorer: explorer of the scene.
        setting: settings of the pages, besides the scene.
        listening: socket from `listen`.
        board: drawing board, which is the first page; None for the sliders alone.
        browser: whether to open the page in a browser.

    Raises:
        MissingLibrary: the extra is not installed.
        KeyboardInterrupt: the process was interrupted.
    """
    ui = imported("nicegui", "the page", "explore").ui
    uvicorn = imported("uvicorn", "the page", "explore")
    from fastapi import FastAPI
    from fastapi.responses import FileResponse, PlainTextResponse, RedirectResponse, Response

    from retrodict.explore.page import Page

    # the pages that describe an interface load their scripts from elsewhere
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    def report() -> Response:
        path = setting.out / "report.html"
        return FileResponse(path) if path.is_file() else PlainTextResponse("No report.", 404)

    def sliders() -> Response | None:
        if explorer.scene is None:  # nothing to slide yet
            return RedirectResponse("/")
        explorer.start_from_here()
        Page(explorer, setting).build()
        return None

    app.get("/report")(report)
    if board is None:
        ui.page("/")(lambda: Page(explorer, setting).build())
    else:
        from retrodict.explore.board.backdrop import image_at
        from retrodict.explore.board.page import BoardPage

        def ground() -> Response:
            found = image_at(board.path.parent, board.state.backdrop)
            if found is None:
                return PlainTextResponse("No photograph.", 404)
            path, kind = found
            return FileResponse(
                path, media_type=kind, headers={"X-Content-Type-Options": "nosniff"}
            )

        app.get("/ground")(ground)
        ui.page("/")(lambda: BoardPage(board, explorer, setting).build())
        ui.page("/sliders")(sliders)
    ui.run_with(
        app,
        title="retrodict explore",
        favicon=_ICON,
        language="en-US",
        tailwind=False,
        reconnect_timeout=60.0,  # s: a computation may hold this process up
        show_welcome_message=False,
    )
    load_libraries()
    app.add_middleware(Guard, port=listening.getsockname()[1])
    config = uvicorn.Config(app, log_level="warning", timeout_graceful_shutdown=1)
    if browser:
        threading.Thread(target=webbrowser.open, args=(address(listening),), daemon=True).start()
    uvicorn.Server(config).run(sockets=[listening])


class Guard:
    """Refuses requests that do not come from this server's own page, such as by DNS rebinding.

    Args:
        app: application that is guarded.
        port: port that the application is served at.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app = app
        self._hosts = {f"{host}:{port}" for host in (HOST, "localhost")}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        from starlette.datastructures import Headers, MutableHeaders
        from starlette.responses import PlainTextResponse

        headers = Headers(scope=scope)
        origins = {None, *(f"http://{host}" for host in self._hosts)}
        if headers.get("host") not in self._hosts or headers.get("origin") not in origins:
            refused = PlainTextResponse("This page is for browsers of its own machine.", 403)
            await refused(scope, receive, send)
            return

        async def with_policy(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).setdefault("content-security-policy", _POLICY)
            await send(message)

        await self._app(scope, receive, with_policy)
