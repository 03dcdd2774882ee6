"""Shock response: the largest motion under one load over the natural frequency, with the stop and without it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import require, shown
from vibroscope.engine.load import Load
from vibroscope.engine.methods import Method, Reference
from vibroscope.engine.model import FAR_OPEN, System
from vibroscope.engine.transients.run import CYCLE, FREE_CYCLES, transient

RATIO_RANGE = (1e-3, 1e3)


@dataclass(frozen=True)
class ShockResponse:
    """Outcome of :func:`engine.shock_response`.

    Attributes
    ----------
    ratio : (n,) ndarray
        Natural frequency of body 1 in units of ω₁ of the system that was given; all frequencies grow with it.
    displacement, acceleration : (n,) ndarray
        Largest displacement relative to the base and absolute acceleration of the observed body
        (:attr:`System.observed_body`), during the load and after it, in units of length, and of that times ω₁²; nan
        where it is not finite, as within an impact of the reference.
    displacement_without, acceleration_without : (n,) ndarray
        The same without the stop: the shock response spectrum (maximax).
    impulse : (n,) ndarray
        The largest impulse of a contact, in units of m₁ω₁ times the length.
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
    cancelled: Callable[[], bool] | None = None,
) -> ShockResponse:
    """Run a system under a base shock with other natural frequencies, each with its stops and without.

    The damping ratios, the clearance and the shock stay as they are. A penalty method keeps its K and D in units of
    the body's own spring and mass, and its steps in a natural period.

    Parameters
    ----------
    system : System
        With springs, and no constant forces.
    load : Load
        Acceleration of the base.
    ratios : sequence of float
        Natural frequencies of body 1 in units of ω₁.
    method : Method, optional
        By default the reference.
    cancelled : callable, optional
        Polled many times a second; when it returns true the study is cancelled.

    Returns
    -------
    ShockResponse

    Raises
    ------
    ValueError
        If the load is a force, a body has no spring or a constant force, or a run ends early.
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
    apart = replace(system.with_first_stop, clearance=FAR_OPEN)
    rows = []
    for ratio in values:
        # time is counted in 1/ω of the body as it now is
        own = load.scaled(ratio, 1.0 / ratio**2)
        found = [
            transient(each, own, method, free=FREE_CYCLES * CYCLE, cancelled=cancelled) for each in (system, apart)
        ]
        ended = next((each.response.ending for each in found if not each.ok), None)
        if ended:
            raise ValueError(f"ratio = {ratio:g}: {ended}")
        body = system.observed_body
        with_stop, without = (each.peaks for each in found)
        rows.append(
            [
                *(size * each[f"{name}{body}"] for each in (with_stop, without) for name, size in _sizes(ratio)),
                ratio * with_stop["impulse"],
            ]
        )
    return ShockResponse(np.array(values), *np.array(rows).T)


def _sizes(ratio: float) -> tuple[tuple[str, float], ...]:
    return ("displacement", 1.0), ("acceleration", ratio**2)
