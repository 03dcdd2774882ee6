"""A step of any length, and the instant within it at which contact changes (of Newmark's method: α = ½, β = ¼).

**Step.** The unknowns are ξ₁ with its velocity and acceleration (x, v, a), and the gap with its own (g, u, b):
subtracting ξ₁ from ξ₂ would lose the digits that a stiff contact needs. On one side of the contact surface the
equations of motion (:mod:`..equations.motion`) are linear,

    a = A₂ₓ x + A₂ᵥ v + A₂g g + A₂ᵤ u + f₁(τ),        b = A₄ₓ x + A₄ᵥ v + A₄g g + A₄ᵤ u + f(τ),           (12)

A₂ and A₄ being rows of that side's generator, f₁ and f what drives body 1 and the gap, constants included. A step of
any length s is Newmark's: a and b at its end solve (12) there, with x = p + s²a/4, v = q + sa/2 from the predictors
p = x + sv + s²a/4, q = v + sa/2, and g and u likewise.

**Instant of change.** A step of length θ is itself such a step, so the gap g(θ) that it ends with is a known function.
If the gap at the end of the step is not on the side of its beginning, secants in a bracket find the θ with g(θ) = 0.
They begin at the zeros of two cubics, through what is known at the beginning and the gap at the end, then through the
gap of the first step, too. Two steps are enough in most cases: the motion at the next instant follows from a parabola
through those at the end of the step and at the last two instants, to rounding. A gap that changes sides
twice within a step is on the same side at both ends. It shows in the motion between them, which is Newmark's own:
constant acceleration (b₀ + b₁)/2, a parabola. Where the vertex of the parabola lies beyond the surface, the step that
ends at the vertex decides. Of other integrators the parabola is that through the gaps at both ends, with the rate at
the beginning.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.equations.contact_law import KELVIN_VOIGT, ContactLaw, law_force
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.time_stepping.law_step import solve_force

CUBIC_NEWTON = 3  # iterations for the zero of a cubic, which are cheap, and the step there is solved in any case
PRECISION = 1e-14  # of an instant of change, as a share of its step: the rounding of the gap allows little more
ITERATIONS = 100  # two to four are needed, half of this with bisection alone
AWAY = 1e-3  # of a bracket that begins at a zero of the gap, which rises there: so close to that, bisection is safer
# Of a squared step: the last change of an instant times the next one, which is then not solved for
LOCATED_INSTANT = 1e-15


class Side(NamedTuple):
    """Eq. (12) on one side of the contact surface."""

    ax: float
    av: float
    ag: float
    au: float
    bx: float
    bv: float
    bg: float
    bu: float


class Stages(NamedTuple):
    """The stages of a one-step method (:mod:`engine.integrators`), of any length; none of Newmark's own step above.

    That one takes the contact of spring and damper alone.
    """

    count: int
    averaged: bool
    react1: float  # acceleration of body 1 by a unit of contact force
    inverse_mass: float  # … and of the gap
    # of each of two stages: c, d₀, d₁, e₀, e₁, β, f₀, f₁, γ, α_m, α_f, α_v, and γ of the velocity that the dampers feel
    numbers: tuple


STAGE_NUMBERS = 13


class LocatedScheme(NamedTuple):
    """Both sides, the contact law, and the time grid."""

    separated: Side
    pressed: Side
    forcing: tuple  # f₁ and f as factors of cos ητ and sin ητ, and constants: (2, 3)
    clearance: float
    wall: float  # 1 if body 1 is a wall, else 0
    law: ContactLaw
    eta: float
    frequency: float  # 1/T
    h: float  # T/n
    steps: int  # n
    shortest_step: float  # Δτ T_c/T_f, the step with which a contact begins (see located.py)
    step_per_age: float  # 2Δτ/T_f, by how much the next ones grow with the time since then
    load: np.ndarray  # (5,) 1 of a load that is linear between steps, f₁ and f at the step, their slopes; else zeros
    sign: float  # as in ..parameters
    reach: float  # gap beyond which steps are seen from another stop, else LIMIT of .newmark
    stages: Stages


STAGES = Layout(Stages, numbers=(2, STAGE_NUMBERS))
SIDE, LAW = Layout(Side), Layout(ContactLaw)
SCHEME = Layout(LocatedScheme, separated=SIDE, pressed=SIDE, forcing=(2, 3), law=LAW, load=(5,), stages=STAGES)
unpack_scheme = SCHEME.unpack


@jit
def side_of(generator):
    """The rows of a generator that accelerations follow from."""
    a, b = generator[1], generator[3]
    return Side(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3])


@jit
def forcing_of(generator, equilibrium):
    """f₁ and f as factors of cos ητ and sin ητ, and constants, of one side, whose equilibrium is ξ₁ and g."""
    a, b = generator[1], generator[3]
    x, g = equilibrium
    return (a[4], a[5], a[6] - (a[0] * x + a[2] * g)), (b[4], b[5], b[6] - (b[0] * x + b[2] * g))


@jit_inlined
def side(m, pressed):
    """The equations of a side."""
    return m.pressed if pressed else m.separated


@jit_inlined
def with_accelerations(e, z, forcing):
    """The motion with a and b from the equations of a side; ``forcing``: f₁ and f."""
    x, v, _, g, u, _ = z
    # beginning with what is known long before the motion, so that the chain of dependent sums is short
    a = e.ax * x + (e.av * v + (e.ag * g + (e.au * u + forcing[0])))
    b = e.bx * x + (e.bv * v + (e.bg * g + (e.bu * u + forcing[1])))
    return x, v, a, g, u, b


@jit_inlined
def step(e, z, s, forcing):
    """The motion after a step of length ``s`` on one side of the surface; ``forcing``: f₁ and f at its end."""
    x, v, a, g, u, b = z
    half, quarter = 0.5 * s, 0.25 * s * s
    p, q = x + s * v + quarter * a, v + half * a
    pg, qg = g + s * u + quarter * b, u + half * b
    # right side and matrix of the two equations for a and b at the end
    _, _, a, _, _, b = with_accelerations(e, (p, q, 0.0, pg, qg, 0.0), forcing)
    m11, m12 = 1.0 - half * e.av - quarter * e.ax, -half * e.au - quarter * e.ag
    m21, m22 = -half * e.bv - quarter * e.bx, 1.0 - half * e.bu - quarter * e.bg
    over = 1.0 / (m11 * m22 - m12 * m21)
    a, b = (m22 * a - m12 * b) * over, (m11 * b - m21 * a) * over
    return p + quarter * a, q + half * a, a, pg + quarter * b, qg + half * b, b


@jit_inlined
def forcing_with(m, cosine, sine):
    """f₁ and f from cos ητ and sin ητ, numbers or arrays."""
    one, gap = m.forcing
    return one[0] * cosine + one[1] * sine + one[2], gap[0] * cosine + gap[1] * sine + gap[2]


@jit_inlined
def forcing_at(m, at):
    """f₁ and f at an instant: a step of the period, and the time after it."""
    k, s = at
    if m.load[0] > 0.0:
        return m.load[1] + s * m.load[3], m.load[2] + s * m.load[4]
    cosine, sine = cos_sin((k * m.h + s) * m.frequency)
    return forcing_with(m, cosine, sine)


@jit_inlined
def begin_load_of_step(m, forces, k):
    """Set the load of step k, if it is one that is linear between steps."""
    if m.load[0] > 0.0:
        for i in range(2):
            m.load[1 + i], m.load[3 + i] = forces[k, i], (forces[k + 1, i] - forces[k, i]) / m.h


@jit_inlined
def force_of(m, gain, pressed, z):
    """λ of a motion."""
    if m.law.kind == KELVIN_VOIGT:  # of most runs, without a call
        return -m.law.stiffness * z[3] - gain * z[4] if pressed else 0.0
    return law_force(m.law, gain, -z[3], -z[4]) if pressed else 0.0


@jit_no_alloc
def with_contact_accelerations(m, gain, pressed, z, forcing):
    """The motion with a and b from the equations of motion with the force of the law; ``forcing``: f₁ and f."""
    t, push = m.stages, force_of(m, gain, pressed, z)
    x, v, a, g, u, b = with_accelerations(m.separated, z, forcing)
    return x, v, a - t.react1 * push, g, u, b + t.inverse_mass * push


@jit_inlined
def stage_end(m, numbers, gain, pressed, start, former, s, at):
    """The motion at the end of a stage, Eqs. (14) and (15), from that at the beginning of the step.

    (15) divided by the masses is (12) without contact, with λ felt by both. ``gain``: c, or h of Eq. (18), of the open
    contact; ``start``: the motion and λ at the beginning of the step, which is ``at`` an instant as in
    :func:`forcing_at`; ``former``: the motion at the end of the stage before.
    """
    (x, v, a, g, u, b), begun = start
    k, offset = at
    _, v1, a1, _, u1, b1 = former
    t, e = m.stages, m.separated
    end, d0, d1, e0, e1, beta, f0, f1, gamma, alpha_m, alpha_f, alpha_v, damped = numbers
    by_q, by_v, now, late = s * s * beta, s * gamma, 1.0 - alpha_f, 1.0 - alpha_v
    xk, vk = x + s * (d0 * v + d1 * v1) + s * s * (e0 * a + e1 * a1), v + s * (f0 * a + f1 * a1)
    gk, uk = g + s * (d0 * u + d1 * u1) + s * s * (e0 * b + e1 * b1), u + s * (f0 * b + f1 * b1)
    felt = now * xk + alpha_f * x, late * vk + alpha_v * v, 0.0, now * gk + alpha_f * g, late * uk + alpha_v * u, 0.0
    felt_q, felt_v = now * by_q, late * (s * damped)
    if t.averaged:
        ended, started = forcing_at(m, (k, offset + s * end)), forcing_at(m, at)
        forcing = now * ended[0] + alpha_f * started[0], now * ended[1] + alpha_f * started[1]
    else:
        forcing = forcing_at(m, (k, offset + s * end * now))
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
            push = solve_force(m.law, gain, gk + by_q * known, uk + by_v * known, step_q, step_v)
            push = now * push + alpha_f * begun
        else:
            step_q, step_v = felt_q * by_b, felt_v * by_b
            push = solve_force(m.law, gain, felt[3] + felt_q * b1, felt[4] + felt_v * b1, step_q, step_v)
        a1, b1 = a1 + by_a * push, b1 + by_b * push
    return xk + by_q * a1, vk + by_v * a1, a1, gk + by_q * b1, uk + by_v * b1, b1


@jit_no_alloc
def step_of_stages(m, gain, pressed, z, s, at):
    """The motion after a step of length ``s`` that begins ``at`` an instant as in :func:`forcing_at`."""
    t = m.stages
    start = z, force_of(m, gain, pressed and t.averaged, z)
    end = stage_end(m, t.numbers[0], gain, pressed, start, z, s, at)
    if t.count > 1:
        end = stage_end(m, t.numbers[1], gain, pressed, start, end, s, at)
    return end


@jit_inlined
def step_from(m, gain, pressed, z, s, at):
    """The same, by Newmark's own step where the scheme has no stages."""
    if m.stages.count > 0:
        return step_of_stages(m, gain, pressed, z, s, at)
    return step(side(m, pressed), z, s, forcing_at(m, (at[0], at[1] + s)))


