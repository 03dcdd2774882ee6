"""What a comparison means, in plain English: what agrees, which number is to blame, and what to change first.

Every sentence is made from numbers that were computed, and the number that is blamed was changed to see
(:mod:`.cures`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..motions.description import Motion
from ..motions.section import SCATTER
from ..result import Status
from ..simulate import simulate
from .compare import Comparison, nearest_attractor
from .cures import HELPS, Cure, cures, difference
from .details import details_of, number, percent

SAME, CLOSE = 0.02, 0.10  # below the first two curves are one on the screen
IMPACTS = 0.05  # per period, and as a share: fewer are not worth a word
VISIBLE = 1e-3  # of the section's size: less scatter is not worth a sentence
NEARLY = 1.3  # times as much is left
THIRD = 3.0  # a time step that adds a third of what K and D do hardly shows in the root of the sum of squares
MOST_STEPS = 10_000_000
DOUBLINGS = 6  # of the steps, tried for a run that blew up


@dataclass(frozen=True)
class Verdict:
    """A comparison in words.

    Attributes
    ----------
    headline : str
        At most three short sentences.
    agree : {"yes", "partly", "no", "unknown"}
    blame : {"steps", "K", "D", "joint damping", ""}
        The number that takes most of the difference away if it alone is changed; "" if none does.
    change : dict of str to float or bool
        What to set first: some of ``K``, ``D``, ``steps`` and ``located``; empty if no number mends it.
    left : float
        What is left of the difference without what is to blame; nan if nothing is.
    scatter : float
        Standard deviation of ξ₂ about the section's points that the time step alone causes; 0 if there is none.
    details : tuple of str
        The numbers behind it, a sentence each.
    """

    headline: str
    agree: str
    blame: str = ""
    change: dict[str, float | bool] = field(default_factory=dict)
    left: float = np.nan
    scatter: float = 0.0
    details: tuple[str, ...] = ()

    def as_dict(self) -> dict:
        """For scripts; None for what is not known."""
        return {**vars(self), "left": _finite(self.left), "details": list(self.details)}


def verdict(found: Comparison, *, cancelled: Callable[[], bool] | None = None) -> Verdict:
    """Say what a comparison means; it runs Newmark and the reference a few times more.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    if found.parts is None:
        return _ended_early(found, cancelled)
    total, scatter = difference(found), _scatter(found)
    if (
        found.motions.reference.period
        and total > CLOSE
        and (elsewhere := nearest_attractor(found, cancelled)) < min(CLOSE, total / 2)
    ):
        told = (
            "The penalty solution shows another motion, yet no wrong one: started from its state, the reference moves "
            f"so too, {percent(elsewhere)} apart. From rest they are {percent(total)} apart: mind the start."
        )
        return Verdict(told, "partly", left=elsewhere, scatter=scatter, details=details_of(found, []))
    tried = cures(found, cancelled)
    agree, first = _agreement(found, total)
    best = _best(found, tried, total, scatter)
    second, change = _blamed(found, total, best)
    noise = f" The section's scatter (σ of ξ₂ = {scatter:.2g}) is the time step's." if _shows(found, scatter) else ""
    return Verdict(
        f"{first} {second}{noise}",
        agree,
        best.name if best else "",
        change,
        best.left if best else np.nan,
        scatter,
        details_of(found, tried),
    )


def _best(found: Comparison, tried: list[Cure], total: float, scatter: float) -> Cure | None:
    """The cure that leaves least; the step's, if the step scatters the section and its cure leaves hardly more.

    For what K and D leave at such a step is scattered too, a matter of chance, and the section stays a blot with them.
    """
    limit = [cure for cure in tried if cure.name == "steps"]
    if limit and _shows(found, scatter) and limit[0].left <= min(NEARLY * tried[0].left, total):
        return limit[0]
    return tried[0] if tried and tried[0].left <= HELPS * total else None


# ---------------------------------------------------------------------------------------------------- what agrees


def _agreement(found: Comparison, total: float) -> tuple[str, str]:
    """Whether they agree, and the sentence that says it."""
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
    small = limit and _scatter(found) <= SCATTER * _size(found)
    theirs = limit if small else found.motions.penalty.near_period
    if theirs == ours:
        return ""
    other = f"repeats after {number(theirs, 'period')}" if theirs else "does not repeat"
    return f"the penalty solution {other}, the reference after {number(ours, 'period')}"


