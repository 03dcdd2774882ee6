"""The hard cases: runs that a solver of impacts can get wrong, each with the outcome expected of this engine.

The conditioning of a run: the error that no solver in double precision can undercut.

Every number of the data carries a relative rounding error ε_m = 2⁻⁵². A solver is as accurate as possible if its error
is not much larger than the change of the result when the data change by ε_m. This change is not measured at ε_m, where
it would include the solver's own errors, but at a larger relative change r, and scaled down: the solver's errors then
contribute at most the fraction ε_m/r. r is the largest change for which no event appears or disappears and the result
changes in proportion to r. The change per relative error is the *sensitivity*; with a rounding error for each radian of
the fastest motion, and MARGIN = 64 for what each piece of a run rounds,

    attainable error = 64 ε_m (sensitivity + accumulated rounding),        ε_m = 2⁻⁵².        (43)

In a grazing impact there is no such r: the smallest change decides whether there is an impact. A gap in error by δg
changes the speed of such an impact by at most √(2 g″ δg): only half of the digits are left.
"""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files

import numpy as np
from vibroscope import assets
from vibroscope.engine.contact import contact_frequency
from vibroscope.engine.drivers.event_driven import contact_state, displaced_state
from vibroscope.engine.hardcases.tolerances import MARGIN, PIECE, PROPORTION, ROUNDED_CHANGE, SAME_STATISTICS
from vibroscope.engine.methods import ExactPenalty, Method, Newmark, Reference
from vibroscope.engine.model import System
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.result import Response, Status
from vibroscope.engine.simulate import simulate

EPSILON = float(np.finfo(float).eps)
RELATIVE_CHANGES = tuple(10.0**-k for k in range(6, 13))

Change = Callable[["SimulationSetup", float], "SimulationSetup"]


@dataclass(frozen=True)
class SimulationSetup:
    """The arguments of a simulation that keeps all its periods."""

    system: System
    eta: float
    method: Method
    periods: int
    initial: tuple[float, float, float, float] | None = REST

    def solve(self, **options) -> Response:
        """Simulate; ``options`` are further arguments of :func:`engine.simulate`."""
        kept = {"periods": self.periods, "keep": self.periods, "initial": self.initial}
        return simulate(self.system, self.eta, self.method, **kept, **options)


def sensitivity(setup: SimulationSetup) -> float | None:
    """Return the largest change of a state of the section per relative change of the data, summed over all data.

    Returns
    -------
    float or None
        None if an event appears or disappears at the smallest change that can be measured, as in a grazing impact.
    """
    response = setup.solve()
    parts = [_sensitivity_to(response, setup, change) for change in _changes(setup)]
    return None if None in parts else sum(parts)


def attainable_error(setup: SimulationSetup) -> float | None:
    """Return the error that a solver in double precision may have; None as for :func:`sensitivity`."""
    measured = sensitivity(setup)
    return None if measured is None else MARGIN * EPSILON * (measured + accumulated_rounding(setup))


def attainable_grazing_error(setup: SimulationSetup, clear: SimulationSetup) -> float:
    """Return the same for a run with a grazing impact.

    Parameters
    ----------
    clear : SimulationSetup
        The same run, except that the pendulums pass at a small distance instead of grazing.
    """
    size = _size(clear.solve())
    acceleration = max(1.0, setup.system.kappa) ** 2 * size + setup.eta**2
    speed = np.sqrt(2 * acceleration * MARGIN * EPSILON * size)
    return float(2 * speed * max(1.0, sensitivity(clear) / size))


def accumulated_rounding(setup: SimulationSetup) -> float:
    """Return the sum of the rounding errors of the states in units of ε_m: one per PIECE of motion and contact."""
    response = setup.solve()
    angle = response.window[1] * max(1.0, setup.system.kappa, setup.eta)
    touching = float((response.contacts[:, 1] - response.contacts[:, 0]).sum())
    angle += touching * contact_frequency(setup.system, setup.method.numbers.get("K", 0.0))
    return _size(response) * (1 + angle / PIECE)


def _size(response: Response) -> float:
    """Largest number of the section; at least η, since a body at rest in space has ξ′ = η sin ητ."""
    return float(max(np.abs(response.section).max(), response.eta))


def _sensitivity_to(response: Response, setup: SimulationSetup, change: Change) -> float | None:
    """Change of the result per relative change of one number; None if it cannot be measured."""
    for relative in RELATIVE_CHANGES:
        once, twice, back = (
            _section_with_same_events(response, change(setup, factor * relative)) for factor in (1, 2, -1)
        )
        if once is None or twice is None or back is None:
            continue
        small = np.abs(once - back).max() / 2
        noise = ROUNDED_CHANGE * np.abs(response.section).max()
        if small <= noise or PROPORTION[0] <= np.abs(twice - response.section).max() / small <= PROPORTION[1]:
            return float(max(small, np.abs(once - response.section).max()) / relative)
    return None


