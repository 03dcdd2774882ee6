"""Equations of motion of the two bodies: separated, joined, and pressed together by a penalty contact.

Displacements are relative to the base, time is τ = ω₁t, lengths are counted in base amplitudes. With the coefficients

    c₁ = 2d₁,   k₁ = 1,   c₂ = 2d₂κ,   k₂ = κ²

and the contact force λ, which pushes body 1 down and body 2 up,

    ξ₁″ = η² cos ητ − c₁ξ₁′ − k₁ξ₁ − λ                                                   (1)
    ξ₂″ = η² cos ητ − c₂ξ₂′ − k₂ξ₂ + λ/μ                                                 (2)

Subtracting (1) from (2) gives the gap g = ξ₂ − ξ₁; the excitation cancels, being common to both:

    g″ = −(k₂ − k₁) ξ₁ − (c₂ − c₁) ξ₁′ − k₂ g − c₂ g′ + (1 + 1/μ) λ                      (3)

Solvers in closed form work in y = (ξ₁, ξ₁′, g, g′): where the bodies nearly touch, ξ₂ − ξ₁ would lose the digits that
g keeps. Joined bodies move as one oscillator,

    ξ″ = η² cos ητ − 2d₃κ₃ξ′ − κ₃²ξ                                                      (4)

All three motions are linear, z′ = A z with z = (ξ₁, ξ₁′, g, g′, cos ητ, sin ητ); a *generator* is the upper four rows
of A, (4, 6).
"""

from typing import NamedTuple

import numpy as np

from ..compile.options import jit, jit_uncontracted
from .contact_law import force


class Coefficients(NamedTuple):
    """Coefficients of Eqs. (1) to (3)."""

    load: float  # η²
    c1: float
    k1: float
    c2: float
    k2: float
    stiffening: float  # k₂ − k₁ as (κ − 1)(κ + 1), to all digits where κ is close to 1
    mu: float  # μ = m₂/m₁
    inverse_mass: float  # 1 + 1/μ, the inverse of the reduced mass


@jit
def coefficients(p):
    """Coefficients of the equations of motion, from :class:`..parameters.Parameters`."""
    kappa = p.kappa
    stiffening = (kappa - 1.0) * (kappa + 1.0)
    return Coefficients(
        p.eta * p.eta, 2.0 * p.d1, 1.0, 2.0 * p.d2 * kappa, kappa * kappa, stiffening, p.mu, 1.0 + 1.0 / p.mu
    )


@jit_uncontracted
def accelerations(c, x1, v1, x2, v2, contact_force, cosine):
    """ξ₁″ and ξ₂″; ``cosine`` is cos ητ."""
    a1 = c.load * cosine - c.c1 * v1 - c.k1 * x1 - contact_force  # Eq. (1)
    a2 = c.load * cosine - c.c2 * v2 - c.k2 * x2 + contact_force / c.mu  # Eq. (2)
    return a1, a2


@jit
def separated_generator(p):
    """Generator without contact."""
    c, a = coefficients(p), np.zeros((4, 6))
    a[0, 1] = a[2, 3] = 1.0
    a[1, 0], a[1, 1], a[1, 4] = -c.k1, -c.c1, c.load  # Eq. (1)
    a[3, 0], a[3, 1], a[3, 2], a[3, 3] = -c.stiffening, -(c.c2 - c.c1), -c.k2, -c.c2  # Eq. (3)
    return a


@jit
def pressed_generator(p):
    """Generator in penalty contact, whose force is linear in g and g′, Eq. (5)."""
    c, a = coefficients(p), separated_generator(p)
    by_gap, by_rate = force(p.stiffness, p.damping, 1.0, 0.0), force(p.stiffness, p.damping, 0.0, 1.0)
    a[1, 2] -= by_gap
    a[1, 3] -= by_rate
    a[3, 2] += c.inverse_mass * by_gap
    a[3, 3] += c.inverse_mass * by_rate
    return a


@jit
def joined_generator(eta, kappa3, d3):
    """Generator of the common motion of joined bodies; the gap stays as it is."""
    a = np.zeros((4, 6))
    a[0, 1] = 1.0
    a[1, 0], a[1, 1], a[1, 4] = -kappa3 * kappa3, -2.0 * d3 * kappa3, eta * eta  # Eq. (4)
    return a
