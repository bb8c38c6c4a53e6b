"""The server of the page: on this machine only, for who holds the token of the address that is printed."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import Server
from bokeh.util.token import generate_secret_key, generate_session_id

from vibropipe.view.page import Page
from vibropipe.view.results import Results

HOST = "127.0.0.1"


def make_document(results: Results) -> Callable[[Document], None]:
    """Return what fills the document of a session."""

    def fill(document: Document) -> None:
        context = document.session_context
        given = {} if context is None else context.request.arguments
        chosen = {name: values[-1].decode() for name, values in given.items()}
        page = Page(results, document.add_next_tick_callback, chosen)
        document.title = f"{results.title} – vibropipe"
        document.add_root(page.root)
        for event, callback in page.scripts.items():
            document.js_on_event(event, callback)

    return fill


def new_server(results: Results, port: int = 0) -> tuple[Server, str]:
    """Return a server and the address of its page, with the token.

    Parameters
    ----------
    results : Results
    port : int
        Port; 0 is a free one.
    """
    secret = generate_secret_key()
    application = Application(FunctionHandler(make_document(results)))
    server = Server(
        {"/": application}, address=HOST, port=port, sign_sessions=True, secret_key=secret,
        generate_session_ids=False, check_unused_sessions_milliseconds=2000,
    )  # fmt: skip
    token = generate_session_id(secret, signed=True)
    return server, f"http://localhost:{server.port}/?bokeh-session-id={token}"


def serve(
    results: Results, on_ready: Callable[[str], None], opens_browser: bool, port: int = 0
) -> None:
    """Serve the page until Ctrl-C.

    Parameters
    ----------
    results : Results
    on_ready : callable
        Called with the address.
    opens_browser : bool
        Whether to open the address in the browser.
    port : int
        Port; 0 is a free one.
    """
    server, address = new_server(results, port)
    server.start()
    on_ready(address)
    if opens_browser:
        webbrowser.open(address)
    try:
        server.io_loop.start()
    except KeyboardInterrupt:
        pass
    finally:
        server.stop()
