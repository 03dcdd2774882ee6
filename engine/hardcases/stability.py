"""The hard cases: what a solver of impacts can get wrong, each with the outcome that is expected of this engine.

Each case is run, compared with its 60-digit solution where there is one (assets/truth/hard.json), and its energy is
balanced (:mod:`.energy`). The error allowed is what double precision can attain (:mod:`.condition`); that of a constant
step follows from the order of the method. ``vibroscope stability`` prints the outcomes, the tests run the same list.
"""

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..methods import ExactPenalty, Newmark, Reference
from ..model import System
from ..result import Record, Response, Status
from ..simulate import simulate
from .condition import EPSILON, MARGIN, Run, at_the_edge, attainable
from .energy import energy

TRUTH = Path(__file__).resolve().parents[2] / "assets" / "truth" / "hard.json"
BATCHES = 40  # of a long chaotic run, whose means scatter as the statistics do
SIGMAS = 5.0  # by which statistics of the same motion may differ: once in two million times
SAMPLES = 400  # a period, at which penetration is looked for


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes
    ----------
    name : str
        The group, a colon, and what is special about the case.
    run : Run
        What is solved.
    truth : str
        Name of its solution in hard.json; empty if there is none.
    clear : str
        Of a grazing case: the same but for the graze, whose conditioning tells how far the graze's error grows.
    allowed : float or None
        Largest error that is allowed; None: what double precision can attain.
    statuses : tuple of Status
        How the run may end.
    mentions : str
        What the message of a run that ends early must name.
    compared : Run or None
        A solution to compare with in place of the truth: the last row of the section.
    kind : {"states", "statistics", "drift"}
        Whether states, statistics of a chaotic motion, or states before and after very many periods are compared.
    """

    name: str
    run: Run
    truth: str = ""
    clear: str = ""
    allowed: float | None = None
    statuses: tuple[Status, ...] = (Status.OK,)
    mentions: str = ""
    compared: Run | None = None
    kind: str = "states"

    @property
    def expected(self) -> str:
        """In words."""
        return " or ".join(self.statuses)


@dataclass(frozen=True)
class Outcome:
    """What became of a case; NaN where there is nothing to compare or to balance.

    Attributes
    ----------
    case : Case
    status : Status
    message : str
        Why the run ended early and what to change.
    error, allowed : float
        Largest error of a state, and what is allowed; of statistics, in standard errors.
    residual, balanced : float
        Largest residual of the energy balance of a period in units of the energy, and what is allowed.
    penetration : float
        Deepest penetration of the reference, in units of the largest displacement.
    microseconds : float
        Cost of a period.
    failures : tuple of str
        What is not as expected.
    """

    case: Case
    status: Status
    message: str
    error: float
    allowed: float
    residual: float
    balanced: float
    penetration: float
    microseconds: float
    failures: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """Whether all is as expected."""
        return not self.failures


def stability(cases: Iterable[Case] | None = None, progress: Callable[[Outcome], None] | None = None) -> list[Outcome]:
    """Run the hard cases.

    Parameters
    ----------
    cases : iterable of Case, optional
        By default all of :func:`hard_cases`.
    progress : callable, optional
        Called with each outcome as it comes.

    Returns
    -------
    list of Outcome
    """
    outcomes = []
    for case in hard_cases() if cases is None else cases:
        outcomes.append(outcome(case))
        if progress is not None:
            progress(outcomes[-1])
    return outcomes


# ------------------------------------------------------------------------------------------------------ the cases


@cache
def _solutions() -> dict:
    return json.loads(TRUTH.read_text(encoding="utf-8"))["cases"]


def run_of(truth: str, **changed) -> Run:
    """The run of which hard.json has the solution; ``changed`` replaces attributes of the method."""
    entry = _solutions()[truth]
    numbers = {name: value for name, value in (entry["method"] | changed).items() if name != "name"}
    method = (Reference if entry["method"]["name"] == "reference" else ExactPenalty)(**numbers)
    return Run(System(**entry["system"]), entry["eta"], method, entry["periods"], tuple(entry["initial"]))


def hard_cases() -> list[Case]:
    """All of them."""
    groups = (_grazing, _chatter, _close, _resonance, _stiffness, _steps, _long, _endless, _starts, _chaos, _refused)
    return [case for group in groups for case in group()]


def _known(group: str, *truths: str, **changed) -> Iterable[Case]:
    """Cases of which the truth is known."""
    for truth in truths:
        yield Case(f"{group}: {truth}", run_of(truth, **changed), truth=truth)


def _grazing():
    for law, flows in (("grazing", "abcde"), ("grazing-exact", "abc"), ("grazing-force", "ab")):
        for flow in flows:
            for dip in ("1e-14", "-1e-14", "0"):
                truth = f"{law}|{flow}|{dip}"
                yield Case(f"grazing: {truth}", run_of(truth), truth=truth, clear=f"{law}|{flow}|1e-06")


def _chatter():
    for e in ("0.0", "0.1", "0.5", "0.9", "0.99"):
        for threshold in ("0.002", "1e-06"):
            yield from _known("chatter", f"chatter|{e}|{threshold}", f"chatter-pressed|{e}|{threshold}")
    for e in ("0.1", "0.5", "0.9", "0.99"):
        yield from _known("chatter, limit of the threshold", f"limit-pressed|2.76|{e}|table|1e-24", threshold=0.0)
    yield from _known("chatter, limit of the threshold", "limit|1.08|0.5|derived|1e-24", threshold=0.0)
    yield from _known("elastic", "elastic|2.76|table", "elastic|2.76|derived", "elastic-pressed|2.76|table")


def _close():
    for eta in ("1.0", "2.0"):
        for law in ("table", "derived", "12000,18"):
            yield from _known("κ close to 1", f"kappa|1+0.0001|{eta}|{law}", f"kappa|1+1e-07|{eta}|{law}")


def _resonance():
    for eta in ("1.0", "2.41", "1.8"):
        for d in ("damped", "1e-9", "undamped"):
            yield from _known("resonance", f"resonance|{eta}|{d}|table", f"resonance|{eta}|{d}|12000,18")
    yield from _known("undamped", *(f"undamped|2.76|{law}" for law in ("e=0.5", "e=1", "100,0", "12000,0")))


def _stiffness():
    for k in ("1e+00", "1e+02", "1e+04", "1e+06", "1e+09"):
        for zeta in ("0", "0.2", "1-1e-9", "1", "1+1e-9", "5"):
            yield from _known("stiffness", f"stiffness|2.76|K={k}|zeta={zeta}")
    for k in ("1e+00", "1e+09"):
        yield from _known("damping", f"stiffness|2.76|K={k}|D=1e6", f"stiffness|1.08|K={k}|D=1e6")


def _steps():
    """Newmark: T/20 to T/10⁶, and steps that are far too long for the contact."""
    system, eta, k, d, periods = System(), 2.76, 12000.0, 18.0, 2
    exact = Run(system, eta, ExactPenalty(k, d), periods)
    pole, fastest = math.sqrt(k / system.mass_share), max(system.kappa, eta)
    size = 10.0  # of the motion
    for n in (20, 200, 2000, 20_000, 1_000_000):
        h = 2 * math.pi / eta / n
        # a change of contact is missed by up to a step: the speed is off by that much of the contact's own
        missed = 4 * size * pole * h if pole * h < 1 else math.inf
        cut = size * (fastest * h) ** 2 * 2 * math.pi / eta * fastest * periods
        rounded = MARGIN * EPSILON * size * n * periods
        for located, allowed in ((False, missed + rounded), (True, cut + rounded)):
            method = Newmark(k, d, n, located=located)
            blows = (Status.OK, Status.DIVERGED) if not located and pole * h > 1 else (Status.OK,)
            name = f"time step: T/{n}, {'located' if located else 'plain'}"
            yield Case(name, replace(exact, method=method), allowed=allowed, statuses=blows, compared=exact)
    for k, d in ((1e9, 0.0), (1e9, 1e3), (1.0, 1e6)):
        for located in (False, True):
            method = Newmark(k, d, 20, located=located)
            name = f"K Δτ² ≫ 1: K = {k:g}, D = {d:g}, T/20, {'located' if located else 'plain'}"
            blows = (Status.OK,) if located else (Status.OK, Status.DIVERGED)
            yield Case(name, Run(system, eta, method, 500), statuses=blows, mentions="step")
    method = Newmark(6e4, 1.0, 100)
    yield Case("K Δτ² ≫ 1: blows up", Run(system, eta, method, 500), statuses=(Status.DIVERGED,), mentions="step")


def _long():
    for method in (Reference(), ExactPenalty(12000, 18)):
        yield Case(f"a million periods: {method.name}", Run(System(), 2.76, method, 1_000_000), kind="drift")


def _endless():
    both = ("reference", "exact")
    yield from _known("contact never ends", *(f"start|contact-never-ends|{law}" for law in both))
    yield from _known("contact never ends", "start|never-ends|D=1e6")
    yield from _known("contact never comes", *(f"start|contact-never-comes|{law}" for law in both))


def _starts():
    names = (
        "at-rest approaching leaving compressed pulled barely-approaching barely-leaving separated far-away slow fast"
    )
    for name in names.split():
        yield from _known("start", f"start|{name}|reference", f"start|{name}|exact")
    yield from _known("start", "start|penetrating|exact")


def _chaos():
    system, periods = System(), 8000
    moved = (1e-9, 0.0, 1e-9, 0.0)
    for name, one, other in (
        ("two starts", Reference("derived"), Reference("derived")),
        ("two thresholds", Reference("derived", 0.002), Reference("derived", 0.0)),
        ("two starts, exact penalty", ExactPenalty(12000, 18), ExactPenalty(12000, 18)),
    ):
        first, second = Run(system, 1.70, one, periods), Run(system, 1.70, other, periods, moved)
        yield Case(f"chaos: {name}", first, compared=second, allowed=SIGMAS, kind="statistics")


def _refused():
    """What cannot be solved says so: elastic impacts that pile up without end."""
    pressed = (1e5, 0.0, 1e5, -1e-3)
    method, system = Reference(threshold=0.0), System(restitution=1.0)
    run = Run(system, 0.01, method, 1, pressed)
    yield Case("no end: elastic chatter", run, statuses=(Status.PILED_UP,), mentions="restitution")


# ------------------------------------------------------------------------------------------------------ judgement


def outcome(case: Case) -> Outcome:
    """Run one case and judge it."""
    judge = {"states": _states, "statistics": _statistics, "drift": _drift}[case.kind]
    return judge(case)


def _judged(case: Case, response: Response, error: float, allowed: float, extra: tuple[str, ...] = ()) -> Outcome:
    """The outcome with what every case is judged by: status, message, finite numbers, energy, penetration."""
    failures = list(extra)
    if response.status not in case.statuses:
        failures.append(f"ended as {response.status}, not {case.expected}")
    if not response.ok and (not response.message or case.mentions not in response.message):
        failures.append("does not say why it ended and what to change")
    if not np.isfinite(response.section).all():
        failures.append("a number is not finite")
    if not (math.isnan(error) or error <= allowed):
        failures.append(f"error {error:.1e} is above {allowed:.1e}")
    residual, balanced = _balance(case, response)
    if residual > balanced:
        failures.append(f"energy residual {residual:.1e} is above {balanced:.1e}")
    penetration = _penetration(response)
    if penetration > 8 * EPSILON:
        failures.append(f"penetrates by {penetration:.1e}")
    cost = response.cost.seconds / max(1, response.periods) * 1e6
    return Outcome(
        case=case,
        status=response.status,
        message=response.message,
        error=error,
        allowed=allowed,
        residual=residual,
        balanced=balanced,
        penetration=penetration,
        microseconds=cost,
        failures=tuple(failures),
    )


def _balance(case: Case, response: Response) -> tuple[float, float]:
    """Residual of the closed-form solvers' energy, relative, and what rounding leaves of it."""
    if isinstance(response.method, Newmark) or not response.ok:
        return math.nan, math.nan
    kept_all = response.keep == case.run.periods
    balance = energy(response, case.run.initial if kept_all else None)
    contact = math.sqrt(getattr(response.method, "stiffness", 0.0)) + getattr(response.method, "damping", 0.0)
    radians = (1 + contact + max(1.0, response.system.kappa)) * (1 + response.period)
    return float(np.abs(balance.residual).max() / balance.size), 4 * MARGIN * EPSILON * radians


