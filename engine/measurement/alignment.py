"""Alignment of a solution with a measurement: the phase at which the measurement began, and what remains then.

A measurement begins at an unknown phase τ₀ of the excitation. It is estimated as the one with the least sum of squares

    min over 0 ≤ τ₀ < pT of  Σ |x(tᵢ) − ξ(tᵢ + τ₀) [− cos η(tᵢ + τ₀)]|²,                          (58)

with the bracket for fixed sensors. The sum has several minima (about one for each impact), so that τ₀ is searched for
on a grid first and then refined by the Gauss–Newton method. Each solution has its own τ₀. What remains is then
independent of the sensor's clock, and the difference of the two τ₀ is the lag of one solution behind the other.
"""

from dataclasses import dataclass

import numpy as np
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.measurement.cycle import Cycle
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.recurrence import Sensor, summarise_sensor
from vibroscope.engine.measurement.tolerances import WITHIN_NOISE


@dataclass(frozen=True)
class Alignment:
    """A solution aligned with a measurement.

    Attributes
    ----------
    phase : float
        τ₀, τ of the solution's cycle at the first sample; of a motion from its start, the time since then.
    rms : float
        Root mean square difference of the displacements, relative to the measured ones.
    channels : (2,) or (1,) ndarray
        The same for each measured body, in base amplitudes.
    offset : (2,) or (1,) ndarray
        Mean of measured − solution, in base amplitudes; if it is not small, a sensor has a zero error, or measured
        accelerations.
    displacement : (2, n) or (1, n) ndarray
        The solution at the instants of the measurement, in its frame.
    sensor : Sensor
        What the contact sensor would have measured of the solution, with the same samples; impacts closer than a sample
        count as one in both.
    closing_error : float or None
        Mean distance in time from each closing of the sensor to the nearest one of the solution, as a fraction of T;
        None without a sensor, or if either of them never closes.
    """

    phase: float
    rms: float
    channels: np.ndarray
    offset: np.ndarray
    displacement: np.ndarray
    sensor: Sensor
    closing_error: float | None

    def is_within(self, noise: float) -> bool:
        """Whether the difference is no more than the noise of the measurement, in base amplitudes."""
        return rms(self.channels) <= WITHIN_NOISE * noise


def align(cycle: Cycle, measurement: Measurement) -> Alignment:
    """Align a cycle with a measurement at the phase of the least squares.

    Raises
    ------
    ValueError
        If the measurement is in a frame in which the motion is not known.
    """
    frame = measurement.frame
    if frame not in cycle.frames:
        raise ValueError(
            "an acceleration of the base does not show where the base is: give displacements relative to it, xi1, xi2"
        )
    phase = best_phase(cycle, measurement, frame)
    displacement = cycle.displacement(measurement.time + phase, frame)
    difference = measurement.residual(displacement)
    touching = cycle.touching(measurement.time + phase, float(np.median(np.diff(measurement.time))))
    return Alignment(
        phase=phase,
        rms=rms(difference) / max(rms(measurement.displacement), 1e-300),
        channels=np.sqrt(np.mean(difference**2, axis=1)),
        offset=(measurement.displacement - displacement[: len(difference)]).mean(axis=1),
        displacement=displacement[: len(difference)],
        sensor=summarise_sensor(measurement.time, touching, cycle.eta),
        closing_error=_closing_error(cycle, measurement, phase),
    )


def best_phase(cycle: Cycle, measurement: Measurement, frame: str) -> float:
    """Return τ₀ in [0, pT) of the least squares: the best of a grid, refined by Gauss–Newton steps.

    Of a motion from its start it is the time since then, and negative if the measurement began before.
    """
    thin = measurement.thinned(1000)  # samples are enough for the grid
    grid = cycle.phases(measurement.span)
    phase = min(grid, key=lambda shift: np.sum(_difference(cycle, thin, shift, frame) ** 2))
    for _ in range(8):  # Gauss–Newton steps
        slope = cycle.velocity(measurement.time + phase, frame)[: len(measurement.displacement)]
        step = np.sum(slope * _difference(cycle, measurement, phase, frame)) / max(np.sum(slope**2), 1e-300)
        phase += np.clip(step, grid[0] - grid[1], grid[1] - grid[0])
    return float(cycle.within(phase) if cycle.repeats else phase)


def _difference(cycle: Cycle, measurement: Measurement, phase: float, frame: str) -> np.ndarray:
    return measurement.residual(cycle.displacement(measurement.time + phase, frame))


def _closing_error(cycle: Cycle, measurement: Measurement, phase: float) -> float | None:
    if measurement.contact is None or not len(cycle.closings):
        return None
    measured = summarise_sensor(measurement.time, measurement.contact, cycle.eta).closings + phase
    if not len(measured):
        return None
    half = cycle.length / 2
    distance = np.mod(measured[:, None] - cycle.closings + half, cycle.length) - half
    return float(np.abs(distance).min(axis=1).mean() * cycle.eta / (2 * np.pi))
