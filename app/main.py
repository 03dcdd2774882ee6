"""The page, and the server that shows it."""

from __future__ import annotations

import panel as pn
from bokeh.document import Document

from app import compute
from app.diagrams import kept
from app.files import ASSETS, asset, style
from app.session import Session
from app.views.base import THEME

TITLE = "Vibroscope"
_SUBTITLE = "where a penalty contact departs from the exact impact motion"
# The page sends a few hundred bytes at a time; anything large is not from it.
_MESSAGE_LIMIT = 1 << 20

# The style sheet gives the desk its height: no guessing from what lies in it.
pn.extension(respect_explicit_sizing=True)


def create_app() -> pn.Column:
    """The page for the session that is being opened."""
    doc = pn.state.curdoc
    doc.template = asset("page.html").replace("TOKENS", asset("style/tokens.css"))
    doc.theme = THEME
    doc.title = f"{TITLE}: {_SUBTITLE}"
    session = Session(_query(doc))
    pn.state.onload(session.start)
    pn.state.on_session_destroyed(lambda context: session.close())
    return pn.Column(
        session.header,
        session.controls,
        session.stage,
        css_classes=["page"],
        stylesheets=[style("page")],
        sizing_mode="stretch_width",
    )


def _query(doc: Document | None) -> str:
    """The address's query as it was sent; Panel's own parser fails on some."""
    context = doc.session_context if doc is not None else None
    request = getattr(context, "request", None)
    uri = getattr(request, "uri", "") or ""
    return uri.partition("?")[2]


def serve(*, address: str = "127.0.0.1", port: int = 5006, show: bool = False, origins: list[str] | None = None):
    """Serve the explorer until interrupted; only this machine may look unless told otherwise.

    Parameters
    ----------
    address, port
        Where to listen; port 0 takes a free one.
    show
        Open a browser.
    origins
        Host names a page may be opened under when it is not the address itself.
    """
    compute.warm()
    kept("table")
    return pn.serve(
        # location=False: Panel's own parser of the address answers some of them with a server error.
        {"/": create_app},
        address=address,
        port=port,
        show=show,
        title=TITLE,
        websocket_origin=origins or [f"{address}:{port}", f"localhost:{port}"] if port else None,
        websocket_max_message_size=_MESSAGE_LIMIT,
        autoreload=False,
        threaded=False,
        liveness=True,
        location=False,
        static_dirs={"speed": str(ASSETS / "speed")},
    )