def _penetration(response: Response) -> float:
    if not isinstance(response.method, Reference) or response.trajectory is None:
        return 0.0
    x1, x2 = response.trajectory.displacement
    return float(max(0.0, (x1 - x2).max()) / max(np.abs(x1).max(), np.abs(x2).max(), 1e-300))


def _states(case: Case) -> Outcome:
    run = case.run
    record = None if isinstance(run.method, Newmark) else Record(run.periods, SAMPLES)
    response = run.solve(record=record)
    allowed = math.inf if case.allowed is None else case.allowed
    if case.truth:
        truth = _solutions()[case.truth]
        states = np.array(truth["states"], dtype=float)
        if case.allowed is None:
            allowed = _attainable(case)
        wrong = _events_wrong(case, response, truth) if allowed < math.inf else ()
        complete = len(response.section) == len(states)
        return _judged(case, response, _largest(response.section - states) if complete else math.inf, allowed, wrong)
    if case.compared is not None and response.ok:
        error = _largest(response.section[-1] - case.compared.solve().section[-1])
        return _judged(case, response, error, allowed)
    return _judged(case, response, math.nan, allowed)


def _largest(difference: np.ndarray) -> float:
    return float(np.abs(difference).max())


def _attainable(case: Case) -> float:
    """The error allowed; a dip that clears the surface grazes nothing and is as well conditioned as a higher one."""
    if not case.clear:
        found = attainable(case.run)
        return math.inf if found is None else found
    clear = run_of(case.clear)
    if float(_solutions()[case.truth]["dip"]) > EPSILON * _size_of_start(case.run):
        return attainable(clear)
    return at_the_edge(case.run, clear)


