"""What a comparison means, in plain English: what agrees, which number is to blame, and what to change first.

Every sentence is made from numbers that were computed: :mod:`.agreement` says what agrees, :mod:`.blame` which number
it is, and that number was changed to see (:mod:`.cures`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..result import Status
from ..simulate import simulate
from .agreement import CLOSE, agreement, scatter_of, shows
from .blame import MOST_STEPS, best_cure, blamed
from .compare import Comparison, nearest_attractor
from .cures import cures, difference
from .details import details_of, percent

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
    total, scatter = difference(found), scatter_of(found)
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
    agree, first = agreement(found, total)
    best = best_cure(found, tried, total, scatter)
    second, change = blamed(found, total, best)
    noise = f" The section's scatter (σ of ξ₂ = {scatter:.2g}) is the time step's." if shows(found, scatter) else ""
    return Verdict(
        f"{first} {second}{noise}",
        agree,
        best.name if best else "",
        change,
        best.left if best else np.nan,
        scatter,
        details_of(found, tried),
    )


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
