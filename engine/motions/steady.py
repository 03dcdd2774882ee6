"""Steady motion without the transient: Newton's method on the Poincaré map, with its exact Jacobian.

A motion of p excitation periods is a fixed point z = P(z) of the map P that carries a state from τ = 0 to τ = pT. A
short run from the start shows where the transient leads; from its end on, Newton's method converges in some steps,
where the run itself would need the more periods the weaker the damping. The Jacobian DP is exact (see
:mod:`engine.kernels.tangent`), and its eigenvalues, the Floquet multipliers, tell how fast a disturbance dies away.

Newton's method finds unstable orbits as well, and orbits that the transient does not lead to. So an orbit z is taken
only if the run is caught by it: in a norm in which DP shrinks every vector, to γ < 1 of it at most, the return of the
last state y differs so little from what the Jacobian foretells,

    |P(y) − z − DP (y − z)| ≤ ½ (1 − γ) |y − z|,

that it comes closer to z. The difference is of second order in y − z as long as events come in the same sequence, so
that this holds from there on. Both are checked, cycle by cycle, until a thirtieth of y − z is left. Otherwise the run
goes on, four times as long. (An orbit whose basin ends still closer would deceive it.)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..drivers.closed import ClosedDriver
from ..methods import ExactPenalty, Reference
from ..model import System, check_eta, whole
from ..result import Checkpoint, Record, Response, Status
from ..simulate import beginning, simulate
from .poincare import PoincareMap, Return, coordinates, displacements
from .section import repeats_after

STAGES = (8, 32, 128, 512)  # periods run until each attempt
LONG, KEEP = 2050, 50  # of the run that it falls back to, the paper's
MAX_PERIOD_LIMIT = 64
NEAR = 0.3  # of the section's size: a return within this is worth an attempt …
NEARER = 0.5  # … if it is so much nearer than all earlier ones
STEPS = 30  # of Newton's method
SMALLEST_STEP = 2.0**-10
FARTHEST = 1e3  # sizes of the section that a step may lead away
RESIDUAL = 1e-12  # of the section's size
FOLLOWED = 0.03  # the run is followed until it is so much nearer to the orbit
CAUGHT = 1e-10  # so near to the orbit, a state is on it but for rounding
GROWTH_TERMS = 60  # doublings of the sum that makes up the norm


@dataclass(frozen=True)
class Steady:
    """Outcome of :func:`steady`.

    Attributes
    ----------
    periodic : bool
        Whether a periodic motion was found.
    message : str
        What was not found and what the response is instead; empty if ``periodic``.
    period : int
        p, excitation periods until the motion repeats itself; 0 if not periodic.
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod pT, τ counted as by the run from the start, in base amplitudes and 1/ω₁; if not
        periodic, where the long run ended.
    multipliers : (4,) complex ndarray
        Floquet multipliers, what p periods make of a small disturbance, largest first; empty if not periodic.
        A permanent contact of the reference forgets gap and rate: two of them are zero.
    residual : float
        Largest |P(z) − z| of the four numbers; nan if not periodic.
    iterations : int
        Steps of Newton's method that led to the orbit.
    periods : int
        Excitation periods run in all, each march with its Jacobian counted as one; without those of ``response`` if
        periodic, which only writes down what was found.
    response : Response
        One cycle of the steady motion, τ counted from one cycle before it; if not periodic, the long run from the
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

    @property
    def stable(self) -> bool:
        """Whether the motion is periodic and small disturbances die away."""
        return self.periodic and bool(np.abs(self.multipliers).max() < 1)


