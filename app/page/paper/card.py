"""A claim of the paper as a card: the sentence, the verdict, what was found, why, and a button to its setting."""

from __future__ import annotations

from collections.abc import Callable

import param
from vibroscope.app.page.shared.component import Component
from vibroscope.app.paper import Finding


class ClaimCard(Component):
    """The card.

    Parameters
    ----------
    claim : dict
        What the card shows at once: ``name``, ``place``, ``text``, ``scene``, and the view that its button opens as
        ``view`` and ``title``.
    on_view : callable
        Called whenever the card comes into view, or the user asks for the check.
    on_cancel : callable
        Called when the user cancels the check.
    """

    claim = param.Dict(default={}, doc="name, place, text, scene; view that the button opens and its title")
    found = param.Dict(default={}, doc="verdict, found, why; or error; or cancelled; empty until it is known")

    script = "paper/card"

    def __init__(self, claim: dict, on_view: Callable[[], None], on_cancel: Callable[[], None]) -> None:
        super().__init__(claim=claim, css_classes=["card"], sizing_mode="stretch_width")
        self._on_view, self._on_cancel = on_view, on_cancel
        self.on_msg(lambda event: self.receive(event.data))

    def receive(self, data: object) -> None:
        """Take a message of the browser; only ``{"seen": True}`` and ``{"cancel": True}`` have a meaning."""
        if data == {"seen": True}:
            self._on_view()
        elif data == {"cancel": True}:
            self._on_cancel()

    def show_finding(self, verdict: str, finding: Finding) -> None:
        """Show a finding."""
        self.found = {"verdict": verdict, "found": finding.result, "why": finding.reason}

    def show_cancelled(self, cancelled: bool) -> None:
        """Show whether the user has cancelled the check."""
        self.found = {"cancelled": True} if cancelled else {}

    def show_error(self, error: str) -> None:
        """Show why the claim could not be checked."""
        self.found = {"error": error}
