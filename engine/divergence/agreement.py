"""Whether two solutions agree, in words: displacements, periods, impacts, and the scatter that the time step causes."""

import numpy as np

from ..drivers.section import NEAR_TOLERANCE
from ..motions.description import Motion
from ..wording import counted, percent
from .compare import Comparison

SAME, CLOSE = 0.02, 0.10  # relative rms: below the first, two curves coincide on the screen
IMPACTS = 0.05  # per period, and relative: smaller differences in number are not mentioned
VISIBLE = 1e-3  # of the section's size: smaller scatter is not mentioned


def agreement(comparison: Comparison, total: float) -> tuple[str, str]:
    """Return how far the solutions agree, as in :class:`.verdict.Verdict`, and a sentence about it."""
    if not comparison.motions.reference.period:
        return _agreement_of_sections(comparison)
    impacts = _impacts_clause(comparison.motions.reference, comparison.motions.penalty)
    periods = _periods_clause(comparison)
    amount = f"the displacements differ by {percent(total)} (rms)"
    if periods:
        return ("partly" if total <= CLOSE else "no"), f"They disagree: {periods}, and {amount}{impacts}."
    if total <= SAME:
        return ("partly" if impacts else "yes"), f"They agree: {amount}{impacts and ', but' + impacts[1:]}."
    if total <= CLOSE:
        return "partly", f"They agree roughly: {amount}{impacts}."
    return "no", f"They disagree: {amount}{impacts}."


def time_step_scatter(comparison: Comparison) -> float:
    """Return the standard deviation σ of ξ₂ about the points of a cycle that the exact penalty solution has, too."""
    period, penalty = comparison.motions.exact.period, comparison.motions.penalty
    if not period or penalty.period == period:
        return 0.0
    xi2 = comparison.runs.penalty.section[:, 2]
    cycles = len(xi2) // period
    return float(np.sqrt(np.mean(np.var(xi2[: cycles * period].reshape(cycles, period), axis=0))))


def is_visible(scatter: float, comparison: Comparison) -> bool:
    """Whether a scatter is large enough to be mentioned."""
    return scatter > VISIBLE * _section_size(comparison)


def _agreement_of_sections(comparison: Comparison) -> tuple[str, str]:
    statistics = comparison.statistics
    repeats = "Neither repeats" if not comparison.motions.penalty.near_period else "The reference does not repeat"
    head = f"{repeats}, so that only statistics can be compared: the sections differ by {percent(statistics.total)}"
    if statistics.alike:
        return "yes", f"{head}, no more than chance ({percent(statistics.floor)})."
    impacts = _impacts_clause(comparison.motions.reference, comparison.motions.penalty)
    agree = "partly" if statistics.total <= CLOSE and not impacts else "no"
    return agree, f"{head} (chance: {percent(statistics.floor)}){impacts}."


def _impacts_clause(reference: Motion, penalty: Motion) -> str:
    """Impacts and contacts per period, if their numbers differ; else empty."""
    impacts, contacts = reference.impacts_per_period, penalty.impacts_per_period
    if abs(impacts - contacts) <= max(IMPACTS, IMPACTS * impacts):
        return ""
    return f", with {counted(contacts, 'contact')} a period for {counted(impacts, 'impact')}"


def _periods_clause(comparison: Comparison) -> str:
    """Periods of the two motions, if they differ by more than the time-step scatter explains; else empty."""
    reference, limit = comparison.motions.reference.period, comparison.motions.exact.period
    scattered = limit and time_step_scatter(comparison) <= NEAR_TOLERANCE * _section_size(comparison)
    penalty = limit if scattered else comparison.motions.penalty.near_period
    if penalty == reference:
        return ""
    other = f"repeats after {counted(penalty, 'period')}" if penalty else "does not repeat"
    return f"the penalty solution {other}, the reference after {counted(reference, 'period')}"


def _section_size(comparison: Comparison) -> float:
    return float(np.abs(comparison.runs.penalty.section).max())
