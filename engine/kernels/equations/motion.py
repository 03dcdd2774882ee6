"""Equations of motion of the two bodies: separated, joined, and pressed together by a penalty contact.

Displacements are relative to the base, time is τ = ω₁t. With the coefficients

    c₁ = 2d₁,   k₁ = 1,   c₂ = 2d₂κ,   k₂ = κ²     (k₁ = 0 or κ = 0, and 2d₂ for c₂, of a body without a spring),

the base motion b(τ), the forces fᵢ(τ) + pᵢ on the bodies, harmonic and constant, and the contact force λ, which pushes
body 1 down and body 2 up,

    ξ₁″ = −b″ + f₁ + p₁ − c₁ξ₁′ − k₁ξ₁ − λ                                               (1)
    ξ₂″ = −b″ + (f₂ + p₂)/μ − c₂ξ₂′ − k₂ξ₂ + λ/μ                                         (2)

where the paper's base b = cos ητ gives −b″ = η² cos ητ. Subtracting (1) from (2) gives the gap g = g₀ + ξ₂ − ξ₁, with
the clearance g₀; the base cancels, being common to both:

    g″ = f − (k₂ − k₁)(ξ₁ − ξ₁ₛ) − (c₂ − c₁) ξ₁′ − k₂(g − gₛ) − c₂g′ + (1 + 1/μ) λ        (3)

with f = f₂/μ − f₁. ξ₁ₛ = p₁/k₁ and gₛ = g₀ + p₂/(μk₂) − p₁/k₁ are the static equilibrium of the separated bodies:
constant forces and the clearance have no other effect than to shift it. (Where there is none, or one far away, beside
a wall: :mod:`..parameters`.)

Solvers in closed form work in y = (ξ₁, ξ₁′, g, g′): where the bodies nearly touch, g₀ + ξ₂ − ξ₁ would lose the digits
that g keeps. Joined bodies move as one oscillator,

    ξ″ = −b″ + (f₁ + f₂)/(1 + μ) − 2d₃κ₃ξ′ − κ₃²(ξ − ξⱼ)                                  (4)

All three motions are linear about an *equilibrium* of their own: z′ = A z with z = (ξ₁ − ξ₁*, ξ₁′, g − g*, g′, cos ητ,
sin ητ); a *generator* is the upper four rows of A, (4, 6). With κ̂ = μκ²/(1 + μκ²), the stiffness of both springs in
series, the bodies rest at

    ξ₁* = ξ₁ₛ,           g* = gₛ                         separated
    ξ₁* = ξ₁ₛ + κ̂gₛ,     g* = 0,   λ* = −κ̂gₛ             joined (ξ₁* is ξⱼ of (4))
    ξ₁* = ξ₁ₛ + Kg*,     g* = gₛκ̂/(κ̂ + K)                pressed together by a spring K

A *wall* takes the place of body 1 (:mod:`..parameters`): neither −b″ and f₁ nor λ act in (1), so that ξ₁ stays zero,
and the f of (3), which drives the gap between the wall and the body, is b″ − f₁.

Coordinates of the kernels and of the user: (ξ₁, ξ₁′, g, g′) and (ξ₁, ξ₁′, ξ₂, ξ₂′), with the gap g = g₀ + ξ₂ − ξ₁.

At a wall the kernels see the body as body 2 and the wall as body 1 (:mod:`..parameters`): the user's ξ₁ is −ξ₂ of the
kernels, whose ξ₁ is zero. With w = 1 there and w = 0 for two bodies (the field ``wall``) one formula serves both. Of
a second stop they see the mirrored system, whose ξ are the negative of the user's: ``sign`` is −1 there, else 1. The
functions take numbers or arrays, and whatever has the fields ``wall``, ``clearance`` and ``sign``.

How fast a motion can be: bounds of the eigenvalues |ν| by which tables choose their spacing and steps their size.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_uncontracted
from vibroscope.engine.kernels.equations.contact_law import contact_rate, force


@jit_inlined
def displacements(p, x1, v1, gap, rate):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ as the user counts them."""
    x2, v2 = p.sign * (x1 + (gap - p.clearance)), p.sign * (v1 + rate)
    x1, v1 = p.sign * x1, p.sign * v1
    return x1 - p.wall * x2, v1 - p.wall * v2, x2 - p.wall * x2, v2 - p.wall * v2