def _size_of_start(run: Run) -> float:
    return MARGIN / 8 * max(np.abs(run.initial))


def _events_wrong(case: Case, response: Response, truth: dict) -> tuple[str, ...]:
    """Events that are not those of the truth, in number; those that rounding decides are left out."""
    if case.clear and abs(float(truth["dip"])) < EPSILON * max(np.abs(case.run.initial)):
        return ()
    kinds = [kind for _, kind, _ in truth["events"]]
    if isinstance(response.method, Reference):
        impacts, contacts = kinds.count(0), kinds.count(1)
        same = truth["omitted"] > 0 or len(response.impacts) == impacts
    else:
        contacts, same = kinds.count(0), True
    if same and len(response.contacts) == contacts:
        return ()
    return ("events differ from the truth",)


def _statistics(case: Case) -> Outcome:
    """Largest difference of the two runs' statistics in units of its standard error."""
    response, other = case.run.solve(), case.compared.solve()
    (one, one_error), (two, two_error) = _means(response), _means(other)
    error = float(np.max(np.abs(one - two) / np.hypot(one_error, two_error)))
    return _judged(case, response, error, case.allowed)


def _means(response: Response) -> tuple[np.ndarray, np.ndarray]:
    """Impacts per period, contact share, mean ξ₂ and ξ₂², and ξ₂′²: means and their standard errors, from batches."""
    edges = np.linspace(*response.window, BATCHES + 1)
    rates = np.histogram(response.impacts.time, edges)[0] / (len(response.section) / BATCHES)
    inside = [np.clip(response.contacts, low, high) for low, high in pairwise(edges)]
    shares = np.array([(spans[:, 1] - spans[:, 0]).sum() for spans in inside]) / (edges[1] - edges[0])
    sections = response.section[:, 2:].reshape(BATCHES, -1, 2)
    rows = np.column_stack([rates, shares, sections[..., 0].mean(1), (sections**2).mean(1)])
    return rows.mean(0), rows.std(0, ddof=1) / math.sqrt(BATCHES) + 1e-300


def _drift(case: Case) -> Outcome:
    """Difference between the steady motion after a fiftieth of the periods and after all."""
    run, keep = case.run, 100
    early, late = (
        simulate(run.system, run.eta, run.method, periods=periods, keep=keep, record=Record(keep, SAMPLES))
        for periods in (run.periods // 50, run.periods)
    )
    # a periodic motion that attracts forgets all errors but those of its last periods; τ of the events keeps ε τ
    allowed = attainable(replace(run, periods=20))
    error = _largest(late.section - early.section)
    return _judged(case, late, error, allowed if allowed is not None else math.inf)
