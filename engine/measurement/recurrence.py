"""Properties of a measurement alone: whether it is in phase with the excitation, and how noisy it is.

A motion of p excitation periods consists of the harmonics iη/p, i = 0, 1, …, and nothing else. So their least-squares
fit finds the period: the smallest p whose harmonics leave hardly more than those of longer cycles. What they leave is
noise, and the harmonics beyond those fitted. If all p leave much, the motion is not in phase with the excitation: it is
chaotic, quasi-periodic, still settling, hidden by noise of a fifth of its size, or η (or the unit of time) is wrong.

With few samples a period, harmonics coincide at the samples (aliasing), and a fit uses up as many degrees of freedom as
harmonics differ there: the trace of its hat matrix. A longer cycle is found only if what it leaves is smaller by more
than chance explains; and where the harmonics of the excitation reproduce those of a longer cycle at the samples, these
do not show which of the two it is.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.facts import OMEGA1, equation, stated
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.tolerances import (
    BETTER,
    CERTAIN_SIGMAS,
    HIDDEN,
    INTEGRATED,
    LAST_DIGITS,
    NORMAL_MEDIAN,
    NYQUIST,
    OVERLAP,
    RIDGE,
    UNEXPLAINED,
    UNOBSERVED,
)

HARMONIC_SAMPLES = 2000  # samples are enough for the harmonics
LONGEST = 4  # periods after which a measurement may repeat itself
HARMONICS = 24  # per excitation frequency


@dataclass(frozen=True)
class Sensor:
    """Summary of the samples of a contact sensor.

    Attributes
    ----------
    closings : (m,) ndarray
        τ of the samples at which it closes.
    per_period : float
        Closings per excitation period; each counts by how often its phase was observed, so that neither gaps in the
        record nor its end within a period change the number.
    share : float
        Share of the observed time in which it is closed.
    """

    closings: np.ndarray
    per_period: float
    share: float


@dataclass(frozen=True)
class Recurrence:
    """Properties of a measurement that need no solution.

    Attributes
    ----------
    period : int
        Excitation periods until it repeats itself, the smallest number that the samples allow; 0 if it is not in phase
        with the excitation.
    possible : tuple of int
        Periods that the samples cannot tell apart, ``period`` among them; empty if that is 0, but of a motion from its
        start (0,).
    noise : float
        Standard deviation about the harmonics, in base amplitudes: noise, and the harmonics beyond those fitted. 0 of
        data that have none beyond rounding.
    eta : float
        The excitation frequency near the given one whose harmonics fit best; nan if ``period`` is 0.
    eta_error : float
        Its standard error.
    strongest : float
        Frequency of the largest peak of the spectrum, in units of ω₁.
    sensor : Sensor or None
        Summary of the contact sensor, if there is one.
    """

    period: int
    possible: tuple[int, ...]
    noise: float
    eta: float
    eta_error: float
    strongest: float
    sensor: Sensor | None


def recurrence(measurement: Measurement, eta: float) -> Recurrence:
    """Find the period and the noise of a measurement.

    Raises
    ------
    ValueError
        If it covers less than an excitation period.
    """
    periods = measurement.span * eta / (2 * np.pi)
    if periods < 1:
        raise ValueError(
            stated(
                "the measurement covers {} periods of the excitation at {}: give at least one, and check the unit of "
                "time and {}",
                f"{periods:.3g}",
                equation("eta", eta),
                OMEGA1,
            )
        )
    thin = measurement.thinned(HARMONIC_SAMPLES)
    size = float(np.std(thin.displacement, axis=1).max())
    period, possible, variance = _period(thin, eta, periods)
    if np.sqrt(variance) > UNEXPLAINED * size:
        period, possible = 0, ()
    own, error = _own_frequency(thin, eta, max(possible), periods) if period else (np.nan, np.nan)
    noise = _beyond_rounding(float(np.sqrt(variance)), size)
    return Recurrence(period, possible, noise, own, error, _strongest_frequency(measurement), _sensor(measurement, eta))


def free_record(measurement: Measurement, eta: float) -> Recurrence:
    """The properties of a measurement of a motion from its start, which has no period.

    Its noise is the median size of third differences, which a smooth motion does not have; impacts are rare.

    Raises
    ------
    ValueError
        If it holds accelerations, of which only a steady motion shows the displacements.
    """
    if not measurement.mean_known:
        raise ValueError("accelerations do not show where a motion that nothing drives starts: give displacements")
    rows = measurement.displacement
    third = np.abs(np.diff(rows, 3, axis=1)) / np.sqrt(20.0)  # 1, 3, 3, 1: of noise of size 1 their size is √20
    size = np.median(third, axis=1) / NORMAL_MEDIAN
    noise = _beyond_rounding(rms(size), float(np.std(rows, axis=1).max()))
    return Recurrence(0, (0,), noise, np.nan, np.nan, _strongest_frequency(measurement), _sensor(measurement, eta))


def _sensor(measurement: Measurement, eta: float) -> Sensor | None:
    contact = measurement.contact
    return None if contact is None else summarise_sensor(measurement.time, contact, eta)


def _beyond_rounding(noise: float, size: float) -> float:
    """The noise of a measurement of this size; 0 where it is rounding."""
    return noise if noise > LAST_DIGITS * size else 0.0


def summarise_sensor(time: np.ndarray, contact: np.ndarray, eta: float) -> Sensor:
    """Summarise the samples (n,) of a contact sensor; contacts between two samples are not seen."""
    intervals = np.diff(time)
    observed = intervals <= UNOBSERVED * np.median(intervals)
    weights = observed / _passes(time, observed, 2 * np.pi / eta)
    closed, length = contact.astype(float), np.sum(weights * intervals)
    closes = contact[1:] & ~contact[:-1]
    return Sensor(
        closings=time[1:][closes],
        per_period=float(np.sum(weights[closes]) * 2 * np.pi / (eta * length)),
        share=float(np.sum(weights * intervals * (closed[1:] + closed[:-1]) / 2) / length),
    )


def _passes(time: np.ndarray, observed: np.ndarray, period: float) -> np.ndarray:
    """How often the phase of each interval between samples, (n − 1,), was observed; at least once.

    A record covers some phases of the excitation more often than others, unless it has no gap and ends after a whole
    period. What happens at such a phase would count more often than it does in a period.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], observed, [False]]).astype(int)))
    begin, length = time[edges[::2]], time[edges[1::2]] - time[edges[::2]]
    start = np.sort(np.mod(begin, period))
    end = np.sort(np.mod(begin, period) + np.mod(length, period))  # of what exceeds whole periods
    phase = np.mod((time[1:] + time[:-1]) / 2, period)
    wrapped = len(end) - np.searchsorted(end, phase + period)
    parts = np.searchsorted(start, phase, side="right") - np.searchsorted(end, phase) + wrapped
    return np.maximum(np.sum(length // period) + parts, 1)


class _Fitted(NamedTuple):
    """What the harmonics of a cycle leave: the variance per degree of freedom, and how many of these there are."""

    variance: float
    freedom: float


def _period(measurement: Measurement, eta: float, periods: float) -> tuple[int, tuple[int, ...], float]:
    """Return the period, those that the samples cannot tell from it, and the variance that its harmonics leave."""
    candidates = range(1, max(1, min(LONGEST, int(periods / OVERLAP + 1e-9))) + 1)
    fitted = {period: _fitted(measurement, eta, period) for period in candidates}
    period = 1
    for longer in candidates[1:]:
        if _better(fitted[period], fitted[longer]):
            period = longer
    doubtful = [
        longer
        for longer in candidates[period:]
        if _better(fitted[period], fitted[longer]) is None or _is_hidden(measurement, eta, period, longer)
    ]
    return period, (period, *doubtful), fitted[period].variance


def _better(fitted: _Fitted, longer: _Fitted) -> bool | None:
    """Whether a longer cycle leaves less of the squares than chance explains; None: less, but chance may explain it."""
    ratio = fitted.variance / max(longer.variance, 1e-300)
    if ratio <= BETTER:
        return False
    return True if ratio > 1 + CERTAIN_SIGMAS * np.sqrt(2 / longer.freedom) else None


def _fitted(measurement: Measurement, eta: float, period: int, highest: float = np.inf) -> _Fitted:
    """Fit the harmonics of a cycle of so many periods, up to a frequency."""
    basis, _ = harmonics(measurement, eta, period, highest)
    rows = measurement.displacement.T
    gram = basis.T @ basis
    used = np.trace(np.linalg.solve(gram + RIDGE * len(basis) * np.eye(len(gram)), gram))
    freedom = max(rows.shape[1] * (len(basis) - used), 1.0)
    drift = 0.0 if measurement.mean_known else INTEGRATED * float(np.std(rows, axis=0).max())
    return _Fitted(max(float(np.sum(_residual(basis, rows) ** 2) / freedom), drift**2), float(freedom))


def _is_hidden(measurement: Measurement, eta: float, period: int, longer: int) -> bool:
    """Whether the samples show either a longer cycle, or harmonics of the shorter one above half the sampling rate.

    They may where those harmonics reproduce, at the samples, the lowest ones that only the longer cycle has. They do
    where without them the longer cycle leaves less.
    """
    basis, _ = harmonics(measurement, eta, period)
    orders = [order for order in range(1, 2 * longer) if order * period % longer]
    angles = np.outer(measurement.time, eta / longer * np.array(orders))
    waves = np.hstack([np.cos(angles), np.sin(angles)])
    if not (np.sum(_residual(basis, waves) ** 2, axis=0) < HIDDEN * np.sum(waves**2, axis=0)).any():
        return False
    slow, slower = (_fitted(measurement, eta, one, _half_rate(measurement)) for one in (period, longer))
    return _better(slow, slower) is not False


def _half_rate(measurement: Measurement) -> float:
    """Half the mean sampling rate, in units of ω₁, less a margin."""
    return NYQUIST * np.pi * (len(measurement) - 1) / measurement.span


def harmonics(
    measurement: Measurement, eta: float, period: int, highest: float = np.inf
) -> tuple[np.ndarray, np.ndarray]:
    """Return 1, cos iητ/p, sin iητ/p as columns up to a frequency, and their derivatives with respect to ln η."""
    count = min(HARMONICS * period, (len(measurement) - 1) // 4)
    if count * eta / period > highest:
        count = max(1, int(highest * period / eta))
    angles = np.outer(measurement.time, eta / period * np.arange(1, count + 1))
    cosines, sines, one = np.cos(angles), np.sin(angles), np.ones((len(measurement), 1))
    return np.hstack([one, cosines, sines]), np.hstack([0 * one, -angles * sines, angles * cosines])


def coefficients(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the least-squares coefficients of the rows.

    Normal equations are accurate enough: over whole cycles the basis is nearly orthogonal. Where a gap in the record
    makes it less so, the ridge suppresses what cannot be determined.
    """
    gram = basis.T @ basis
    return np.linalg.solve(gram + RIDGE * len(basis) * np.eye(len(gram)), basis.T @ rows)


def _residual(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return rows - basis @ coefficients(basis, rows)


def _own_frequency(measurement: Measurement, eta: float, period: int, periods: float) -> tuple[float, float]:
    """Return the frequency near η whose harmonics leave least, by Gauss–Newton steps, and its standard error.

    It differs from η by at most half a turn over the record. The harmonics change with η; only the part of that
    change counts that other amplitudes of the harmonics cannot reproduce. Harmonics above half the sampling rate
    coincide with lower ones, whose derivatives are others, so that they are left out.
    """
    rows, frequency, width = measurement.displacement.T, eta, 0.5 / periods
    highest = _half_rate(measurement)
    for _ in range(5):  # Gauss–Newton steps towards the measurement's own frequency
        basis, derivative = harmonics(measurement, frequency, period, highest)
        drift = _residual(basis, derivative @ coefficients(basis, rows))
        remaining, weight = _residual(basis, rows), max(np.sum(drift**2), 1e-300)
        step = np.sum(drift * remaining) / weight
        frequency = float(np.clip(frequency * (1 + step), eta * (1 - width), eta * (1 + width)))
    freedom = max(rows.size - rows.shape[1] * basis.shape[1], 1)
    return frequency, float(frequency * np.sqrt(np.sum(remaining**2) / freedom / weight))


def _strongest_frequency(measurement: Measurement) -> float:
    """Return the frequency of the largest peak of the spectrum, after interpolation to equally spaced samples."""
    count = min(len(measurement), 2**16)
    even = np.linspace(0, measurement.span, count)
    rows = np.stack([np.interp(even, measurement.time, row) for row in measurement.displacement])
    rows = (rows - rows.mean(axis=1, keepdims=True)) * np.hanning(count)
    power = np.sum(np.abs(np.fft.rfft(rows, axis=1)) ** 2, axis=0)
    return float(2 * np.pi * np.argmax(power) / measurement.span * (count - 1) / count)
