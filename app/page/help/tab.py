"""Help: the model, drawn; its equations, held to the kernels by a test; a glossary; how to read each figure."""

from __future__ import annotations

import panel as pn
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.files import style, template
from vibroscope.app.page.tab import Tab


class Help(Tab):
    """A text that depends on nothing that is set: ``help.html``."""

    key = "help"
    title = "Help"
    controls = False

    def build(self) -> pn.viewable.Viewable:
        """The text."""
        return pn.pane.HTML(
            template("help/help.html"),
            stylesheets=[style("shared/text")],
            sizing_mode="stretch_width",
            sanitize_html=False,
        )

    def summary(self, setting: Setting) -> str:
        """What it is about."""
        return "The model and its equations, how to read each figure, and a glossary."
