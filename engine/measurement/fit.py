"""Fit of the restitution and the damping to a measurement, with standard errors.

The paper (section 3) determines e and the damping from the measured motion by eye. Here they, and the phase τ₀ at which
the measurement begins, minimise the sum of squares of measured − reference over all samples of both displacements. With
independent noise of one size σ_n, the estimates scatter about the truth with the covariance

    C = σ_n² (JᵀJ)⁻¹,    σ_n² = Σ r² / (2n − k),                                                 (59)

where J is the Jacobian of the residuals r and k the number of estimates, τ₀ included. The standard errors are the
square roots of its diagonal. They hold if the model is right: if the residuals are larger than the measurement's own
noise, or depend on each other, a remark says so.

The zero of a sensor is what it shows where the displacement is 0. It is fitted like a constant, since an unknown zero
is taken for another mean of the motion, which e and the damping change. A scale that all sensors have in common is
fitted where it is asked for.

Not every constant can be determined from every motion. One that does not change the motion (d₃ where no contact is
permanent) has a column of zeros: it keeps its value, and its error is infinite. Two that change the motion alike are
strongly correlated.

The reference is used in the limit ε → 0 of its threshold (:class:`engine.Reference`), in which the motion depends
smoothly on e: with a threshold, the number of impacts of a chatter jumps. The sum of squares still has several minima,
so the search starts from several guesses.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import Poll, shown
from vibroscope.engine.facts import Amount, Statement, equation, stated
from vibroscope.engine.measurement.cycle import (
    Cycle,
    align,
    free_motion,
    free_offsets,
    held_by_trigger,
    held_words,
    reference_cycle,
)
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.recurrence import free_record, recurrence
from vibroscope.engine.measurement.tolerances import (
    AT_BOUND,
    CONTACT_DIFFERENCE,
    CORRELATED,
    DEPENDENT,
    EXPLAINS,
    FIT_DIFFERENCE,
    INVISIBLE,
    NOISIER,
    SAME_MINIMUM,
    WITHIN_NOISE,
)
from vibroscope.engine.methods import ExactPenalty, Reference, TimeStepping
from vibroscope.engine.model import BODY_2, System, check_eta
from vibroscope.engine.motions.steady import REST

CONTACT = {"K": "stiffness", "D": "damping"}  # of a penalty solution
ZEROS = ("zero1", "zero2")  # what the sensor of each body shows where its displacement is 0
SCALE = "scale"  # what the sensors show of a displacement of one
UPPER = {"restitution": 1.0, "d1": 0.5, "d2": 0.5, "d3": 0.5}
# Initial guesses, as changes of the given system: a restitution, or a factor of the dampings
GUESSES = ({}, {"restitution": 0.2}, {"restitution": 0.8}, {"damping": 0.5}, {"damping": 2.0})
FREE_GUESSES = 41  # of the restitution, for a motion from its start …
FREE_MINIMA = 3  # … of which the best are refined
FREE_ROUNDS = 3  # at most, each with the other constants of the one before


def constant(system: System, name: str, method: Reference | ExactPenalty | None = None) -> float:
    """A constant that can be fitted; d₃ as it follows from the dampers where it was never measured."""
    if name in CONTACT:
        return getattr(method, CONTACT[name])
    return system.joint_damping("table") if name == "d3" else getattr(system, name)


class FitProblem:
    """Residuals and Jacobian as functions of the fitted constants and, last, the phase.

    Parameters
    ----------
    system : System
        The initial guess; constants that are not fitted keep its values.
    eta : float
    measurement : Measurement
    names : tuple of str
        The constants to fit, out of `UPPER`, those of a penalty solution, out of `CONTACT`, zeros of sensors, out of
        `ZEROS`, and `SCALE`.
    method : Reference or ExactPenalty
    cancelled : callable or None
    initial : (4,) sequence or None
        The start of bodies that nothing drives, which are followed from there.
    """

    def __init__(
        self,
        system: System,
        eta: float,
        measurement: Measurement,
        names: tuple[str, ...],
        method: Reference | ExactPenalty,
        cancelled: Poll | None,
        initial: Sequence[float] | None = REST,
    ):
        self.system, self.eta, self.measurement, self.names = system, eta, measurement, names
        self.method, self.cancelled, self.initial = method, cancelled, initial
        self.last_state = REST  # of the last cycle found
        early, late = (-np.inf, np.inf) if system.excitation.repeats else free_offsets(measurement)
        self.lower = np.append([-np.inf if name in ZEROS else 0.0 for name in names], early)
        self.upper = np.append([UPPER.get(name, np.inf) for name in names], late)

    def guesses(self) -> list[np.ndarray]:
        """Return different initial values of the constants, each within its range."""
        guesses = []
        for change in GUESSES:
            e = change.get("restitution", self.system.restitution)
            own = dict.fromkeys(ZEROS, 0.0) | {SCALE: 1.0, "restitution": e}
            others = (name for name in self.names if name not in own)
            own |= {name: change.get("damping", 1.0) * constant(self.system, name, self.method) for name in others}
            values = np.clip([own[name] for name in self.names], 0.0, self.upper[:-1])
            if not any(np.array_equal(values, other) for other in guesses):
                guesses.append(values)
        return guesses if self.system.excitation.repeats else self.nearest(guesses)

    def nearest(self, guesses: list[np.ndarray]) -> list[np.ndarray]:
        """The best guesses for a motion from its start, whose later impacts fit only near the right contact.

        The other constants are those of the first of the given guesses.
        """
        first = dict(zip(self.names, guesses[0].tolist(), strict=True))
        if "restitution" in first:
            guesses = [np.array([*(first | {"restitution": one}).values()]) for one in np.linspace(0, 1, FREE_GUESSES)]
        elif CONTACT.keys() & first.keys():  # K up to a hundred times as large or small, and D at other damping ratios
            of_spring, of_damper = (np.array([name == own for name in self.names]) for own in CONTACT)
            stiffer = np.logspace(-2, 2, 7) if of_spring.any() else [1.0]
            more = np.logspace(-1, 1, 11) if of_damper.any() else [1.0]
            guesses = [
                guesses[0] * one**of_spring * (one**0.5 * other) ** of_damper
                for one, other in itertools.product(stiffer, more)
            ]
        cycles = [self.cycle(guess) for guess in guesses]
        off = [np.inf if cycle is None else align(cycle, self.measurement).rms for cycle in cycles]
        return [guesses[i] for i in np.argsort(off)[:FREE_MINIMA]]

    def system_of(self, parameters: np.ndarray) -> System:
        """Return the system with these constants."""
        fitted = zip(self.names, parameters[: len(self.names)].tolist(), strict=True)
        return replace(self.system, **{name: value for name, value in fitted if name in UPPER})

    def cycle(self, parameters: np.ndarray) -> Cycle | None:
        """Find the solution's cycle, from the last one found: it is close, and the same one if several exist."""
        system, cancelled = self.system_of(parameters), self.cancelled
        fitted = zip(self.names, parameters[: len(self.names)].tolist(), strict=True)
        method = replace(self.method, **{CONTACT[name]: value for name, value in fitted if name in CONTACT})
        if not system.excitation.repeats:
            options = {"initial": self.initial, "cancelled": cancelled}
            return free_motion(system, self.eta, method, self.measurement, **options).cycle
        found = reference_cycle(system, self.eta, method, initial=self.last_state, cancelled=cancelled)
        if found.cycle is not None:
            # rounding may leave pendulums that touch in each other
            self.last_state = system.without_penetration(found.response.section[-1])
        return found.cycle

    def minimum(self, guess: np.ndarray):
        """Return the minimum that SciPy finds from a guess; None if the motion is not periodic there."""
        self.last_state = REST
        cycle = self.cycle(guess)
        if cycle is None:
            return None
        free = any(name in ZEROS for name in self.names)
        known = replace(self.measurement, mean_known=self.measurement.mean_known and not free)
        aligned = align(cycle, known)
        zeros = dict(zip(ZEROS, aligned.offset.tolist(), strict=False))
        start = [zeros.get(name, value) for name, value in zip(self.names, guess, strict=True)]
        return _least_squares()(
            self.residuals,
            np.append(start, aligned.phase),
            jac=self.jacobian,
            bounds=(self.lower, self.upper),
            x_scale=[*map(self._scale, self.names), 0.1],
            max_nfev=60,  # per guess
        )

    def _scale(self, name: str) -> float:
        """How much a fitted number may change."""
        if name in CONTACT:
            return 0.1 * max(constant(self.system, name, self.method), 1.0)
        return 0.1 if name == "restitution" else 0.01

    def residuals(self, parameters: np.ndarray) -> np.ndarray:
        """Return scale · solution + zeros − measured, (2n,) or (n,); 0 − measured where the motion is not periodic."""
        measured = self.measurement
        cycle = self.cycle(parameters)
        if cycle is None:
            return -measured.displacement.ravel()
        moved = cycle.displacement(measured.time + parameters[-1], measured.frame)
        return -measured.residual(self._of_sensors(parameters) * moved + self._zeros(parameters)).ravel()

    def _of_sensors(self, parameters: np.ndarray) -> float:
        """The scale of the sensors."""
        return parameters[self.names.index(SCALE)] if SCALE in self.names else 1.0

    def _zeros(self, parameters: np.ndarray) -> np.ndarray:
        """What the sensors show at rest, (2, 1); 0 of those that are not fitted."""
        return np.array([[parameters[self.names.index(name)] if name in self.names else 0.0] for name in ZEROS])

    def by_body(self, residuals: np.ndarray) -> np.ndarray:
        """The residuals of each measured body, (2, n) or (1, n)."""
        return residuals.reshape(self.measurement.displacement.shape)

    def jacobian(self, parameters: np.ndarray) -> np.ndarray:
        """Return the Jacobian, (2n, k) or (n, k): differences, one-sided at a bound, and for the phase velocities.

        The zero of a sensor is in each of its own residuals.
        """
        columns = []
        for i, name in enumerate(self.names):
            if name in ZEROS:
                own = np.arange(len(self.measurement.displacement))[:, None] == ZEROS.index(name)
                columns.append(np.broadcast_to(own, self.measurement.displacement.shape).ravel().astype(float))
                continue
            sides, step = np.tile(parameters, (2, 1)), FIT_DIFFERENCE
            if name in CONTACT:
                step = CONTACT_DIFFERENCE * max(parameters[i], 1.0)
            sides[:, i] = np.clip(parameters[i] + np.array([-step, step]), self.lower[i], self.upper[i])
            below, above = map(self.residuals, sides)
            columns.append((above - below) / (sides[1, i] - sides[0, i]))
        cycle, measured = self.cycle(parameters), self.measurement
        if cycle is None:
            velocity = 0 * measured.displacement
        else:
            moving = cycle.velocity(measured.time + parameters[-1], measured.frame)
            velocity = self._of_sensors(parameters) * moving[: len(measured.displacement)]
        return np.stack([*columns, velocity.ravel()], axis=1)


