"""A step, of any length too, with the contact force of a law that is not spring and damper alone.

Where the law takes them, the gap and its rate at the end of a stage are linear in λ, g = g₀ + aλ and g′ = r₀ + bλ with
a, b ≥ 0, so that one scalar equation is left,

    λ = L(−g₀ − aλ, −r₀ − bλ),                                                            (27)

L by Eqs. (6) and (16) to (21) of :mod:`..equations.contact_law`. L falls with λ, hence the root lies between zero and
L(−g₀, −r₀), and that of the larger, or the smaller, of two forces is the larger, or the smaller, of their roots: so
are those of the laws that are piecewise linear,

    max(0, Kδ + cv),   Kδ + min(max(cv, −Kδ), Kδ) = max(0, min(Kδ + cv, 2Kδ)),   Kδ + c max(v, 0) = max(Kδ + cv, Kδ).

For the others Newton's method finds it. Where that does not converge, the secants of a bracket that always holds the
root do (Illinois: Dowell & Jarratt, BIT 11 (1971) 168), across the kinks of a law as well, to the last digits. Only the
law of constant restitution does not fall everywhere: where a contact is about to end, it pulls by √δ or more, and the
root lies beyond L(−g₀, −r₀).
"""

import math
from typing import NamedTuple

from ..compile.options import jit_inlined, jit_no_alloc
from ..equations.contact_law import (
    FLORES,
    HUNT_CROSSLEY,
    IMPACT,
    OTHER,
    count_kinks,
    factors,
    gain_at,
    is_piecewise_linear,
    law_force,
    law_slopes,
    of_both,
)
from .contact_location import LocatedScheme, forcing_at, with_accelerations

SOLVES = 100  # secants, of which 6 to 10 are needed
WIDENINGS = 200  # of a bracket, each twice as far
CLOSE = 4 * 2.0**-52
NEWTON = 6  # iterations of Newton's method, of which two are needed
SLIGHT = 1e-6  # its step, times what of the slope is not 1, as a share of the force, after which another is rounding


class LawScheme(NamedTuple):
    """The grid and the stages, and the law in the place of the contact's spring and damper."""

    located: LocatedScheme
    law: int
    stiffness: float
    exponent: float
    penetration: float
    gain: float  # as in :class:`..parameters.Parameters`
    relative: float


@jit_inlined
def linear_root(stiffness, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) with the force Kδ + cv."""
    return -(stiffness * gap + gain * rate) / (1.0 + stiffness * by_gap + gain * by_rate)


@jit_no_alloc
def solve_force(m, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27).

    Parameters
    ----------
    m : Scheme or LawScheme
        Scheme of :mod:`.newmark`, or that below.
    gain : float
        c, or h of Eq. (18).
    gap, rate : float
        g₀ and r₀.
    by_gap, by_rate : float
        a and b.
    """
    if is_piecewise_linear(m.law):  # the force of a step grows with that of the law, so that it has the same form
        found = linear_root(m.stiffness, gain, gap, rate, by_gap, by_rate)
        for piece in range(OTHER, OTHER + count_kinks(m.law)):
            a, b = factors(m.law, piece)
            own = linear_root(a * m.stiffness, b * gain, gap, rate, by_gap, by_rate)
            found = of_both(m.law, piece, found, own)
        return found
    push = newton_root(m, gain, gap, rate, by_gap, by_rate) if HUNT_CROSSLEY <= m.law <= IMPACT else math.nan
    return push if push == push else bracketed_root(m, gain, gap, rate, by_gap, by_rate)


@jit_inlined
def newton_root(m, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) by Newton's method from λ = 0, its second step with the curvature that two slopes show; or NaN."""
    push, last, before = 0.0, 0.0, 0.0
    for i in range(NEWTON):
        depth, speed = -gap - by_gap * push, -rate - by_rate * push
        value = push - law_force(m.law, m.stiffness, gain, m.exponent, m.penetration, depth, speed)
        if abs(value) <= CLOSE * abs(push):
            return push
        if not depth > 0.0:
            break
        by_depth, by_speed = law_slopes(m.law, m.stiffness, gain, m.exponent, m.penetration, depth, speed)
        by_depth, by_speed = by_gap * by_depth, by_rate * by_speed
        slope = 1.0 + (by_depth + by_speed)
        if not slope > 0.0:
            break
        over = 1.0 / slope
        change = -value * over
        if i > 0:
            change *= 1.0 - 0.5 * (slope - before) / (push - last) * change * over
            if m.law <= FLORES and abs(change) * (abs(by_depth) + abs(by_speed)) <= SLIGHT * abs(push):
                return push + change  # these laws have no kink between the two
        last, before = push, slope
        push += change
    return math.nan


