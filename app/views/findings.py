"""What it means: the verdict, how the difference is made up, what kind of motion each solver found, what it cost."""

from __future__ import annotations

import panel as pn
import param

from app.files import script, style
from app.words import Told


class Findings(pn.custom.JSComponent):
    """Plain text in live regions: screen readers hear what changes, and no text can become markup."""

    told = param.Dict(default={}, doc="Lines by name, parts of the difference, costs")

    _esm = script("dom", "findings")
    _stylesheets = [style("findings")]  # noqa: RUF012 - Panel reads it from the class

    def update(self, told: Told) -> None:
        """Show what is told of a new frame."""
        shown = {**vars(told), "cost": [list(chip) for chip in told.cost]}
        if shown != self.told:
            self.told = shown
