"""The numbers that a bifurcation diagram can be swept over: where they begin and end, and which solvers have them."""

from __future__ import annotations

from typing import NamedTuple

from vibroscope.app.explorer.parameters import FIELDS


class Swept(NamedTuple):
    """A number that can be swept; it has its name in `FIELDS`.

    Attributes
    ----------
    symbol, text : str
        Symbol, and what it is.
    bounds : (float, float)
        The smallest and largest value; `app.explorer.ranges` has the range at first.
    parts : int
        Into how many parts a unit is divided where the line is dragged; 1 for whole numbers.
    solvers : tuple of str
        Solvers that have it, the preferred one first.
    """

    symbol: str
    text: str
    bounds: tuple[float, float]
    parts: int
    solvers: tuple[str, ...]

    @property
    def choice(self) -> str:
        """The label in the list of choices: its name, without its definition."""
        return self.text.removesuffix(" Ω/ω₁")

    def rounded(self, value: float) -> float:
        """The nearest value that the line can be dragged to."""
        low, high = self.bounds
        return min(max(round(value * self.parts) / self.parts, low), high)


def _swept(name: str, parts: int, *solvers: str) -> Swept:
    field = FIELDS[name]
    return Swept(field.label, field.hint, field.bounds, parts, solvers)


SWEPT = {
    "eta": _swept("eta", 10_000, "reference", "exact", "newmark"),
    "K": _swept("K", 10, "exact", "newmark"),
    "D": _swept("D", 1000, "exact", "newmark"),
    "steps": _swept("steps", 1, "newmark"),
    "restitution": _swept("restitution", 10_000, "reference"),
}
