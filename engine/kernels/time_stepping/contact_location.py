"""A step of Newmark's method of any length, and where within it contact changes (α = ½, β = ¼).

**Unknowns.** ξ₁ with its speed and acceleration (x, v, a), and the gap with its own (g, u, b): subtracting ξ₁ from ξ₂
would lose the digits that a stiff contact needs. With c₁ = 2d₁, k₁ = 1, c₂ = 2d₂κ, k₂ = κ² MODEL.md's equations read

    a = η² cos ητ − c₁v − k₁x + Kg + 2Du
    b = −(c₂ − c₁)v − (k₂ − k₁)x − (c₂ + 2D(1 + 1/μ))u − (k₂ + K(1 + 1/μ))g

in contact, and with K = D = 0 in flight. A step of any length s is Newmark's: a and b at its end solve these two
equations there, with x = p + s²a/4, v = q + sa/2, from the predictors p = x + sv + s²a/4, q = v + sa/2, and g and u
likewise.

**Where contact changes.** A step of length θ is itself such a step, so the gap g(θ) it lands on is a known function. If
the side of the gap at its end is not that at its start, a bracketed secant iteration finds the θ at which g(θ) = 0. A
gap that changes twice within a step is on the same side at both ends; it shows in the motion between them, which is
Newmark's own: constant acceleration (b₀ + b₁)/2, a parabola. Where its vertex lies beyond the surface, the step that
ends at the vertex decides.
"""

import math
from typing import NamedTuple

from ..compile.options import jit

PRECISION = 1e-14  # of an instant of change, as a share of its step: rounding of the gap leaves little more
ITERATIONS = 100  # three or four are needed, by bisection half of these


class Law(NamedTuple):
    """Coefficients of the equations, and the time grid; 1 and 2: the pendulums."""

    load: float  # η²
    damping1: float  # c₁
    stiffness1: float  # k₁
    damping2: float  # c₂
    stiffness2: float  # k₂
    both: float  # 1 + 1/μ
    stiffness: float  # K
    damper: float  # D
    eta: float
    h: float  # T/n
    steps: int  # n
    first: float  # Δτ T_c/T_f, the step with which a contact begins
    growth: float  # 2Δτ/T_f, the later ones per time since the landing


@jit
def squeezing(m, contact):
    """K and D as they act."""
    return (m.stiffness, m.damper) if contact else (0.0, 0.0)


@jit
def accelerations(m, contact, z, cosine):
    """The motion with a and b from the equations of a side."""
    x, v, _, g, u, _ = z
    k, d = squeezing(m, contact)
    a = m.load * cosine - m.damping1 * v - m.stiffness1 * x + k * g + 2.0 * d * u
    b = (m.damping1 - m.damping2) * v + (m.stiffness1 - m.stiffness2) * x
    b -= (m.damping2 + 2.0 * d * m.both) * u + (m.stiffness2 + k * m.both) * g
    return x, v, a, g, u, b


@jit
def step(m, contact, z, s, cosine):
    """The motion after a step of length ``s`` on one side of the gap; ``cosine`` is cos ητ at its end."""
    x, v, a, g, u, b = z
    half, quarter = 0.5 * s, 0.25 * s * s
    p, q = x + s * v + quarter * a, v + half * a
    pg, qg = g + s * u + quarter * b, u + half * b
    # accelerations as the predictors alone would have them, and the matrix that stands before those at the end
    _, _, a, _, _, b = accelerations(m, contact, (p, q, 0.0, pg, qg, 0.0), cosine)
    k, d = squeezing(m, contact)
    m11 = 1.0 + half * m.damping1 + quarter * m.stiffness1
    m12 = -(2.0 * half * d + quarter * k)
    m21 = half * (m.damping2 - m.damping1) + quarter * (m.stiffness2 - m.stiffness1)
    m22 = 1.0 + half * (m.damping2 + 2.0 * d * m.both) + quarter * (m.stiffness2 + k * m.both)
    over = 1.0 / (m11 * m22 - m12 * m21)
    a, b = (m22 * a - m12 * b) * over, (m11 * b - m21 * a) * over
    return p + quarter * a, q + half * a, a, pg + quarter * b, qg + half * b, b


@jit
def cosine_at(m, k, s):
    """Cos ητ at the offset s beyond step k of a period."""
    return math.cos(m.eta * (k * m.h + s))


@jit
def change_within(m, contact, z, end, length, k, s):
    """Where contact changes within a step, the motion there, and the solves that it took to find it.

    ``z`` and ``end`` are the motions at the start of the step, s beyond step k of the period, and ``length`` later. inf
    stands for a step without change.
    """
    side = -1.0 if contact else 1.0
    gap, speed = side * z[3], side * z[4]
    solves, reach, there = 0, length, end
    if (end[3] <= 0.0) == contact:
        bend = 0.5 * side * (z[5] + end[5])
        if not (gap > 0.0 and speed < 0.0 and -speed < bend * length and 2.0 * gap * bend <= speed * speed):
            return math.inf, end, 0
        reach, solves = -speed / bend, 1
        there = step(m, contact, z, reach, cosine_at(m, k, s + reach))
        if (there[3] <= 0.0) == contact:
            return math.inf, end, 1
    elif gap <= 0.0 and speed <= 0.0:
        # begun on the surface and not moving away from it: no first instant of change but the start
        return length, end, 0
    low, high, theta, slope = 0.0, reach, reach, there[4]  # the speed: g′(θ) but for terms of second order
    for i in range(ITERATIONS):
        if (there[3] <= 0.0) == contact:
            low = theta
        else:
            high = theta
        better = theta - there[3] / slope if slope != 0.0 else low
        if min(abs(better - theta), high - low) <= PRECISION * reach:
            break
        if not low < better < high or i % 8 == 7:
            better = 0.5 * (low + high)
        before, passed = there[3], better - theta
        there = step(m, contact, z, better, cosine_at(m, k, s + better))
        theta, slope, solves = better, (there[3] - before) / passed, solves + 1
    return theta, (there[0], there[1], there[2], 0.0, there[4], there[5]), solves


@jit
def force_of(m, contact, z):
    """Contact force λ by its definition."""
    k, d = squeezing(m, contact)
    return -k * z[3] - 2.0 * d * z[4]
