"""Type of a motion with the evidence for it: periodic, quasi-periodic or chaotic.

For the closed-form solvers (reference, exact penalty) the motion is

- *periodic* if Newton's method finds a cycle that the run converges to (:mod:`.steady`); the Floquet multipliers are
  those of the cycle. Otherwise the run is followed with its Jacobian (:mod:`.lyapunov`), and the motion is
- *chaotic* if the largest Lyapunov exponent is significantly positive, the section is irregular, and both halves of
  the run give the same exponent,
- *quasi-periodic* if the exponent is not significantly different from zero and averages over the section converge as
  they do for regular motion only,
- *undecided* otherwise: a transient, or a case for a longer run. A motion that settles to a cycle while it is followed
  is periodic.

A motion of Newmark's method, or of another one with a time step, is judged by its limit without one
(:mod:`.time_step_scatter`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.cells import Cells
from vibroscope.engine.drivers.law_driven import remembers
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.energy.balance import energy_balance, is_balance_known
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import (
    CellKind,
    Kind,
    Motion,
    describe,
    impulse_per_period,
    peak_force,
    sampled_periods,
)
from vibroscope.engine.motions.judge import LONGEST_SEEN, SETTLED_PERIODS, Evidence, classify, judge
from vibroscope.engine.motions.lyapunov import lyapunov
from vibroscope.engine.motions.poincare_map import (
    fate_of_disturbances,
    half_cycle_multipliers,
    lyapunov_exponent,
    multipliers,
    nearest_bifurcation,
    unresolved,
)
from vibroscope.engine.motions.section import rotation_number
from vibroscope.engine.motions.steady import REST, Steady, schedule_of, steady
from vibroscope.engine.motions.time_step_scatter import SCATTER_TRANSIENT, section_judgement
from vibroscope.engine.motions.tolerances import (
    DRIFTS,
    FOLLOWED_GROWTH,
    REPEATED_IMPACTS,
    REPEATED_IMPACTS_BY_STEPS,
    UNBALANCED,
)
from vibroscope.engine.result import Checkpoint, Record, Response
from vibroscope.engine.simulate import FARTHEST, LONG, simulate
from vibroscope.engine.wording import counted, end_text

DESCRIBED_PERIODS = SETTLED_PERIODS  # described periods of a motion that does not repeat itself
SAMPLES_PER_PERIOD, SAMPLED_PERIODS = 2000, 50  # samples per period; sampled periods
SAMPLED = Record(SAMPLED_PERIODS, SAMPLES_PER_PERIOD)  # of a motion that does not repeat itself
MOST_SAMPLES = 100_000
MOST_IMPACTS = 8  # of a cycle of a free vibration
FEWEST_PERIODS = 8  # sampled periods at least of a motion that does not repeat itself …
STORED_SAMPLES = 1_000_000  # … unless these are more samples
SAMPLES_IN_CONTACT = 60  # samples in the shortest contact of a cycle: the peak of half a sine wave to 0.04 %


def motion(
    subject: Response | System,
    eta: float | None = None,
    method: Method | None = None,
    *,
    initial: Sequence[float] | None = REST,
    cancelled: Poll | None = None,
) -> Motion:
    """Describe the kept periods of a response, or find out what the motion of a system is.

    ``motion(response)`` takes a fraction of a millisecond. It calls a motion periodic if it repeats itself within half
    of the kept periods, and undecided otherwise. ``motion(system, eta, method)`` makes the runs that decide the type:
    some milliseconds for a periodic motion, some tenths of a second for another one.

    Parameters
    ----------
    subject : Response or System
    eta : float
        Excitation frequency η = Ω/ω₁; with a system.
    method : Reference, ExactPenalty or TimeStepping
        With a system. If the damper of its contact law depends on the speed with which a contact closed, the section
        alone says what the motion is.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest; with a system.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is cancelled.

    Raises
    ------
    ValueError
        If a response ended early, or a number is out of range.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, Reference, System, motion
    >>> found = motion(System(), 2.76, Reference())
    >>> print(found.type, found.period)
    periodic 1
    >>> found = motion(System(), 2.76, Newmark(12000, 18, 2000))
    >>> print(found.type, found.period, found.step_noise > 0)  # the time step scatters its section
    periodic 1 True
    """
    if isinstance(subject, Response):
        if eta is not None or method is not None:
            raise ValueError("a response knows its eta and method: give them with a system only")
        if not subject.ok:
            raise ValueError(subject.ending)
        return describe(subject)
    if eta is None or method is None:
        raise ValueError("a system alone has no motion: give motion(system, eta, method), or a response")
    stepped = method.has_step
    find = _stepped_motion if stepped else _closed_form_motion
    if remembers(subject, method.limit if stepped else method):
        find = _remembering_motion
    return find(Runs(subject, eta, method, cancelled), initial)


class Runs(NamedTuple):
    """The runs by which a motion is found out, all of one system, η and method."""

    system: System
    eta: float
    method: Method
    cancelled: Poll | None

    def run(self, periods: int, initial: Sequence[float] | Checkpoint | None, **how) -> Response:
        """A run that keeps its last DESCRIBED_PERIODS; other keywords as of :func:`engine.simulate`."""
        how = {"keep": DESCRIBED_PERIODS, "cancelled": self.cancelled} | how
        return simulate(self.system, self.eta, self.method, periods=periods, initial=initial, **how)

    def steady(self, initial: Sequence[float] | None) -> Steady:
        """The cycle that a run from a start tends to (:func:`.steady.steady`), of the lengths that are looked for."""
        how = {"max_period": schedule_of(self.method).longest, "cancelled": self.cancelled}
        return steady(self.system, self.eta, self.method, initial=initial, **how)

    def judged(self, run: Response) -> Evidence:
        """By what the judge of many cells decides on a run that keeps its last DESCRIBED_PERIODS."""
        evidence, cells = Evidence(), Cells(self.system, [self.eta], self.method)
        judge(cells, run.section[None], evidence=evidence, threads=1, cancelled=self.cancelled)
        return evidence

    def multipliers(self, state: np.ndarray, period: int) -> np.ndarray:
        """The Floquet multipliers of a cycle through a state."""
        return multipliers(self.system, self.eta, self.method, state, period, self.cancelled)

    def with_multipliers(self, described: Motion, values: np.ndarray, limit: Motion | None = None) -> Motion:
        """Add the Floquet multipliers of a cycle, or of the limit of one that its steps scatter, and what follows."""
        cycle, halves = limit or described, ()
        if cycle.symmetric:
            state = cycle.section[-cycle.period]
            halves = half_cycle_multipliers(self.system, self.eta, self.method, state, cycle.period, self.cancelled)
        name, margin = nearest_bifurcation(values, described.closing_speeds, described.approach, halves)
        rate = lyapunov_exponent(values, described.period)
        return replace(
            described, multipliers=values, lyapunov=rate, lyapunov_error=0.0, bifurcation=name, margin=margin
        )


# ------------------------------------------------------------------------------------------------- closed-form solvers


def _closed_form_motion(runs: Runs, initial) -> Motion:
    system, cancelled = runs.system, runs.cancelled
    if reason := unresolved(system):
        run = runs.run(LONG, initial)
        return replace(describe(run, 0), type=Kind.UNDECIDED, reason=reason) if run.ok else describe(run)
    found = runs.steady(initial)
    run = found.response
    if found.periodic:
        return _periodic_motion(run, found.period, found.multipliers, cancelled)
    if not run.ok:
        return describe(run)
    state = run.section[-1]
    if reason := _why_unbounded(run):
        return replace(describe(run, 0), type=Kind.UNDECIDED, reason=reason, near_period=0)
    if not system.excitation.drives and (run.section == state).all() and not (state[[1, 3]].any() or len(run.impacts)):
        return _periodic_motion(runs.run(2, state, keep=1), 1, runs.multipliers(state, 1), cancelled)  # nothing moves
    if not system.excitation.drives and (own := own_period(run)) == own:
        return _free_motion(runs.run(DESCRIBED_PERIODS, state), own, cancelled)
    long = schedule_of(runs.method).long
    run = runs.run(long, initial)
    return _judged_motion(runs, run.section[-1], runs.judged(run), long)


def _judged_motion(runs: Runs, state: np.ndarray, evidence: Evidence, periods: int) -> Motion:
    """Describe a motion without a time step by what the judge found from a state on, after a run of so many periods."""
    system, eta, method, cancelled = runs
    kind, followed = evidence.kind, evidence.followed
    if kind["kind"] == CellKind.PERIODIC:
        cycle = _late_cycle(runs, evidence.section, int(kind["kind_period"]))
        return replace(cycle, reason=cycle.reason + f"; a run of {periods} periods did not find it")
    if kind["lyapunov"] == -np.inf:
        run = runs.run(DESCRIBED_PERIODS, evidence.section[-1], record=SAMPLED)
        none = f"no cycle of up to {LONGEST_SEEN} periods is found"
        if followed.growth > FOLLOWED_GROWTH:
            grows = f"e^{followed.growth:.0f}-fold within {counted(len(followed.section), 'period')}"
            none = f"until then it grows {grows}: rounding decides after which period the motion repeats itself"
        reason = f"contacts that stick leave nothing of a disturbance, and {none}"
        described = _with_energy(describe(run, 0), run, cancelled)
        return replace(described, reason=reason, lyapunov=-np.inf, lyapunov_error=0.0)
    if np.isnan(kind["lyapunov"]):
        reason = f"after {len(followed.section)} periods more it has no derivative: an impact grazes"
        return replace(describe(runs.run(DESCRIBED_PERIODS, state), 0), reason=reason)
    if kind["kind"] != CellKind.UNDECIDED:  # the exponent over more periods, where they show the same kind
        more = schedule_of(method).followed
        longer = lyapunov(system, eta, method, initial=state, periods=more, cancelled=cancelled)
        followed = longer if classify(longer)[0] is classify(followed)[0] else followed
    (kind, reason), state = classify(followed), followed.section[-1]
    run = runs.run(DESCRIBED_PERIODS, state, record=SAMPLED)
    return replace(
        _with_energy(describe(run, 0), run, cancelled),
        type=kind,
        reason=reason,
        lyapunov=followed.exponent,
        lyapunov_error=followed.error,
        rotation=rotation_number(followed.section) if kind is Kind.QUASI_PERIODIC else np.nan,
    )


def _remembering_motion(runs: Runs, initial) -> Motion:
    """Describe a run of a law whose section does not say all of the state: its period alone, no multipliers."""
    run = runs.run(LONG, initial)
    return _with_samples(describe(run), run, runs.cancelled) if run.ok else describe(run)


def _late_cycle(runs: Runs, section: np.ndarray, period: int) -> Motion:
    """Return the cycle that the motion settled to while it was judged: its transient was long, or the cycle is."""
    state = section[-1]
    found = runs.steady(state)
    if found.periodic:
        return _periodic_motion(found.response, found.period, found.multipliers, runs.cancelled)
    values = runs.multipliers(state, period)
    return _periodic_motion(runs.run(2 * period, state, keep=period), period, values, runs.cancelled)


def _why_unbounded(run: Response) -> str:
    """Why a motion does not come back to where it was; empty if it may."""
    if flies_off(run):
        return "nothing pulls the bodies back: they part, and do not meet again"
    if period := moves_on(run):
        repeats = f"while their gap repeats itself after {counted(period, 'period')}"
        return f"no spring holds the bodies: both move on, {repeats}"
    if np.abs(run.section[-1]).max() <= FARTHEST:
        return ""
    if any(run.system.free_pulls) and not run.system.held_pull:
        return (
            f"no spring bears the constant forces: the bodies have moved on by more than {end_text(FARTHEST)} lengths"
        )
    return f"it has grown to more than {end_text(FARTHEST)} base amplitudes: nothing takes the energy that is put in"


def flies_off(run: Response) -> bool:
    """Whether a body without a spring leaves: no stop is ahead, and the gap grows by no less in each kept period."""
    system = run.system
    is_held = system.spring1 and (system.wall or system.kappa)
    if is_held or system.two_stops or len(run.impacts) or len(run.contacts):
        return False
    return _grows(system.gap(run.section[:, 0], run.section[:, 2]))


def moves_on(run: Response) -> int:
    """The periods after which the gap of two bodies without springs repeats itself while they move away; 0 if not so.

    Their common centre moves by no less in each kept period.
    """
    system = run.system
    if system.wall or system.spring1 or system.kappa:
        return 0
    x1, v1, x2, v2 = run.section.T
    centre = x1 + system.mass_share * (x2 - x1)
    moved = np.abs(np.diff(centre)).max(initial=0.0) > DRIFTS * np.abs(run.section).max()  # by more than rounding
    if not moved or not (_grows(centre) or _grows(-centre)):
        return 0
    gap, none = system.gap(x1, x2), np.zeros(len(x1))
    return period_of(np.column_stack([gap, v2 - v1, none, none]))


def _grows(values: np.ndarray) -> bool:
    """Whether a number grows by no less in each period, but for rounding."""
    growth = np.diff(values)
    return len(growth) > 1 and growth.min() > 0.0 and bool((np.diff(growth) > -DRIFTS * growth.max()).all())


def _periodic_motion(once: Response, period: int, values: np.ndarray, cancelled) -> Motion:
    """Describe a cycle by two turns of it.

    Parameters
    ----------
    once : Response
        Its kept periods begin with the cycle.
    values : ndarray
        Floquet multipliers.
    """
    record = Record(period, _samples_per_period(once))
    start, twice = once.checkpoint, {"periods": 2 * period, "keep": 2 * period}
    run = simulate(once.system, once.eta, once.method, initial=start, record=record, cancelled=cancelled, **twice)
    described = _with_energy(describe(run, period), run, cancelled)
    fate = fate_of_disturbances(values)
    reason = f"a cycle of {counted(period, 'period')} closes, and disturbances of it {fate}"
    if not once.system.excitation.drives:
        reason = f"nothing drives the bodies: their free vibration has come to rest, and disturbances {fate}"
    described = replace(described, reason=reason, section=run.section[-period:])
    return Runs(once.system, once.eta, once.method, cancelled).with_multipliers(described, values)


def _free_motion(run: Response, own: float, cancelled) -> Motion:
    """A free vibration that repeats itself after a period of its own."""
    times = f"{own / run.period:.6g} times the period 2 pi/eta, which eta alone sets"
    reason = (
        f"nothing that changes with time acts, and nothing takes energy: the impacts repeat themselves after {times}"
    )
    return replace(_with_samples(describe(run, 0), run, cancelled), type=Kind.PERIODIC, reason=reason, own_period=own)


def _samples_per_period(run: Response) -> int:
    """Samples per period with which the shortest contact has enough of them to show the peak of its force."""
    shortest = np.diff(run.contacts, axis=1).min(initial=run.period)
    return int(
        np.clip(SAMPLES_IN_CONTACT * run.period / shortest, SAMPLES_PER_PERIOD, MOST_SAMPLES // max(run.keep, 1))
    )


def _with_energy(described: Motion, run: Response, cancelled) -> Motion:
    """Add the energy lost per period, averaged over whole cycles or all periods, and what the time step creates."""
    if run.trajectory is None or not is_balance_known(run):
        return described
    balance = energy_balance(run, cancelled=cancelled)
    # the balance follows located steps in closed form; coarse steps deviate from it, and the balance does not close
    if run.method.located and not np.abs(balance.residual).max() <= UNBALANCED * balance.size:
        return described
    cycle = described.period or 1
    balanced = len(balance.lost) // cycle * cycle  # periods: whole cycles
    lost, created = (float(each[-balanced:].mean()) for each in (balance.lost, balance.residual))
    stepped = run.method.has_step
    return replace(described, energy_lost=lost, energy_created=created if stepped else np.nan)


# --------------------------------------------------------------------------------------------- methods with a time step


def _with_samples(described: Motion, run: Response, cancelled) -> Motion:
    """Add what needs samples: peak force, impulse and energy, over whole cycles from the first kept period on.

    Of a motion that does not repeat itself FEWEST_PERIODS are sampled at least; nothing if that takes too many steps.
    """
    per_period = run.method.steps if run.method.has_step else SAMPLES_PER_PERIOD
    cycle, most = described.period or 1, max(MOST_SAMPLES // per_period, 0 if described.period else FEWEST_PERIODS)
    periods = cycle * max(1, min(SAMPLED_PERIODS, most) // cycle)
    if run.method.located or not run.method.has_step:
        periods += cycle  # their balance begins with the second period
    if periods > run.keep or periods * per_period > STORED_SAMPLES:
        return described
    record, kept = Record(periods, per_period), {"periods": periods, "keep": periods, "initial": run.checkpoint}
    sampled = simulate(run.system, run.eta, run.method, record=record, cancelled=cancelled, **kept)
    numbers = {"peak_force": peak_force(sampled), "impulse": impulse_per_period(sampled)}
    found = replace(described, sampled=sampled_periods(sampled), **numbers)
    return _with_energy(found, sampled, cancelled)


def _stepped_motion(runs: Runs, initial) -> Motion:
    cancelled, run = runs.cancelled, runs.run(LONG, initial)
    if not run.ok:
        return describe(run)
    state = run.section[-1]
    if reason := _why_unbounded(run):
        return replace(describe(run, 0), type=Kind.UNDECIDED, reason=reason, near_period=0)
    if not runs.system.excitation.drives and (own := own_period(run)) == own:
        return _free_motion(run, own, cancelled)
    evidence = runs.judged(run)
    if evidence.starts:  # the band at first was the rest of a transient
        start, transient = evidence.starts[-1]
        run = runs.run(transient + DESCRIBED_PERIODS, start)
        state = run.section[-1]
    limit = _limit_motion(runs._replace(method=runs.method.limit), state, evidence.limit)
    late = evidence.limit.is_late and limit.type is Kind.PERIODIC
    judged = section_judgement(run, limit, evidence.judged, evidence.own_period, evidence.finer, late)
    scattered = judged.step_noise > 0
    described = describe(run, 0 if scattered else judged.period)
    described = replace(
        described,
        type=judged.type,
        reason=judged.reason,
        period=judged.period,
        near_period=described.near_period if judged.type is Kind.UNDECIDED else judged.period,
        scatter=judged.step_noise if scattered else described.scatter,
        step_noise=judged.step_noise,
        bands=judged.bands,
    )
    described = _with_samples(described, run, cancelled)
    if judged.type is not Kind.PERIODIC:
        return replace(described, lyapunov=limit.lyapunov, lyapunov_error=limit.lyapunov_error, rotation=limit.rotation)
    if scattered:
        return runs.with_multipliers(described, limit.multipliers, limit) if limit.period else described
    values = runs.multipliers(state, judged.period)
    return runs.with_multipliers(replace(described, section=described.section[-judged.period :]), values)


def _limit_motion(runs: Runs, state: np.ndarray, evidence: Evidence | None) -> Motion:
    """Describe the motion without a time step from a state on, by what the judge decided about it; else anew."""
    kind = evidence.kind["kind"] if evidence else CellKind.UNDECIDED
    if kind == CellKind.PERIODIC and not evidence.is_late:
        return _late_cycle(runs, evidence.section, int(evidence.kind["kind_period"]))
    if kind == CellKind.UNDECIDED:
        return _closed_form_motion(runs, state)
    return _judged_motion(runs, state, evidence, SCATTER_TRANSIENT + DESCRIBED_PERIODS)


def own_period(response: Response) -> float:
    """Time τ after which a free vibration repeats itself, by its impacts; nan if they do not show one.

    Nothing sets the instant at which such a motion is looked at, so that its section at τ ≡ 0 mod 2π/η says nothing: η
    is arbitrary. The motion repeats itself if its impacts do, in position and velocities.

    Parameters
    ----------
    response : Response
        Of a system that nothing drives.
    """
    found = response.impacts
    rows = np.column_stack([found.position, found.velocity_before])
    tolerance = (REPEATED_IMPACTS_BY_STEPS if response.method.has_step else REPEATED_IMPACTS) * np.abs(rows).max(
        initial=0.0
    )
    for count in range(1, min(MOST_IMPACTS, len(rows) // 2) + 1):
        times = found.time[count:] - found.time[:-count]
        if np.abs(rows[count:] - rows[:-count]).max() <= tolerance and np.ptp(times) <= tolerance:
            return float(times.mean())
    return np.nan
