"""The three parts that add up to the difference between a penalty solution and the reference.

    Newmark(K, D, Δτ) − reference(d₃) =  [Newmark(K, D, Δτ) − exact penalty(K, D)]       time step
                                       + [exact penalty(K, D) − reference(derived d₃)]   regularisation by K and D
                                       + [reference(derived d₃) − reference(d₃)]         joint damping         (53)

Each bracket changes one thing: the time step tends to zero; then K tends to infinity at the restitution e; then the
joined pendulums have the measured damping instead of that of the two dampers. The sum telescopes, so that it holds at
every instant for any four solutions.

A motion of p > 1 periods can run in p ways that differ by whole excitation periods, all of equal right. The brackets
must not count that as a difference. So the reference and the exact penalty solution are shifted by whole periods to be
closest to Newmark's, and the reference with derived damping to be closest to the reference: each solution is aligned
with a neighbour in the chain. (Aligned with a reference of one period, the exact penalty solution of a doubled motion
would have two equally good shifts, and could end up one period off Newmark's.)

What the parts of a difference consist of: those of the regularisation by K and D, and those of the time step.

**Regularisation.** Its three parts are a finite contact time, pulling at its end, and another restitution.

A contact of damping ratio ζ has the restitution e(ζ), and would have e°(ζ) if it ended where its force vanishes and the
damper begins to pull (:mod:`engine.contact` derives both). Two more references separate three parts that add up to the
regularisation, all with derived joint damping:

    exact penalty(K, D) − reference(e) =  [exact penalty(K, D) − reference(e(ζ))]   finite contact time
                                        + [reference(e(ζ)) − reference(e°(ζ))]      pulling at the end of contact
                                        + [reference(e°(ζ)) − reference(e)]         restitution of the damper alone (57)

The last two together are the effect of a wrong restitution e(ζ) ≠ e. At equal restitution they cancel, since
D = ζ(e)√(Kμ/(1 + μ)) takes the pulling into account. The first part is also the remainder: it includes everything that
has no counterpart in an impact, such as contacts that follow each other before the first has ended, or that the springs
press together.

Other contact laws have one more reference, with the restitution that the law gives at the mean closing speed of the
impacts (:func:`engine.effective_restitution`), and two parts: the finite contact time and the wrong restitution.

**Time step.** Its two parts are the contact status of whole steps, and the integrator.

    penalty(K, D, Δτ) − exact penalty(K, D) =  [steps with their status − the same steps located]   status
                                             + the rest                                             integrator     (56)

A located step is cut where contact changes, so that it has the right status all along. The two runs of the first
bracket are those of the method itself. What remains is the error that the integrator makes with the right status: of
second order or better where the method has it, with its numerical damping. The rest is a difference, so that both add
up exactly at every instant.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.contact import damping_ratio, effective_restitution
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.grid import about_rest, relative_to, rms, run_again, samples_beside, samples_on_grid
from vibroscope.engine.facts import Choice, Statement, stated
from vibroscope.engine.law_table import restitution_of, restitution_without_pull
from vibroscope.engine.methods import CONTACT_LAWS, ExactPenalty, Reference, TimeStepping, with_located_steps
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Motion, describe
from vibroscope.engine.motions.motion import SAMPLED_PERIODS
from vibroscope.engine.result import Record, Response
from vibroscope.engine.wording import percent

T = TypeVar("T")
PART_NAMES = {"time_step": "time step", "regularisation": "K and D", "joint_damping": "joint damping"}
PARTS = tuple(PART_NAMES)
WINDOWS = 5  # parts of the kept periods that show how much of a number is chance


class PerSolution(NamedTuple, Generic[T]):
    """One value for each of the four solutions of a comparison."""

    penalty: T
    exact: T
    derived: T
    reference: T


@dataclass(frozen=True)
class DifferenceSeries:
    """The four solutions on Newmark's grid, their difference and its parts as time series.

    Attributes
    ----------
    time : (n,) ndarray
        τ of Newmark's run at the sampled instants of its kept periods.
    runs : PerSolution of (4, n) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′ of each solution; nan for one that ended early.
    shifts : PerSolution of int
        Excitation periods by which each was shifted.
    size : float
        Rms of the reference's displacements from the static equilibrium.
    periods : int
        Excitation periods in the series.
    """

    time: np.ndarray
    runs: PerSolution[np.ndarray]
    shifts: PerSolution[int]
    size: float
    periods: int

    @cached_property
    def total(self) -> np.ndarray:
        """Newmark − reference, (4, n): ξ₁, ξ₂, ξ₁′, ξ₂′; the parts have the same rows."""
        return self.runs.penalty - self.runs.reference

    @cached_property
    def time_step(self) -> np.ndarray:
        """Newmark − exact penalty."""
        return self.runs.penalty - self.runs.exact

    @cached_property
    def regularisation(self) -> np.ndarray:
        """Exact penalty − reference with derived joint damping."""
        return self.runs.exact - self.runs.derived

    @cached_property
    def joint_damping(self) -> np.ndarray:
        """Reference with derived joint damping − reference."""
        return self.runs.derived - self.runs.reference

    @cached_property
    def residual(self) -> float:
        """Largest deviation of the sum of the parts from the total, in base amplitudes (and ω₁ times these)."""
        return float(np.abs(self.time_step + self.regularisation + self.joint_damping - self.total).max())

    def relative(self, difference: np.ndarray) -> float:
        """Return the rms of the displacements in a difference, relative to ``size``.

        Relative to a reference that stays at rest a difference is infinite, unless there is none.
        """
        return relative_to(rms(difference[:2]), self.size)

    def of_windows(self) -> tuple[float, ...]:
        """Return the smallest and the largest relative rms of the total in WINDOWS parts of the periods, if so many."""
        if self.periods < WINDOWS:
            return ()
        per_period = self.total.shape[1] // self.periods
        ends = [i * self.periods // WINDOWS * per_period for i in range(WINDOWS + 1)]
        found = [self.relative(self.total[:, begin:end]) for begin, end in pairwise(ends)]
        return min(found), max(found)

    def without(self, name: str) -> float:
        """Return the relative rms of the total without one of PARTS."""
        return self.relative(self.total - getattr(self, name))


def described(run: Response) -> Motion:
    """The motion of a compared run: a free vibration has no period, so that it is shifted against no other.

    What comes to rest repeats its section, and not what led there.
    """
    return describe(run, None if run.system.excitation.drives else 0)


def difference_series(
    runs: PerSolution[Response], motions: PerSolution[Motion], per_period: int, cancelled: Poll | None = None
) -> DifferenceSeries:
    """Sample the kept periods of four runs, SAMPLED_PERIODS at most, on one grid, up to ``per_period`` times a period.

    Where nothing drives the bodies, all of them: more than SAMPLED_PERIODS have as many samples altogether. Of
    closed-form solutions that repeat themselves one cycle is sampled and repeated.

    Raises
    ------
    ValueError
        If Newmark's run ended early.
    """
    penalty = runs.penalty
    keep, steps = min(penalty.keep, SAMPLED_PERIODS), penalty.method.steps
    if not penalty.system.excitation.drives and penalty.keep > keep:
        keep, per_period = penalty.keep, max(1, per_period * keep // penalty.keep)
    newmark = samples_on_grid(penalty, Record(keep, per_period, steps), cancelled)

    grid = Record(1, per_period, steps)
    reference, reference_shift = samples_beside(runs.reference, motions.reference.period, newmark, grid, cancelled)
    exact, exact_shift = samples_beside(runs.exact, motions.exact.period, newmark, grid, cancelled)
    derived, derived_shift = samples_beside(runs.derived, motions.derived.period, reference, grid, cancelled)
    instants = np.arange(keep)[:, None] + grid.phases(steps)
    return DifferenceSeries(
        time=penalty.window[0] + instants.ravel() * penalty.period,
        runs=PerSolution(*(rows.reshape(4, -1) for rows in (newmark, exact, derived, reference))),
        shifts=PerSolution(0, exact_shift, derived_shift, reference_shift),
        size=rms(about_rest(reference[:2], penalty.system)),
        periods=keep,
    )


@dataclass(frozen=True)
class Difference:
    """The difference of a penalty solution from the reference, and its parts as far as they are known.

    Attributes
    ----------
    measure : {"displacements", "sections"}
        Rms of the displacements over the kept periods, where the reference repeats itself; else the distance of the
        Poincaré sections (:mod:`.compare`).
    total : float
        Relative to the reference; nan if a solution does not reach the end of the longer runs for the sections.
    parts : dict of str to float
        The same of each of PARTS, of the joint damping only where the reference has one of its own;
        empty where the displacements are compared and not all four motions repeat themselves. They add up at each
        instant, not as numbers.
    chance : float
        The largest distance of sections that may be chance; 0 for displacements.
    law : str
        The contact law of the penalty solution.
    windows : (2,) tuple of float
        The smallest and the largest total of the WINDOWS parts of the kept periods, of a penalty solution that does
        not repeat itself in them; empty of others, and for sections.
    """

    measure: str
    total: float
    parts: dict[str, float]
    chance: float = 0.0
    law: str = CONTACT_LAWS[0]
    windows: tuple[float, ...] = ()

    def name(self, part: str) -> str | Statement:
        """Return the words for a part; of K and D with a law that is another one than the spring and the damper."""
        named = part == "regularisation" and self.law != CONTACT_LAWS[0]
        return stated("{} (law {})", PART_NAMES[part], Choice("law", (self.law,))) if named else PART_NAMES[part]

    @property
    def amount(self) -> str:
        """The total in words, "about" so much where other periods of the same motions give another number."""
        return f"about {percent(self.total)}" if self.certainty else percent(self.total)

    @property
    def certainty(self) -> str:
        """How certain the total of motions is that do not repeat themselves; empty where it is exact."""
        if self.chance and math.isfinite(self.total):
            return f"chance explains up to {percent(self.chance)}"
        low, high = map(percent, self.windows or (self.total, self.total))
        return "" if low == high else f"{low} to {high} in {WINDOWS} parts of the kept periods, which do not repeat"

    @property
    def largest(self) -> str:
        """The name of the largest part; "" where the parts are not known."""
        return max(self.parts, key=self.parts.__getitem__, default="")


def part_names(system: System, reference: Reference) -> tuple[str, ...]:
    """The names of PARTS that a difference can have: joint damping only where the reference has one of its own."""
    own = system.joint_damping(reference.joint_damping) != system.derived_joint_damping
    return tuple(name for name in PARTS if own or name != "joint_damping")


def known(values: dict[str, float]) -> dict[str, float]:
    """Only the finite ones."""
    return {name: float(value) for name, value in values.items() if np.isfinite(value)}


@dataclass(frozen=True)
class Regularisation:
    """Parts of the regularisation: finite contact time, pulling, and the restitution of the damper.

    Attributes
    ----------
    ratio : float
        ζ of the contact; nan with a law other than the spring and the damper.
    restitution, without_pull : float
        e(ζ) and e°(ζ); of another law the restitution that it gives, and nan.
    contact_time, wrong_restitution, pulling, damper : (4, n) ndarray
        The parts on the grid of :class:`.parts.DifferenceSeries`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a reference ended early.
        The wrong restitution is pulling and damper together; these are nan with another law.
    in_step : bool
        Whether the two further references repeat after as many periods as the one with e, or are free vibrations;
        otherwise the parts are hardly meaningful.
    """

    ratio: float
    restitution: float
    without_pull: float
    contact_time: np.ndarray
    wrong_restitution: np.ndarray
    pulling: np.ndarray
    damper: np.ndarray
    in_step: bool


def split_regularisation(
    series: DifferenceSeries,
    exact: ExactPenalty,
    derived: Response,
    grid: Record,
    initial: Sequence[float] | None,
    cancelled: Poll | None = None,
) -> Regularisation:
    """Split the regularisation of a comparison, by two more runs of the reference.

    Parameters
    ----------
    series : DifferenceSeries
    exact : ExactPenalty
    derived : Response
        Of the reference with derived joint damping; it is repeated with e(ζ) and e°(ζ).
    grid : Record
        Of one period of the series.
    initial : (4,) sequence, or None for rest
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of all runs.

    Raises
    ------
    ValueError
        If nothing collides, so that no closing speed says which restitution another law gives.
    """
    ratio, restitutions = _restitutions(exact, derived)
    own = series.runs.derived.reshape(4, series.periods, -1)
    rows, periods = [], {described(derived).period}
    for restitution in restitutions:
        run = _with_restitution(derived, restitution, initial, cancelled)
        period = described(run).period
        periods.add(period)
        rows.append(samples_beside(run, period, own, grid, cancelled)[0].reshape(4, -1))
    together = len(periods) == 1 and 0 not in periods
    free = not derived.system.excitation.drives and not np.isnan(rows).any()
    delivered, without_pull = rows if len(rows) == 2 else (rows[0], np.full_like(rows[0], np.nan))
    return Regularisation(
        ratio,
        restitutions[0],
        restitutions[1] if len(rows) == 2 else np.nan,
        contact_time=series.runs.exact - delivered,
        wrong_restitution=delivered - series.runs.derived,
        pulling=delivered - without_pull,
        damper=without_pull - series.runs.derived,
        in_step=together or free,
    )


def _restitutions(exact: ExactPenalty, derived: Response) -> tuple[float, tuple[float, ...]]:
    """Return ζ with e(ζ) and e°(ζ); of another law nan with the restitution that it gives."""
    if exact.linear:
        ratio = damping_ratio(derived.system, exact.stiffness, exact.damping)
        return ratio, (restitution_of(ratio), restitution_without_pull(ratio))
    speed = mean_closing_speed(derived)
    if np.isnan(speed):
        raise ValueError(f"nothing collides, so that the restitution of the law {exact.law!r} has no closing speed")
    return np.nan, (effective_restitution(derived.system, exact, speed),)


def _with_restitution(derived: Response, restitution: float, initial: Sequence[float] | None, cancelled) -> Response:
    return run_again(
        derived, system=replace(derived.system, restitution=restitution), initial=initial, cancelled=cancelled
    )


@dataclass(frozen=True)
class TimeStepParts:
    """Parts of the time step.

    Attributes
    ----------
    status, integrator : (4, n) ndarray
        On the grid of :class:`.parts.DifferenceSeries`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a run ended early.
    located : TimeStepping
        The method of the located steps.
    in_step : bool
        Whether that run repeats after as many periods as the penalty solution; otherwise the parts are hardly
        meaningful.
    """

    status: np.ndarray
    integrator: np.ndarray
    located: TimeStepping
    in_step: bool


def split_time_step(
    series: DifferenceSeries, penalty: Response, grid: Record, initial, cancelled: Poll | None = None
) -> TimeStepParts:
    """Split the time step of a comparison, by a run with located steps.

    Parameters
    ----------
    series : DifferenceSeries
    penalty : Response
    grid : Record
        Of one period of the series.
    initial : (4,) sequence, or None for rest
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of all runs.
    """
    method, run = with_located_steps(penalty.method), penalty
    if method != penalty.method:
        run = run_again(penalty, method=method, initial=initial, cancelled=cancelled)
    first, found = described(penalty), described(run)
    own = series.runs.penalty.reshape(4, series.periods, -1)
    located = own if run is penalty else samples_beside(run, found.period, own, grid, cancelled)[0]
    status = (own - located).reshape(4, -1)
    together = found.near_period == first.near_period > 0
    free = not penalty.system.excitation.drives and run.ok
    return TimeStepParts(status, series.time_step - status, method, together or free)
