"""Restitution and damping fitted to a measurement, with what can be said of their errors.

The paper (section 3) takes e and the damping from the measured motion by eye. Here they, and the phase δ at which the
measurement begins, are the least squares of measured − reference over all samples of both displacements. With
independent noise of one size σ, the estimates scatter about the truth with the covariance

    C = σ² (JᵀJ)⁻¹,    σ² = Σ r² / (2n − k),

J the Jacobian of the residuals r and k the number of parameters; the standard errors are the roots of its diagonal.
That holds if the model is right: if the residuals are larger than the measurement's own noise or depend on each other,
the fit says so.

Not everything can be read from every motion. A parameter that does not change the motion (d₃ where no contact is
permanent) has a column of zeros: it keeps its value and its error is infinite. Two that change it alike are strongly
correlated.

The reference is taken in the limit ε → 0 (:class:`engine.Reference`), in which the motion depends smoothly on e: with
a threshold, the number of impacts of a chatter jumps. The squares still have several minima, so the search begins at
several places.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..methods import Reference
from ..model import System, check_eta
from .measured import Measurement
from .problem import UPPER, Problem
from .recurrence import recurrence

FITTED = tuple(UPPER)
ALIKE = 1e-6  # relative: sums of squares that differ by less are the same minimum
BLIND = 1e-6  # of the largest column, per unit: a parameter that changes the motion so little does not show
CLOSE = 0.95  # correlation worth telling
NOISIER = 1.5  # than the measurement's own noise: the model does not hold
DEPENDENT = 0.3  # correlation of neighbouring residuals: they are not independent noise


@dataclass(frozen=True)
class Fit:
    """Outcome of :func:`fit`.

    Attributes
    ----------
    system : System
        With the fitted constants.
    values, errors : dict
        Of each parameter asked for; the standard error is infinite if the motion does not show it.
    correlation : (k, k) ndarray
        Of those that show, in their order.
    phase : float
        δ, τ of the reference's cycle at the first sample.
    deviation : float
        Standard deviation of the residuals, in base amplitudes.
    noise : float
        The measurement's own, see :class:`.recurrence.Recurrence`.
    agreeing, starts : int
        How many of the starts led to this minimum.
    remarks : tuple of str
        What to know before the numbers are used.
    """

    system: System
    values: dict[str, float]
    errors: dict[str, float]
    correlation: np.ndarray
    phase: float
    deviation: float
    noise: float
    agreeing: int
    starts: int
    remarks: tuple[str, ...]


def fit(
    system: System,
    eta: float,
    measurement: Measurement,
    *,
    names: Sequence[str] = FITTED,
    method: Reference | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Fit:
    """Fit constants of the system to a measurement.

    Parameters
    ----------
    system : System
        Where to begin; constants that are not fitted keep its values.
    eta : float
        Excitation frequency η = Ω/ω₁ of the measurement.
    measurement : Measurement
    names : sequence of {"restitution", "d1", "d2", "d3"}
        What to fit.
    method : Reference, optional
        By default with the threshold 0, see above.
    cancelled : callable, optional
        Polled many times a second; when it returns true the fit is withdrawn.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a name is unknown or given twice, a number is out of range, or the motion is nowhere periodic.
    Cancelled
        If ``cancelled`` returned true.
    """
    names = tuple(names)
    unknown = [name for name in names if name not in UPPER]
    if unknown or not names or len(set(names)) < len(names):
        raise ValueError(f"cannot fit {', '.join(names) or 'nothing'}: give some of {', '.join(UPPER)}, each once")
    eta = check_eta(eta, system)
    noise = recurrence(measurement, eta).noise
    problem = Problem(system, eta, measurement, names, method or Reference(threshold=0.0), cancelled)
    found = [result for start in problem.starts() if (result := problem.minimum(start)) is not None]
    if not found:
        raise ValueError(f"the reference is not periodic at eta = {eta:g} near this system: there is no cycle to fit")
    best = min(found, key=lambda result: result.cost)
    agreeing = sum(bool(result.cost <= best.cost * (1 + ALIKE)) for result in found)
    return _concluded(problem, best.x, noise, agreeing, len(found))


def _concluded(problem: Problem, best: np.ndarray, noise: float, agreeing: int, starts: int) -> Fit:
    names, residuals, jacobian = problem.names, problem.residuals(best), problem.jacobian(best)
    sizes = np.linalg.norm(jacobian, axis=0)
    shown = sizes > BLIND * sizes.max()
    degrees = max(len(residuals) - int(shown.sum()), 1)
    deviation = float(np.sqrt(residuals @ residuals / degrees))
    # columns of length one: else a small damping and a large phase would share one measure of what is negligible
    spread = np.linalg.pinv((jacobian[:, shown] / sizes[shown]).T @ (jacobian[:, shown] / sizes[shown]))
    errors = np.full(len(best), np.inf)
    errors[shown] = deviation * np.sqrt(np.diag(spread)) / sizes[shown]
    scale = np.sqrt(np.diag(spread))
    correlation = (spread / np.outer(scale, scale))[: shown[:-1].sum(), : shown[:-1].sum()]
    visible = [name for name, yes in zip(names, shown, strict=False) if yes]
    system = problem.system_of(np.where(shown, best, np.append([getattr(problem.system, n) for n in names], 0.0)))
    return Fit(
        system=system,
        values={name: getattr(system, name) for name in names},
        errors=dict(zip(names, errors.tolist(), strict=False)),
        correlation=correlation,
        phase=float(np.mod(best[-1], problem.cycle(best).length)),
        deviation=deviation,
        noise=noise,
        agreeing=agreeing,
        starts=starts,
        remarks=tuple(_remarks(names, best, visible, correlation, residuals, deviation, noise)),
    )


def _remarks(names, best, visible, correlation, residuals, deviation, noise):
    for name in names:
        if name not in visible:
            yield f"{name} does not change this motion and was left as it is"
    for name, value in zip(names, best, strict=False):
        if name in visible and not 1e-6 < value < UPPER[name] - 1e-6:
            yield f"{name} ended at the edge of its range, where the standard errors do not hold"
    for i, one in enumerate(visible):
        for j in range(i):
            if abs(correlation[i, j]) > CLOSE:
                yield f"{visible[j]} and {one} can hardly be told apart (correlation {correlation[i, j]:.3f})"
    rows = residuals.reshape(2, -1)
    neighbours = np.sum(rows[:, 1:] * rows[:, :-1]) / max(np.sum(rows**2), 1e-300)
    if deviation > NOISIER * noise:
        yield (
            f"the residual ({deviation:.3g}) is larger than the measurement's own noise ({noise:.3g}): the reference "
            "moves otherwise, and the standard errors do not hold"
        )
    if neighbours > DEPENDENT:
        yield f"neighbouring residuals depend on each other ({neighbours:.2f}): the standard errors are too small"
