"""The page, and the server that shows it."""

from __future__ import annotations

import panel as pn
import panel_material_ui as pmui
import param
from bokeh.document import Document

from app import compute
from app.diagrams import kept
from app.files import ASSETS, asset
from app.session import Session

TITLE = "Vibroscope"
_SUBTITLE = "where a penalty contact departs from the exact impact motion"
# The page sends a few hundred bytes at a time; anything large is not from it.
_MESSAGE_LIMIT = 1 << 20

# The style sheet gives the desk its height: no guessing from what lies in it.
pn.extension(respect_explicit_sizing=True)


def create_app() -> pmui.Page:
    """The page for the session that is being opened."""
    session = Session(_query(pn.state.curdoc))
    pn.state.onload(session.start)
    pn.state.on_session_destroyed(lambda context: session.close())
    page = pmui.Page(
        title=f"{TITLE}: {_SUBTITLE}",
        main=[_desk(session)],
        theme_toggle=False,
        sizing_mode="stretch_width",
        sx={"& .MuiToolbar-root": {"minHeight": "46px"}, "& .MuiAppBar-root h3": {"fontSize": "17px"}},
    )
    # Panel's busy mark walks through every model of the page twice for each message; this page has a mark of its own.
    with param.edit_constant(page):
        page.busy = False
    return page


def _query(doc: Document | None) -> str:
    """The address's query as it was sent; Panel's own parser fails on some."""
    context = doc.session_context if doc is not None else None
    request = getattr(context, "request", None)
    uri = getattr(request, "uri", "") or ""
    return uri.partition("?")[2]


def _desk(session: Session) -> pn.Column:
    """Controls, words and figures; `assets/style.css` lays them out as a grid."""
    figures = [
        *session.phase.figures,
        session.displacement.figure,
        session.displacement.strip,
        session.force.figure,
        session.diagram.figure,
    ]
    cells = [
        _cell(session.controls, "controls"),
        _cell(session.report, "report"),
        *(_cell(pn.pane.Bokeh(plot, sizing_mode="stretch_both"), plot.name) for plot in figures),
    ]
    return pn.Column(*cells, css_classes=["desk"], stylesheets=[asset("style.css")], sizing_mode="stretch_width")


def _cell(view, name: str):
    view.css_classes = [*view.css_classes, "cell", name]
    return view


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
