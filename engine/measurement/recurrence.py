"""What a measurement tells without any solution: whether it is in step with the excitation, and how noisy it is.

A motion of p excitation periods holds the harmonics kη/p, k = 0, 1, … and nothing else. So their least-squares fit
tells the period: the smallest p whose harmonics leave hardly more than those of longer cycles. What they leave is
noise, and the highest harmonics. If all leave much, the motion is not in step with the excitation: it is chaotic,
quasi-periodic, still settling, hidden by noise of a fifth of its size, or η (or the unit of time) is wrong.
"""

from dataclasses import dataclass

import numpy as np

from .measured import Measurement

COARSE = 2000  # samples are enough for harmonics
LONGEST = 4  # periods after which a measurement may repeat itself
HARMONICS = 24  # per excitation frequency
BETTER = 1.5  # a longer cycle must leave so many times less of the squares
RIDGE = 1e-12  # of the Gram matrix's diagonal
REFINED = 5  # steps towards the measurement's own frequency
UNEXPLAINED = 0.2  # of the measurement's size: more than this is not in step with the excitation


@dataclass(frozen=True)
class Sensor:
    """Samples of a contact sensor in short.

    Attributes
    ----------
    closings : (k,) ndarray
        τ of the samples at which it closes.
    per_period : float
        How often it closes in an excitation period.
    share : float
        Of the time that it is closed.
    """

    closings: np.ndarray
    per_period: float
    share: float


@dataclass(frozen=True)
class Recurrence:
    """What a measurement tells without a solution.

    Attributes
    ----------
    period : int
        Excitation periods until it repeats; 0 if it is not in step with the excitation.
    noise : float
        Standard deviation about the harmonics, in base amplitudes: noise, and what the highest harmonics hold.
    eta : float
        The excitation frequency near the given one whose harmonics explain most; nan if ``period`` is 0.
    strongest : float
        Frequency of the largest harmonic of the record, in ω₁.
    sensor : Sensor or None
        What the contact sensor tells, if there is one.
    """

    period: int
    noise: float
    eta: float
    strongest: float
    sensor: Sensor | None


def recurrence(measurement: Measurement, eta: float) -> Recurrence:
    """Whether a measurement is in step with the excitation, and what its sensor tells.

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
    thin = thinned(measurement)
    size = float(np.std(thin.displacement, axis=1).max())
    period, left = 1, _left(thin, eta, 1)
    for p in range(2, min(LONGEST, int(periods)) + 1):
        longer = _left(thin, eta, p)
        if BETTER * longer < left:
            period, left = p, longer
    if np.sqrt(left) > UNEXPLAINED * size:
        period = 0
    told = None if measurement.contact is None else sensor(measurement.time, measurement.contact, eta)
    return Recurrence(
        period=period,
        noise=float(np.sqrt(left)),
        eta=_own_frequency(thin, eta, period, periods) if period else float("nan"),
        strongest=_strongest(measurement),
        sensor=told,
    )


def sensor(time: np.ndarray, contact: np.ndarray, eta: float) -> Sensor:
    """What a contact sensor's samples (n,) tell; contacts between two samples are not seen."""
    span, weights = time[-1] - time[0], np.diff(time)
    closed = contact.astype(float)
    return Sensor(
        closings=time[1:][contact[1:] & ~contact[:-1]],
        per_period=float(np.sum(np.diff(closed) > 0) * 2 * np.pi / (eta * span)),
        share=float(np.sum(weights * (closed[1:] + closed[:-1]) / 2) / span),
    )


def thinned(measurement: Measurement, count: int = COARSE) -> Measurement:
    """At most so many of the samples, evenly taken."""
    some = np.unique(np.linspace(0, len(measurement) - 1, min(count, len(measurement))).astype(int))
    return Measurement(measurement.time[some], measurement.displacement[:, some], None, measurement.frame)


def _left(measurement: Measurement, eta: float, period: int) -> float:
    """Variance that harmonics of a cycle of so many periods leave, per degree of freedom."""
    basis, _ = _harmonics(measurement, eta, period)
    left = _apart(basis, measurement.displacement.T)
    return float(np.sum(left**2) / (2 * (len(measurement) - basis.shape[1])))


def _harmonics(measurement: Measurement, eta: float, period: int) -> tuple[np.ndarray, np.ndarray]:
    """1, cos kητ/p, sin kητ/p as columns, and τ times their derivatives, which is what they change by with ln η."""
    count = min(HARMONICS * period, (len(measurement) - 1) // 4)
    angles = np.outer(measurement.time, eta / period * np.arange(1, count + 1))
    cosines, sines, one = np.cos(angles), np.sin(angles), np.ones((len(measurement), 1))
    return np.hstack([one, cosines, sines]), np.hstack([0 * one, -angles * sines, angles * cosines])


def _solved(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    # the normal equations are as good as the fit itself: over whole cycles the basis is nearly orthogonal, and where a
    # gap in the record makes it less so, the ridge keeps out what cannot be told
    gram = basis.T @ basis
    return np.linalg.solve(gram + RIDGE * len(basis) * np.eye(len(gram)), basis.T @ rows)


def _apart(basis: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What the basis leaves of the rows."""
    return rows - basis @ _solved(basis, rows)


def _own_frequency(measurement: Measurement, eta: float, period: int, periods: float) -> float:
    """The frequency near η whose harmonics leave least, within half a turn over the record: Gauss and Newton's steps.

    Only the part of the change with η that the harmonics cannot follow tells anything of η.
    """
    rows, found, width = measurement.displacement.T, eta, 0.5 / periods
    for _ in range(REFINED):
        basis, change = _harmonics(measurement, found, period)
        drift = _apart(basis, change @ _solved(basis, rows))
        step = np.sum(drift * _apart(basis, rows)) / max(np.sum(drift**2), 1e-300)
        found = float(np.clip(found * (1 + step), eta * (1 - width), eta * (1 + width)))
    return found


def _strongest(measurement: Measurement) -> float:
    """Frequency of the largest peak in the spectrum, of samples made equally spaced."""
    count = min(len(measurement), 2**16)
    even = np.linspace(0, measurement.span, count)
    rows = np.stack([np.interp(even, measurement.time, row) for row in measurement.displacement])
    rows = (rows - rows.mean(axis=1, keepdims=True)) * np.hanning(count)
    power = np.sum(np.abs(np.fft.rfft(rows, axis=1)) ** 2, axis=0)
    return float(2 * np.pi * np.argmax(power) / measurement.span * (count - 1) / count)
