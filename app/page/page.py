"""The document of one session: template, theme, and the layout of its parts."""

import json
from functools import cache

import panel as pn
from bokeh.document import Document
from panel.io.resources import LOCAL_DIST
from vibroscope.app import QUESTION
from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.page.files import address_of, modules, style, template
from vibroscope.app.page.session import Session
from vibroscope.app.page.shared.figure import THEME

TITLE = "Vibroscope"

_FIRST = ("shared", "header", "controls", "explore")  # folders of what the first tab shows

# The style sheet sets the height of the page; Panel must not derive it from the content.
pn.extension(respect_explicit_sizing=True)


def create_app() -> pn.Column:
    """The page of the session that is being opened."""
    doc = pn.state.curdoc
    html = template("shared/page.html").replace("TOKENS", style("shared/tokens")).replace("QUESTION", QUESTION)
    terms = json.dumps(glossary(), ensure_ascii=False).replace("<", "\\u003c")
    doc.template = html.replace("MODULES", _loaded_at_once()).replace("GLOSSARY", terms)
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
        session.tab_area.column,
        css_classes=["page"],
        stylesheets=[style("shared/page")],
        sizing_mode="stretch_width",
    )


@cache
def _loaded_at_once() -> str:
    """Elements that fetch the modules of the first tab ahead, and run the hooks into Bokeh and Panel."""
    ahead = (name for name in modules() if name.partition("/")[0] in _FIRST)
    links = (f'<link rel="modulepreload" href="{address_of(name)}">' for name in ahead)
    return "\n".join((*links, f'<script type="module" src="{address_of("shared/compat")}"></script>'))


def _query(doc: Document | None) -> str:
    """The query string as it was sent; Panel's own parser fails on some."""
    context = doc.session_context if doc is not None else None
    request = getattr(context, "request", None)
    uri = getattr(request, "uri", "") or ""
    return uri.partition("?")[2]
