"""The growth of a small disturbance of a motion, from period to period (:mod:`engine.motions.lyapunov`).

Only the direction of the disturbance is carried along, not the whole Jacobian: a variation of one number.
"""

import math

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.event_driven.integrate import integrate
from vibroscope.engine.kernels.event_driven.state import unpack_system, write_start
from vibroscope.engine.kernels.status import OK


@jit_no_alloc
def follow_disturbance(packed, state, variation, nothing, y, direction, growth, section):
    """Follow a motion and a disturbance of it through an excitation period for each entry of ``growth``.

    Parameters
    ----------
    packed : (n,) float64
        A :class:`.state.HybridSystem`.
    state : (n,) float64
        Work space for the :class:`.state.HybridState`.
    variation : Variation
        Of one number.
    nothing : (flat, sizes)
        Packed record buffers without room.
    y, direction : (4,) float64
        (ξ₁, ξ₁′, g, g′) at τ = 0 and the disturbance; in the end those of the last period, the direction of length 1.
    growth : (n,) float64
        ln of the growth in each period: −∞ where nothing is left of the disturbance, which then begins anew; nan from
        the period on that ends early or has no derivative.
    section : (n, 4) float64
        y at the end of each period.
    """
    flat, sizes = nothing
    for n in range(growth.shape[0]):
        growth[n] = math.nan
    lowest = 0.0 if unpack_system(packed).rigid else -math.inf  # rounding must not make a reference penetrate
    for n in range(growth.shape[0]):
        write_start(packed, state, y[0], y[1], max(y[2], lowest), y[3])
        for k in range(4):
            variation.state[k, 0] = direction[k]
        variation.time[0] = 0.0
        status, _, _ = integrate(packed, state, 1.0, (0.0, 0.0), flat, sizes, variation)
        square = size = 0.0
        for k in range(4):
            square += variation.state[k, 0] ** 2
            size += abs(variation.end[k])
        if status != OK or not (square < math.inf and size < math.inf):
            return
        length = math.sqrt(square)
        for k in range(4):
            y[k] = section[n, k] = variation.end[k]
            direction[k] = variation.state[k, 0] / length if length > 0.0 else 0.5
        growth[n] = math.log(length) if length > 0.0 else -math.inf
