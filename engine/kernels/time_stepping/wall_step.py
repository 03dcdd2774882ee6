"""One body at a wall: a step of Newmark's method of any length, and the instant at which contact changes within it.

The gap g with its rate u and its acceleration b is all that moves (:mod:`.contact_location`), and Eq. (12) is

    b = A₄g g + A₄ᵤ u + f(τ).

With this, and with the predictors of a step of length θ, the gap at its end is

    (1 − θA₄ᵤ/2 − θ²A₄g/4) g(θ) = g + θ (u − A₄ᵤ g/2) + θ²/4 (b − A₄ᵤ u + f(θ)),                      (60)

of which the factor is positive. But for f(θ), which changes little within a step, the right side is a parabola. Its
zero, with f taken from both ends of the step, leaves so little that one step of third order (Chebyshev's) is enough.

Plain twin: the secants of :func:`.contact_location.locate_change` (tests/engine/kernels/test_wall.py).
"""

import math

from ..compile.options import jit_inlined
from ..linear.cos_sin import cos_sin

SMALL = 1e-5  # the last change of an instant, as a share of the step, whose third power is below rounding
NOT_FOUND = -1.0


@jit_inlined
def step_alone(e, g, u, b, s, force):
    """The gap with velocity and acceleration after a step of length ``s`` at a wall; ``force``: f at its end."""
    half, quarter = 0.5 * s, 0.25 * s * s
    pg, qg = g + s * u + quarter * b, u + half * b
    over = 1.0 / (1.0 - half * e.bu - quarter * e.bg)  # long known: a division of the sum would be waited for
    b = (e.bg * pg + (e.bu * qg + force)) * over
    return pg + quarter * b, qg + half * b, b


@jit_inlined
def falling_root(value, slope, curve):
    """Where value + slope t + curve t² falls to zero, and the square root of its discriminant; NaN where it does not.

    Without a difference of like numbers, hence also at the other zero where the value is zero.
    """
    root = math.sqrt(slope * slope - 4.0 * value * curve)
    return (2.0 * value / (root - slope) if slope <= 0.0 else -0.5 * (slope + root) / curve), root


@jit_inlined
def change_at_wall(m, e, pressed, z, end, length, k, s):
    """Where contact changes within a step, and the motion (g, u, b) there; NOT_FOUND where that is not certain.

    ``e``: Eq. (12) on the side of the step; the others as in :func:`.contact_location.locate_change`. Contact has
    changed at the ``end``.
    """
    sign = -1.0 if pressed else 1.0
    g, u, b = z[3], z[4], z[5]
    value, slope, rest = sign * g, sign * (u - 0.5 * e.bu * g), b - e.bu * u
    first, last = b - e.bg * g - e.bu * u, end[5] - e.bg * end[3] - e.bu * end[4]  # f
    at, root = falling_root(value, slope, 0.25 * sign * (rest + last))
    at += 0.25 * sign * at * at * (first - last) * (1.0 - at / length) / root
    if not 0.0 < at <= length:
        return NOT_FOUND, (g, u, b)
    c1, c2, c3 = m.forcing[1]
    cosine, sine = cos_sin((k * m.h + s + at) * m.frequency)
    swinging = c1 * cosine + c2 * sine
    push, rate, curve = swinging + c3, m.eta * (c2 * cosine - c1 * sine), -m.eta * m.eta * swinging  # f, f′, f″
    half, quarter = 0.5 * at, 0.25 * at * at
    falls = slope + sign * (half * (rest + push) + quarter * rate)
    bends = sign * (0.5 * (rest + push) + at * rate + quarter * curve)
    over = 1.0 / falls
    change = -(value + at * slope + sign * quarter * (rest + push)) * over
    turned = bends * change * over
    change -= 0.5 * turned * change
    theta = at + change
    if not (falls < 0.0 and 0.0 < theta <= length and abs(change) <= SMALL * length and abs(turned) <= SMALL):
        return NOT_FOUND, (g, u, b)
    return theta, step_alone(e, g, u, b, theta, push + change * (rate + 0.5 * change * curve))
