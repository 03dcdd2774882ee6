"""The conditioning of a run: the error that no solver in double precision can undercut.

Every number of the data carries a relative rounding error ε_m = 2⁻⁵². A solver is as accurate as possible if its error
is not much larger than the change of the result when the data change by ε_m. This change is not measured at ε_m, where
it would include the solver's own errors, but at a larger relative change r, and scaled down: the solver's errors then
contribute at most the fraction ε_m/r. r is the largest change for which no event appears or disappears and the result
changes in proportion to r. The change per relative error is the *sensitivity*; with a rounding error for each radian of
the fastest motion, and MARGIN = 64 for what each piece of a run rounds,

    attainable error = 64 ε_m (sensitivity + accumulated rounding),        ε_m = 2⁻⁵².        (43)

In a grazing impact there is no such r: the smallest change decides whether there is an impact. A gap in error by δg
changes the speed of such an impact by at most √(2 g″ δg): only half of the digits are left.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.contact import contact_frequency
from vibroscope.engine.drivers.event_driven import contact_state, displaced_state
from vibroscope.engine.hardcases.tolerances import MARGIN, PIECE, PROPORTION, ROUNDED_CHANGE
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.result import Response
from vibroscope.engine.simulate import simulate

EPSILON = float(np.finfo(float).eps)
RELATIVE_CHANGES = tuple(10.0**-k for k in range(6, 13))

Change = Callable[["SimulationSetup", float], "SimulationSetup"]


@dataclass(frozen=True)
class SimulationSetup:
    """The arguments of a simulation that keeps all its periods."""

    system: System
    eta: float
    method: Method
    periods: int
    initial: tuple[float, float, float, float] | None = REST

    def solve(self, **options) -> Response:
        """Simulate; ``options`` are further arguments of :func:`engine.simulate`."""
        return simulate(
            self.system,
            self.eta,
            self.method,
            periods=self.periods,
            keep=self.periods,
            initial=self.initial,
            **options,
        )


def sensitivity(setup: SimulationSetup) -> float | None:
    """Return the largest change of a state of the section per relative change of the data, summed over all data.

    Returns
    -------
    float or None
        None if an event appears or disappears at the smallest change that can be measured, as in a grazing impact.
    """
    response = setup.solve()
    parts = [_sensitivity_to(response, setup, change) for change in _changes(setup)]
    return None if None in parts else sum(parts)


def attainable_error(setup: SimulationSetup) -> float | None:
    """Return the error that a solver in double precision may have; None as for :func:`sensitivity`."""
    measured = sensitivity(setup)
    return None if measured is None else MARGIN * EPSILON * (measured + accumulated_rounding(setup))


def attainable_grazing_error(setup: SimulationSetup, clear: SimulationSetup) -> float:
    """Return the same for a run with a grazing impact.

    Parameters
    ----------
    clear : SimulationSetup
        The same run, except that the pendulums pass at a small distance instead of grazing.
    """
    size = _size(clear.solve())
    acceleration = max(1.0, setup.system.kappa) ** 2 * size + setup.eta**2
    speed = np.sqrt(2 * acceleration * MARGIN * EPSILON * size)
    return float(2 * speed * max(1.0, sensitivity(clear) / size))


def accumulated_rounding(setup: SimulationSetup) -> float:
    """Return the sum of the rounding errors of the states in units of ε_m: one per PIECE of motion and contact."""
    response = setup.solve()
    angle = response.window[1] * max(1.0, setup.system.kappa, setup.eta)
    touching = float((response.contacts[:, 1] - response.contacts[:, 0]).sum())
    angle += touching * contact_frequency(setup.system, setup.method.numbers.get("K", 0.0))
    return _size(response) * (1 + angle / PIECE)


def _size(response: Response) -> float:
    """Largest number of the section; at least η, since a body at rest in space has ξ′ = η sin ητ."""
    return float(max(np.abs(response.section).max(), response.eta))


def _sensitivity_to(response: Response, setup: SimulationSetup, change: Change) -> float | None:
    """Change of the result per relative change of one number; None if it cannot be measured."""
    for relative in RELATIVE_CHANGES:
        once, twice, back = (
            _section_with_same_events(response, change(setup, factor * relative)) for factor in (1, 2, -1)
        )
        if once is None or twice is None or back is None:
            continue
        small = np.abs(once - back).max() / 2
        noise = ROUNDED_CHANGE * np.abs(response.section).max()
        if small <= noise or PROPORTION[0] <= np.abs(twice - response.section).max() / small <= PROPORTION[1]:
            return float(max(small, np.abs(once - response.section).max()) / relative)
    return None


def _section_with_same_events(response: Response, changed: SimulationSetup) -> np.ndarray | None:
    """Return the section of a changed run; None if it has more or fewer events."""
    try:
        other = changed.solve()
    except ValueError:  # the change leads out of the allowed range
        return None
    same = len(other.impacts) == len(response.impacts) and len(other.contacts) == len(response.contacts)
    return other.section if other.status == response.status and same else None


def _changes(setup: SimulationSetup) -> Iterator[Change]:
    """Yield a function for each number of the data that changes this number of a setup by a relative amount."""
    yield lambda old, r: replace(old, eta=old.eta * (1 + r))
    # κ and κ₃ matter by their distances from 1 and from each other; as frequencies they are covered by η
    yield lambda old, r: replace(old, system=_with_frequencies_apart(old.system, 1 + r))
    for name in ("d1", "d2", "d3", "clearance"):
        if getattr(setup.system, name):
            yield lambda old, r, name=name: replace(old, system=_scaled(old.system, name, 1 + r))
    if setup.method.rigid and 0 < setup.system.restitution < 1:
        yield lambda old, r: replace(old, system=_scaled(old.system, "restitution", 1 + r))
    for name, value in setup.system.excitation.numbers().items():
        if value != 0 and (name, value) != ("base", 1.0):  # with a base of 1 the lengths are counted in it
            yield lambda old, r, name=name: replace(
                old, system=replace(old.system, excitation=_scaled(old.system.excitation, name, 1 + r))
            )
    if not (setup.method.rigid or setup.method.has_step):
        for name in ("stiffness", "damping"):
            if getattr(setup.method, name) > 0:
                yield lambda old, r, name=name: replace(old, method=_scaled(old.method, name, 1 + r))
    if setup.initial is None:
        return
    for i, value in enumerate(contact_state(setup.system, setup.initial)):
        if value != 0:
            yield lambda old, r, i=i: replace(old, initial=_with_scaled_coordinate(old, i, 1 + r))


def _scaled(holder, name: str, factor: float):
    return replace(holder, **{name: getattr(holder, name) * factor})


def _with_frequencies_apart(system: System, factor: float) -> System:
    """Scale the distances of κ and κ₃ from 1, or the mass ratio where it is given."""
    if system.mu is not None:
        return replace(system, kappa=1 + (system.kappa - 1) * factor, mu=system.mu * factor)
    return replace(system, kappa=1 + (system.kappa - 1) * factor, kappa3=1 + (system.kappa3 - 1) * factor)


def _with_scaled_coordinate(setup: SimulationSetup, i: int, factor: float) -> tuple[float, ...]:
    """Scale ξ₁, ξ₁′, the gap or its rate; bodies that touch keep the gap zero."""
    y = contact_state(setup.system, setup.initial)
    y[i] *= factor
    return tuple(displaced_state(setup.system, y).tolist())
