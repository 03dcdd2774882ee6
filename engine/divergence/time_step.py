"""The two parts of the time step: the contact status of whole steps, and the integrator.

    penalty(K, D, Δτ) − exact penalty(K, D) =  [steps with their status − the same steps located]   status
                                             + the rest                                             integrator     (56)

A located step is cut where contact changes, so that it has the right status all along. The two runs of the first
bracket are those of the method itself. What remains is the error that the integrator makes with the right status: of
second order or better where the method has it, with its numerical damping. The rest is a difference, so that both add
up exactly at every instant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..methods import Newmark, TimeStepping
from ..motions.description import describe
from ..result import Record, Response
from .grid import run_again, samples_beside
from .parts import DifferenceSeries


@dataclass(frozen=True)
class TimeStepParts:
    """Parts of the time step.

    Attributes
    ----------
    status, integrator : (4, n) ndarray
        On the grid of :class:`.parts.DifferenceSeries`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a run ended early.
    located : Newmark or TimeStepping
        The method of the located steps.
    in_step : bool
        Whether that run repeats after as many periods as the penalty solution; otherwise the parts are hardly
        meaningful.
    """

    status: np.ndarray
    integrator: np.ndarray
    located: Newmark | TimeStepping
    in_step: bool


def with_located_steps(method: Newmark | TimeStepping) -> Newmark | TimeStepping:
    """Return a method with the same numbers whose steps are cut where contact changes.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, with_located_steps
    >>> with_located_steps(Newmark(2500, 8, 500)).located
    True
    """
    return replace(method, status="located") if method.has_choices else replace(method, every_step=False, located=True)


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