def _least_squares() -> Callable:
    try:
        from scipy.optimize import least_squares  # not at the top: the page and its image do without SciPy
    except ImportError:
        raise ValueError("a fit needs SciPy: install the package with its extra named fit, vibroscope[fit]") from None
    return least_squares


FITTED = (*UPPER, *CONTACT, *ZEROS, SCALE)


@dataclass(frozen=True)
class Fit:
    """Outcome of :func:`fit`.

    Attributes
    ----------
    system : System
        With the fitted constants.
    values, errors : dict
        Value and standard error of each constant asked for; the error is infinite if it cannot be determined. Zeros of
        sensors are in base amplitudes.
    correlation : (k, k) ndarray
        Of the constants that can be determined, in their order.
    phase : float
        τ₀, τ of the reference's cycle at the first sample; of a motion from its start, the time since then.
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

    def applied(self, method: TimeStepping) -> TimeStepping:
        """The method with the fitted K and D."""
        return replace(method, **{CONTACT[name]: value for name, value in self.values.items() if name in CONTACT})

    def corrected(self, measurement: Measurement) -> Measurement:
        """The measurement less the fitted zeros of its sensors, over their fitted scale."""
        zeros = np.array([[self.values.get(name, 0.0)] for name in ZEROS])
        shown = measurement.displacement - zeros[: len(measurement.displacement)]
        return replace(measurement, displacement=shown / self.values.get(SCALE, 1.0))


def fit(
    system: System,
    eta: float,
    measurement: Measurement,
    *,
    names: Sequence[str] | None = None,
    method: Reference | ExactPenalty | None = None,
    initial: Sequence[float] | None = None,
    cancelled: Poll | None = None,
) -> Fit:
    """Fit constants of the system to a measurement.

    Parameters
    ----------
    system : System
        The initial guess; constants that are not fitted keep its values.
    eta : float
        Excitation frequency η = Ω/ω₁ of the measurement.
    measurement : Measurement
    names : sequence of {"restitution", "d1", "d2", "d3", "K", "D", "zero1", "zero2", "scale"}, optional
        What to fit, by default everything in :func:`fitted_names`. The scale is that of all sensors, beside which the
        amplitude of the excitation must be known.
    method : Reference or ExactPenalty, optional
        By default the reference with the threshold 0, in whose limit the motion depends smoothly on e. K and D need a
        penalty solution, which has their initial guess.
    initial : (4,) sequence, optional
        The start ξ₁, ξ₁′, ξ₂, ξ₂′ of bodies that nothing drives, or a load that is no harmonic, from which they are
        followed; by default rest.
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
    names = fitted_names(system, measurement) if names is None else tuple(names)
    _refuse_names(names, system, measurement, method)
    eta, measurement = check_eta(eta), measurement.of(system)
    noise = (recurrence if system.excitation.repeats else free_record)(measurement, eta).noise
    problem = FitProblem(system, eta, measurement, names, method or Reference(threshold=0.0), cancelled, initial)
    minima = _minima(problem, problem.guesses())
    rounds = 0 if system.excitation.repeats or not minima else FREE_ROUNDS
    for _ in range(rounds):  # the contact is searched again with what was found of the rest
        best = min(minima, key=lambda minimum: minimum.cost)
        if np.sqrt(np.mean(best.fun**2)) <= WITHIN_NOISE * noise:
            break
        minima += _minima(problem, problem.nearest([best.x[:-1]]))
        if min(minimum.cost for minimum in minima) >= best.cost * (1 - SAME_MINIMUM):
            break
    if not minima:
        where = equation("eta", eta)
        raise ValueError(
            stated("the reference is not periodic at {} near this system: there is no cycle to fit", where)
        )
    best = min(minima, key=lambda minimum: minimum.cost)
    agreeing = sum(bool(minimum.cost <= best.cost * (1 + SAME_MINIMUM)) for minimum in minima)
    found = _result(problem, best.x, noise, agreeing, len(minima))
    left = [name for name in fitted_names(system, measurement) if name in ZEROS and name not in names]
    if left and found.deviation > NOISIER * noise:
        other = fit(
            system, eta, measurement, names=(*names, *left), method=method, initial=initial, cancelled=cancelled
        )
        if other.deviation < EXPLAINS * found.deviation:
            words = "fitted with the zeros of the sensors, too, the residual is {}: fit {} as well"
            remark = stated(words, Amount(other.deviation, "displacement", 3), ", ".join(left))
            found = replace(found, remarks=(*found.remarks, remark))
    return found