def _section_with_same_events(response: Response, changed: SimulationSetup) -> np.ndarray | None:
    """Return the section of a changed run; None if it has more or fewer events."""
    try:
        other = changed.solve()
    except ValueError:  # the change leads out of the allowed range
        return None
    same = len(other.impacts) == len(response.impacts) and len(other.contacts) == len(response.contacts)
    return other.section if other.status == response.status and same else None


def _changes(setup: SimulationSetup) -> Iterator[Change]:
    """Yield a function for each number of the data that changes this number of a setup by a relative amount."""
    yield lambda old, r: replace(old, eta=old.eta * (1 + r))
    # κ and κ₃ matter by their distances from 1 and from each other; as frequencies they are covered by η
    yield lambda old, r: replace(old, system=_with_frequencies_apart(old.system, 1 + r))
    for name in ("d1", "d2", "d3", "clearance"):
        if getattr(setup.system, name):
            yield lambda old, r, name=name: replace(old, system=_scaled(old.system, name, 1 + r))
    if setup.method.rigid and 0 < setup.system.restitution < 1:
        yield lambda old, r: replace(old, system=_scaled(old.system, "restitution", 1 + r))
    for name, value in setup.system.excitation.numbers().items():
        if value != 0 and (name, value) != ("base", 1.0):  # with a base of 1 the lengths are counted in it
            yield lambda old, r, name=name: replace(
                old, system=replace(old.system, excitation=_scaled(old.system.excitation, name, 1 + r))
            )
    if not (setup.method.rigid or setup.method.has_step):
        for name in ("stiffness", "damping"):
            if getattr(setup.method, name) > 0:
                yield lambda old, r, name=name: replace(old, method=_scaled(old.method, name, 1 + r))
    if setup.initial is None:
        return
    for i, value in enumerate(contact_state(setup.system, setup.initial)):
        if value != 0:
            yield lambda old, r, i=i: replace(old, initial=_with_scaled_coordinate(old, i, 1 + r))


def _scaled(holder, name: str, factor: float):
    return replace(holder, **{name: getattr(holder, name) * factor})


def _with_frequencies_apart(system: System, factor: float) -> System:
    """Scale the distances of κ and κ₃ from 1, or the mass ratio where it is given."""
    if system.mu is not None:
        return replace(system, kappa=1 + (system.kappa - 1) * factor, mu=system.mu * factor)
    return replace(system, kappa=1 + (system.kappa - 1) * factor, kappa3=1 + (system.kappa3 - 1) * factor)


def _with_scaled_coordinate(setup: SimulationSetup, i: int, factor: float) -> tuple[float, ...]:
    """Scale ξ₁, ξ₁′, the gap or its rate; bodies that touch keep the gap zero."""
    y = contact_state(setup.system, setup.initial)
    y[i] *= factor
    return tuple(displaced_state(setup.system, y).tolist())


TRUTH = files(assets) / "truth"


@dataclass(frozen=True)
class HardCase:
    """One hard case.

    Attributes
    ----------
    name : str
        The group, a colon, and what is special about the case.
    setup : SimulationSetup
        What is solved.
    truth : str
        Name of its solution in hard.json or systems.json; empty if there is none.
    clear : str
        For a grazing case: the name of the same case without the graze, whose conditioning shows how errors grow.
    allowed : float or None
        Largest error that is allowed; None: what double precision can attain.
    statuses : tuple of Status
        How the run may end.
    mentions : str
        A word that the message of a run that ends early must contain.
    compared : SimulationSetup or None
        What to compare with if there is no truth: the last row of the section, or the statistics.
    kind : {"states", "statistics", "drift"}
        Whether to compare states, statistics of a chaotic motion, or states before and after very many periods.
    """

    name: str
    setup: SimulationSetup
    truth: str = ""
    clear: str = ""
    allowed: float | None = None
    statuses: tuple[Status, ...] = (Status.OK,)
    mentions: str = ""
    compared: SimulationSetup | None = None
    kind: str = "states"

    @property
    def expected(self) -> str:
        """The allowed statuses in words."""
        return " or ".join(self.statuses)


@cache
def solutions() -> dict:
    """Return the true solutions (computed with 60 and 80 digits) by name, in the form of hard.json."""
    paper, general = (json.loads((TRUTH / name).read_text(encoding="utf-8")) for name in ("hard.json", "systems.json"))
    return paper["cases"] | {entry["name"]: _as_in_hard(entry) for entry in general["cases"]}


