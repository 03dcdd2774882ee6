"""A stage of a one-step method, Eqs. (14) and (15) of :mod:`engine.integrators`: the one place of its formula.

The unknowns are ξ₁ with its velocity and acceleration (x, v, a), and the gap with its own (g, u, b): subtracting ξ₁
from ξ₂ would lose the digits that a stiff contact needs. On one side of the contact surface the equations of motion
(:mod:`..equations.motion`) are linear,

    a = A₂ₓ x + A₂ᵥ v + A₂g g + A₂ᵤ u + f₁(τ),        b = A₄ₓ x + A₄ᵥ v + A₄g g + A₄ᵤ u + f(τ),           (12)

A₂ and A₄ being rows of that side's generator, f₁ and f what drives body 1 and the gap, constants included. (15) divided
by the masses is (12) without contact, with λ felt by both.

Located steps (:mod:`.contact_location`) call it. Steps of the grid multiply by its matrix, which is what it makes of
unit vectors (:mod:`.linear_step`).
"""

from typing import NamedTuple

from vibroscope.engine.kernels.compile.options import jit, jit_inlined
from vibroscope.engine.kernels.equations.motion import free_equilibrium, separated_generator


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


# Of a stage: c, d₀, d₁, e₀, e₁, β, f₀, f₁, γ, α_m, α_f, α_v, and γ of the velocity that the dampers feel
STAGE_NUMBERS, ALPHA_F = 13, 10
# Newmark's, α = ½, β = ¼: for a share that is None nothing is compiled
AVERAGE_ACCELERATION = (1.0, 1.0, 0.0, 0.25, 0.0, 0.25, 0.5, 0.0, 0.5, None, None, None, 0.5)


class Stages(NamedTuple):
    """The stages of a one-step method, of any length."""

    count: int
    averaged: bool
    reaction: tuple  # acceleration of body 1 and of the gap by a unit of contact force
    numbers: tuple  # of each of two stages


class Unforced(NamedTuple):
    """The end of a stage before the contact force in it is known, and what a unit of that adds."""

    known: tuple  # x, v, g, u without what the accelerations at the end give
    a: float  # accelerations at the end without the force
    b: float
    by_q: float  # what a unit of acceleration gives to a displacement, and to a velocity
    by_v: float
    by_a: float  # what a unit of force gives to the accelerations
    by_b: float
    share: float  # of λ of the stage, and what λ at the beginning gives, of the force that acts
    begun: float
    # where the law takes them: gap and rate without the force, and what a unit of it gives to them, as of Eq. (27)
    point: tuple


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


@jit
def without_contact(p):
    """The side without contact and its forcing, from :class:`..parameters.Parameters`."""
    generator = separated_generator(p)
    return side_of(generator), forcing_of(generator, free_equilibrium(p))


@jit_inlined
def forcing_with(forcing, cosine, sine):
    """f₁ and f from cos ητ and sin ητ, numbers or arrays."""
    one, gap = forcing
    return one[0] * cosine + one[1] * sine + one[2], gap[0] * cosine + gap[1] * sine + gap[2]


@jit_inlined
def with_accelerations(e, z, forcing):
    """The motion with a and b from the equations of a side; ``forcing``: f₁ and f."""
    x, v, _, g, u, _ = z
    # beginning with what is known long before the motion, so that the chain of dependent sums is short
    a = e.ax * x + (e.av * v + (e.ag * g + (e.au * u + forcing[0])))
    b = e.bx * x + (e.bv * v + (e.bg * g + (e.bu * u + forcing[1])))
    return x, v, a, g, u, b


@jit_inlined
def between(share, end, begin):
    """What is felt of a quantity at both ends of a stage; ``share``: that of the beginning, or None."""
    return end if share is None else (1.0 - share) * end + share * begin


@jit_inlined
def of_end(share):
    """The share of the end."""
    return 1.0 if share is None else 1.0 - share


@jit_inlined
def less(share, end, begin):
    """A quantity without the share of the beginning."""
    return end if share is None else end - share * begin


@jit_inlined
def unforced_end(e, averaged, reaction, numbers, start, former, s, forcing):
    """The :class:`Unforced` end of a stage.

    Parameters
    ----------
    e : Side
    averaged : bool
        Whether the method averages the forces at both ends.
    reaction : (float, float)
        What a unit of contact force does to a and to b.
    numbers : (STAGE_NUMBERS,) tuple
        Of the stage.
    start : (z, λ)
        The motion and λ at the beginning of the step.
    former : z or None
        The motion at the end of the stage before.
    s : float
        Length of the step.
    forcing : (f₁, f)
        As the stage takes them: at the instant that belongs to its displacement, or the average of both ends.
    """
    (x, v, a, g, u, b), begun = start
    _, d0, d1, e0, e1, beta, f0, f1, gamma, alpha_m, alpha_f, alpha_v, damped = numbers
    by_q, by_v, now = s * s * beta, s * gamma, of_end(alpha_f)
    if former is None:  # Eq. (14)
        xk, vk = x + s * (d0 * v) + s * s * (e0 * a), v + s * (f0 * a)
        gk, uk = g + s * (d0 * u) + s * s * (e0 * b), u + s * (f0 * b)
    else:
        _, v1, a1, _, u1, b1 = former
        xk, vk = x + s * (d0 * v + d1 * v1) + s * s * (e0 * a + e1 * a1), v + s * (f0 * a + f1 * a1)
        gk, uk = g + s * (d0 * u + d1 * u1) + s * s * (e0 * b + e1 * b1), u + s * (f0 * b + f1 * b1)
    felt_g, felt_u = between(alpha_f, gk, g), between(alpha_v, uk, u)
    felt = between(alpha_f, xk, x), between(alpha_v, vk, v), 0.0, felt_g, felt_u, 0.0
    felt_q, felt_v, own = now * by_q, of_end(alpha_v) * (s * damped), of_end(alpha_m)
    _, _, p, _, _, q = with_accelerations(e, felt, forcing)  # Eq. (15)
    p, q = less(alpha_m, p, a), less(alpha_m, q, b)
    m11, m12 = own - felt_v * e.av - felt_q * e.ax, -felt_v * e.au - felt_q * e.ag
    m21, m22 = -felt_v * e.bv - felt_q * e.bx, own - felt_v * e.bu - felt_q * e.bg
    over = 1.0 / (m11 * m22 - m12 * m21)
    a, b = (m22 * p - m12 * q) * over, (m11 * q - m21 * p) * over
    one, gap = reaction
    by_a, by_b = (m22 * one - m12 * gap) * over, (m11 * gap - m21 * one) * over
    share, known = 1.0, 0.0
    if averaged:  # the law takes the end
        share, known = now, between(alpha_f, 0.0, begun)
        felt_g, felt_u, felt_q, felt_v = gk, uk, by_q, by_v
    free, step_b = b + by_b * known, by_b * share
    point = felt_g + felt_q * free, felt_u + felt_v * free, felt_q * step_b, felt_v * step_b
    return Unforced((xk, vk, gk, uk), a, b, by_q, by_v, by_a, by_b, share, known, point)


@jit_inlined
def end_with(k, a, b):
    """The motion at the end of a stage with these accelerations there; ``k``: :class:`Unforced`."""
    x, v, g, u = k.known
    return x + k.by_q * a, v + k.by_v * a, a, g + k.by_q * b, u + k.by_v * b, b


@jit_inlined
def end_with_force(k, push):
    """The motion at the end of a stage with a contact force in it."""
    acting = k.share * push + k.begun
    return end_with(k, k.a + k.by_a * acting, k.b + k.by_b * acting)