def _refuse_names(
    names: tuple[str, ...], system: System, measurement: Measurement, method: Reference | ExactPenalty | None
) -> None:
    """Raise ValueError for what cannot be fitted, in general or by this method."""
    known = all(isinstance(name, str) and name in FITTED for name in names)
    if not names or not known or len(set(names)) < len(names):
        raise ValueError(
            f"cannot fit {shown(names) if names else 'nothing'}: give some of {', '.join(FITTED)}, each once"
        )
    if idle := [name for name in names if system.wall and name in BODY_2]:
        raise ValueError(f"cannot fit {', '.join(idle)}: a wall has no such number, leave it out")
    contact = [name for name in names if name in CONTACT]
    has_restitution = isinstance(method, ExactPenalty) and method.damping is None  # from which its law takes D
    of_reference = [name for name in names if name == "d3" or (name == "restitution" and not has_restitution)]
    if contact and of_reference:
        raise ValueError(
            f"cannot fit {', '.join(of_reference)} beside {', '.join(contact)}: the penalty solution, which has K and "
            f"D, has no {' and no '.join(of_reference)}; fit D in place of restitution, or leave K and D out"
        )
    if contact and not isinstance(method, ExactPenalty):
        raise ValueError(f"cannot fit {', '.join(contact)}, which the reference does not have: give a penalty solution")
    if "D" in contact and method.damping is None:
        raise ValueError("cannot fit D, which follows from the restitution: give D, or leave it out")
    if idle := [name for name in names if name in ZEROS and name not in fitted_names(system, measurement)]:
        raise ValueError(f"cannot fit {', '.join(idle)}: no sensor shows the mean of this displacement, leave it out")


