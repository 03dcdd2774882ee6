"""The head of the page: title, tabs, what can be taken away, light and dark, keys, the tour, errors, the summary."""

from __future__ import annotations

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class Header(Component):
    """Lives in the browser; sends which tab, file and theme, and what was loaded, as text that the session reads."""

    tabs = param.List(doc="Key and title of each tab")
    tab = param.String(doc="Key of the open tab")
    theme = param.String(default="", doc="Light or dark, where the link says so")
    offers = param.List(default=[], doc="Name and title of each figure; whether a picture and a table can be taken")
    error = param.String(default="", doc="What was refused or failed; empty when nothing was")
    summary = param.String(default="", doc="What the figures show, for screen readers")

    _esm = script("shared/dom", "shared/theme", "header/tour", "shared/picture", "header/take", "header/header")
    _stylesheets = [style("header/header")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(self, **params) -> None:
        super().__init__(css_classes=["header"], sizing_mode="stretch_width", **params)

    def give(self, what: str, taken: dict) -> None:
        """Hand a file to the browser, which saves or copies it."""
        self._send_msg({"give": what, **taken})