@jit_no_alloc
def bracketed_root(m, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) of a law that is not linear."""
    first = law_force(m.law, m.stiffness, gain, m.exponent, m.penetration, -gap, -rate)
    low, below, high = 0.0, -first, first
    above = first - law_force(
        m.law, m.stiffness, gain, m.exponent, m.penetration, -gap - by_gap * high, -rate - by_rate * high
    )
    push = high
    if above == 0.0 or first == 0.0:
        return push
    for _ in range(WIDENINGS):
        if (above > 0.0) != (below > 0.0):
            break
        low, below, high = high, above, 2.0 * high
        above = high - law_force(
            m.law, m.stiffness, gain, m.exponent, m.penetration, -gap - by_gap * high, -rate - by_rate * high
        )
    for _ in range(SOLVES):
        push = high - above * (high - low) / (above - below)
        value = push - law_force(
            m.law, m.stiffness, gain, m.exponent, m.penetration, -gap - by_gap * push, -rate - by_rate * push
        )
        if abs(value) <= CLOSE * abs(push) or abs(high - low) <= CLOSE * abs(push):
            break
        if (value > 0.0) != (above > 0.0):
            low, below = high, above
        else:
            below *= 0.5
        high, above = push, value
    return push


@jit_inlined
def gain_of(m, contact):
    """c, or h of Eq. (18), of the open contact."""
    return gain_at(m, contact.speed1 - contact.speed2)


@jit_inlined
def force_of(m, gain, pressed, z):
    """λ of a motion."""
    return law_force(m.law, m.stiffness, gain, m.exponent, m.penetration, -z[3], -z[4]) if pressed else 0.0


@jit_no_alloc
def with_law_accelerations(m, gain, pressed, z, forcing):
    """The motion with a and b from the equations; ``forcing``: f₁ and f."""
    t, push = m.located.stages, force_of(m, gain, pressed, z)
    x, v, a, g, u, b = with_accelerations(m.located.separated, z, forcing)
    return x, v, a - t.react1 * push, g, u, b + t.inverse_mass * push


@jit_inlined
def stage_of_law(m, numbers, gain, pressed, z, former, begun, s, k, offset):
    """As :func:`.contact_location.stage_end`."""
    x, v, a, g, u, b = z
    _, v1, a1, _, u1, b1 = former
    t, e = m.located.stages, m.located.separated
    end, d0, d1, e0, e1, beta, f0, f1, gamma, alpha_m, alpha_f = numbers
    by_q, by_v, now = s * s * beta, s * gamma, 1.0 - alpha_f
    xk, vk = x + s * (d0 * v + d1 * v1) + s * s * (e0 * a + e1 * a1), v + s * (f0 * a + f1 * a1)
    gk, uk = g + s * (d0 * u + d1 * u1) + s * s * (e0 * b + e1 * b1), u + s * (f0 * b + f1 * b1)
    felt = now * xk + alpha_f * x, now * vk + alpha_f * v, 0.0, now * gk + alpha_f * g, now * uk + alpha_f * u, 0.0
    felt_q, felt_v = now * by_q, 0.0 if t.explicit else now * by_v
    if t.averaged:
        ended, started = forcing_at(m.located, k, offset + s * end), forcing_at(m.located, k, offset)
        forcing = now * ended[0] + alpha_f * started[0], now * ended[1] + alpha_f * started[1]
    else:
        forcing = forcing_at(m.located, k, offset + s * end * now)
    _, _, p, _, _, q = with_accelerations(e, felt, forcing)
    p, q = p - alpha_m * a, q - alpha_m * b
    m11, m12 = 1.0 - alpha_m - e.ax * felt_q - e.av * felt_v, -e.ag * felt_q - e.au * felt_v
    m21, m22 = -e.bx * felt_q - e.bv * felt_v, 1.0 - alpha_m - e.bg * felt_q - e.bu * felt_v
    over = 1.0 / (m11 * m22 - m12 * m21)
    # accelerations without contact force, and what a unit of it adds
    a1, b1 = (m22 * p - m12 * q) * over, (m11 * q - m21 * p) * over
    if pressed:
        by_a, by_b = (-m22 * t.react1 - m12 * t.inverse_mass) * over, (m11 * t.inverse_mass + m21 * t.react1) * over
        if t.averaged:
            known = b1 + by_b * alpha_f * begun
            step_q, step_v = by_q * by_b * now, by_v * by_b * now
            push = solve_force(m, gain, gk + by_q * known, uk + by_v * known, step_q, step_v)
            push = now * push + alpha_f * begun
        else:
            step_q, step_v = felt_q * by_b, felt_v * by_b
            push = solve_force(m, gain, felt[3] + felt_q * b1, felt[4] + felt_v * b1, step_q, step_v)
        a1, b1 = a1 + by_a * push, b1 + by_b * push
    return xk + by_q * a1, vk + by_v * a1, a1, gk + by_q * b1, uk + by_v * b1, b1


@jit_no_alloc
def step_of_law(m, gain, pressed, z, s, k, offset):
    """The motion after a step of length ``s``, as :func:`.contact_location.step_of_stages` with the force of a law."""
    t = m.located.stages
    begun = force_of(m, gain, pressed and t.averaged, z)
    end = stage_of_law(m, t.numbers[0], gain, pressed, z, z, begun, s, k, offset)
    if t.count > 1:
        end = stage_of_law(m, t.numbers[1], gain, pressed, z, end, begun, s, k, offset)
    return end
