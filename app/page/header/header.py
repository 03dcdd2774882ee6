"""The head of the page: title, question, tabs, take-away menu, theme, keys, tour, errors, and a summary to be read."""

import param
from vibroscope.app import QUESTION
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import DARK


class Header(Component):
    """Sends the view, file or theme that the user chooses, and uploaded parameters; `app.page.session` reads them."""

    question = param.String(default=QUESTION, constant=True, doc="What the page answers")
    caption = param.String(
        default="",
        doc="What to see in the motions of a scene, or of a setting of one's own; empty where none are shown",
    )
    look = param.String(default="", doc="Name of the figure that the caption speaks of")
    tabs = param.List(doc="Title of each tab, and key and title of each of its views")
    view = param.String(doc="Key of the open view")
    theme = param.String(default="", doc="Light or dark, if the link says so")
    dark = param.Dict(default=DARK, constant=True, doc="Colours of figures in the dark page by those in the light one")
    offers = param.List(default=[], doc="Name and title of each figure; whether a picture and a table are offered")
    compiling = param.Dict(default={}, doc="How far the solvers are compiled (`CompileProgress`); empty once they are")
    awaited = param.String(default="", doc="What a file that was asked for waits for; empty if none does")
    error = param.String(default="", doc="What was refused or has failed; empty if nothing")
    note = param.String(default="", doc="What a loaded file leaves out, or a link gives in vain; empty if nothing")
    summary = param.String(default="", doc="Summary of the figures for screen readers")

    script = "header/header"

    def __init__(self, tabs: list[list], **params) -> None:
        super().__init__(tabs=tabs, css_classes=["header"], sizing_mode="stretch_width", **params)

    def send_file(self, what: str, file: dict[str, str]) -> None:
        """Send a file to the browser, which saves or copies it."""
        self._send_msg({"give": what, **file})
