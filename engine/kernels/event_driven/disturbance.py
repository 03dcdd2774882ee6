"""The growth of a small disturbance of a motion, from period to period (:mod:`engine.motions.lyapunov`).

Only the direction of the disturbance is carried along, not the whole Jacobian: a variation of one number.
"""

import math

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.event_driven.integrate import integrate
from vibroscope.engine.kernels.event_driven.two_stops import write_start
from vibroscope.engine.kernels.status import OK


@jit_no_alloc
def follow_disturbance(solver, variation, ends, growth, section, signals):
    """Follow a motion and a disturbance of it through an excitation period for each entry of ``growth``.

    Returns False if the call was withdrawn.

    Parameters
    ----------
    solver : (packed, state, (flat, sizes))
        A :class:`.state.HybridSystem` of each stop, (1, n) or (2, n), work space for a packed hybrid state, (n + 1,),
        and packed record buffers without room.
    variation : Variation
        Of one number.
    ends : (2, 4) float64
        (ξ₁, ξ₁′, g, g′) at τ = 0 and the disturbance; in the end those of the last period, the latter of length 1.
    growth : (n,) float64
        ln of the growth in each period: −∞ where nothing is left of the disturbance, which then begins anew; nan from
        the period on that ends early or has no derivative.
    section : (n, 4) float64
        (ξ₁, ξ₁′, g, g′) at the end of each period.
    signals : (n,) int64
        ``signals[0]`` is set to withdraw the call.
    """
    packed, state, (flat, sizes) = solver
    y, direction = ends[0], ends[1]
    for n in range(growth.shape[0]):
        growth[n] = math.nan
    for n in range(growth.shape[0]):
        if signals[0] != 0:
            return False
        write_start(packed, state, (y[0], y[1], y[2], y[3]))
        for k in range(4):
            variation.state[k, 0] = direction[k]
        variation.time[0] = 0.0
        status, _, _ = integrate(packed, state, 1.0, (0.0, 0.0), flat, sizes, variation)
        square = size = 0.0
        for k in range(4):
            square += variation.state[k, 0] ** 2
            size += abs(variation.end[k])
        if status != OK or not (square < math.inf and size < math.inf):
            return True
        length = math.sqrt(square)
        for k in range(4):
            y[k] = section[n, k] = variation.end[k]
            direction[k] = variation.state[k, 0] / length if length > 0.0 else 0.5
        growth[n] = math.log(length) if length > 0.0 else -math.inf
    return True
