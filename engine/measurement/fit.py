"""Fit of the restitution and the damping to a measurement, with standard errors.

The paper (section 3) determines e and the damping from the measured motion by eye. Here they, and the phase τ₀ at which
the measurement begins, minimise the sum of squares of measured − reference over all samples of both displacements. With
independent noise of one size σ_n, the estimates scatter about the truth with the covariance

    C = σ_n² (JᵀJ)⁻¹,    σ_n² = Σ r² / (2n − k),                                                 (59)

where J is the Jacobian of the residuals r and k the number of estimates, τ₀ included. The standard errors are the
square roots of its diagonal. They hold if the model is right: if the residuals are larger than the measurement's own
noise, or depend on each other, a remark says so.

Not every constant can be determined from every motion. One that does not change the motion (d₃ where no contact is
permanent) has a column of zeros: it keeps its value, and its error is infinite. Two that change the motion alike are
strongly correlated.

The reference is used in the limit ε → 0 of its threshold (:class:`engine.Reference`), in which the motion depends
smoothly on e: with a threshold, the number of impacts of a chatter jumps. The sum of squares still has several minima,
so the search starts from several guesses.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import shown
from ..facts import Amount, Statement, equation, stated
from ..methods import Reference
from ..model import BODY_2, System, check_eta
from .least_squares import UPPER, FitProblem, constant
from .measurement import Measurement
from .recurrence import recurrence
from .tolerances import AT_BOUND, CORRELATED, DEPENDENT, INVISIBLE, NOISIER, SAME_MINIMUM

FITTED = tuple(UPPER)


@dataclass(frozen=True)
class Fit:
    """Outcome of :func:`fit`.

    Attributes
    ----------
    system : System
        With the fitted constants.
    values, errors : dict
        Value and standard error of each constant asked for; the error is infinite if it cannot be determined.
    correlation : (k, k) ndarray
        Of the constants that can be determined, in their order.
    phase : float
        τ₀, τ of the reference's cycle at the first sample.
    deviation : float
        Standard deviation of the residuals, in base amplitudes.
    noise : float
        The measurement's own, see :class:`.recurrence.Recurrence`.
    agreeing, starts : int
        How many of the initial guesses led to this minimum, and how many led to any.
    remarks : tuple of str or Statement
        Reservations about the numbers.
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
    names: Sequence[str] | None = None,
    method: Reference | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Fit:
    """Fit constants of the system to a measurement.

    Parameters
    ----------
    system : System
        The initial guess; constants that are not fitted keep its values.
    eta : float
        Excitation frequency η = Ω/ω₁ of the measurement.
    measurement : Measurement
    names : sequence of {"restitution", "d1", "d2", "d3"}, optional
        Constants to fit; by default all that the system has: a wall has neither d2 nor d3.
    method : Reference, optional
        By default with the threshold 0, in whose limit the motion depends smoothly on e.
    cancelled : callable, optional
        Polled many times a second; when it returns true the fit is cancelled.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a name is unknown, given twice or not of this system, a number is out of range, or the motion is nowhere
        periodic.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import System, fit, synthetic_measurement
    >>> made = synthetic_measurement(System(restitution=0.45), 2.76, noise=0.01)
    >>> found = fit(System(), 2.76, made, names=["restitution"])
    >>> print(f"{found.values['restitution']:.2f}")
    0.45
    """
    names = fitted_names(system) if names is None else tuple(names)
    known = all(isinstance(name, str) and name in UPPER for name in names)
    if not names or not known or len(set(names)) < len(names):
        raise ValueError(
            f"cannot fit {shown(names) if names else 'nothing'}: give some of {', '.join(UPPER)}, each once"
        )
    if idle := [name for name in names if system.wall and name in BODY_2]:
        raise ValueError(f"cannot fit {', '.join(idle)}: a wall has no such number, leave it out")
    eta, measurement = check_eta(eta), measurement.of(system)
    noise = recurrence(measurement, eta).noise
    problem = FitProblem(system, eta, measurement, names, method or Reference(threshold=0.0), cancelled)
    minima = [minimum for guess in problem.guesses() if (minimum := problem.minimum(guess)) is not None]
    if not minima:
        where = equation("eta", eta)
        raise ValueError(
            stated("the reference is not periodic at {} near this system: there is no cycle to fit", where)
        )
    best = min(minima, key=lambda minimum: minimum.cost)
    agreeing = sum(bool(minimum.cost <= best.cost * (1 + SAME_MINIMUM)) for minimum in minima)
    return _result(problem, best.x, noise, agreeing, len(minima))


