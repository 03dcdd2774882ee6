"""Whether two solutions agree, in words: displacements, periods, impacts, and the scatter that is the time step's."""

import numpy as np

from ..motions.description import Motion
from ..motions.section import SCATTER
from .compare import Comparison
from .details import number, percent

SAME, CLOSE = 0.02, 0.10  # below the first two curves are one on the screen
IMPACTS = 0.05  # per period, and as a share: fewer are not worth a word
VISIBLE = 1e-3  # of the section's size: less scatter is not worth a sentence


def agreement(found: Comparison, total: float) -> tuple[str, str]:
    """Whether they agree, as in :class:`.verdict.Verdict`, and the sentence that says it."""
    if not found.motions.reference.period:
        return _agreement_of_sections(found)
    counts = _counts(found.motions.reference, found.motions.penalty)
    periods = _periods(found)
    amount = f"the displacements differ by {percent(total)} (rms)"
    if periods:
        return ("partly" if total <= CLOSE else "no"), f"They disagree: {periods}, and {amount}{counts}."
    if total <= SAME:
        return ("partly" if counts else "yes"), f"They agree: {amount}{counts and ', but' + counts[1:]}."
    if total <= CLOSE:
        return "partly", f"They agree roughly: {amount}{counts}."
    return "no", f"They disagree: {amount}{counts}."


def scatter_of(found: Comparison) -> float:
    """σ of ξ₂ about the points of a cycle that the exact penalty solution goes through without scatter."""
    period, penalty = found.motions.exact.period, found.motions.penalty
    if not period or penalty.period == period:
        return 0.0
    xi2 = found.runs.penalty.section[:, 2]
    cycles = len(xi2) // period
    return float(np.sqrt(np.mean(np.var(xi2[: cycles * period].reshape(cycles, period), axis=0))))


def shows(found: Comparison, scatter: float) -> bool:
    """Whether a scatter is worth a sentence."""
    return scatter > VISIBLE * _size(found)


def _agreement_of_sections(found: Comparison) -> tuple[str, str]:
    told = found.statistics
    repeats = "Neither repeats" if not found.motions.penalty.near_period else "The reference does not repeat"
    head = f"{repeats}, so that only statistics can be compared: the sections differ by {percent(told.total)}"
    if told.alike:
        return "yes", f"{head}, no more than chance ({percent(told.floor)})."
    counts = _counts(found.motions.reference, found.motions.penalty)
    agree = "partly" if told.total <= CLOSE and not counts else "no"
    return agree, f"{head} (chance: {percent(told.floor)}){counts}."


def _counts(reference: Motion, penalty: Motion) -> str:
    """Impacts against contacts, where they differ."""
    ours, theirs = reference.impacts_per_period, penalty.impacts_per_period
    if abs(ours - theirs) <= max(IMPACTS, IMPACTS * ours):
        return ""
    return f", with {number(theirs, 'contact')} a period for {number(ours, 'impact')}"


def _periods(found: Comparison) -> str:
    """Periods, where they differ by more than the step's scatter."""
    ours, limit = found.motions.reference.period, found.motions.exact.period
    small = limit and scatter_of(found) <= SCATTER * _size(found)
    theirs = limit if small else found.motions.penalty.near_period
    if theirs == ours:
        return ""
    other = f"repeats after {number(theirs, 'period')}" if theirs else "does not repeat"
    return f"the penalty solution {other}, the reference after {number(ours, 'period')}"


def _size(found: Comparison) -> float:
    return float(np.abs(found.runs.penalty.section).max())
