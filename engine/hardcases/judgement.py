"""Judge the outcome of a hard case: errors, events, energy and penetration against what is allowed.

The allowed error is what double precision can attain (:mod:`.cases`). That of a constant step follows from the
order of the method. ``vibroscope stability`` prints the outcomes; the tests run the same list.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.hardcases.cases import (
    EPSILON,
    HardCase,
    accumulated_rounding,
    attainable_error,
    attainable_grazing_error,
    hard_cases,
    setup_of,
    solutions,
)
from vibroscope.engine.hardcases.tolerances import MARGIN
from vibroscope.engine.motions.section import standard_error
from vibroscope.engine.result import Record, Response, Status
from vibroscope.engine.simulate import simulate

RUN_BATCHES = 40  # of a long chaotic run, whose means scatter as independent numbers do
PENETRATION_SAMPLES = 400  # per period, at which penetration is looked for
DRIFT_KEEP = 100  # periods to compare before and after very many periods


@dataclass(frozen=True)
class HardCaseOutcome:
    """Outcome of a case; numbers are nan where there is nothing to compare or to balance.

    Attributes
    ----------
    case : HardCase
    status : Status
    message : str
        Why the run ended early and what to change.
    error, allowed : float
        Largest error of a state, and what is allowed; for statistics, in standard errors.
    residual, balanced : float
        Largest residual of the energy balance of a period in units of the energy, and what is allowed.
    penetration : float
        Deepest penetration of the reference, in units of the largest displacement.
    microseconds : float
        Cost of a period.
    failures : tuple of str
        What is not as expected.
    """

    case: HardCase
    status: Status
    message: str
    error: float
    allowed: float
    residual: float
    balanced: float
    penetration: float
    microseconds: float
    failures: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether everything is as expected."""
        return not self.failures


def stability(
    cases: Iterable[HardCase] | None = None, progress: Callable[[HardCaseOutcome], None] | None = None
) -> list[HardCaseOutcome]:
    """Run the hard cases and return their outcomes.

    Parameters
    ----------
    cases : iterable of HardCase, optional
        By default all of :func:`hard_cases`.
    progress : callable, optional
        Called with each outcome in turn.

    Returns
    -------
    list of HardCaseOutcome
    """
    outcomes = []
    for case in hard_cases() if cases is None else cases:
        outcomes.append(outcome(case))
        if progress is not None:
            progress(outcomes[-1])
    return outcomes


def outcome(case: HardCase) -> HardCaseOutcome:
    """Run one case and judge it."""
    judge = {"states": _judge_states, "statistics": _judge_statistics, "drift": _judge_drift}[case.kind]
    return judge(case)


def _outcome(
    case: HardCase, response: Response, error: float, allowed: float, extra: tuple[str, ...] = ()
) -> HardCaseOutcome:
    """Judge what every case is judged by: status, message, finite numbers, error, energy, penetration."""
    failures = list(extra)
    if response.status not in case.statuses:
        failures.append(f"ended as {response.status}, not {case.expected}")
    if not response.ok and (not response.message or case.mentions not in response.message):
        failures.append("does not say why it ended and what to change")
    if not np.isfinite(response.section).all():
        failures.append("a number is not finite")
    if not (math.isnan(error) or error <= allowed):
        failures.append(f"error {error:.1e} is above {allowed:.1e}")
    residual, balanced = _energy_residual(case, response)
    if residual > balanced:
        failures.append(f"energy residual {residual:.1e} is above {balanced:.1e}")
    penetration = _penetration(response)
    if penetration > 8 * EPSILON:
        failures.append(f"penetrates by {penetration:.1e}")
    return HardCaseOutcome(
        case=case,
        status=response.status,
        message=response.message,
        error=error,
        allowed=allowed,
        residual=residual,
        balanced=balanced,
        penetration=penetration,
        microseconds=response.cost.seconds / max(1, response.periods) * 1e6,
        failures=tuple(failures),
    )


def _energy_residual(case: HardCase, response: Response) -> tuple[float, float]:
    """Return the relative residual of a closed-form solver's energy balance, and what rounding may leave of it."""
    if response.method.has_step or not response.ok:
        return math.nan, math.nan
    all_kept = response.keep == case.setup.periods
    balance = energy_balance(response, case.setup.initial if all_kept else None)
    numbers = response.method.numbers
    contact = math.sqrt(numbers.get("K", 0.0)) + numbers.get("D", 0.0)
    radians = (1 + contact + max(1.0, response.system.kappa)) * (1 + response.period)
    return float(np.abs(balance.residual).max() / balance.size), 4 * MARGIN * EPSILON * radians


def _penetration(response: Response) -> float:
    if not response.method.rigid or response.trajectory is None:
        return 0.0
    (x1, x2), system = response.trajectory.displacement, response.system
    size = max(np.abs(x1).max(), np.abs(x2).max(), abs(system.clearance), 1e-300)
    return float(max(0.0, -system.gap(x1, x2).min()) / size)