def _minima(problem: FitProblem, guesses: Sequence[np.ndarray]) -> list:
    """What SciPy finds from each guess at which there is a motion to fit."""
    return [minimum for guess in guesses if (minimum := problem.minimum(guess)) is not None]


def fitted_names(system: System, measurement: Measurement | None = None) -> tuple[str, ...]:
    """What can be fitted: the constants that a system has, and the zeros of the sensors that a measurement has.

    Examples
    --------
    >>> from vibroscope.engine import System, fitted_names
    >>> fitted_names(System(wall=True))
    ('restitution', 'd1', 'zero1')
    """
    bodies = 1 if system.wall or (measurement is not None and len(measurement.displacement) == 1) else 2
    zeros = ZEROS[:bodies] if measurement is None or measurement.mean_known else ()
    return (*(name for name in UPPER if not (system.wall and name in BODY_2)), *zeros)


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
    cycle = problem.cycle(best)
    remarks = list(_remarks(problem, best, determined, correlation, residuals, deviation, noise))
    if agreeing == 1 < starts:
        remarks.append(
            f"only 1 of {starts} starts led here: other values may fit as well; begin with better ones, or fit fewer"
        )
    found = {name: float(best[names.index(name)]) for name in determined}
    system = replace(problem.system, **{name: value for name, value in found.items() if name in UPPER})
    return Fit(
        system=system,
        values={name: found[name] if name in found else constant(system, name, problem.method) for name in names},
        errors=dict(zip(names, errors.tolist(), strict=False)),
        correlation=correlation,
        phase=float(cycle.within(best[-1]) if cycle.repeats else best[-1]),
        deviation=deviation,
        noise=noise,
        agreeing=agreeing,
        starts=starts,
        remarks=tuple(remarks),
    )