def fitted_names(system: System) -> tuple[str, ...]:
    """The constants that a system has and that can be fitted.

    Examples
    --------
    >>> from vibroscope.engine import System, fitted_names
    >>> fitted_names(System(wall=True))
    ('restitution', 'd1')
    """
    return tuple(name for name in FITTED if not (system.wall and name in BODY_2))


def _result(problem: FitProblem, best: np.ndarray, noise: float, agreeing: int, starts: int) -> Fit:
    """Return the fit at a minimum, with errors from the Jacobian there."""
    names, residuals, jacobian = problem.names, problem.residuals(best), problem.jacobian(best)
    sizes = np.linalg.norm(jacobian, axis=0)
    visible = sizes > INVISIBLE * sizes.max()
    degrees = max(len(residuals) - int(visible.sum()), 1)
    deviation = float(np.sqrt(residuals @ residuals / degrees))
    # columns of length one: small dampings and a large phase need different measures of what is negligible
    columns = jacobian[:, visible] / sizes[visible]
    covariance = np.linalg.pinv(columns.T @ columns)
    scale = np.sqrt(np.diag(covariance))
    errors = np.full(len(best), np.inf)
    errors[visible] = deviation * scale / sizes[visible]
    fitted = visible[:-1].sum()
    correlation = (covariance / np.outer(scale, scale))[:fitted, :fitted]
    determined = [name for name, shown in zip(names, visible, strict=False) if shown]
    system = replace(problem.system, **{name: float(best[names.index(name)]) for name in determined})
    return Fit(
        system=system,
        values={name: constant(system, name) for name in names},
        errors=dict(zip(names, errors.tolist(), strict=False)),
        correlation=correlation,
        phase=float(np.mod(best[-1], problem.cycle(best).length)),
        deviation=deviation,
        noise=noise,
        agreeing=agreeing,
        starts=starts,
        remarks=tuple(_remarks(names, best, determined, correlation, problem.by_body(residuals), deviation, noise)),
    )


def _remarks(names, best, determined, correlation, rows, deviation, noise) -> Iterator[str | Statement]:
    """Yield reservations about a fit, in words."""
    for name in names:
        if name not in determined:
            yield f"{name} does not change this motion and was left as it is"
    for name, value in zip(names, best, strict=False):
        if name in determined and not AT_BOUND < value < UPPER[name] - AT_BOUND:
            yield f"{name} ended at the edge of its range, where the standard errors do not hold"
    for i, one in enumerate(determined):
        for j in range(i):
            if abs(correlation[i, j]) > CORRELATED:
                yield f"{determined[j]} and {one} can hardly be distinguished (correlation {correlation[i, j]:.3f})"
    neighbours = np.sum(rows[:, 1:] * rows[:, :-1]) / max(np.sum(rows**2), 1e-300)
    if deviation > NOISIER * noise:
        yield stated(
            "the residual ({}) is larger than the measurement's own noise ({}): the reference moves otherwise, and the "
            "standard errors do not hold",
            *(Amount(value, "displacement", 3) for value in (deviation, noise)),
        )
    if neighbours > DEPENDENT:
        yield f"neighbouring residuals depend on each other ({neighbours:.2f}): the standard errors are too small"