# ---------------------------------------------------------------------------------------------------------- the states


def _judge_states(case: HardCase) -> HardCaseOutcome:
    """Compare the section with the true solution, or its last row with another method's."""
    record = None if case.setup.method.has_step else Record(case.setup.periods, PENETRATION_SAMPLES)
    response = case.setup.solve(record=record)
    if case.truth:
        return _judge_by_truth(case, response)
    allowed = math.inf if case.allowed is None else case.allowed
    error = math.nan
    if case.compared is not None and response.ok:
        error = _largest(response.section[-1] - case.compared.solve().section[-1])
    return _outcome(case, response, error, allowed)


def _judge_by_truth(case: HardCase, response: Response) -> HardCaseOutcome:
    truth = solutions()[case.truth]
    states = np.array(truth["states"], dtype=float)
    allowed = _attainable(case) if case.allowed is None else case.allowed
    wrong = _wrong_events(case, response, truth) if allowed < math.inf else ()
    complete = len(response.section) == len(states)
    error = _largest(response.section - states) if complete else math.inf
    return _outcome(case, response, error, allowed, wrong)


def _largest(difference: np.ndarray) -> float:
    return float(np.abs(difference).max())


def _attainable(case: HardCase) -> float:
    """Return the attainable error; inf where rounding alone decides.

    Of a general system the conditioning is part of the truth. A motion that passes above the surface, however closely,
    does not graze: it is as well conditioned as the clear one.
    """
    condition = solutions()[case.truth].get("condition")
    if condition is not None:
        return MARGIN * EPSILON * (condition + accumulated_rounding(case.setup))
    if not case.clear:
        attainable = attainable_error(case.setup)
        return math.inf if attainable is None else attainable
    clear = setup_of(case.clear)
    if float(solutions()[case.truth]["dip"]) > MARGIN / 8 * EPSILON * max(np.abs(case.setup.initial)):
        return attainable_error(clear)
    return attainable_grazing_error(case.setup, clear)


def _wrong_events(case: HardCase, response: Response, truth: dict) -> tuple[str, ...]:
    """Compare the numbers of events with the truth; a graze that rounding decides is not compared."""
    if case.clear and abs(float(truth["dip"])) < EPSILON * max(np.abs(case.setup.initial)):
        return ()
    kinds = [kind for _, kind, _ in truth["events"]]
    if response.method.rigid:
        impacts, contacts = kinds.count(0), kinds.count(1)
        same = truth["omitted"] > 0 or len(response.impacts) == impacts
    else:
        contacts, same = kinds.count(0), True
    if same and len(response.contacts) == contacts:
        return ()
    return ("events differ from the truth",)


# --------------------------------------------------------------------------------------------------- long-term motions


def _judge_statistics(case: HardCase) -> HardCaseOutcome:
    """Compare the statistics of two chaotic runs, in units of the standard error of their difference."""
    response, other = case.setup.solve(), case.compared.solve()
    (means, errors), (other_means, other_errors) = _statistics(response), _statistics(other)
    error = float(np.max(np.abs(means - other_means) / np.hypot(errors, other_errors)))
    return _outcome(case, response, error, case.allowed)


def _statistics(response: Response) -> tuple[np.ndarray, np.ndarray]:
    """Return means and their standard errors: impacts per period, contact share, ξ, ξ² and ξ′² of the observed body."""
    edges = np.linspace(*response.window, RUN_BATCHES + 1)
    rates = np.histogram(response.impacts.time, edges)[0] / (len(response.section) / RUN_BATCHES)
    inside = [np.clip(response.contacts, low, high) for low, high in pairwise(edges)]
    shares = np.array([(spans[:, 1] - spans[:, 0]).sum() for spans in inside]) / (edges[1] - edges[0])
    first = 2 * response.system.observed_body - 2
    sections = response.section[:, first : first + 2].reshape(RUN_BATCHES, -1, 2)
    rows = np.column_stack([rates, shares, sections[..., 0].mean(1), (sections**2).mean(1)])
    return rows.mean(0), standard_error(rows) + 1e-300


def _judge_drift(case: HardCase) -> HardCaseOutcome:
    """Compare the steady motion after a fiftieth of the periods with that after all periods."""
    setup = case.setup
    record = Record(DRIFT_KEEP, PENETRATION_SAMPLES)
    early, late = (
        simulate(setup.system, setup.eta, setup.method, periods=periods, keep=DRIFT_KEEP, record=record)
        for periods in (setup.periods // 50, setup.periods)
    )
    # on an attracting cycle only errors of the last periods remain; the τ of events is rounded to ε_m τ
    attainable = attainable_error(replace(setup, periods=20))
    return _outcome(case, late, _largest(late.section - early.section), math.inf if attainable is None else attainable)
