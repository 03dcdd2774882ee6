"""One run of one solver: validate, call its driver, return a Response."""

import math
from collections.abc import Sequence
from dataclasses import replace

from vibroscope.engine.arguments import Poll, require, shown, whole
from vibroscope.engine.drivers.base import Driver
from vibroscope.engine.drivers.event_driven import EventDriver
from vibroscope.engine.drivers.law_driven import LawDriver, needs_law
from vibroscope.engine.drivers.located import LocatedDriver
from vibroscope.engine.drivers.newmark import NewmarkDriver, takes_own_loop
from vibroscope.engine.drivers.time_stepping import TimeSteppingDriver
from vibroscope.engine.load import Load, refuse_period
from vibroscope.engine.methods import Method, Reference
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.result import Checkpoint, Record, Response, Status

FARTHEST = 1e6  # units of length, base amplitudes in the paper's: no run can start farther away
PERIODS_LIMIT = 100_000_000
KEEP_LIMIT = 1_000_000
LONG, KEEP = 2050, 50  # periods of a long run, and the last of them that are kept: the paper's
FREE_PERIODS = 2  # that are kept where nothing drives the bodies: a free vibration decays
LONGEST_FLIGHT = 512  # periods of a free vibration in which its first contact is looked for
SAMPLES_LIMIT = 20_000_000
STEPS_LIMIT = 10**13


