"""Steady motion without the transient: Newton's method on the Poincaré map, with its exact Jacobian.

A motion of p excitation periods is a fixed point z = P(z) of the map P that carries a state from τ = 0 to τ = pT. A
short run from the start shows where the transient leads; from its end on, Newton's method converges in some steps,
where the run itself would need the more periods the weaker the damping. The Jacobian DP is exact (see
:mod:`..kernels.event_driven.tangent`), and its eigenvalues, the Floquet multipliers, tell how fast a disturbance dies
away.

An orbit is taken only if the run is caught by it (:mod:`.orbit`). Otherwise the run goes on, four times as long.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..drivers.event_driven import EventDriver
from ..methods import ExactPenalty, Reference
from ..model import System, check_eta, whole
from ..result import Checkpoint, Record, Response, Status
from ..simulate import simulate, starting_checkpoint
from .floquet import largest_first
from .orbit import Orbit, OrbitSearch
from .poincare_map import PoincareMap, displacements
from .section import repeats_after

STAGES = (8, 32, 128, 512)  # periods run until each attempt
LONG, KEEP = 2050, 50  # of the run that it falls back to, the paper's
MAX_PERIOD_LIMIT = 64


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
    start = starting_checkpoint(initial, system, eta, method)
    driver = EventDriver(system, eta, method, start, STAGES[-1], 0, None)
    search = OrbitSearch(PoincareMap(system, eta, method, cancelled), max_period, stable_only)
    for reached in STAGES:
        status, _ = driver.advance(reached, cancelled, record=True)
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


def _written_down(system, eta, method, orbit: Orbit, search: OrbitSearch, record) -> Steady:
    """The orbit as a Steady; the run begins one cycle earlier, so that open contacts have their beginning."""
    start = Checkpoint(system, eta, method, 0, tuple(search.map.start(orbit.state).tolist()))
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
    return Steady(
        periodic=True,
        message="",
        period=orbit.period,
        state=displacements(orbit.state),
        multipliers=largest_first(orbit.back.jacobian),
        residual=orbit.back.miss,
        iterations=orbit.iterations,
        periods=search.all_periods,
        response=response,
    )


def _at_most(record: Record | None, periods: int) -> Record | None:
    return record and replace(record, periods=min(record.periods, periods))


def _why_not(run: Response, search: OrbitSearch) -> str:
    if not run.ok:
        return run.ending
    period = repeats_after(run.section)
    if period > search.max_period:
        return f"the motion repeats itself after {period} periods, more than max_period = {search.max_period}"
    reason = search.rejected or f"the run does not come back near to where it was within {search.max_period} periods"
    return f"no periodic motion found: {reason}"