@jit_inlined
def vertex_within(gap, rate, curvature, length):
    """When within a step a parabola that begins with a positive gap is lowest, at zero or below; else 0."""
    approaches = gap > 0.0 and rate < 0.0 and -rate < curvature * length
    return -rate / curvature if approaches and 2.0 * gap * curvature <= rate * rate else 0.0


@jit_inlined
def cubic_of(value, rate, last, last_rate, length):
    """The factors of t² and t³ of a cubic over t = τ/length, from its values and its rates in τ at both ends."""
    mean = (last - value) / length
    return 3.0 * mean - 2.0 * rate - last_rate, rate + last_rate - 2.0 * mean


@jit_inlined
def falling_root(value, rate, square, cube, length):
    """Where a cubic with these factors over t = τ/length falls to zero, or a time outside the step."""
    at = 1.0
    for _ in range(CUBIC_NEWTON):
        slope = rate + at * (2.0 * square + 3.0 * cube * at)
        if not slope < 0.0:
            return -length
        at -= (value / length + at * (rate + at * (square + at * cube))) / slope
    return at * length


@jit_inlined
def root_of_cubic(value, rate, last, last_rate, length):
    """Where the cubic with these values and rates at both ends of a step falls to zero, or a time outside the step."""
    square, cube = cubic_of(value, rate, last, last_rate, length)
    return falling_root(value, rate, square, cube, length)


