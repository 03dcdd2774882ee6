"""Tab Help: the model and its equations, which a test compares with the kernels; the figures; a glossary."""

from html import escape

import panel as pn
from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.files import style, template
from vibroscope.app.page.tab import TabView


class Help(TabView):
    """The text ``help.html``, which does not depend on the setting."""

    key = "help"
    title = "Model, figures, glossary"
    controls = False

    def build(self) -> pn.viewable.Viewable:
        """Make the text."""
        return pn.pane.HTML(
            template("help/help.html").replace("GLOSSARY", glossary_rows()),
            stylesheets=[style("shared/text")],
            sizing_mode="stretch_width",
            sanitize_html=False,
        )

    def summary(self, setting: Setting) -> str:
        """Contents of the tab."""
        return "The model and its equations, how to read each figure, and a glossary."


def glossary_rows() -> str:
    """The glossary as rows of a table."""
    return "\n".join(
        f'<tr><th scope="row">{escape(entry.head)}</th><td>{escape(entry.text)} '
        f'<a href="docs/{entry.read}" target="_blank" aria-label="More about {escape(entry.head)}">More</a></td></tr>'
        for entry in glossary()
    )