def simulate(
    system: System,
    eta: float,
    method: Method,
    *,
    periods: int = LONG,
    keep: int = KEEP,
    initial: Sequence[float] | Checkpoint | None = None,
    record: Record | None = None,
    cancelled: Poll | None = None,
) -> Response:
    """Run one solver and keep the last periods.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference, ExactPenalty or TimeStepping
    periods : int
        Excitation periods to run, the transient included.
    keep : int
        Last periods to keep; the transient before them leaves nothing behind.
    initial : (4,) sequence or Checkpoint
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest, the static equilibrium (:attr:`System.rest`); or the checkpoint of
        an earlier response of the same system, η and method, from which the run goes on bit for bit, τ counting on from
        the start of that run.
    record : Record, optional
        Ask for samples of the last periods.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is cancelled.

    Returns
    -------
    Response

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, Record, System, simulate
    >>> method = ExactPenalty(stiffness=12000, damping=18)
    >>> run = simulate(System(), 2.76, method, periods=500, keep=50, record=Record(periods=2, per_period=400))
    >>> print(run.status, run.section.shape, run.trajectory.displacement.shape)
    ok (50, 4) (2, 801)
    >>> further = simulate(System(), 2.76, method, periods=50, initial=run.checkpoint)  # goes on where it ended
    """
    eta = check_eta(eta)
    if system.excitation.load is not None:
        refuse_period()
    periods, keep = check_lengths(periods, keep)
    steps = periods * method.steps
    require("periods × steps", steps, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")
    if record is not None:
        record = _check_record(record, keep)
    return _run(starting_checkpoint(initial, system, eta, method), periods, keep, record, cancelled)


def _run(start: Checkpoint, periods: int, keep: int, record: Record | None, cancelled: Poll | None) -> Response:
    """Run the solver of a checkpoint from there."""
    kept_from = start.periods + periods - keep
    driver = _driver(start.method)(start, keep, kept_from, record)
    status, message = driver.advance(kept_from, cancelled, record=False)
    begun = driver.checkpoint()
    if status is Status.OK:
        status, message = driver.advance(kept_from + keep, cancelled, record=True)
    return Response(*driver.problem, periods, keep, status, message, checkpoint=begun, **driver.results())


def free_length(
    system: System, eta: float, initial: Sequence[float] | None = None, contacts: int = 2
) -> dict[str, int]:
    """``periods`` and ``keep`` of a free vibration: its first FREE_PERIODS, or those that begin with the first contact.

    Nothing sets the length of a period there, so that a drop or a throw may be any number of them away from its first
    contact, and the next one as far from that. Those of the reference are looked for in the first LONGEST_FLIGHT.

    Parameters
    ----------
    system : System
        That nothing drives.
    eta : float
        A period is 2π/η.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    contacts : int
        So many begin in these periods, if there are as many.

    Examples
    --------
    >>> from vibroscope.engine import Excitation, System, free_length
    >>> hammer = System(kappa=0.0, mu=0.15, d2=0.0, clearance=50.0, excitation=Excitation(base=0.0))
    >>> free_length(hammer, 1.0, (0.0, 0.0, 0.0, -2.0))  # thrown at the sprung body, which it meets at τ = 25
    {'periods': 5, 'keep': 2}
    """
    begun, periods = [], FREE_PERIODS
    while len(begun) < contacts and periods <= LONGEST_FLIGHT:
        try:
            run = simulate(system, eta, Reference(), periods=periods, keep=periods, initial=initial)
        except ValueError:  # a start that only a penalty solution can have: the bodies penetrate
            break
        begun = sorted(time * eta / (2 * math.pi) for time in (*run.impacts.time, *run.contacts[:, 0]))
        periods *= 4
    if not begun:
        return {"periods": FREE_PERIODS, "keep": FREE_PERIODS}
    before = math.floor(begun[0]) if begun[0] >= FREE_PERIODS else 0
    keep = max(FREE_PERIODS, math.floor(begun[:contacts][-1]) + 1 - before)
    return {"periods": before + keep, "keep": keep}


def simulate_load(
    system: System,
    method: Method,
    *,
    record: Record,
    initial: Sequence[float] | None = None,
    cancelled: Poll | None = None,
) -> Response:
    """Run one solver under a load that is no harmonic: one period, as long as the load says, with samples of all of it.

    ``method.steps`` are those of the whole run.
    """
    eta = 2 * math.pi / system.excitation.load.length
    return _run(starting_checkpoint(initial, system, eta, method), 1, 1, record, cancelled)


def under_load(system: System, load: Load, method: Method, free: float) -> tuple[System, Method]:
    """The system under a load that ends ``free`` before the run, and the method with the steps of the whole run.

    ``method.steps`` are given as those of a natural period of body 1. Raises ValueError if a number is out of range, or
    the load is a force on a wall.
    """
    if load.on == "force2" and system.wall:
        raise ValueError("the load is a force on body 2, which is a wall that nothing moves: give one on body 1")
    free = require("free", free, 0.0, 1e9, "give the time in 1/ω₁ for which the run goes on after the load")
    load = replace(load, length=load.end + free)
    if method.has_step:
        steps = math.ceil(method.steps * load.length / (2 * math.pi) * (1 - 1e-12))
        require("steps", steps, 1, min(SAMPLES_LIMIT, STEPS_LIMIT), "take fewer steps, or a shorter load")
        method = replace(method, steps=max(4, steps))
    return replace(system, excitation=replace(system.excitation, load=load)), method


def check_lengths(periods: float, keep: float) -> tuple[int, int]:
    """Periods to run and to keep, as whole numbers.

    Raises
    ------
    ValueError
        If one is none, or out of range.
    """
    periods = whole("periods", periods, 1, PERIODS_LIMIT, "give the excitation periods to run")
    return periods, whole("keep", keep, 1, min(periods, KEEP_LIMIT), "keep at least one period and at most all of them")


def _driver(method: Method) -> type[Driver]:
    if method.located:
        return LocatedDriver
    if needs_law(method):
        return LawDriver
    if not method.has_step:
        return EventDriver
    return NewmarkDriver if takes_own_loop(method) else TimeSteppingDriver


def _check_record(record: Record, keep: int) -> Record:
    periods = whole("record.periods", record.periods, 1, keep, "sample at most the kept periods")
    per_period = whole("record.per_period", record.per_period, 1, 10_000_000, "give samples per period")
    require("samples", periods * per_period, 1, SAMPLES_LIMIT, "sample fewer periods or fewer points in each")
    steps = record.steps
    if steps is not None:
        steps = whole("record.steps", steps, 1, 10_000_000, "give the steps per period of the other solver")
    return Record(periods, per_period, steps)


def starting_checkpoint(
    initial: Sequence[float] | Checkpoint | None, system: System, eta: float, method: Method
) -> Checkpoint:
    """The checkpoint from which a run begins, as :func:`simulate` takes it.

    Raises
    ------
    ValueError
        If it is not four numbers within range, or belongs to another run.
    """
    if isinstance(initial, Checkpoint):
        if (initial.system, initial.eta, initial.method) != (system, eta, method):
            raise ValueError(
                f"a checkpoint of {initial.method} at eta = {initial.eta:g} cannot start {method} at eta = {eta:g}: "
                "go on with the same system, eta and method, or start from a state of four numbers"
            )
        return initial
    if initial is None:
        return Checkpoint(system, eta, method, 0, system.rest)
    try:
        state = tuple(float(value) for value in initial)
    except (TypeError, ValueError, OverflowError):
        state = ()
    if len(state) != 4:
        raise ValueError(f"initial = {shown(initial)} is not four numbers: give ξ₁, ξ₁′, ξ₂, ξ₂′")
    for name, value in zip(("ξ₁", "ξ₁′", "ξ₂", "ξ₂′"), state, strict=True):
        require(f"initial {name}", value, -FARTHEST, FARTHEST, "start within a million units of length")
    if system.wall and any(state[2:]):
        name, value = ("ξ₂", state[2]) if state[2] else ("ξ₂′", state[3])
        raise ValueError(f"initial {name} = {value:g}: a wall does not move, give 0")
    return Checkpoint(system, eta, method, 0, state)
