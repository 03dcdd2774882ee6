"""Shock response: the largest motion of body 1 under one load over its natural frequency, with and without its stops.

The spring of body 1 alone varies. Its mass, its damping ratio, the clearances, K and D of the contact, the time step
and body 2 stay as they are in physical units; only what they are counted in, 1/ω₁, differs.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import Poll, require, shown
from vibroscope.engine.facts import Amount, message_of, stated
from vibroscope.engine.load import Load
from vibroscope.engine.methods import STEPS_RANGE, Method, Reference
from vibroscope.engine.model import FAR_OPEN, System
from vibroscope.engine.transients.run import CYCLE, FREE_CYCLES, Transient, transient
from vibroscope.engine.units import Units

RATIO_RANGE = (1e-3, 1e3)


@dataclass(frozen=True)
class ShockResponse:
    """Outcome of :func:`engine.shock_response`.

    Attributes
    ----------
    ratio : (n,) ndarray
        Natural frequency of body 1 in units of ω₁ of the system that was given.
    displacement, acceleration : (n,) ndarray
        Largest displacement relative to the base and absolute acceleration of body 1, during the load and after it, in
        units of length, and of that times ω₁² of the system that was given; nan where it is not finite, as within an
        impact of the reference.
    displacement_without, acceleration_without : (n,) ndarray
        The same of body 1 alone, without a stop or body 2: the shock response spectrum (maximax).
    impulse : (n,) ndarray
        The largest impulse of a contact, in units of m₁ω₁ times the length, with the same ω₁.
    """

    ratio: np.ndarray
    displacement: np.ndarray
    acceleration: np.ndarray
    displacement_without: np.ndarray
    acceleration_without: np.ndarray
    impulse: np.ndarray


def shock_response(
    system: System,
    load: Load,
    ratios: Sequence[float],
    method: Method | None = None,
    *,
    cancelled: Poll | None = None,
) -> ShockResponse:
    """Run a system under a base shock with other natural frequencies of body 1, and body 1 alone.

    The spring of body 1 changes, and its damper by its damping ratio. All else is what it was in physical units: both
    masses, spring and damper of body 2, a measured damping ratio of the joined bodies, clearances, K, D and the time
    step, but for whole steps in the new 2π/ω₁, rounded up. The threshold of the reference stays the same number, as in
    a system that is given with this natural frequency in the first place.

    Parameters
    ----------
    system : System
        Body 1 with a spring, and no constant forces.
    load : Load
        Acceleration of the base.
    ratios : sequence of float
        Natural frequencies of body 1 in units of ω₁.
    method : Method, optional
        By default the reference. K and D are in units of the system that is given, the steps in its 2π/ω₁.
    cancelled : callable, optional
        Polled many times a second; when it returns true the study is cancelled.

    Returns
    -------
    ShockResponse

    Raises
    ------
    ValueError
        If the load is a force, body 1 has no spring, there is a constant force, a number is out of range with one of
        the frequencies, or a run ends early.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Load, System, shock_response
    >>> found = shock_response(System(wall=True, d1=0.0, clearance=0.5), Load.half_sine(-1.0, 3.14159265), [1.0])
    >>> found.displacement.round(4).tolist(), found.displacement_without.round(4).tolist()
    ([0.5], [1.5708])
    """
    method, excitation = method or Reference(), system.excitation
    if load.on != "base":
        raise ValueError(f"on = {load.on!r}: a shock response is that to a motion of the base; give on = 'base'")
    if not system.spring1 or excitation.constant1 or excitation.constant2:
        raise ValueError("a shock response needs a spring, which gives the natural frequency, and no constant forces")
    values = [require("ratio", each, *RATIO_RANGE, "give natural frequencies in units of ω₁") for each in ratios]
    if not values:
        raise ValueError(f"ratios = {shown(ratios)} is empty: give natural frequencies in units of ω₁")
    rows = []
    for ratio in values:
        try:
            rows.append(_row(system, load, method, ratio, cancelled))
        except ValueError as error:
            where = Amount(ratio, "frequency")
            raise ValueError(stated("natural frequency {} of body 1: {}", where, message_of(error))) from None
    return ShockResponse(np.array(values), *np.array(rows).T)


def with_natural_frequency(system: System, method: Method, ratio: float) -> tuple[System, Method]:
    """System and method, counted in the new 1/ω₁, where the spring of body 1 gives it ``ratio`` times the former ω₁.

    Raises
    ------
    ValueError
        If the frequency ratio of the bodies, K, D or the steps in the new 2π/ω₁ are out of range.
    """
    own = {"d1": system.d1 / math.sqrt(system.spring1), "spring1": 1.0}
    if not system.wall:
        own |= {"kappa": system.kappa / ratio, "mu": system.mass_ratio}
        own["d2"] = system.d2 if system.kappa else system.d2 / ratio  # a damper where there is no spring
    numbers = {}
    if not method.rigid:
        before, after = (Units(omega1=each).of_contact(method) for each in (1.0, ratio))
        given = {"stiffness": method.stiffness, "damping": method.damping}
        numbers = {
            name: after.model(f"contact_{name}", before.physical(f"contact_{name}", value))
            for name, value in given.items()
            if value is not None
        }
    if method.has_step:
        steps = method.steps / ratio
        if steps < STEPS_RANGE[0]:
            raise ValueError(f"its natural period has {steps:.3g} time steps: give at least {STEPS_RANGE[0]}")
        numbers["steps"] = math.ceil(steps * (1 - 1e-9))
    return replace(system, **own), replace(method, **numbers) if numbers else method


def _row(system: System, load: Load, method: Method, ratio: float, cancelled: Poll | None) -> tuple[float, ...]:
    """What :class:`ShockResponse` has of one natural frequency."""
    system, method = with_natural_frequency(system, method, ratio)
    load = load.scaled(ratio, 1.0 / ratio**2)
    alone = System(wall=True, d1=system.d1, clearance=FAR_OPEN)
    largest = max(1.0, load.peak * load.end)  # |ξ₁| ≤ ∫|L|dτ of body 1 alone, which the stop of its model must not meet

    def run(system: System, load: Load) -> Transient:
        found = transient(system, load, method, free=FREE_CYCLES * CYCLE, cancelled=cancelled)
        if not found.ok:
            raise ValueError(found.response.ending)
        return found

    found, free = run(system, load).peaks, run(alone, load.scaled(1.0, 1.0 / largest)).peaks
    sizes = 1.0, ratio**2
    with_stop, without = ((each["displacement1"], each["acceleration1"]) for each in (found, free))
    return (
        *(size * value for size, value in zip(sizes, with_stop, strict=True)),
        *(size * largest * value for size, value in zip(sizes, without, strict=True)),
        ratio * found["impulse"],
    )