def _remarks(problem, best, determined, correlation, residuals, deviation, noise) -> Iterator[str | Statement]:
    """Yield reservations about a fit, in words."""
    names, rows = problem.names, problem.by_body(residuals)
    for name in names:
        if name not in determined:
            yield f"{name} does not change this motion and was left as it is"
    for name, value, lower, upper in zip(names, best, problem.lower, problem.upper, strict=False):
        if name in determined and not lower + AT_BOUND < value < upper - AT_BOUND:
            yield f"{name} ended at the edge of its range, where the standard errors do not hold"
    if not problem.system.excitation.repeats and held_by_trigger(best[-1], problem.measurement):
        yield held_words(best[-1])
    for i, one in enumerate(determined):
        for j in range(i):
            if abs(correlation[i, j]) > CORRELATED:
                yield f"{determined[j]} and {one} can hardly be distinguished (correlation {correlation[i, j]:.3f})"
    neighbours = np.sum(rows[:, 1:] * rows[:, :-1]) / max(np.sum(rows**2), 1e-300)
    if deviation > NOISIER * noise:
        of_sensors = [name for name in (*ZEROS[: len(rows)], SCALE) if name not in names]
        yield stated(
            "the residual ({}) is larger than the measurement's own noise ({}): the {} moves otherwise, and the "
            "standard errors do not hold{}",
            *(Amount(value, "displacement", 3) for value in (deviation, noise)),
            "reference" if problem.method.rigid else "penalty solution",
            f"; where sensors may be off, fit {', '.join(of_sensors)}, too" if of_sensors else "",
        )
    if neighbours > DEPENDENT:
        yield f"neighbouring residuals depend on each other ({neighbours:.2f}): the standard errors are too small"
