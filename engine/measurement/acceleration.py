"""Displacements from accelerations: integrated twice, without the drift that integration adds.

The integral x̃ of an acceleration differs from the displacement by what the velocity and the displacement at the start
and a bias of the sensor add, a polynomial c₀ + c₁t + c₂t². A motion in step with the excitation has no part that grows,
so that the polynomial is found by a least-squares fit to x̃ together with harmonics of η/p. It takes the mean of the
displacement with it, which an accelerometer does not show.
"""

import numpy as np
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.recurrence import HARMONIC_SAMPLES, LONGEST, coefficients, harmonics
from vibroscope.engine.measurement.tolerances import OVERLAP


def integrated(time: np.ndarray, acceleration: np.ndarray, eta: float) -> np.ndarray:
    """Displacements without their means, (k, n), from accelerations of fixed sensors, (k, n), in units of the model.

    Parameters
    ----------
    time : (n,) ndarray
        τ, increasing from 0.
    acceleration : (k, n) ndarray
    eta : float
        Excitation frequency, about.
    """
    moved = Measurement(time, _integral(time, _integral(time, acceleration)), None, "absolute")
    thin = moved.thinned(HARMONIC_SAMPLES)
    period = max(1, min(LONGEST, int(moved.span * eta / (2 * np.pi) / OVERLAP)))
    basis, _ = harmonics(thin, eta, period)
    growing = np.vander(thin.time / moved.span, 3, increasing=True)
    found = coefficients(np.hstack([growing, basis[:, 1:]]), thin.displacement.T)[:3]
    rest = moved.displacement - (np.vander(time / moved.span, 3, increasing=True) @ found).T
    return rest - rest.mean(axis=1, keepdims=True)


def _integral(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The integral from the first sample on, by the trapezoidal rule, (k, n)."""
    steps = np.diff(time) * (values[:, 1:] + values[:, :-1]) / 2
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(steps, axis=1)], axis=1)
