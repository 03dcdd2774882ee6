"""The two parts of the time step: the contact status of whole steps, and the integrator.

    penalty(K, D, Δτ) − exact penalty(K, D) =  [steps with their status − the same steps located]   status
                                             + the rest                                             integrator

A located step is cut where contact changes, so that it has the right status all along. The two runs of the first
bracket are those of the method itself, if its steps can be located; otherwise those of Newmark's method, α = ½, β = ¼,
with the same status, law and steps. What remains is the error that the integrator makes with the right status: of
second order or better where the method has it, with its numerical damping. The rest is a difference, so that both add
up exactly at every instant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..integrators import NewmarkBeta
from ..methods import Newmark, TimeStepping
from ..motions.description import describe
from ..result import Record, Response
from ..simulate import simulate
from .grid import samples_beside
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
    own : bool
        Whether it is the integrator of the penalty solution; otherwise it is Newmark's method.
    in_step : bool
        Whether both runs repeat after as many periods as the penalty solution; otherwise the parts are hardly
        meaningful.
    """

    status: np.ndarray
    integrator: np.ndarray
    located: Newmark | TimeStepping
    own: bool
    in_step: bool


def with_located_steps(method: Newmark | TimeStepping) -> Newmark | TimeStepping:
    """Return a method with the same numbers whose steps are cut where contact changes.

    Raises
    ------
    ValueError
        If its steps, or those with its contact law, cannot be located.
    """
    if isinstance(method, Newmark):
        return replace(method, every_step=False, located=True)
    try:
        return replace(method, status="located")
    except ValueError:
        if method.integrator != NewmarkBeta():
            raise
        return Newmark(method.stiffness, method.damping, method.steps, located=True, law=method.law)


def status_pair(method: Newmark | TimeStepping) -> tuple[Newmark | TimeStepping, Newmark | TimeStepping]:
    """Return two methods that differ in the contact status alone: that of the method, and located steps.

    Raises
    ------
    ValueError
        If no steps with its contact law can be located.
    """
    try:
        return method, with_located_steps(method)
    except ValueError:
        if isinstance(method, Newmark):
            raise
        newmark = replace(method, integrator=NewmarkBeta())
        return newmark, with_located_steps(newmark)


def split_time_step(
    series: DifferenceSeries,
    penalty: Response,
    grid: Record,
    initial,
    cancelled: Callable[[], bool] | None = None,
) -> TimeStepParts:
    """Split the time step of a comparison, by one or two more runs.

    Parameters
    ----------
    series : DifferenceSeries
    penalty : Response
    grid : Record
        Of one period of the series.
    initial : (4,) sequence, or None for rest
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of all runs.

    Raises
    ------
    ValueError
        If no steps with the contact law can be located.
    """
    pair = status_pair(penalty.method)
    options = {"periods": penalty.periods, "keep": penalty.keep, "initial": initial, "cancelled": cancelled}
    runs = [
        penalty if method == penalty.method else simulate(penalty.system, penalty.eta, method, **options)
        for method in pair
    ]
    motions = [describe(run) for run in (penalty, *runs)]
    own = series.runs.penalty.reshape(4, penalty.keep, -1)
    rows = [
        own if run is penalty else samples_beside(run, found.period, own, grid, cancelled)[0]
        for run, found in zip(runs, motions[1:], strict=True)
    ]
    status = (rows[0] - rows[1]).reshape(4, -1)
    together = len({found.near_period for found in motions}) == 1 and motions[0].near_period > 0
    free = not penalty.system.excitation.drives and all(run.ok for run in runs)
    return TimeStepParts(status, series.time_step - status, pair[1], pair[0] == penalty.method, together or free)
