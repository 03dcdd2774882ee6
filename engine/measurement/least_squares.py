"""The least-squares problem of a fit: its residuals and Jacobian, its initial guesses, and its minima."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from vibroscope.engine.measurement.alignment import align
from vibroscope.engine.measurement.cycle import Cycle, free_motion, reference_cycle
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.tolerances import CONTACT_DIFFERENCE, FIT_DIFFERENCE
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System
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
        cancelled: Callable[[], bool] | None,
        initial: Sequence[float] | None = REST,
    ):
        self.system, self.eta, self.measurement, self.names = system, eta, measurement, names
        self.method, self.cancelled, self.initial = method, cancelled, initial
        self.last_state = REST  # of the last cycle found
        self.lower = np.append([-np.inf if name in ZEROS else 0.0 for name in names], -np.inf)
        self.upper = np.append([UPPER.get(name, np.inf) for name in names], np.inf)

    def guesses(self) -> list[np.ndarray]:
        """Return different initial values of the constants, each within its range."""
        guesses = []
        for change in GUESSES:
            factor = change.get("damping", 1.0)
            values = [
                change.get("restitution", self.system.restitution)
                if name == "restitution"
                else 0.0
                if name in ZEROS
                else 1.0
                if name == SCALE
                else factor * constant(self.system, name, self.method)
                for name in self.names
            ]
            values = np.clip(values, 0.0, self.upper[:-1])
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
            span = self.measurement.span
            return free_motion(system, self.eta, method, span, initial=self.initial, cancelled=cancelled).cycle
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