def _as_in_hard(entry: dict) -> dict:
    """Return a solution of systems.json in the form of hard.json, and what it has besides: the conditioning."""
    numbers = {"stiffness": "K", "damping": "D", "joint_damping": "joint_damping", "threshold": "threshold"}
    method = {name: entry[key] for name, key in numbers.items() if key in entry} | {"name": entry["method"]}
    omitted = method.get("threshold", 1.0) < 1e-20  # which stands for its limit 0 in systems.json
    if omitted:
        method["threshold"] = 0.0
    samples = len(entry["tau"]) // entry["periods"]
    constants = {"mu" if name == "mass_ratio" else name: value for name, value in entry["system"].items()}
    return {
        "system": constants | entry["excitation"],
        "eta": entry["eta"],
        "method": method,
        "initial": entry["start"],
        "periods": entry["periods"],
        "states": entry["state"][samples - 1 :: samples],
        "events": entry["events"],
        "omitted": int(omitted),
        "condition": entry["condition"],
    }


def setup_of(truth: str, **changed) -> SimulationSetup:
    """Return the setup of a true solution; ``changed`` replaces attributes of the method."""
    entry = solutions()[truth]
    numbers = {name: value for name, value in (entry["method"] | changed).items() if name != "name"}
    method = (Reference if entry["method"]["name"] == "reference" else ExactPenalty)(**numbers)
    system, initial = System.from_dict(entry["system"]), tuple(entry["initial"])
    return SimulationSetup(system, entry["eta"], method, entry["periods"], initial)


def hard_cases() -> list[HardCase]:
    """Return all hard cases."""
    groups = _grazing, _chatter, _close_frequencies, _resonance, _stiffness, _time_steps
    groups += _many_periods, _endless_contact, _starts, _any_system, _chaos, _unsolvable
    return [case for group in groups for case in group()]


def _with_truth(group: str, *truths: str, **changed) -> Iterator[HardCase]:
    """Yield cases whose true solution is known."""
    for truth in truths:
        yield HardCase(f"{group}: {truth}", setup_of(truth, **changed), truth=truth)


def _grazing() -> Iterator[HardCase]:
    for law, flows in (("grazing", "abcde"), ("grazing-exact", "abc"), ("grazing-force", "ab")):
        for flow in flows:
            for dip in ("1e-14", "-1e-14", "0"):
                truth = f"{law}|{flow}|{dip}"
                yield HardCase(f"grazing: {truth}", setup_of(truth), truth=truth, clear=f"{law}|{flow}|1e-06")


def _chatter() -> Iterator[HardCase]:
    for e in ("0.0", "0.1", "0.5", "0.9", "0.99"):
        for threshold in ("0.002", "1e-06"):
            yield from _with_truth("chatter", f"chatter|{e}|{threshold}", f"chatter-pressed|{e}|{threshold}")
    limit = "chatter, limit of the threshold"
    for e in ("0.1", "0.5", "0.9", "0.99"):
        yield from _with_truth(limit, f"limit-pressed|2.76|{e}|table|1e-24", threshold=0.0)
    yield from _with_truth(limit, "limit|1.08|0.5|derived|1e-24", threshold=0.0)
    yield from _with_truth("elastic", "elastic|2.76|table", "elastic|2.76|derived", "elastic-pressed|2.76|table")


def _close_frequencies() -> Iterator[HardCase]:
    for eta in ("1.0", "2.0"):
        for law in ("table", "derived", "12000,18"):
            yield from _with_truth("κ close to 1", f"kappa|1+0.0001|{eta}|{law}", f"kappa|1+1e-07|{eta}|{law}")


def _resonance() -> Iterator[HardCase]:
    for eta in ("1.0", "2.41", "1.8"):
        for d in ("damped", "1e-9", "undamped"):
            yield from _with_truth("resonance", f"resonance|{eta}|{d}|table", f"resonance|{eta}|{d}|12000,18")
    yield from _with_truth("undamped", *(f"undamped|2.76|{law}" for law in ("e=0.5", "e=1", "100,0", "12000,0")))


def _stiffness() -> Iterator[HardCase]:
    for stiffness in ("1e+00", "1e+02", "1e+04", "1e+06", "1e+09"):
        for zeta in ("0", "0.2", "1-1e-9", "1", "1+1e-9", "5"):
            yield from _with_truth("stiffness", f"stiffness|2.76|K={stiffness}|zeta={zeta}")
    for stiffness in ("1e+00", "1e+09"):
        extreme = (f"stiffness|{eta}|K={stiffness}|D=1e6" for eta in ("2.76", "1.08"))
        yield from _with_truth("damping", *extreme)


