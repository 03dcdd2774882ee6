"""What the parts of a difference consist of: those of the regularisation by K and D, and those of the time step.

**Regularisation.** Its three parts are a finite contact time, pulling at its end, and another restitution.

A contact of damping ratio ζ has the restitution e(ζ), and would have e°(ζ) if it ended where its force vanishes and the
damper begins to pull (:mod:`engine.contact` derives both). Two more references separate three parts that add up to the
regularisation, all with derived joint damping:

    exact penalty(K, D) − reference(e) =  [exact penalty(K, D) − reference(e(ζ))]   finite contact time
                                        + [reference(e(ζ)) − reference(e°(ζ))]      pulling at the end of contact
                                        + [reference(e°(ζ)) − reference(e)]         restitution of the damper alone (57)

The last two together are the effect of a wrong restitution e(ζ) ≠ e. At equal restitution they cancel, since
D = ζ(e)√(Kμ/(1 + μ)) takes the pulling into account. The first part is also the remainder: it includes everything that
has no counterpart in an impact, such as contacts that follow each other before the first has ended, or that the springs
press together.

Other contact laws have one more reference, with the restitution that the law gives at the mean closing speed of the
impacts (:func:`engine.effective_restitution`), and two parts: the finite contact time and the wrong restitution.

**Time step.** Its two parts are the contact status of whole steps, and the integrator.

    penalty(K, D, Δτ) − exact penalty(K, D) =  [steps with their status − the same steps located]   status
                                             + the rest                                             integrator     (56)

A located step is cut where contact changes, so that it has the right status all along. The two runs of the first
bracket are those of the method itself. What remains is the error that the integrator makes with the right status: of
second order or better where the method has it, with its numerical damping. The rest is a difference, so that both add
up exactly at every instant.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.contact import damping_ratio, effective_restitution
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.grid import run_again, samples_beside
from vibroscope.engine.divergence.parts import DifferenceSeries
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.law_table import restitution_of, restitution_without_pull
from vibroscope.engine.methods import ExactPenalty, TimeStepping, with_located_steps
from vibroscope.engine.motions.description import describe
from vibroscope.engine.result import Record, Response


@dataclass(frozen=True)
class Regularisation:
    """Parts of the regularisation: finite contact time, pulling, and the restitution of the damper.

    Attributes
    ----------
    ratio : float
        ζ of the contact; nan with a law other than the spring and the damper.
    restitution, without_pull : float
        e(ζ) and e°(ζ); of another law the restitution that it gives, and nan.
    contact_time, wrong_restitution, pulling, damper : (4, n) ndarray
        The parts on the grid of :class:`.parts.DifferenceSeries`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a reference ended early.
        The wrong restitution is pulling and damper together; these are nan with another law.
    in_step : bool
        Whether the two further references repeat after as many periods as the one with e; otherwise the parts are
        hardly meaningful.
    """

    ratio: float
    restitution: float
    without_pull: float
    contact_time: np.ndarray
    wrong_restitution: np.ndarray
    pulling: np.ndarray
    damper: np.ndarray
    in_step: bool


def split_regularisation(
    series: DifferenceSeries,
    exact: ExactPenalty,
    derived: Response,
    grid: Record,
    initial: Sequence[float] | None,
    cancelled: Callable[[], bool] | None = None,
) -> Regularisation:
    """Split the regularisation of a comparison, by two more runs of the reference.

    Parameters
    ----------
    series : DifferenceSeries
    exact : ExactPenalty
    derived : Response
        Of the reference with derived joint damping; it is repeated with e(ζ) and e°(ζ).
    grid : Record
        Of one period of the series.
    initial : (4,) sequence, or None for rest
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of all runs.

    Raises
    ------
    ValueError
        If nothing collides, so that no closing speed says which restitution another law gives.
    """
    ratio, restitutions = _restitutions(exact, derived)
    own = series.runs.derived.reshape(4, series.periods, -1)
    rows, periods = [], {period_of(derived.section)}
    for restitution in restitutions:
        run = _with_restitution(derived, restitution, initial, cancelled)
        period = period_of(run.section) if run.ok else 0
        periods.add(period)
        rows.append(samples_beside(run, period, own, grid, cancelled)[0].reshape(4, -1))
    delivered, without_pull = rows if len(rows) == 2 else (rows[0], np.full_like(rows[0], np.nan))
    return Regularisation(
        ratio,
        restitutions[0],
        restitutions[1] if len(rows) == 2 else np.nan,
        contact_time=series.runs.exact - delivered,
        wrong_restitution=delivered - series.runs.derived,
        pulling=delivered - without_pull,
        damper=without_pull - series.runs.derived,
        in_step=len(periods) == 1 and 0 not in periods,
    )


def _restitutions(exact: ExactPenalty, derived: Response) -> tuple[float, tuple[float, ...]]:
    """Return ζ with e(ζ) and e°(ζ); of another law nan with the restitution that it gives."""
    if exact.linear:
        ratio = damping_ratio(derived.system, exact.stiffness, exact.damping)
        return ratio, (restitution_of(ratio), restitution_without_pull(ratio))
    speed = mean_closing_speed(derived)
    if np.isnan(speed):
        raise ValueError(f"nothing collides, so that the restitution of the law {exact.law!r} has no closing speed")
    return np.nan, (effective_restitution(derived.system, exact, speed),)


def _with_restitution(derived: Response, restitution: float, initial: Sequence[float] | None, cancelled) -> Response:
    return run_again(
        derived, system=replace(derived.system, restitution=restitution), initial=initial, cancelled=cancelled
    )


@dataclass(frozen=True)
class TimeStepParts:
    """Parts of the time step.

    Attributes
    ----------
    status, integrator : (4, n) ndarray
        On the grid of :class:`.parts.DifferenceSeries`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a run ended early.
    located : TimeStepping
        The method of the located steps.
    in_step : bool
        Whether that run repeats after as many periods as the penalty solution; otherwise the parts are hardly
        meaningful.
    """

    status: np.ndarray
    integrator: np.ndarray
    located: TimeStepping
    in_step: bool


def split_time_step(
    series: DifferenceSeries,
    penalty: Response,
    grid: Record,
    initial,
    cancelled: Callable[[], bool] | None = None,
) -> TimeStepParts:
    """Split the time step of a comparison, by a run with located steps.

    Parameters
    ----------
    series : DifferenceSeries
    penalty : Response
    grid : Record
        Of one period of the series.
    initial : (4,) sequence, or None for rest
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of all runs.
    """
    method, run = with_located_steps(penalty.method), penalty
    if method != penalty.method:
        run = run_again(penalty, method=method, initial=initial, cancelled=cancelled)
    first, found = describe(penalty), describe(run)
    own = series.runs.penalty.reshape(4, series.periods, -1)
    located = own if run is penalty else samples_beside(run, found.period, own, grid, cancelled)[0]
    status = (own - located).reshape(4, -1)
    together = found.near_period == first.near_period > 0
    free = not penalty.system.excitation.drives and run.ok
    return TimeStepParts(status, series.time_step - status, method, together or free)
