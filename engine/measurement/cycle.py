"""One cycle of a periodic motion, or a motion from its start, as a continuous function of time, accurate at impacts.

Between the samples of a run, a cubic Hermite polynomial through displacements and velocities errs by O(h⁴). At an
impact the velocity jumps by Δv, and a cubic across it would err by O(h Δv). So each impact of the reference becomes two
knots an instant apart, with the velocities before and after it.

(NumPy has no Hermite interpolation, and SciPy, which has, is required only where constants are fitted.)

A measurement begins at an unknown phase τ₀ of the excitation. To align a solution with it, τ₀ is estimated as the one
with the least sum of squares

    min over 0 ≤ τ₀ < pT of  Σ |x(tᵢ) − ξ(tᵢ + τ₀) [− cos η(tᵢ + τ₀)]|²,                          (58)

with the bracket for fixed sensors. The sum has several minima (about one for each impact), so that τ₀ is searched for
on a grid first and then refined by the Gauss–Newton method. Each solution has its own τ₀. What remains is then
independent of the sensor's clock, and the difference of the two τ₀ is the lag of one solution behind the other.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.drivers.section import LONGEST_NEAR_PERIOD
from vibroscope.engine.facts import Amount, Statement, stated
from vibroscope.engine.measurement.measurement import FRAMES, Measurement
from vibroscope.engine.measurement.recurrence import Sensor, summarise_sensor
from vibroscope.engine.measurement.tolerances import AT_BOUND, INSTANT, STILL, TRIGGER, WITHIN_NOISE
from vibroscope.engine.methods import ExactPenalty, Method, Reference, TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.motions.motion import SAMPLES_PER_PERIOD, motion
from vibroscope.engine.motions.steady import steady
from vibroscope.engine.result import Record, Response
from vibroscope.engine.simulate import KEEP, simulate, simulate_load, under_load

SHIFTS = 256  # instants per period at which a measurement may have begun, to be refined
FREE_SAMPLES = 400_000  # of a motion from its start, at most
KNOTS_IN_CONTACT = 20  # of a penalty solution from its start


@dataclass(frozen=True)
class Cycle:
    """A motion that repeats itself, or one from its start, where nothing that repeats drives the bodies.

    Attributes
    ----------
    eta : float
    periods : int
        Excitation periods in the cycle.
    closings : (m,) ndarray
        τ since the beginning of the cycle (τ ≡ 0 mod T) at which the pendulums meet.
    response : Response
        The run that ends with the cycle.
    knots : (n,) ndarray
        τ since the beginning of the cycle at which displacements and velocities are known.
    values, slopes : (2, n) ndarray
        ξ₁ and ξ₂, and ξ₁′ and ξ₂′, at the knots.
    repeats : bool
        Whether it goes on for ever. A motion from its start does not: before it the bodies are held there.
    """

    eta: float
    periods: int
    closings: np.ndarray
    response: Response
    knots: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    repeats: bool = True

    @property
    def frames(self) -> tuple[str, ...]:
        """In which frames it is known: not in a fixed one under a load that is an acceleration of the base."""
        load = self.response.system.excitation.load
        return FRAMES if load is None or load.on != "base" else ("relative",)

    @property
    def length(self) -> float:
        """Duration τ of the cycle."""
        return 2 * np.pi / self.eta * self.periods

    def within(self, time: np.ndarray | float) -> np.ndarray | float:
        """The instants τ since the beginning, within the cycle."""
        return np.mod(time, self.length) if self.repeats else np.clip(time, 0.0, self.length)

    def phases(self, measurement: Measurement) -> np.ndarray:
        """Instants at which a measurement may have begun, equally spaced, more than one."""
        if self.repeats:
            return np.arange(0, self.length, self.length / (SHIFTS * self.periods))
        return np.linspace(*free_offsets(measurement), SHIFTS)

    def displacement(self, time: np.ndarray, frame: str = "relative") -> np.ndarray:
        """Return ξ₁ and ξ₂ at the instants τ, (2, n), relative to the base or ``"absolute"``."""
        u, h, (left, right), (before, after) = self._interval(time)
        relative = left + u * u * (3 - 2 * u) * (right - left) + h * u * (1 - u) * ((1 - u) * before - u * after)
        return relative + self._base(time)[0] if frame == "absolute" else relative

    def velocity(self, time: np.ndarray, frame: str = "relative") -> np.ndarray:
        """Return ξ₁′ and ξ₂′ at the instants τ, (2, n), relative to the base or ``"absolute"``."""
        u, h, (left, right), (before, after) = self._interval(time)
        relative = 6 * u * (1 - u) / h * (right - left) + (1 - u) * (1 - 3 * u) * before + u * (3 * u - 2) * after
        return relative + self._base(time)[1] if frame == "absolute" else relative

    def _base(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.response.system.excitation.base_motion(self.eta, time)

    def _interval(self, time):
        """Return, of the interval between two knots: the fraction that has passed, its length, values and slopes."""
        within = self.within(time)
        i = np.clip(np.searchsorted(self.knots, within, side="right") - 1, 0, len(self.knots) - 2)
        h = self.knots[i + 1] - self.knots[i]
        ends = [(array[:, i], array[:, i + 1]) for array in (self.values, self.slopes)]
        return (within - self.knots[i]) / h, h, *ends

    def touching(self, time: np.ndarray, step: float) -> np.ndarray:
        """Whether the pendulums touch at the instants τ, or met within ``step`` before, (n,) of bool."""
        within = self.within(time)
        begin = self.response.window[1] - self.length
        closed = np.zeros(len(within), bool)
        for start, end in self.response.contacts - begin:  # a contact may have begun before the cycle
            closed |= (within >= start) & (within <= end)
        for closing in self.closings:
            closed |= np.mod(within - closing, self.length) < step
        return closed


def free_offsets(measurement: Measurement) -> tuple[float, float]:
    """The first and the last τ since the start of a motion at which a measurement of it may have begun.

    A trigger misses the start by a few samples, and before it the record may show the bodies at rest. A longer shift
    would lay a solution over other oscillations of the record, and hide how far it is off.
    """
    rows, interval = measurement.displacement, sampling_interval(measurement)
    far = np.abs(rows - rows[:, :1]) > STILL * np.ptp(rows, axis=1, keepdims=True)
    held = measurement.time[np.argmax(far.any(axis=0))]  # 0 of a record in which nothing moves
    return -float(held - measurement.time[0]) - TRIGGER * interval, TRIGGER * interval


def sampling_interval(measurement: Measurement) -> float:
    """The median τ between samples."""
    return float(np.median(np.diff(measurement.time)))


def held_by_trigger(phase: float, measurement: Measurement) -> bool:
    """Whether a measurement of a motion from its start begins as early or as late as is allowed."""
    early, late = free_offsets(measurement)
    return not early + AT_BOUND < phase < late - AT_BOUND


def held_words(phase: float) -> Statement:
    """Say that a record begins as early or as late as is allowed, where another start may fit better."""
    side, most = ("after", "") if phase > 0 else ("before", "as long as it shows no motion, and ")
    most = f"the most that is allowed ({most}{TRIGGER:g} samples)"
    words = f"the record fits best if it begins {{}} {side} the start, {most}: check the start that is given, and where"
    return stated(f"{words} the record begins", Amount(abs(phase), "time", 3))


class SettledRun(NamedTuple):
    """A run and the cycle that it settles to; None if it diverged or does not repeat itself."""

    response: Response
    cycle: Cycle | None


def reference_cycle(system: System, eta: float, method: Reference | ExactPenalty, **options) -> SettledRun:
    """Find a steady motion without a time step; arguments and errors are those of :func:`..motions.steady.steady`."""
    found = steady(system, eta, method, record=Record(8, SAMPLES_PER_PERIOD), **options)
    return SettledRun(found.response, _last_cycle(found.response, found.period) if found.periodic else None)


def penalty_cycle(system: System, eta: float, method: TimeStepping, periods: int, **options) -> SettledRun:
    """Return the last cycle of a run with a time step; ``options``: initial and cancelled, as of `engine.simulate`.

    How long it is says the judge of motions: a section that the step scatters may repeat itself by chance, or not.
    """
    keep = min(KEEP, periods)
    record = Record(min(LONGEST_NEAR_PERIOD, keep), SAMPLES_PER_PERIOD)
    response = simulate(system, eta, method, periods=periods, keep=keep, record=record, **options)
    period = motion(system, eta, method, **options).period if response.ok else 0
    return SettledRun(response, _last_cycle(response, period) if 0 < period <= record.periods else None)


def free_motion(system: System, eta: float, method: Method, measurement: Measurement, **options) -> SettledRun:
    """Return the motion from its start, as long as a measurement needs.

    Nothing drives the bodies, or a load that is no harmonic: then ``steps`` are those in 2π/ω₁. ``options``: initial
    and cancelled, as of :func:`engine.simulate`.
    """
    load, end = system.excitation.load, measurement.span + free_offsets(measurement)[1]
    contact = np.pi / math.sqrt(1.0 if method.rigid else method.stiffness)  # as long as a contact, at most about
    if load is not None:
        system, method = under_load(system, load, method, max(0.0, end - load.end))
        periods, period, changes = 1, max(end, load.end), min(2 * np.pi, load.end)
    else:
        periods, period = math.ceil(end * eta / (2 * np.pi)), 2 * np.pi / eta
        changes = period
    samples = math.ceil(period * max(SAMPLES_PER_PERIOD / changes, KNOTS_IN_CONTACT / contact))
    record = Record(periods, max(2, min(samples, FREE_SAMPLES // periods)))
    if load is not None:
        response = simulate_load(system, method, record=record, **options)
    else:
        response = simulate(system, eta, method, periods=periods, keep=periods, record=record, **options)
    return SettledRun(response, replace(_last_cycle(response, periods), repeats=False) if response.ok else None)


def _last_cycle(response: Response, periods: int) -> Cycle:
    length = periods * response.period
    begin = response.window[1] - length
    sampled, impacts = response.trajectory, response.impacts
    inside = (impacts.time > begin) & (impacts.time <= begin + length)
    time = sampled.time - begin
    values, slopes = sampled.displacement, sampled.velocity
    closings = impacts.time[inside] - begin
    if response.method.rigid:
        position = np.array([impacts.position[inside], impacts.position2(response.system)[inside]])
        time = np.concatenate([time, closings - INSTANT * length, closings + INSTANT * length])
        values = np.concatenate([values, position, position], axis=1)
        slopes = np.concatenate([slopes, impacts.velocity_before[inside].T, impacts.velocity_after[inside].T], axis=1)
    order = np.argsort(time, kind="stable")
    order = order[time[order] > -INSTANT * length]  # Newmark is sampled for more than one cycle
    order = order[np.diff(time[order], prepend=-np.inf) >= INSTANT * length]
    return Cycle(response.eta, periods, closings, response, time[order], values[:, order], slopes[:, order])


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
    held : bool
        Of a motion from its start: whether τ₀ is as early or as late as is allowed, so that another one may fit better.
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
    held: bool
    displacement: np.ndarray
    sensor: Sensor
    closing_error: float | None

    def is_within(self, noise: float) -> bool:
        """Whether the difference is no more than the noise of the measurement, in base amplitudes."""
        return rms(self.channels) <= WITHIN_NOISE * noise


def align(cycle: Cycle, measurement: Measurement, phase: float | None = None) -> Alignment:
    """Align a cycle with a measurement at the phase of the least squares, or at a given one.

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
    if phase is None:
        phase = best_phase(cycle, measurement, frame, cycle.phases(measurement))
    displacement = cycle.displacement(measurement.time + phase, frame)
    difference = measurement.residual(displacement)
    touching = cycle.touching(measurement.time + phase, sampling_interval(measurement))
    return Alignment(
        phase=phase,
        rms=rms(difference) / max(rms(measurement.displacement), 1e-300),
        channels=np.sqrt(np.mean(difference**2, axis=1)),
        offset=(measurement.displacement - displacement[: len(difference)]).mean(axis=1),
        held=not cycle.repeats and held_by_trigger(phase, measurement),
        displacement=displacement[: len(difference)],
        sensor=summarise_sensor(measurement.time, touching, cycle.eta),
        closing_error=_closing_error(cycle, measurement, phase),
    )


def best_phase(cycle: Cycle, measurement: Measurement, frame: str, grid: np.ndarray) -> float:
    """Return τ₀ in [0, pT) of the least squares: the best of a grid, refined by Gauss–Newton steps.

    Of a motion from its start it is the time since then, within the grid, and negative if the measurement began before.
    """
    thin = measurement.thinned(1000)  # samples are enough for the grid
    phase = min(grid, key=lambda shift: np.sum(_difference(cycle, thin, shift, frame) ** 2))
    for _ in range(8):  # Gauss–Newton steps
        slope = cycle.velocity(measurement.time + phase, frame)[: len(measurement.displacement)]
        step = np.sum(slope * _difference(cycle, measurement, phase, frame)) / max(np.sum(slope**2), 1e-300)
        phase += np.clip(step, grid[0] - grid[1], grid[1] - grid[0])
        phase = phase if cycle.repeats else np.clip(phase, grid[0], grid[-1])
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
