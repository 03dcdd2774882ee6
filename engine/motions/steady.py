"""Steady periodic motion by Newton's method on the Poincaré map, with its exact Jacobian.

A motion of period pT is a fixed point y* = P(y*) of the map P that carries a state from τ = 0 to τ = pT. A short run
from the start shows where the transient leads. From its end, Newton's method converges in a few steps, where the run
alone would need the more periods the weaker the damping is. The Jacobian DP is exact
(:mod:`..kernels.event_driven.saltation`). Its eigenvalues, the Floquet multipliers, are the factors by which small
disturbances change in each cycle.

An orbit is accepted only if the run converges to it (:mod:`.orbit`). Otherwise the run continues to four times as many
periods, and the search starts again. With a contact law that has no closed form a period takes some tens of times as
long: the search ends earlier there, and the message says after how many periods.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.checks import whole
from vibroscope.engine.drivers.event_driven import EventDriver
from vibroscope.engine.drivers.law_driven import LawDriver, by_steps, needs_law
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.floquet import eigenvalues_by_modulus, is_stable
from vibroscope.engine.motions.orbit import FixedPoint, approached_orbit
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.result import Checkpoint, Record, Response, Status
from vibroscope.engine.simulate import KEEP, LONG, simulate, starting_checkpoint

REST = None  # as a start: the static equilibrium of the system
MAX_PERIOD_LIMIT = 64


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
    """

    attempts: tuple[int, ...]
    long: int
    longest: int
    followed: int
    judged: tuple[int, ...]


CLOSED_FORM = Schedule((8, 32, 128, 512), LONG, 64, 8192, (512, 4096, 8192, 4 * 8192))
BY_STEPS = Schedule((8, 32, 128), 512, 16, 2048, (512, 2048))  # contact without a closed form


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
    message: str
    period: int
    state: np.ndarray
    multipliers: np.ndarray
    residual: float
    iterations: int
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
    cancelled: Callable[[], bool] | None = None,
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
    driver = kind(system, eta, method, start, schedule.attempts[-1], 0, None)
    poincare, sought = (
        PoincareMap(system, eta, method, cancelled),
        {"max_period": max_period, "stable_only": stable_only},
    )
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
    return Steady(
        periodic=False,
        message=message,
        period=0,
        state=end,
        multipliers=np.empty(0, complex),
        residual=np.nan,
        iterations=0,
        periods=periods + poincare.periods,
        response=run,
    )


def _of_orbit(problem: tuple, poincare: PoincareMap, orbit: FixedPoint, periods: int, record: Record | None) -> Steady:
    """The result for an orbit, after runs of so many periods.

    Its response starts one cycle early, to include where open contacts began.
    """
    start = Checkpoint(*problem, 0, tuple(poincare.start(orbit.state).tolist()))
    cycles = {"periods": 2 * orbit.period, "keep": orbit.period, "record": _limited(record, orbit.period)}
    return Steady(
        periodic=True,
        message="",
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
