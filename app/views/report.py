"""The lines above the figures: what each solver found, the verdict, and what went wrong, in words."""

from __future__ import annotations

from pathlib import Path

import panel as pn
import param

from app.files import asset
from app.words import Told


class Report(pn.custom.JSComponent):
    """Plain text in live regions: screen readers hear what changes, and no text can become markup."""

    told = param.Dict(default={}, doc="Lines by name")
    error = param.String(default="", doc="What was refused or failed; empty when nothing was")

    _esm = Path(__file__).with_suffix(".js")
    _stylesheets = [asset("style.css")]  # noqa: RUF012 - Panel reads it from the class

    def update(self, told: Told) -> None:
        """Show the lines of a new frame."""
        lines = {"reference": told.reference, "penalty": told.penalty, "verdict": told.verdict, "agree": told.agree}
        if lines != self.told:
            self.told = lines
