"""A synthetic measurement, to try the tools on and to test them: the reference's steady motion plus noise."""

import numpy as np
from vibroscope.engine.arguments import require, whole
from vibroscope.engine.measurement.cycle import reference_cycle
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.methods import Reference
from vibroscope.engine.model import System

PER_PERIOD_RANGE = (8, 100_000)


def synthetic_measurement(
    system: System,
    eta: float,
    *,
    periods: int = 8,
    per_period: int = 200,
    noise: float = 0.02,
    phase: float = 0.0,
    frame: str = "absolute",
    seed: int = 0,
) -> Measurement:
    """Sample the reference's steady motion, with independent normal noise on both displacements.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    periods : int
        Excitation periods to cover.
    per_period : int
        Samples per period.
    noise : float
        Standard deviation in base amplitudes.
    phase : float
        τ of the cycle at which the measurement begins.
    frame : {"absolute", "relative"}
    seed : int
        The same seed gives the same noise.

    Returns
    -------
    Measurement
        Its contact sensor is closed in permanent contact, and at the first sample after an impact.

    Raises
    ------
    ValueError
        If a number is out of range, the motion is not periodic, or nothing drives the bodies.
    """
    require("periods", periods, 1, 100_000, "give the excitation periods to cover")
    require("per_period", per_period, *PER_PERIOD_RANGE, "give samples per period")
    require("noise", noise, 0, 1e6, "give the standard deviation in base amplitudes")
    require("phase", phase, -1e6, 1e6, "give the tau at which it begins")
    seed = whole("seed", seed, 0, 2**53, "give the start of the random numbers")
    if not system.excitation.drives:
        raise ValueError("nothing drives the bodies, so that they come to rest: give what drives them")
    _, cycle = reference_cycle(system, eta, Reference())
    if cycle is None:
        raise ValueError(f"the motion at eta = {eta:g} is not periodic: choose another eta")
    step = 2 * np.pi / eta / per_period
    time = step * np.arange(int(periods * per_period) + 1)
    displacement = cycle.displacement(time + phase, frame)
    random = np.random.default_rng(seed)
    return Measurement(
        time=time,
        displacement=displacement + noise * random.standard_normal(displacement.shape),
        contact=cycle.touching(time + phase, step),
        frame=frame,
    ).of(system)
