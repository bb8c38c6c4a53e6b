"""The server of the page: on this machine only, for who holds the token of the address that is printed."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable

import numpy as np
from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.events import DocumentReady
from bokeh.server.server import Server
from bokeh.util.token import generate_secret_key, generate_session_id

from vibropipe.view.page import Page
from vibropipe.view.results import Results
from vibropipe.view.what_if import attractor_rows, steady_row
from vibropipe.words.regimes import Regime

HOST = "127.0.0.1"
# Seconds that a point is shown before motions that coexist are sought.
REST = 0.4


def make_document(results: Results) -> Callable[[Document], None]:
    """Return what fills the document of a session."""

    def fill(document: Document) -> None:
        context = document.session_context
        given = {} if context is None else context.request.arguments
        chosen = {name: values[-1].decode() for name, values in given.items()}
        page = Page(results, document.add_next_tick_callback, chosen, rest=REST)
        page.point.seek.active = True
        document.title = f"{results.title} – vibropipe"
        document.add_root(page.root)
        document.js_on_event(DocumentReady, *page.scripts)

    return fill


def new_server(results: Results, port: int = 0) -> tuple[Server, str]:
    """Return a server and the address of its page, with the token.

    port : 0 is a free one
    """
    secret = generate_secret_key()
    application = Application(FunctionHandler(make_document(results)))
    server = Server(
        {"/": application}, address=HOST, port=port, sign_sessions=True, secret_key=secret,
        generate_session_ids=False, check_unused_sessions_milliseconds=2000,
    )  # fmt: skip
    token = generate_session_id(secret, signed=True)
    return server, f"http://localhost:{server.port}/?bokeh-session-id={token}"


def answer_once(results: Results) -> None:
    """Show a point, a change of parameters, and a rest: what has to be compiled is compiled before anybody waits."""
    page = Page(results)
    if page.point.stored is not None:
        steady_row(page.point.stored, {})
        attractor_rows(page.point.stored)
    if not page.plane.of_starts:
        resting = np.argwhere(
            page.plane.at_further(page.plane.dataset["regime"]) == Regime.WITH_REST
        )
        for at in resting[:1]:
            page.point.show(page.plane.row(page.plane.row_number(tuple(at[::-1]))), "", "", "", {})


def serve(
    results: Results, on_ready: Callable[[str], None], opens_browser: bool, port: int = 0
) -> None:
    """Serve the page until Ctrl-C.

    on_ready : called with the address
    opens_browser : whether to open the address in the browser
    port : 0 is a free one
    """
    answer_once(results)
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