@jit_inlined
def root_by_curvature(gap, rate, curvature, last, length):
    """The same of a gap, from its rate and its second derivative at the beginning, and from its value at both ends.

    At the end of a step the derivative of the gap over the length of the step is not the rate there: it differs by
    terms of second order, which the cubic through the rates would be wrong by.
    """
    square = 0.5 * curvature * length
    return falling_root(gap, rate, square, (last - gap) / length - rate - square, length)


@jit_inlined
def next_root(value, rate, last, length, at, here):
    """The zero next to ``at`` of the cubic with a value and a rate at the beginning and values ``here`` and at the end.

    Beyond the step where it does not fall at ``at``.
    """
    left, right = 1.0 / at, 1.0 / (at - length)
    chord, mean = (here - value) * left, (last - value) / length
    curve = (chord - rate) * left  # divided differences: of 0, 0, at
    cube = (curve - (mean - rate) / length) * right  # … and of the end
    to_end = (here - last) * right
    curve = (to_end - mean) * left  # of 0, at, the end
    slope = to_end + (curve + cube * at) * (at - length)
    if not slope < 0.0:
        return -length
    change = -here / slope
    return at - here / (slope + (curve + cube * (2.0 * at - length)) * change)


@jit_inlined
def has_converged(passed, next_change, length):
    """Whether secants have converged within a step of a length, by their last change of an instant and the next one.

    A parabola through the motions at the end of the step and at the last two instants then gives the motion at the
    next one (:func:`motion_between`): it is wrong by both changes times a sixth of a third derivative.
    """
    return abs(passed * next_change) <= LOCATED_INSTANT * (length * length) and abs(next_change) <= 0.5 * abs(passed)


@jit_inlined
def motion_between(end, length, before, earlier, there, at, instant):
    """The motion at an instant, on the parabola through those at ``length``, ``earlier`` and ``at``."""
    share = (instant - at) / (earlier - at)
    weight = share * (instant - length) / (earlier - length)  # of ``before``
    other = (share - weight) * (earlier - at) / (length - at)  # of ``end``
    own = 1.0 - weight - other
    return (
        own * there[0] + (weight * before[0] + other * end[0]),
        own * there[1] + (weight * before[1] + other * end[1]),
        own * there[2] + (weight * before[2] + other * end[2]),
        own * there[3] + (weight * before[3] + other * end[3]),
        own * there[4] + (weight * before[4] + other * end[4]),
        own * there[5] + (weight * before[5] + other * end[5]),
    )
