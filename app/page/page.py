"""The document of one session: template, theme, and the layout of its parts."""

from __future__ import annotations

import json

import panel as pn
from bokeh.document import Document
from panel.io.resources import LOCAL_DIST
from vibroscope.app import QUESTION
from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.page.files import script, style, template
from vibroscope.app.page.session import Session
from vibroscope.app.page.shared.figure import THEME

TITLE = "Vibroscope"

# The style sheet sets the height of the page; Panel must not derive it from the content.
pn.extension(respect_explicit_sizing=True)


def create_app() -> pn.Column:
    """The page of the session that is being opened."""
    doc = pn.state.curdoc
    html = template("shared/page.html").replace("TOKENS", style("shared/tokens")).replace("QUESTION", QUESTION)
    terms = json.dumps(glossary(), ensure_ascii=False).replace("<", "\\u003c")
    doc.template = html.replace("FIRST", script("shared/compat")).replace("GLOSSARY", terms)
    # Panel sets this only where the session is built with the page; otherwise its style sheets come from another host.
    doc.template_variables["dist_url"] = LOCAL_DIST
    doc.theme = THEME
    doc.config.update(reconnect_session=False, notify_connection_status=False)  # page.html handles a lost connection
    doc.title = f"{TITLE}: {QUESTION}"
    session = Session(_query(doc))
    pn.state.onload(session.start)
    pn.state.on_session_destroyed(lambda context: session.close())
    return pn.Column(
        session.header,
        session.controls,
        session.tab_area.view,
        css_classes=["page"],
        stylesheets=[style("shared/page")],
        sizing_mode="stretch_width",
    )


def _query(doc: Document | None) -> str:
    """The query string as it was sent; Panel's own parser fails on some."""
    context = doc.session_context if doc is not None else None
    request = getattr(context, "request", None)
    uri = getattr(request, "uri", "") or ""
    return uri.partition("?")[2]