@jit_inlined
def users_displacements(p, x1, v1, x2, v2):
    """The same from the displacements of both of the kernels' bodies: by their difference it would round once more."""
    x1, v1, x2, v2 = p.sign * x1, p.sign * v1, p.sign * x2, p.sign * v2
    return x1 - p.wall * x2, v1 - p.wall * v2, x2 - p.wall * x2, v2 - p.wall * v2


@jit_inlined
def contact_coordinates(p, x1, v1, x2, v2):
    """(ξ₁, ξ₁′, g, g′) as kernels count them."""
    x1, v1, x2, v2 = p.sign * x1, p.sign * v1, p.sign * x2, p.sign * v2
    x2, v2 = x2 - p.wall * (x1 + x2), v2 - p.wall * (v1 + v2)
    x1, v1 = x1 - p.wall * x1, v1 - p.wall * v1
    return x1, v1, p.clearance + (x2 - x1), v2 - v1


@jit
def load_rate(p):
    """Frequency of the load: η, or that of a pulse; 0 where it is linear in time (:mod:`..event_driven.state`)."""
    return p.eta * (p.pulse < 0.0) + p.pulse * (p.pulse >= 0.0)


@jit
def free_rate(p):
    """Largest |ν| of the separated bodies and the excitation; from Python p may hold arrays."""
    dampers = np.maximum(2.0 * p.damper2 * (p.kappa < 1.0), 2.0 * p.d1 * (p.spring1 == 0.0))  # stronger than a spring
    return np.maximum(np.maximum(np.maximum(1.0, p.kappa), load_rate(p)), dampers)


@jit
def pressed_rate(p):
    """A bound of the largest |ν| of the bodies pressed together.

    The bodies' own springs, and the coupling of the relative to the common motion, add to the contact mode at most the
    largest |ν| of the separated bodies.
    """
    return free_rate(p) + contact_rate(p.stiffness, p.damping, 1.0 / p.mass_share)


class Coefficients(NamedTuple):
    """Coefficients of Eqs. (1) to (3)."""

    load1: tuple  # factors of cos ητ and sin ητ in Eq. (1)
    push: tuple  # … in Eq. (3)
    c1: float
    k1: float
    c2: float
    k2: float
    stiffening: float  # k₂ − k₁ as (κ − 1)(κ + 1), to all digits where κ is close to 1; less the pull
    coupling: float  # what the place of a wall adds to Eq. (2) where it stands for the pull
    mu: float  # μ = m₂/m₁
    react1: float  # acceleration of body 1 by a unit of contact force: 1, 0 of a wall
    inverse_mass: float  # the inverse of the reduced mass: 1 + 1/μ, 1 at a wall
    pull1: float  # constant acceleration of body 1, and of body 2, that no equilibrium holds
    pull2: float


@jit
def coefficients(p):
    """Coefficients of the equations of motion, from :class:`..parameters.Parameters`."""
    kappa, square = p.kappa, p.eta * p.eta
    stiffening = kappa * kappa if p.spring1 == 0.0 else (kappa - 1.0) * (kappa + 1.0)
    load1 = square * p.base_cosine + p.force1_cosine, square * p.base_sine + p.force1_sine
    push, react1 = (p.push_cosine, p.push_sine), 1.0
    if p.wall > 0.0:
        load1, push, react1 = (0.0, 0.0), (-load1[0], -load1[1]), 0.0
    k1, k2, coupling, pull1, pull2 = p.spring1, kappa * kappa, 0.0, 0.0, 0.0
    if from_touch(p):
        k1, stiffening, coupling = 0.0, -p.pull, k2 + p.pull
    else:
        pull1, pull2 = p.pull1, p.pull1 + p.pull
    c2, inverse_mass = 2.0 * p.damper2, react1 + 1.0 / p.mu
    c1, mu = 2.0 * p.d1, p.mu
    return Coefficients(load1, push, c1, k1, c2, k2, stiffening, coupling, mu, react1, inverse_mass, pull1, pull2)


@jit
def from_touch(p):
    """Whether motions are counted from touch, :class:`..parameters.Parameters`."""
    return p.wall > 0.0 and p.free_position != 0.0


