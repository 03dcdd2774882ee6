"""A claim of the paper as a card: the sentence, the verdict, what was found, why, and a button to its setting."""

from __future__ import annotations

from collections.abc import Callable

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component
from vibroscope.app.paper import Finding


class ClaimCard(Component):
    """The card.

    Parameters
    ----------
    claim : dict
        What the card shows at once: ``name``, ``place``, ``text``, ``scene``, and the tab that its button opens as
        ``tab`` and ``title``.
    on_view : callable
        Called whenever the card comes into view.
    """

    claim = param.Dict(default={}, doc="name, place, text, scene; tab that the button opens and its title")
    found = param.Dict(default={}, doc="verdict, found, why; or error; empty until it is known")

    _esm = script("shared/dom", "shared/theme", "paper/card")
    _stylesheets = [style("paper/card")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(self, claim: dict, on_view: Callable[[], None]) -> None:
        super().__init__(claim=claim, css_classes=["card"], sizing_mode="stretch_width")
        self._on_view = on_view
        self.on_msg(lambda event: self.receive(event.data))

    def receive(self, data: object) -> None:
        """Take a message of the browser; only ``{"seen": True}`` has a meaning."""
        if data == {"seen": True}:
            self._on_view()

    def show_finding(self, verdict: str, finding: Finding) -> None:
        """Show a finding."""
        self.found = {"verdict": verdict, "found": finding.result, "why": finding.reason}

    def show_error(self, error: str) -> None:
        """Show why the claim could not be checked."""
        self.found = {"error": error}
