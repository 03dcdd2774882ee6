"""A measurement beside the solutions: when it began, and how far they lie from it.

A measurement begins at no particular phase δ of the excitation. It is the one that leaves least of the squares

    Σ |x(tᵢ) − ξ(tᵢ + δ) [− cos η(tᵢ + δ)]|²,    0 ≤ δ < pT,

the bracket for sensors that stand still. The sum has several minima (one for each impact, about), so δ is looked for
on a grid first, and from there by Gauss and Newton's method. Each solution is given its own δ: what is left is then
no matter of the sensor's clock, and the difference of the two δ is how much one solution lags behind the other.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..methods import Newmark, Reference
from ..model import System, check_eta
from ..motions.motion import motion
from ..result import Response
from .cycle import Cycle, penalty_cycle, reference_cycle
from .measured import Measurement
from .recurrence import Recurrence, Sensor, recurrence, sensor, thinned

SHIFTS = 256  # per period, at which the grid looks for δ
COARSE = 1000  # samples are enough for that grid
REFINED = 8  # steps from there


@dataclass(frozen=True)
class Alignment:
    """A solution laid over a measurement.

    Attributes
    ----------
    phase : float
        δ, τ of the solution's cycle at the first sample.
    rms : float
        Root mean square difference of the displacements, relative to the measured ones.
    channels : (2,) ndarray
        The same for each pendulum, in base amplitudes.
    offset : (2,) ndarray
        Mean of measured − solution, in base amplitudes: a sensor's zero, if it is not small.
    displacement : (2, n) ndarray
        The solution at the instants of the measurement, in its frame.
    sensor : Sensor
        What the measurement's contact sensor would have told of the solution, sampled at the same instants; impacts
        closer than a sample are one to both.
    closing_error : float or None
        Mean distance in time from each closing of the sensor to the nearest of the solution's meetings, as a share of
        T; None without a sensor, or if one of them never closes.
    """

    phase: float
    rms: float
    channels: np.ndarray
    offset: np.ndarray
    displacement: np.ndarray
    sensor: Sensor
    closing_error: float | None


@dataclass(frozen=True)
class Solved:
    """One solution beside the measurement.

    Attributes
    ----------
    response : Response
    period : int
        Excitation periods until it repeats, scatter forgiven; 0 if it does not.
    impacts_per_period, contact_share : float or None
        Of the solution itself; None if it ended early.
    alignment : Alignment or None
        None if it does not repeat.
    """

    response: Response
    period: int
    impacts_per_period: float | None
    contact_share: float | None
    alignment: Alignment | None


@dataclass(frozen=True)
class MeasuredComparison:
    """A measurement beside both solvers.

    Attributes
    ----------
    measurement : Measurement
    recurrence : Recurrence
    reference, penalty : Solved
    other_frame : float or None
        The reference's rms if the columns were meant in the other frame; None if it does not repeat.
    """

    measurement: Measurement
    recurrence: Recurrence
    reference: Solved
    penalty: Solved
    other_frame: float | None

    @property
    def periods(self) -> float:
        """Excitation periods that the measurement covers."""
        return self.measurement.span / self.reference.response.period


def compare_measured(
    system: System,
    eta: float,
    measurement: Measurement,
    penalty: Newmark,
    *,
    reference: Reference | None = None,
    periods: int = 2050,
    cancelled: Callable[[], bool] | None = None,
) -> MeasuredComparison:
    """Lay both solutions over a measurement, each from rest.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁ of the measurement.
    measurement : Measurement
    penalty : Newmark
    reference : Reference, optional
    periods : int
        Excitation periods that Newmark runs.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is withdrawn.

    Returns
    -------
    MeasuredComparison

    Raises
    ------
    ValueError
        If a number is out of range, or the measurement covers less than an excitation period.
    Cancelled
        If ``cancelled`` returned true.
    """
    eta = check_eta(eta, system)
    told = recurrence(measurement, eta)
    exact = reference_cycle(system, eta, reference or Reference(), cancelled=cancelled)
    run, cycle = penalty_cycle(system, eta, penalty, periods=periods, cancelled=cancelled)
    other = None
    if exact.cycle is not None:
        flipped = {"absolute": "relative", "relative": "absolute"}[measurement.frame]
        other = align(exact.cycle, measurement, flipped).rms
    return MeasuredComparison(measurement, told, _solved(measurement, *exact), _solved(measurement, run, cycle), other)


def _solved(measurement: Measurement, response: Response, cycle: Cycle | None) -> Solved:
    if not response.ok:
        return Solved(response, 0, None, None, None)
    found = motion(response)
    period, aligned = (cycle.periods, align(cycle, measurement)) if cycle is not None else (0, None)
    return Solved(response, period, found.impacts_per_period, found.contact_share, aligned)


def align(cycle: Cycle, measurement: Measurement, frame: str | None = None) -> Alignment:
    """Lay a cycle over a measurement at the phase that leaves least of the squares.

    Parameters
    ----------
    cycle : Cycle
    measurement : Measurement
    frame : {"absolute", "relative"}, optional
        Take the displacements as of this frame, whatever the measurement says.
    """
    frame = frame or measurement.frame
    phase = best_phase(cycle, measurement, frame)
    found = cycle.displacement(measurement.time + phase, frame)
    difference = measurement.displacement - found
    size = np.sqrt(np.mean(measurement.displacement**2))
    touching = cycle.touching(measurement.time + phase, float(np.median(np.diff(measurement.time))))
    return Alignment(
        phase=phase,
        rms=float(np.sqrt(np.mean(difference**2)) / max(size, 1e-300)),
        channels=np.sqrt(np.mean(difference**2, axis=1)),
        offset=difference.mean(axis=1),
        displacement=found,
        sensor=sensor(measurement.time, touching, cycle.eta),
        closing_error=_closing_error(cycle, measurement, phase),
    )


def best_phase(cycle: Cycle, measurement: Measurement, frame: str) -> float:
    """δ in [0, pT) of the least squares: the best of a grid, then Gauss and Newton's steps."""
    thin = thinned(measurement, COARSE)
    grid = np.arange(0, cycle.length, cycle.length / (SHIFTS * cycle.periods))
    found = min(grid, key=lambda phase: np.sum(_difference(cycle, thin, phase, frame) ** 2))
    for _ in range(REFINED):
        slope = cycle.velocity(measurement.time + found, frame)
        step = np.sum(slope * _difference(cycle, measurement, found, frame)) / max(np.sum(slope**2), 1e-300)
        found += np.clip(step, -grid[1], grid[1])
    return float(np.mod(found, cycle.length))


def _difference(cycle: Cycle, measurement: Measurement, phase: float, frame: str) -> np.ndarray:
    return measurement.displacement - cycle.displacement(measurement.time + phase, frame)


def _closing_error(cycle: Cycle, measurement: Measurement, phase: float) -> float | None:
    if measurement.contact is None or not len(cycle.closings):
        return None
    seen = sensor(measurement.time, measurement.contact, cycle.eta).closings + phase
    if not len(seen):
        return None
    apart = np.mod(seen[:, None] - cycle.closings + cycle.length / 2, cycle.length) - cycle.length / 2
    return float(np.abs(apart).min(axis=1).mean() * cycle.eta / (2 * np.pi))
