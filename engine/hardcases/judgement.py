"""What became of a hard case, and whether that is as expected.

The error allowed is what double precision can attain (:mod:`.condition`); that of a constant step follows from the
order of the method.
"""

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ..energy.energy import energy
from ..methods import Newmark, Reference
from ..result import Record, Response, Status
from ..simulate import simulate
from .cases import Case, run_of, solutions
from .condition import EPSILON, MARGIN, Run, at_the_edge, attainable

BATCHES = 40  # of a long chaotic run, whose means scatter as the statistics do
SAMPLES = 400  # a period, at which penetration is looked for


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
        truth = solutions()[case.truth]
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
    if float(solutions()[case.truth]["dip"]) > EPSILON * _size_of_start(case.run):
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
