"""A bifurcation diagram in sentences.

The numbers that a bifurcation diagram can be swept over: where they begin and end, and which solvers have them.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.studies.bifurcation import PartialDiagram
from vibroscope.engine.facts import Statement, equation, span, stated
from vibroscope.engine.sweeps import CellKind


class Swept(NamedTuple):
    """A number that can be swept; it has its name in `FIELDS`.

    Attributes
    ----------
    symbol, text : str
        Symbol, and what it is.
    bounds : (float, float)
        The smallest and largest value; `app.explorer.state` has the range at first.
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


def statements(setting: Setting, result: PartialDiagram) -> list[list[str | Statement]]:
    """Head and text of what the diagram says."""
    symbol, nearest = SWEPT[result.question.over].symbol, nearest_cell(setting, result)
    lines = []
    if nearest is not None:
        at = float(result.question.axis[nearest])
        lines.append([stated("Near {}", equation(symbol, at, 5)), motion_at(result, nearest) + "."])
    return [*lines, [stated("From {}", span(symbol, *result.question.span)), f"{'; '.join(shares(result))}."]]


def nearest_cell(setting: Setting, result: PartialDiagram) -> int | None:
    """The known cell that is nearest to the number that is set; None if that lies outside of the diagram."""
    value, (low, high) = getattr(setting, result.question.over), result.question.span
    known = np.flatnonzero(result.known)
    return known[np.argmin(np.abs(result.question.axis[known] - value))] if low <= value <= high else None


_SHARES = {  # a kind of motion as the statement names it
    CellKind.ARTEFACT: "periodic but blurred by the time step",
    CellKind.QUASI_PERIODIC: "quasi-periodic",
    CellKind.CHAOTIC: "chaotic",
    CellKind.UNDECIDED: "aperiodic, kind not decided",
    CellKind.UNKNOWN: "aperiodic, being judged",
    CellKind.ENDED_EARLY: "ended early",
}


def shares(result: PartialDiagram) -> list[str]:
    """The kinds of motion, and the share of the range that each takes."""
    known = np.flatnonzero(result.known)
    kind, period = result.kinds["kind"][known], result.kinds["kind_period"][known]
    periodic = kind == CellKind.PERIODIC
    parts = {f"period {n}": periodic & (period == n) for n in (1, 2)}
    parts["longer periods"] = periodic & (period > 2)
    parts |= {name: kind == code for code, name in _SHARES.items()}
    return [f"{name} {_percent(float(cells.mean()))}" for name, cells in parts.items() if cells.any()]


def motion_at(result: PartialDiagram, index: int) -> str | Statement:
    """The motion of a cell, and its impacts."""
    if result.ended[index]:
        return "the run ended early"
    return kind_text(result, index) + f", impacts per period {result.impacts[index]:.3g}"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.005 else "below 1 %"


def kind_text(result: PartialDiagram, index: int) -> str:
    """Kind of motion of a cell, with its evidence."""
    kind = CellKind(result.kinds["kind"][index])
    if kind is CellKind.UNKNOWN:
        return result.motion_words(index) + " by its section alone (being judged)"
    exponent, error = result.kinds["lyapunov"][index], result.kinds["lyapunov_error"][index]
    is_aperiodic = np.isfinite(exponent) and kind is not CellKind.PERIODIC
    rate = f" (Lyapunov exponent {exponent:+.2g} ± {error:.1g} per period)" if is_aperiodic else ""
    return result.motion_words(index) + rate
