"""What it means: the verdict, how the difference is made up, what kind of motion each solver found, what it cost."""

from __future__ import annotations

import param
from vibroscope.app.explorer.words import Meaning, Told
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class Findings(Component):
    """Plain text in live regions: screen readers hear what changes, and no text can become markup."""

    told = param.Dict(default={}, doc="Lines by name, costs; parts of the difference and what to change, once known")

    _esm = script("shared/dom", "explore/findings")
    _stylesheets = [style("explore/findings")]  # noqa: RUF012 - Panel reads it from the class

    def update(self, told: Told, meaning: Meaning | None) -> None:
        """Show what is told of a new frame; until its meaning is known, the last one stays, greyed."""
        shown = {"reference": told.reference, "penalty": told.penalty, "cost": [list(chip) for chip in told.cost]}
        last = {name: value for name, value in self.told.items() if name not in shown}
        known = (
            last | {"pending": True}
            if meaning is None
            else {name: getattr(meaning, name) for name in ("verdict", "agree", "parts", "change", "details")}
        )
        # lists, as they come back from the browser's side
        if shown | known != self.told:
            self.told = shown | known