@jit_uncontracted
def accelerations(c, x1, v1, x2, v2, contact_force, cosine, sine):
    """ξ₁″ and ξ₂″; xᵢ: ξᵢ less the static equilibrium of the separated bodies; cos ητ and sin ητ."""
    load1 = c.load1[0] * cosine + c.load1[1] * sine
    load2 = (c.load1[0] + c.push[0]) * cosine + (c.load1[1] + c.push[1]) * sine
    a1 = load1 - c.c1 * v1 - c.k1 * x1 - c.react1 * contact_force + c.pull1  # Eq. (1)
    a2 = load2 - c.c2 * v2 - c.k2 * x2 + c.coupling * x1 + contact_force / c.mu + c.pull2  # Eq. (2)
    return a1, a2


@jit
def joint_share(p):
    """What body 1 gains of a relative velocity, or of a relative acceleration, by joining: μ/(1 + μ), 0 of a wall."""
    return coefficients(p).react1 * p.mass_share


@jit
def are_free(p):
    """Whether neither of two bodies has a spring."""
    return p.spring1 == 0.0 and p.kappa == 0.0


@jit
def joint_pull(p):
    """Constant acceleration of two bodies in contact that no spring bears."""
    return p.pull1 + p.mass_share * p.pull if are_free(p) else 0.0


@jit
def holding(p):
    """The force that pulls a body off the contact which has no equilibrium without it; −λ at rest in contact."""
    if are_free(p):
        return p.pull * p.mass_share
    return p.pull if p.spring1 == 0.0 else p.pull * p.mu


@jit
def free_equilibrium(p):
    """ξ₁ and gap of the static equilibrium of the separated bodies."""
    return p.free_position, p.free_gap


@jit
def joined_equilibrium(p):
    """ξ₁ and gap of the static equilibrium of the joined bodies."""
    if from_touch(p):
        return 0.0, 0.0
    shift = coefficients(p).react1 * (p.stiffness_share * p.free_gap)
    if p.pull != 0.0 and not are_free(p):  # the contact force that holds the free body moves the other one
        shift = -p.pull / (p.mu * p.kappa * p.kappa) if p.spring1 == 0.0 else holding(p)
    return p.free_position + shift, 0.0


@jit
def pressed_equilibrium(p):
    """ξ₁ and gap of the static equilibrium of the bodies pressed together by a spring."""
    gap = (p.free_gap * p.stiffness_share + holding(p)) / (p.stiffness_share + p.stiffness)
    if from_touch(p):
        return 0.0, gap
    if p.pull != 0.0:
        return joined_equilibrium(p)[0] - (gap if p.spring1 == 0.0 < p.kappa else 0.0), gap
    return p.free_position + coefficients(p).react1 * (p.stiffness * gap), gap


@jit
def separated_generator(p):
    """Generator without contact."""
    c, a = coefficients(p), np.zeros((4, 7))
    a[0, 1] = a[2, 3] = 1.0
    a[1, 0], a[1, 1], a[1, 4], a[1, 5] = -c.k1, -c.c1, c.load1[0], c.load1[1]  # Eq. (1)
    a[3, 0], a[3, 1], a[3, 2], a[3, 3] = -c.stiffening, -(c.c2 - c.c1), -c.k2, -c.c2  # Eq. (3)
    a[3, 4], a[3, 5] = c.push
    a[1, 6], a[3, 6] = c.pull1, c.pull2 - c.pull1
    return a


@jit
def pressed_generator(p):
    """Generator in penalty contact, whose force is linear in g and g′, Eq. (5)."""
    c, a = coefficients(p), separated_generator(p)
    a[1, 6], a[3, 6] = joint_pull(p), 0.0  # the equilibrium holds the rest
    if from_touch(p):  # … and the place of the wall is any oscillator at rest
        a[1, 0], a[3, 0] = -1.0, 0.0
    by_gap, by_rate = force(p.stiffness, p.damping, 1.0, 0.0), force(p.stiffness, p.damping, 0.0, 1.0)
    a[1, 2] -= c.react1 * by_gap
    a[1, 3] -= c.react1 * by_rate
    a[3, 2] += c.inverse_mass * by_gap
    a[3, 3] += c.inverse_mass * by_rate
    return a


@jit
def joined_generator(p):
    """Generator of the common motion of joined bodies; the gap stays as it is."""
    c, a = coefficients(p), np.zeros((4, 7))
    a[0, 1] = 1.0
    a[1, 0], a[1, 1] = -p.kappa3 * p.kappa3, -2.0 * p.damper3  # Eq. (4)
    share = joint_share(p)
    a[1, 4], a[1, 5] = c.load1[0] + share * c.push[0], c.load1[1] + share * c.push[1]
    a[1, 6] = joint_pull(p)
    return a
