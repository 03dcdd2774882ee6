"""Properties of a measurement alone: whether it is in phase with the excitation, and how noisy it is.

A motion of p excitation periods consists of the harmonics iη/p, i = 0, 1, …, and nothing else. So their least-squares
fit finds the period: the smallest p whose harmonics leave hardly more than those of longer cycles. What they leave is
noise, and the harmonics beyond those fitted. If all p leave much, the motion is not in phase with the excitation: it is
chaotic, quasi-periodic, still settling, hidden by noise of a fifth of its size, or η (or the unit of time) is wrong.
"""

from dataclasses import dataclass

import numpy as np

from .measurement import Measurement

COARSE = 2000  # samples are enough for the harmonics
LONGEST = 4  # periods after which a measurement may repeat itself
HARMONICS = 24  # per excitation frequency
BETTER = 1.5  # a longer cycle must leave so many times less of the squares
RIDGE = 1e-12  # of the Gram matrix's diagonal
REFINEMENTS = 5  # Gauss–Newton steps towards the measurement's own frequency
UNEXPLAINED = 0.2  # of the measurement's size: if more remains, it is not in phase with the excitation


@dataclass(frozen=True)
class Sensor:
    """Summary of the samples of a contact sensor.

    Attributes
    ----------
    closings : (m,) ndarray
        τ of the samples at which it closes.
    per_period : float
        Closings per excitation period.
    share : float
        Share of the time in which it is closed.
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
        Excitation periods until it repeats itself; 0 if it is not in phase with the excitation.
    noise : float
        Standard deviation about the harmonics, in base amplitudes: noise, and the harmonics beyond those fitted.
    eta : float
        The excitation frequency near the given one whose harmonics fit best; nan if ``period`` is 0.
    strongest : float
        Frequency of the largest peak of the spectrum, in units of ω₁.
    sensor : Sensor or None
        Summary of the contact sensor, if there is one.
    """

    period: int
    noise: float
    eta: float
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
            f"the measurement covers {periods:.3g} periods of the excitation at eta = {eta:g}: give at least one, "
            "and check the unit of time and omega1"
        )
    thin = measurement.thinned(COARSE)
    size = float(np.std(thin.displacement, axis=1).max())
    period, variance = 1, _residual_variance(thin, eta, 1)
    for longer in range(2, min(LONGEST, int(periods)) + 1):
        remaining = _residual_variance(thin, eta, longer)
        if BETTER * remaining < variance:
            period, variance = longer, remaining
    if np.sqrt(variance) > UNEXPLAINED * size:
        period = 0
    contact = measurement.contact
    return Recurrence(
        period=period,
        noise=float(np.sqrt(variance)),
        eta=_own_frequency(thin, eta, period, periods) if period else float("nan"),
        strongest=_strongest_frequency(measurement),
        sensor=None if contact is None else summarise_sensor(measurement.time, contact, eta),
    )


def summarise_sensor(time: np.ndarray, contact: np.ndarray, eta: float) -> Sensor:
    """Summarise the samples (n,) of a contact sensor; contacts between two samples are not seen."""
    span, intervals = time[-1] - time[0], np.diff(time)
    closed = contact.astype(float)
    return Sensor(
        closings=time[1:][contact[1:] & ~contact[:-1]],
        per_period=float(np.sum(np.diff(closed) > 0) * 2 * np.pi / (eta * span)),
        share=float(np.sum(intervals * (closed[1:] + closed[:-1]) / 2) / span),
    )


def _residual_variance(measurement: Measurement, eta: float, period: int) -> float:
    """Variance, per degree of freedom, that the harmonics of a cycle of so many periods leave."""
    basis, _ = _harmonics(measurement, eta, period)
    residual = _residual(basis, measurement.displacement.T)
    return float(np.sum(residual**2) / (2 * (len(measurement) - basis.shape[1])))


def _harmonics(measurement: Measurement, eta: float, period: int) -> tuple[np.ndarray, np.ndarray]:
    """Return 1, cos iητ/p, sin iητ/p as columns, and their derivatives with respect to ln η."""
    count = min(HARMONICS * period, (len(measurement) - 1) // 4)
    angles = np.outer(measurement.time, eta / period * np.arange(1, count + 1))
    cosines, sines, one = np.cos(angles), np.sin(angles), np.ones((len(measurement), 1))
    return np.hstack([one, cosines, sines]), np.hstack([0 * one, -angles * sines, angles * cosines])


def _coefficients(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the least-squares coefficients of the rows.

    Normal equations are accurate enough: over whole cycles the basis is nearly orthogonal. Where a gap in the record
    makes it less so, the ridge suppresses what cannot be determined.
    """
    gram = basis.T @ basis
    return np.linalg.solve(gram + RIDGE * len(basis) * np.eye(len(gram)), basis.T @ rows)


def _residual(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return rows - basis @ _coefficients(basis, rows)


def _own_frequency(measurement: Measurement, eta: float, period: int, periods: float) -> float:
    """Return the frequency near η whose harmonics leave least, by Gauss–Newton steps.

    It differs from η by at most half a turn over the record. The harmonics change with η; only the part of that
    change counts that other amplitudes of the harmonics cannot reproduce.
    """
    rows, frequency, width = measurement.displacement.T, eta, 0.5 / periods
    for _ in range(REFINEMENTS):
        basis, derivative = _harmonics(measurement, frequency, period)
        drift = _residual(basis, derivative @ _coefficients(basis, rows))
        step = np.sum(drift * _residual(basis, rows)) / max(np.sum(drift**2), 1e-300)
        frequency = float(np.clip(frequency * (1 + step), eta * (1 - width), eta * (1 + width)))
    return frequency


def _strongest_frequency(measurement: Measurement) -> float:
    """Return the frequency of the largest peak of the spectrum, after interpolation to equally spaced samples."""
    count = min(len(measurement), 2**16)
    even = np.linspace(0, measurement.span, count)
    rows = np.stack([np.interp(even, measurement.time, row) for row in measurement.displacement])
    rows = (rows - rows.mean(axis=1, keepdims=True)) * np.hanning(count)
    power = np.sum(np.abs(np.fft.rfft(rows, axis=1)) ** 2, axis=0)
    return float(2 * np.pi * np.argmax(power) / measurement.span * (count - 1) / count)