def _scatter(found: Comparison) -> float:
    """σ of ξ₂ about the points of a cycle that the exact penalty solution goes through without scatter."""
    period, penalty = found.motions.exact.period, found.motions.penalty
    if not period or penalty.period == period:
        return 0.0
    xi2 = found.runs.penalty.section[:, 2]
    cycles = len(xi2) // period
    return float(np.sqrt(np.mean(np.var(xi2[: cycles * period].reshape(cycles, period), axis=0))))


def _shows(found: Comparison, scatter: float) -> bool:
    return scatter > VISIBLE * _size(found)


def _size(found: Comparison) -> float:
    return float(np.abs(found.runs.penalty.section).max())


# ---------------------------------------------------------------------------------------------------- what is to blame


def _blamed(found: Comparison, total: float, best: Cure | None) -> tuple[str, dict]:
    """What is to blame and the first thing to change, as a sentence and as numbers."""
    if not found.motions.reference.period and found.statistics.alike:
        return "Nothing is to blame.", {}
    if best is None:
        return "No single number is to blame: parts of it cancel; change K, D and the step together.", {}
    if total <= SAME:
        name = {"steps": "the time step", "joint damping": "the joint damping"}.get(best.name, best.name)
        return f"The largest share is that of {name}: without it, {percent(best.left)} would be left.", {}
    say: dict[str, Callable] = {"steps": _steps, "joint damping": _joint, "K": _stiffness, "D": _damping}
    return say[best.name](found, best)


def _steps(found: Comparison, best: Cure) -> tuple[str, dict]:
    method = found.runs.penalty.method
    part = found.time_step if found.motions.reference.period else found.statistics.time_step
    steps = _rounded(method.steps * max(2.0, THIRD * part / max(best.left, 1e-6)))
    way = f"about {steps:,} steps" if method.located else f"the located step, or about {steps:,} steps"
    change = {"steps": steps} if method.located else {"located": True}
    blame = "is to blame" if best.left <= HELPS * difference(found) else "comes first, since it hides what K and D do"
    return f"The time step {blame}: without it {percent(best.left)} would be left; take {way}.", change


def _joint(found: Comparison, best: Cure) -> tuple[str, dict]:
    return (
        f"The joint damping is to blame: without it {percent(best.left)} would be left; the penalty model has no "
        "place for it, so no K, D or time step mends it.",
        {},
    )


def _stiffness(found: Comparison, best: Cure) -> tuple[str, dict]:
    now, new = found.runs.penalty.method, best.method
    along = "" if new.damping == now.damping else f" with D = {new.damping:.3g}"
    text = f"K is to blame: K = {new.stiffness:g}{along} leaves {percent(best.left)}."
    return text, {"K": new.stiffness} | ({"D": new.damping} if along else {})


def _damping(found: Comparison, best: Cure) -> tuple[str, dict]:
    value = best.method.damping
    return f"D is to blame: D = {value:.3g}, of equal restitution, leaves {percent(best.left)}.", {"D": value}


def _rounded(steps: float) -> int:
    """Up to the next number of one digit."""
    digit = 10 ** np.floor(np.log10(steps))
    return int(min(np.ceil(steps / digit) * digit, MOST_STEPS))


# ------------------------------------------------------------------------------------------------------ ended early


def _ended_early(found: Comparison, cancelled) -> Verdict:
    runs = found.runs
    if not runs.reference.ok:
        message = runs.reference.message
        return Verdict(f"The reference ended early, so there is nothing to compare: {message}.", "unknown")
    when = "The penalty solution blew up, so there is nothing to compare."
    if runs.penalty.status is not Status.DIVERGED or not runs.exact.ok:
        return Verdict(f"{when} K and D are to blame: take a smaller K.", "unknown", "K")
    way, change = _enough(found, cancelled)
    text = f"{when} The time step is to blame: the same K and D without one stay bounded."
    return Verdict(f"{text} {way}", "unknown", "steps", change, details=(runs.penalty.message,))


def _enough(found: Comparison, cancelled) -> tuple[str, dict]:
    """Steps with which the run comes to its end, each tried."""
    run = found.runs.penalty
    options = {"periods": run.periods, "keep": run.keep, "cancelled": cancelled}
    for doubling in range(1, DOUBLINGS + 1):
        steps = run.method.steps * 2**doubling
        if steps > MOST_STEPS:
            break
        if simulate(run.system, run.eta, replace(run.method, steps=steps), **options).ok:
            return f"{steps:,} steps are enough for that.", {"steps": steps}
    return "Take a smaller K, or the located step.", {}


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