def steady(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    initial: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    max_period: int = 8,
    stable_only: bool = True,
    record: Record | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Steady:
    """Find the periodic motion that a run from the start settles to.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        A solver in closed form: its map is smooth between changes of the sequence of events.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Take only an orbit that the run is caught by. Otherwise the first that Newton's method comes to from the run,
        stable or not.
    record : Record, optional
        Ask for samples of the response, as far as it has so many periods.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is withdrawn.

    Returns
    -------
    Steady
        If nothing periodic was found, with the run of 2,050 periods, of which 50 are kept.

    Raises
    ------
    ValueError
        If a number is out of range, or the method is not in closed form: the text says what to do.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not isinstance(method, Reference | ExactPenalty):
        raise ValueError(f"{method} has a time step: steady motion wants a closed form, Reference or ExactPenalty")
    eta = check_eta(eta, system)
    if isinstance(initial, Checkpoint):
        raise ValueError("steady motion is looked for from τ = 0: start from a state of four numbers, not a checkpoint")
    max_period = whole("max_period", max_period, 1, MAX_PERIOD_LIMIT, "give the longest cycle to look for")
    driver = ClosedDriver(system, eta, method, beginning(initial, system, eta, method), STAGES[-1], 0, None)
    search = _Search(PoincareMap(system, eta, method, cancelled), max_period, stable_only)
    for reached in STAGES:
        status, _ = driver.advance(reached, cancelled, kept=True)
        search.periods = driver.periods
        if status is not Status.OK:
            break
        found = search.attempt(driver.section, reached)
        if found is not None:
            return _written_down(system, eta, method, found, search, record)
    options = {"periods": LONG, "keep": KEEP, "initial": initial, "cancelled": cancelled}
    run = simulate(system, eta, method, record=_at_most(record, KEEP), **options)
    search.periods += LONG
    found = search.attempt(run.section, LONG) if run.ok else None
    if found is not None:
        return _written_down(system, eta, method, found, search, record)
    message = f"{_why_not(run, search)}; this is the run of {LONG} periods, the last {KEEP} kept"
    end = run.section[-1] if len(run.section) else np.full(4, np.nan)
    return Steady(False, message, 0, end, np.empty(0, complex), np.nan, 0, search.all_periods, run)


class _Orbit(NamedTuple):
    """A fixed point of the map over ``period`` periods."""

    period: int
    state: np.ndarray
    back: Return
    iterations: int


class _Search:
    """Looks for the orbit that the end of a run is caught by."""

    def __init__(self, poincare: PoincareMap, max_period: int, stable_only: bool):
        self.map = poincare
        self.max_period = max_period
        self.stable_only = stable_only
        self.periods = 0  # of the runs
        self.rejected = ""  # why the last orbit was

    @property
    def all_periods(self) -> int:
        """Periods of the runs and of the maps."""
        return self.periods + self.map.periods

    def attempt(self, section: np.ndarray, reached: int) -> _Orbit | None:
        """From the last rows of the section of the run, which has come so many periods from its start."""
        rows = coordinates(section)
        size = max(np.abs(section).max(), 1e-300)
        self.rejected = ""
        for p in _near_returns(rows, size, self.max_period):
            orbit = self._newton(rows[-1], p, size)
            if orbit is not None and self._taken(orbit, rows[-1], size):
                return self._in_step(self._shortest(orbit, size), reached)
        return None

    def _newton(self, y: np.ndarray, p: int, size: float) -> _Orbit | None:
        back, steps = self.map(y, p), 0
        while back is not None and steps < STEPS:
            further = self._step(y, back, p, size)
            if further is None:  # rounding, or no orbit near
                break
            y, back = further
            steps += 1
        if back is None or back.miss > RESIDUAL * size:
            self.rejected = f"Newton's method finds no orbit of period {p} near the end of the run"
            return None
        return _Orbit(p, y, back, steps)

    def _step(self, y, back, p, size):
        """One step, shortened until it brings y nearer to its return: events may come and go on the way."""
        if back.miss == 0.0:
            return None
        try:
            full = np.linalg.solve(np.eye(4) - back.jacobian, back.state - y)
        except np.linalg.LinAlgError:
            return None
        share = 1.0
        while share >= SMALLEST_STEP:
            tried = y + share * full
            there = self.map(tried, p) if np.abs(tried).max() <= FARTHEST * size else None
            if there is not None and there.miss < back.miss:
                return tried, there
            if back.miss <= RESIDUAL * size:  # as near as rounding lets it
                return None
            share /= 2
        return None

    def _taken(self, orbit: _Orbit, y: np.ndarray, size: float) -> bool:
        """Whether the run that ended at y goes on to the orbit."""
        if not self.stable_only:
            return True
        jacobian = orbit.back.jacobian
        largest = np.abs(np.linalg.eigvals(jacobian)).max()
        if not largest < 1 - 1e-9:
            self.rejected = f"the orbit of period {orbit.period} near the end of the run is unstable: it grows "
            self.rejected += f"{largest:.4g}-fold in each cycle"
            return False
        shrinks = (1 + largest) / 2
        factor = _norm(jacobian / shrinks)
        away, farthest = y - orbit.state, np.linalg.norm(factor @ (y - orbit.state))
        while np.abs(away).max() > CAUGHT * size and np.linalg.norm(factor @ away) > FOLLOWED * farthest:
            back = self.map(orbit.state + away, orbit.period)
            foretold, here = jacobian @ away, np.linalg.norm(factor @ away)
            if back is None or back.course != orbit.back.course:
                break
            away = back.state - orbit.state
            if np.linalg.norm(factor @ (away - foretold)) > 0.5 * (1 - shrinks) * here:
                break
        else:
            return True
        self.rejected = f"the run has not settled to the orbit of period {orbit.period} that lies near"
        return False

    def _shortest(self, orbit: _Orbit, size: float) -> _Orbit:
        """The same with the least number of periods: two equal cycles are one."""
        for p in range(1, orbit.period):
            if orbit.period % p == 0:
                back = self.map(orbit.state, p)
                if back is not None and back.miss <= RESIDUAL * size:
                    once = self._newton(orbit.state, p, size)  # what is left after two cycles may be more after one
                    return once._replace(iterations=orbit.iterations + once.iterations)
        return orbit

    def _in_step(self, orbit: _Orbit, reached: int) -> _Orbit:
        """The same, its state not that at the end of the run but at τ ≡ 0 mod pT."""
        ahead = -reached % orbit.period
        if ahead == 0:
            return orbit
        state = self.map(orbit.state, ahead).state
        return orbit._replace(state=state, back=self.map(state, orbit.period))


def _near_returns(rows: np.ndarray, size: float, longest: int) -> list[int]:
    """Numbers of periods after which the last row nearly recurs, each much nearer than all before."""
    found, nearest = [], NEAR * size
    for p in range(1, min(longest, len(rows) - 1) + 1):
        distance = np.abs(rows[-1] - rows[-1 - p]).max()
        if distance <= nearest:
            found.append(p)
            nearest = NEARER * distance
    return found


def _norm(shrinking: np.ndarray) -> np.ndarray:
    """F, so that |F x| is a norm in which x shrinks: FᵀF = Σ (Bᵏ)ᵀBᵏ, B the matrix; summed by doubling."""
    total, power = np.eye(4), shrinking
    for _ in range(GROWTH_TERMS):
        total = total + power.T @ total @ power
        power = power @ power
        if np.abs(power).max() < 1e-18:
            break
    return np.linalg.cholesky(total).T


def _written_down(system, eta, method, orbit: _Orbit, search: _Search, record) -> Steady:
    """The orbit as a Steady; the run begins one cycle earlier, so that open contacts have their beginning."""
    *numbers, touch = search.map.start(orbit.state)
    start = Checkpoint(system, eta, method, 0, (*numbers, *touch))
    response = simulate(
        system,
        eta,
        method,
        periods=2 * orbit.period,
        keep=orbit.period,
        initial=start,
        record=_at_most(record, orbit.period),
        cancelled=search.map.cancelled,
    )
    multipliers = np.linalg.eigvals(orbit.back.jacobian).astype(complex)
    return Steady(
        periodic=True,
        message="",
        period=orbit.period,
        state=displacements(orbit.state),
        multipliers=multipliers[np.argsort(-np.abs(multipliers), kind="stable")],
        residual=orbit.back.miss,
        iterations=orbit.iterations,
        periods=search.all_periods,
        response=response,
    )


def _at_most(record: Record | None, periods: int) -> Record | None:
    return record and replace(record, periods=min(record.periods, periods))


def _why_not(run: Response, search: _Search) -> str:
    if not run.ok:
        return f"the run ended as {run.status}: {run.message}"
    period = repeats_after(run.section)
    if period > search.max_period:
        return f"the motion repeats itself after {period} periods, more than max_period = {search.max_period}"
    reason = search.rejected or f"the run does not come back near to where it was within {search.max_period} periods"
    return f"no periodic motion found: {reason}"