def _time_steps() -> Iterator[HardCase]:
    """Newmark with T/20 to T/10⁶, and with steps that are far too long for the contact."""
    system, eta, stiffness, damping, periods = System(), 2.76, 12000.0, 18.0, 2
    exact = SimulationSetup(system, eta, ExactPenalty(stiffness, damping), periods)
    frequency, fastest = contact_frequency(system, stiffness), max(system.kappa, eta)
    size = 10.0  # of the motion
    for steps in (20, 200, 2000, 20_000, 1_000_000):
        h = 2 * math.pi / eta / steps
        # a contact change is detected up to one step late: the speed errs by this fraction of the contact's own speed
        late = 4 * size * frequency * h if frequency * h < 1 else math.inf
        second_order = size * (fastest * h) ** 2 * 2 * math.pi / eta * fastest * periods
        rounding = MARGIN * EPSILON * size * steps * periods
        for located, allowed in ((False, late + rounding), (True, second_order + rounding)):
            method = Newmark(stiffness, damping, steps, located=located)
            may_diverge = not located and frequency * h > 1
            statuses = (Status.OK, Status.DIVERGED) if may_diverge else (Status.OK,)
            name = f"time step: T/{steps}, {'located' if located else 'plain'}"
            setup = replace(exact, method=method)
            yield HardCase(name, setup, allowed=allowed, statuses=statuses, compared=exact)
    for stiffness, damping in ((1e9, 0.0), (1e9, 1e3), (1.0, 1e6)):
        for located in (False, True):
            method = Newmark(stiffness, damping, 20, located=located)
            how = "located" if located else "plain"
            name = f"K Δτ² ≫ 1: K = {stiffness:g}, D = {damping:g}, T/20, {how}"
            statuses = (Status.OK,) if located else (Status.OK, Status.DIVERGED)
            yield HardCase(name, SimulationSetup(system, eta, method, 500), statuses=statuses, mentions="step")
    setup = SimulationSetup(system, eta, Newmark(6e4, 1.0, 100), 500)
    yield HardCase("K Δτ² ≫ 1: blows up", setup, statuses=(Status.DIVERGED,), mentions="step")


def _many_periods() -> Iterator[HardCase]:
    for method in (Reference(), ExactPenalty(12000, 18)):
        setup = SimulationSetup(System(), 2.76, method, 1_000_000)
        yield HardCase(f"a million periods: {method.name}", setup, kind="drift")


def _endless_contact() -> Iterator[HardCase]:
    both = ("reference", "exact")
    yield from _with_truth("contact never ends", *(f"start|contact-never-ends|{law}" for law in both))
    yield from _with_truth("contact never ends", "start|never-ends|D=1e6")
    yield from _with_truth("contact never comes", *(f"start|contact-never-comes|{law}" for law in both))


def _starts() -> Iterator[HardCase]:
    names = "at-rest approaching leaving compressed pulled barely-approaching barely-leaving separated"
    for name in (*names.split(), "far-away", "slow", "fast"):
        yield from _with_truth("start", f"start|{name}|reference", f"start|{name}|exact")
    yield from _with_truth("start", "start|penetrating|exact")


def _any_system() -> Iterator[HardCase]:
    """Walls, preload, forces, weights, free vibration: from systems.json, what begins with one of these names."""
    kinds = (
        "sticking|",
        "limits|",
        "free|",
        "wall|-0.5|",
        "clearance|-3|",
        "forces|all|",
        "constants|wall 1|",
        "constants|0.5|1.5,-4|",
        "mass ratio|twins",
    )
    yield from _with_truth("any system", *(truth for truth in solutions() if truth.startswith(kinds)))


def _chaos() -> Iterator[HardCase]:
    system, periods = System(), 8000
    displaced = (1e-9, 0.0, 1e-9, 0.0)
    for name, one, other in (
        ("two starts", Reference("derived"), Reference("derived")),
        ("two thresholds", Reference("derived", 0.002), Reference("derived", 0.0)),
        ("two starts, exact penalty", ExactPenalty(12000, 18), ExactPenalty(12000, 18)),
    ):
        first = SimulationSetup(system, 1.70, one, periods)
        second = SimulationSetup(system, 1.70, other, periods, displaced)
        yield HardCase(f"chaos: {name}", first, compared=second, allowed=SAME_STATISTICS, kind="statistics")


def _unsolvable() -> Iterator[HardCase]:
    """Elastic impacts that accumulate without end: the run must end and say why."""
    pressed = (1e5, 0.0, 1e5, -1e-3)
    setup = SimulationSetup(System(restitution=1.0), 0.01, Reference(threshold=0.0), 1, pressed)
    yield HardCase("no end: elastic chatter", setup, statuses=(Status.PILED_UP,), mentions="restitution")
