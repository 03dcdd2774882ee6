"""The least squares of a fit: residuals and Jacobian, where the search begins, and the minimum it comes to."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..methods import Reference
from ..model import System
from .alignment import best_phase
from .cycle import Cycle, reference_cycle
from .measured import Measurement

UPPER = {"restitution": 1.0, "d1": 0.5, "d2": 0.5, "d3": 0.5}
STEP = 1e-5  # of the central differences; the reference's cycle is known to some 1e-8
STARTS = ({}, {"restitution": 0.2}, {"restitution": 0.8}, {"damping": 0.5}, {"damping": 2.0})
REST = (0.0, 0.0, 0.0, 0.0)
EVALUATIONS = 60  # per start


class Problem:
    """Residuals and Jacobian as functions of the parameters and, last, the phase.

    Parameters
    ----------
    system : System
        Where to begin; constants that are not fitted keep its values.
    eta : float
    measurement : Measurement
    names : tuple of str
        What to fit, out of `UPPER`.
    method : Reference
    cancelled : callable or None
    """

    def __init__(
        self,
        system: System,
        eta: float,
        measurement: Measurement,
        names: tuple[str, ...],
        method: Reference,
        cancelled: Callable[[], bool] | None,
    ):
        self.system, self.eta, self.measurement, self.names = system, eta, measurement, names
        self.method, self.cancelled = method, cancelled
        self.near = REST
        self.lower = np.append(np.zeros(len(names)), -np.inf)
        self.upper = np.append([UPPER[name] for name in names], np.inf)

    def starts(self) -> list[np.ndarray]:
        """Parameters to begin the search with, each within its range."""
        begun = []
        for change in STARTS:
            damping = change.get("damping", 1.0)
            values = [
                change.get("restitution", self.system.restitution)
                if name == "restitution"
                else damping * getattr(self.system, name)
                for name in self.names
            ]
            values = np.clip(values, 0.0, self.upper[:-1])
            if not any(np.array_equal(values, other) for other in begun):
                begun.append(values)
        return begun

    def system_of(self, parameters) -> System:
        """The system with these parameters."""
        changed = dict(zip(self.names, parameters[: len(self.names)].tolist(), strict=True))
        return replace(self.system, **changed)

    def cycle(self, parameters) -> Cycle | None:
        """The reference's motion, looked for from the last one found: it is near, and the same where several are."""
        system = self.system_of(parameters)
        found = reference_cycle(system, self.eta, self.method, initial=self.near, cancelled=self.cancelled)
        if found.cycle is not None:
            x1, v1, x2, v2 = found.response.section[-1].tolist()
            self.near = x1, v1, max(x1, x2), v2  # rounding may leave a touching pair in each other
        return found.cycle

    def minimum(self, start: np.ndarray):
        """The minimum that the search comes to; None if the motion is not periodic where it begins."""
        self.near = REST
        cycle = self.cycle(start)
        if cycle is None:
            return None
        phase = best_phase(cycle, self.measurement, self.measurement.frame)
        return _least_squares()(
            self.residuals,
            np.append(start, phase),
            jac=self.jacobian,
            bounds=(self.lower, self.upper),
            x_scale=np.append(np.where(np.array(self.names) == "restitution", 0.1, 0.01), 0.1),
            max_nfev=EVALUATIONS,
        )

    def residuals(self, parameters: np.ndarray) -> np.ndarray:
        """Reference − measured, (2n,); without a periodic motion the reference explains nothing."""
        measured = self.measurement
        cycle = self.cycle(parameters)
        if cycle is None:
            return -measured.displacement.ravel()
        found = cycle.displacement(measured.time + parameters[-1], measured.frame)
        return (found - measured.displacement).ravel()

    def jacobian(self, parameters: np.ndarray) -> np.ndarray:
        """Central differences, one-sided at a bound, and the velocity for the phase; (2n, k)."""
        columns = []
        for i in range(len(self.names)):
            sides = np.tile(parameters, (2, 1))
            sides[:, i] = np.clip(parameters[i] + np.array([-STEP, STEP]), self.lower[i], self.upper[i])
            below, above = map(self.residuals, sides)
            columns.append((above - below) / (sides[1, i] - sides[0, i]))
        cycle, measured = self.cycle(parameters), self.measurement
        moving = cycle is not None
        velocity = (
            cycle.velocity(measured.time + parameters[-1], measured.frame) if moving else 0 * measured.displacement
        )
        return np.stack([*columns, velocity.ravel()], axis=1)


def _least_squares() -> Callable:
    try:
        from scipy.optimize import least_squares  # the page and its image do without SciPy
    except ImportError:
        raise ValueError("a fit needs SciPy: install the package with its extra named fit, vibroscope[fit]") from None
    return least_squares
