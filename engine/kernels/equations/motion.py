"""Equations of motion of the two pendulums: separated, joined, and pressed together (MODEL.md, "Motion").

With k₁ = 1, k₂ = κ², c₁ = 2d₁, c₂ = 2d₂κ the gap of separated pendulums obeys, the excitation being common to both,

    g″ = −(k₂ − k₁) ξ₁ − (c₂ − c₁) ξ₁′ − k₂ g − c₂ g′.

A contact force λ takes λ from ξ₁″ and adds (1 + 1/μ) λ to g″.
"""

import numpy as np

from ..compile.options import jit


@jit
def separated(eta, kappa, d1, d2):
    """Generator (4, 6) of ξ₁, ξ₁′, g, g′ (see :mod:`..linear.tables`) without contact."""
    k2, c1, c2 = kappa * kappa, 2.0 * d1, 2.0 * d2 * kappa
    apart = (kappa - 1.0) * (kappa + 1.0)  # k₂ − k₁ to all digits
    a = np.zeros((4, 6))
    a[0, 1] = a[2, 3] = 1.0
    a[1, 0], a[1, 1], a[1, 4] = -1.0, -c1, eta * eta
    a[3, 0], a[3, 1], a[3, 2], a[3, 3] = -apart, -(c2 - c1), -k2, -c2
    return a


@jit
def joined(eta, kappa3, d3):
    """Generator of the common motion in permanent contact; the gap stays as it is."""
    a = np.zeros((4, 6))
    a[0, 1] = 1.0
    a[1, 0], a[1, 1], a[1, 4] = -kappa3 * kappa3, -2.0 * d3 * kappa3, eta * eta
    return a


@jit
def pressed(eta, kappa, d1, d2, mu, stiffness, damping):
    """Generator in penalty contact, λ = −K g − 2D g′."""
    a = separated(eta, kappa, d1, d2)
    k, d = stiffness, 2.0 * damping
    a[1, 2] += k
    a[1, 3] += d
    a[3, 2] -= (1.0 + 1.0 / mu) * k
    a[3, 3] -= (1.0 + 1.0 / mu) * d
    return a
