"""What is left of a difference when the penalty solution is another one: many runs against one reference.

Each run begins where the compared runs begin, and takes the periods that were asked for: what is left is then what a
user gets who sets the same numbers. Where steps are not skipped, a search makes short runs, which begin on the
reference's motion. What it finds is confirmed by whole runs (:meth:`Remaining.whole`). Where the reference repeats
itself what is left is the error of :class:`.error.Target`, otherwise the distance of the Poincaré sections
(:mod:`.compare`).
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.compare import SECTION, Comparison, compare_changed
from vibroscope.engine.divergence.error import SampledRuns, Target
from vibroscope.engine.divergence.grid import LONGER, PER_PERIOD
from vibroscope.engine.divergence.parts import Difference
from vibroscope.engine.drivers.threads import share_out, thread_count
from vibroscope.engine.methods import ExactPenalty, TimeStepping
from vibroscope.engine.model import DISPLACEMENTS
from vibroscope.engine.result import Checkpoint, Record
from vibroscope.engine.simulate import simulate

Penalty = ExactPenalty | TimeStepping
SEARCHED = 5000  # periods of a run of a search at most …
SEARCHED_SECTIONS = 2500  # … and where the reference does not repeat itself: there is no cycle to settle to
SHORT_TRANSIENT = 200  # periods of a short run before those that are compared


class _Plan(NamedTuple):
    """Where a run begins, and how many periods it takes."""

    start: tuple[float, ...]
    periods: int


class Remaining:
    """What other penalty methods leave of a comparison's difference.

    One is asked for at a time; those that will be can be run side by side before (:meth:`run_ahead`).

    Parameters
    ----------
    comparison : Comparison
        With ``parts``.
    cancelled : callable, optional
        Polled in the calling thread; when it returns true, `Cancelled` is raised.
    threads : int, optional
        That run side by side; by default one for each core.

    Attributes
    ----------
    method : TimeStepping
        Of the comparison.
    quick : bool
        Whether a whole run takes milliseconds, so that neighbours of what is proposed have whole runs, too.
    skips : bool
        Whether steps are skipped, so that many of them take hardly longer.
    """

    def __init__(self, comparison: Comparison, cancelled: Poll | None = None, threads: int | None = None) -> None:
        run = comparison.runs.penalty
        self._system, self._eta, self.method = run.system, run.eta, run.method
        self._cancelled = cancelled
        self._comparison = comparison
        period = comparison.motions.reference.period
        self._target = Target(comparison.runs.reference, period) if period else None
        self._keep = run.keep if period else SECTION
        self._threads = thread_count(threads)
        self._runs = SampledRuns(run.system, run.eta)
        asked = max(comparison.question.periods, self._keep)
        self.quick = self._runs.is_skipped(run.method)
        periods = run.periods if self.quick and period else min(run.periods, LONGER[0] * asked)
        self._settled = _Plan(comparison.question.start, periods)
        most = SEARCHED if period else SEARCHED_SECTIONS
        searched = min(self._settled.periods, max(most, self._keep))
        self._search = self._settled._replace(periods=searched)
        self.skips = run.method.skips_steps
        if not self.skips:
            self._search = _Plan(tuple(comparison.runs.reference.section[-1].tolist()), SHORT_TRANSIENT + self._keep)
        self._known: dict[tuple[Penalty, _Plan], float] = {}

    def __call__(self, method: Penalty) -> float:
        """What is left with a method, relative to the reference, in a search; inf if its run ends early."""
        return self._left(method, self._search)

    def whole(self, method: Penalty) -> float:
        """The same after the periods in which the compared motions settled.

        After fewer where runs take long, and where the reference does not repeat itself.
        """
        return self._left(method, self._settled)

    def compared(self, method: TimeStepping) -> Difference | None:
        """The difference that a comparison with a method has, settled anew; None if a run ends early."""
        return compare_changed(self._comparison, method, self._cancelled)

    def run_ahead(self, methods: Iterable[Penalty], whole: bool = False) -> None:
        """Make the runs with several methods side by side, so that what they leave is known when it is asked for."""
        plan = self._settled if whole else self._search
        new = [each for each in dict.fromkeys(methods) if (each, plan) not in self._known]
        left = np.zeros(len(new))

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            for place in range(*places):
                left[place] = self._measure(new[place], plan, lambda: signals[0] != 0)
                signals[slot] += 1

        if new:
            how = {"threads": self._threads, "cancelled": self._cancelled}
            share_out(np.arange(1, len(new) + 1), lambda: run, **how, grain=1)
        self._known |= {(method, plan): value for method, value in zip(new, left.tolist(), strict=True)}

    def _left(self, method: Penalty, plan: _Plan) -> float:
        if (method, plan) not in self._known:
            self._known[method, plan] = self._measure(method, plan, self._cancelled)
        return self._known[method, plan]

    def without_joint_damping(self) -> float:
        """What is left if the reference has the joint damping that the penalty model tends to."""
        derived, penalty = self._comparison.runs.derived, self._comparison.runs.penalty
        if self._target:
            target = Target(derived) if derived.ok else None
            return target.error(penalty, self._cancelled) if target and target.periodic else np.inf
        return self._comparison.statistics.without_joint_damping

    def _measure(self, method: Penalty, plan: _Plan, cancelled: Poll | None) -> float:
        """Run a method, in any thread, and return what it leaves; inf if the run ends early."""
        if self._target is None:
            start = Checkpoint(self._system, self._eta, method, 0, plan.start)
            options = {"periods": plan.periods, "keep": SECTION, "initial": start, "cancelled": cancelled}
            run = simulate(self._system, self._eta, method, **options)
            return self._comparison.statistics.total_of(run.section[:, DISPLACEMENTS]) if run.ok else np.inf
        record = Record(self._keep, PER_PERIOD, method.steps or None)
        return self._runs.error(self._target, method, *plan, record, cancelled)[0]
