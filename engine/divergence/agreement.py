"""Whether two solutions agree, in words: displacements, kinds of motion, impacts, and the scatter of the time step."""

from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.tolerances import CLOSE_CURVE, SAME_COUNT, SAME_CURVE, VISIBLE
from vibroscope.engine.drivers.section import sizes_of
from vibroscope.engine.facts import Statement, stated
from vibroscope.engine.motions.description import Motion
from vibroscope.engine.motions.tolerances import UNBROKEN
from vibroscope.engine.motions.words import difference_in_kind
from vibroscope.engine.wording import counted, percent


def agreement(comparison: Comparison) -> tuple[str, str | Statement]:
    """Return how far the solutions agree, as in :class:`.verdict.Verdict`, and a sentence about it."""
    if comparison.difference.measure == "sections":
        return _agreement_of_sections(comparison)
    reference, penalty, total = comparison.reference, comparison.penalty, comparison.difference.total
    impacts, kinds = _impacts_clause(reference, penalty), difference_in_kind(reference, penalty)
    amount = f"the displacements differ by {percent(total)} (rms)"
    if kinds and total <= CLOSE_CURVE:
        return "partly", stated("They agree roughly, but not in kind: {}, and {}{}.", kinds, amount, impacts)
    if kinds:
        return "no", stated("They disagree: {}, and {}{}.", kinds, amount, impacts)
    if total <= SAME_CURVE:
        return ("partly" if impacts else "yes"), f"They agree: {amount}{impacts and ', but' + impacts[1:]}."
    if total <= CLOSE_CURVE:
        return "partly", f"They agree roughly: {amount}{impacts}."
    return "no", f"They disagree: {amount}{impacts}."


def closeness(total: float) -> str:
    """How far two solutions agree whose displacements differ by so much, as in :class:`.verdict.Verdict`."""
    return "yes" if total <= SAME_CURVE else "partly" if total <= CLOSE_CURVE else "no"


def time_step_scatter(motion: Motion) -> float:
    """Return the scatter of a motion's section, a standard deviation, if the time step causes it; else 0."""
    return motion.scatter if motion.step_noise > 0 else 0.0


def is_visible(scatter: float, comparison: Comparison) -> bool:
    """Whether a scatter is large enough to be mentioned."""
    return scatter > VISIBLE * float(sizes_of(comparison.runs.penalty.section[None])[0])


def _agreement_of_sections(comparison: Comparison) -> tuple[str, str | Statement]:
    reference, penalty, difference = comparison.reference, comparison.penalty, comparison.difference
    kinds, impacts = difference_in_kind(reference, penalty), _impacts_clause(reference, penalty)
    if kinds:
        first = stated("They differ in kind: {}; only statistics can be compared", kinds)
    elif reference.near_period:
        first = "They repeat too late to be compared instant by instant, so that only statistics can be compared"
    else:
        first = "Neither repeats, so that only statistics can be compared"
    total, chance = difference.total, f"up to {percent(difference.chance)}"
    head = stated("{}: the sections differ by {}", first, percent(total))
    if total <= difference.chance:
        agree = "yes" if total <= CLOSE_CURVE and not kinds else "partly"
        return agree, head + f", no more than chance explains ({chance})."
    agree = "partly" if total <= CLOSE_CURVE and not impacts and not kinds else "no"
    return agree, head + f" (chance explains {chance}){impacts}."


def _impacts_clause(reference: Motion, penalty: Motion) -> str:
    """Impacts and contacts per period, if their numbers differ; else empty."""
    impacts, contacts = reference.impacts_per_period, penalty.impacts_per_period
    if abs(impacts - contacts) <= max(SAME_COUNT, SAME_COUNT * impacts):
        return ""
    lasting = penalty.contact_share >= 1.0 - UNBROKEN
    held = "always in contact" if lasting else f"with {counted(contacts, 'contact')} a period"
    return f", {held} for {counted(impacts, 'impact')}"
