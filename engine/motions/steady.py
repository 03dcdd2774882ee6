"""Steady periodic motion by Newton's method on the Poincaré map, with its exact Jacobian.

A motion of period pT is a fixed point y* = P(y*) of the map P that carries a state from τ = 0 to τ = pT. A short run
from the start shows where the transient leads. From its end, Newton's method converges in a few steps, where the run
alone would need the more periods the weaker the damping is. The Jacobian DP is exact
(:mod:`..kernels.event_driven.saltation`). Its eigenvalues, the Floquet multipliers, are the factors by which small
disturbances change in each cycle.

An orbit is accepted only if the run converges to it. Otherwise the run continues to four times as many periods, and the
search starts again. With a contact law that has no closed form a period takes some tens of times as long: the search
ends earlier there, and the message says after how many periods.

Newton's method also finds unstable orbits, and orbits that the run does not approach. So an orbit y* is accepted only
if the run is seen to converge to it: let DP be the Jacobian at y* and |·| a norm in which DP shrinks every vector at
least by a factor ψ < 1. A state y whose image differs from the linear prediction by at most

    |P(y) − y* − DP (y − y*)| ≤ ½ (1 − ψ) |y − y*|                                               (47)

has an image that is closer to y* than y itself, by the factor ½ (1 + ψ) at least. The left-hand side is of second order
in y − y* as long as the events occur in the same sequence, so that from there on the condition keeps holding. The
sequence and the condition are checked cycle by cycle until the distance has fallen to a thirtieth. (An orbit with a
basin of attraction smaller than that would be accepted wrongly.)
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll, whole
from vibroscope.engine.drivers.event_driven import EventDriver
from vibroscope.engine.drivers.law_driven import LawDriver, by_steps, needs_law
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.poincare_map import (
    PoincareMap,
    Return,
    eigenvalues_by_modulus,
    fate_of_disturbances,
    is_stable,
)
from vibroscope.engine.motions.tolerances import (
    APPROACHED,
    LONGEST_NEWTON_STEP,
    NEAR_RETURN,
    NEARER_RETURN,
    ON_ORBIT,
    RESIDUAL,
    SMALLEST_FRACTION,
)
from vibroscope.engine.result import Checkpoint, Record, Response, Status
from vibroscope.engine.simulate import KEEP, LONG, simulate, starting_checkpoint

MOST_NEWTON_STEPS = 30
REST = None  # as a start: the static equilibrium of the system
MAX_PERIOD_LIMIT = 64


class FixedPoint(NamedTuple):
    """A fixed point of the Poincaré map over ``period`` periods."""

    period: int
    state: np.ndarray  # ξ₁, ξ₁′, g, g′
    returned: Return  # of the state, over the whole cycle
    iterations: int


def approached_orbit(
    poincare: PoincareMap, section: np.ndarray, periods: int, max_period: int, stable_only: bool
) -> FixedPoint | str:
    """The orbit that a run converges to, from its end.

    Parameters
    ----------
    poincare : PoincareMap
    section : (n, 4) ndarray
        Last rows of the run's Poincaré section.
    periods : int
        Excitation periods of the run, up to the last row.
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Accept only an orbit that the run converges to; otherwise the first one that Newton's method finds.

    Returns
    -------
    FixedPoint or str
        Its state belongs to τ ≡ 0 mod pT, τ counted from the start of the run. If no orbit is accepted, why not the
        last one; empty if none was near.
    """
    rows, size, rejection = poincare.coordinates(section), max(np.abs(section).max(), 1e-300), ""
    for period in near_returns(rows, size, max_period, NEAR_RETURN):
        orbit = fixed_point(poincare, rows[-1], period, size)
        if orbit is None:
            rejection = f"Newton's method finds no orbit of period {period} near the end of the run"
            continue
        rejection = _why_not(poincare, orbit, rows[-1], size) if stable_only else ""
        if not rejection:
            return _moved_to_cycle_start(poincare, _with_least_period(poincare, orbit, size), periods)
    return rejection


def _why_not(poincare: PoincareMap, orbit: FixedPoint, y: np.ndarray, size: float) -> str:
    """Why a run that ended at y is not seen to converge to an orbit; empty if it is, and that is stable."""
    norm = contraction(orbit)
    if norm is None:
        values = eigenvalues_by_modulus(orbit.returned.jacobian)
        return (
            f"the orbit of period {orbit.period} near the end of the run is not stable: disturbances "
            f"{fate_of_disturbances(values)}, {abs(values[0]):.4g}-fold in each cycle"
        )
    if not _converges(poincare, orbit, norm, y - orbit.state, size):
        return f"the run has not settled to the orbit of period {orbit.period} that lies near"
    return ""


def _converges(
    poincare: PoincareMap, orbit: FixedPoint, norm: "Contraction", deviation: np.ndarray, size: float
) -> bool:
    """Follow a deviation from the orbit until it has died away; False if it stops obeying the condition."""
    first = np.linalg.norm(norm.factor @ deviation)
    while np.abs(deviation).max() > ON_ORBIT * size and np.linalg.norm(norm.factor @ deviation) > APPROACHED * first:
        returned = poincare(orbit.state + deviation, orbit.period)
        if not norm.contracts(orbit, deviation, returned):
            return False
        deviation = returned.state - orbit.state
    return True


def _with_least_period(poincare: PoincareMap, orbit: FixedPoint, size: float) -> FixedPoint:
    """The same orbit with its least period: a cycle of p periods may consist of equal shorter ones."""
    for period in range(1, orbit.period):
        if orbit.period % period == 0:
            returned = poincare(orbit.state, period)
            # Near a bifurcation the point of several cycles is known less exactly than its residual says.
            if returned is not None and returned.residual <= ON_ORBIT * size:
                once = fixed_point(poincare, orbit.state, period, size)
                if once is not None:
                    return once._replace(iterations=orbit.iterations + once.iterations)
    return orbit


def _moved_to_cycle_start(poincare: PoincareMap, orbit: FixedPoint, periods: int) -> FixedPoint:
    """The orbit with its state at τ ≡ 0 mod pT instead of at the end of a run of so many periods."""
    ahead = -periods % orbit.period
    if ahead == 0:
        return orbit
    state = poincare(orbit.state, ahead).state
    return orbit._replace(state=state, returned=poincare(state, orbit.period))


def fixed_point(poincare: PoincareMap, y: np.ndarray, period: int, size: float) -> FixedPoint | None:
    """Solve P(y*) = y* for the map over ``period`` periods by Newton's method from y on; None if it finds none.

    ``size``: of the motion, of which the residual may be RESIDUAL.
    """
    returned, steps = poincare(y, period), 0
    while returned is not None and steps < MOST_NEWTON_STEPS:
        improved = _newton_step(poincare, y, returned, period, size)
        if improved is None:  # limited by rounding, or there is no orbit nearby
            break
        y, returned = improved
        steps += 1
    found = returned is not None and returned.residual <= RESIDUAL * size
    return FixedPoint(period, y, returned, steps) if found else None


def _newton_step(poincare: PoincareMap, y: np.ndarray, returned: Return, period: int, size: float):
    """One step, halved until it reduces the residual: events may appear and disappear along the way."""
    if returned.residual == 0.0:
        return None
    try:
        full = np.linalg.solve(np.eye(4) - returned.jacobian, returned.state - y)
    except np.linalg.LinAlgError:
        return None
    fraction = 1.0
    while fraction >= SMALLEST_FRACTION:
        tried = y + fraction * full
        near = np.abs(tried).max() <= LONGEST_NEWTON_STEP * size
        there = _image(poincare, tried, period, returned.residual) if near else None
        if there is not None and there.residual < returned.residual:
            return tried, there
        if returned.residual <= RESIDUAL * size:  # rounding prevents any further reduction
            return None
        fraction /= 2
    return None


def _image(poincare: PoincareMap, y: np.ndarray, period: int, residual: float) -> Return | None:
    """The return of y; where a Jacobian takes more runs, None unless y reduces the residual."""
    if poincare.by_differences and not poincare.residual(y, period) < residual:
        return None
    return poincare(y, period)


class Contraction(NamedTuple):
    """A norm in which DP of an orbit shrinks every vector: |factor · x|, by ``rate`` = ψ at least."""

    rate: float
    factor: np.ndarray  # (4, 4)

    def contracts(self, orbit: FixedPoint, deviation: np.ndarray, returned: Return | None) -> bool:
        """Whether the condition of the module holds at a deviation from the orbit, the sequence of events included.

        ``returned``: of the orbit's state with this deviation, over the whole cycle.
        """
        if returned is None or returned.course != orbit.returned.course:
            return False
        difference = self.factor @ (returned.state - orbit.state - orbit.returned.jacobian @ deviation)
        return bool(np.linalg.norm(difference) <= 0.5 * (1 - self.rate) * np.linalg.norm(self.factor @ deviation))


def contraction(orbit: FixedPoint) -> Contraction | None:
    """The norm with ψ halfway between the largest multiplier and 1; None if the orbit is not stable."""
    values = eigenvalues_by_modulus(orbit.returned.jacobian)
    if not is_stable(values):
        return None
    rate = (1 + abs(values[0])) / 2
    return Contraction(rate, norm_factor(orbit.returned.jacobian / rate))


def near_returns(rows: np.ndarray, size: float, longest: int, within: float) -> list[int]:
    """Numbers of periods after which the last row nearly recurs, each much closer than all shorter ones.

    ``within``: the distance that counts as near, as a share of ``size``.
    """
    found, nearest = [], within * size
    for period in range(1, min(longest, len(rows) - 1) + 1):
        distance = np.abs(rows[-1] - rows[-1 - period]).max()
        if distance <= nearest:
            found.append(period)
            nearest = NEARER_RETURN * distance
    return found


def norm_factor(contraction: np.ndarray) -> np.ndarray:
    """Return F such that |F x| is a norm in which B, of spectral radius below 1, shrinks every vector x.

    FᵀF = Σ (Bᵏ)ᵀBᵏ over k = 0, 1, …, so that |F B x|² = |F x|² − |x|². The series is summed by doubling.
    """
    total, power = np.eye(4), contraction
    for _ in range(60):  # doublings of the partial sums
        total = total + power.T @ total @ power
        power = power @ power
        if np.abs(power).max() < 1e-18:
            break
    return np.linalg.cholesky(total).T


class Schedule(NamedTuple):
    """When a search looks for a cycle.

    Attributes
    ----------
    attempts : tuple of int
        Periods of a run after which Newton's method is tried.
    long : int
        Periods of the last run, after which it is tried once more.
    longest : int
        Periods of a cycle that the search for the kind of a motion looks for.
    followed : int
        Periods over which the Lyapunov exponent of a single motion is averaged, and after which a motion that does not
        repeat itself is judged: a chaotic transient may last thousands.
    judged : tuple of int
        Periods with a derivative that decide its kind; each number only if those before do not.
    confirmed : int
        Periods after which a single motion that was found chaotic is looked at again, whether it was a transient.
    """

    attempts: tuple[int, ...]
    long: int
    longest: int
    followed: int
    judged: tuple[int, ...]
    confirmed: int


CLOSED_FORM = Schedule((8, 32, 128, 512), LONG, 64, 8192, (512, 4096, 8192, 4 * 8192), 5 * 8192)
BY_STEPS = Schedule((8, 32, 128), 512, 16, 2048, (512, 2048), 5 * 2048)  # contact without a closed form


def schedule_of(method: Reference | ExactPenalty) -> Schedule:
    """Return how long the motion of a method is searched and followed."""
    return BY_STEPS if by_steps(method) else CLOSED_FORM


@dataclass(frozen=True, kw_only=True)
class Steady:
    """Outcome of :func:`steady`.

    Attributes
    ----------
    periodic : bool
        Whether a periodic motion was found.
    message : str
        Why no periodic motion was found, and what the response is instead; empty if ``periodic``.
    period : int
        p, excitation periods until the motion repeats itself; 0 if not periodic.
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod pT, with τ counted from the start of the run, in base amplitudes and units of ω₁
        times these; if not periodic, the state at the end of the long run.
    multipliers : (4,) complex ndarray
        Floquet multipliers, the factors of small disturbances over p periods, largest first; empty if not periodic.
        Two of them are zero if the reference has a permanent contact, after which gap and gap rate are zero.
    residual : float
        Largest modulus of an element of P(y*) − y*; nan if not periodic.
    iterations : int
        Steps of Newton's method that led to the orbit.
    periods : int
        Excitation periods integrated in all, with or without the Jacobian; those of ``response`` count only if not
        periodic.
    response : Response
        One cycle of the steady motion, with τ counted from one cycle before; if not periodic, the long run from the
        start.
    """

    periodic: bool
    message: str = ""
    period: int = 0
    state: np.ndarray
    multipliers: np.ndarray = field(default_factory=lambda: np.empty(0, complex))
    residual: float = np.nan
    iterations: int = 0
    periods: int
    response: Response

    def __repr__(self) -> str:
        if not self.periodic:
            return f"Steady(no periodic motion: {self.message})"
        return f"Steady(period {self.period}, {'stable' if self.stable else 'unstable'}, residual {self.residual:.1g})"

    @property
    def stable(self) -> bool:
        """Whether the motion is periodic and small disturbances die away."""
        return self.periodic and bool(is_stable(self.multipliers))


def steady(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    initial: Sequence[float] | None = REST,
    max_period: int = 8,
    stable_only: bool = True,
    record: Record | None = None,
    cancelled: Poll | None = None,
) -> Steady:
    """Find the periodic motion that a run from the start converges to.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        A closed-form solver: its map is smooth as long as the sequence of events stays the same.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Accept only an orbit that the run converges to. Otherwise the first orbit that Newton's method finds from the
        run, stable or not.
    record : Record, optional
        Ask for samples of the response, of at most the periods that it has.
    cancelled : callable, optional
        Polled many times a second; when it returns true the search is cancelled.

    Returns
    -------
    Steady
        If no periodic motion is found, with the run of 2,050 periods, the last 50 kept; of 512 periods with a contact
        law that has no closed form.

    Raises
    ------
    ValueError
        If a number is out of range, or the method has a time step: the text says what to do.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, steady
    >>> found = steady(System(), 2.76, Reference())
    >>> found.periodic, found.period, found.stable
    (True, 1, True)
    """
    if method.has_step:
        raise ValueError(f"{method} has a time step: steady motion needs a closed form, Reference or ExactPenalty")
    eta = check_eta(eta)
    max_period = whole("max_period", max_period, 1, MAX_PERIOD_LIMIT, "give the longest cycle to look for")
    start = starting_checkpoint(initial, system, eta, method)
    kind = LawDriver if needs_law(method) else EventDriver
    schedule = schedule_of(method)
    driver = kind(start, schedule.attempts[-1], 0, None)
    poincare = PoincareMap(system, eta, method, cancelled)
    sought = {"max_period": max_period, "stable_only": stable_only}
    for periods in schedule.attempts:
        status, _ = driver.advance(periods, cancelled, record=True)
        if status is not Status.OK:
            break
        orbit = approached_orbit(poincare, driver.section, periods, **sought)
        if isinstance(orbit, FixedPoint):
            return _of_orbit((system, eta, method), poincare, orbit, driver.periods, record)
    options = {"periods": schedule.long, "keep": KEEP, "initial": initial, "cancelled": cancelled}
    run = simulate(system, eta, method, record=_limited(record, KEEP), **options)
    periods = driver.periods + schedule.long
    orbit = approached_orbit(poincare, run.section, schedule.long, **sought) if run.ok else ""
    if isinstance(orbit, FixedPoint):
        return _of_orbit((system, eta, method), poincare, orbit, periods, record)
    message = _failure(run, max_period, orbit) + f"; this is the run of {schedule.long} periods, the last {KEEP} kept"
    end = run.section[-1] if len(run.section) else np.full(4, np.nan)
    return Steady(periodic=False, message=message, state=end, periods=periods + poincare.periods, response=run)


def _of_orbit(problem: tuple, poincare: PoincareMap, orbit: FixedPoint, periods: int, record: Record | None) -> Steady:
    """The result for an orbit, after runs of so many periods.

    Its response starts one cycle early, to include where open contacts began.
    """
    start = Checkpoint(*problem, 0, tuple(poincare.start(orbit.state).tolist()))
    cycles = {"periods": 2 * orbit.period, "keep": orbit.period, "record": _limited(record, orbit.period)}
    return Steady(
        periodic=True,
        period=orbit.period,
        state=poincare.displacements(orbit.state),
        multipliers=eigenvalues_by_modulus(orbit.returned.jacobian),
        residual=orbit.returned.residual,
        iterations=orbit.iterations,
        periods=periods + poincare.periods,
        response=simulate(*problem, initial=start, cancelled=poincare.cancelled, **cycles),
    )


def _limited(record: Record | None, periods: int) -> Record | None:
    """Return the record with at most so many periods."""
    return record and replace(record, periods=min(record.periods, periods))


def _failure(run: Response, max_period: int, rejection: str) -> str:
    """Why no periodic motion was found."""
    if not run.ok:
        return run.ending
    period = period_of(run.section)
    if period > max_period:
        return f"the motion repeats itself after {period} periods, more than max_period = {max_period}"
    reason = rejection or f"the run does not come back near to where it was within {max_period} periods"
    return f"no periodic motion found: {reason}"
