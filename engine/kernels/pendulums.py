"""Closed-form motion of the two pendulums, separated and joined (MODEL.md, "Motion"; paper, section 2).

Each oscillator ξ″ + 2δξ′ + k²ξ = η² cos ητ has the solution ξ(τ) = Re[A e^{iητ}] + Re[c e^{λ(τ − τ₀)}] with the
steady amplitude A = η²/(k² − η² + 2iδη), the pole λ = −δ + i√(k² − δ²), and c set by the state at τ₀.
"""

from typing import NamedTuple

from .jit import jit
from .modes import Modes, cexp


class Pendulums(NamedTuple):
    """System and excitation as the kernels want them; 1 and 2: separate pendulums, 3: joined."""

    period: float  # T = 2π/η
    forcing_pole: complex  # iη
    pole1: complex
    pole2: complex
    pole3: complex
    steady1: complex
    steady2: complex
    steady3: complex
    mass_share: float  # μ/(1 + μ)
    force_position: float  # λ = force_position ξ + force_velocity ξ′ in permanent contact
    force_velocity: float
    restitution: float
    threshold: float


@jit
def free_amplitude(x, v, steady, pole, forcing_pole):
    """c of Re[c e^{λs}], the free part of a motion that starts at (x, v); ``steady`` is A e^{iητ₀}."""
    a = x - steady.real
    b = v - (forcing_pole * steady).real
    return complex(a, -(b - pole.real * a) / pole.imag)


@jit
def flight(p, tau, x1, v1, gap, rate):
    """Modes of ξ₁ and ξ₂ while separated, from ξ₁, ξ₁′, g and g′ at τ."""
    x2, v2 = x1 + gap, v1 + rate
    turn = cexp(p.forcing_pole, tau)
    steady1, steady2 = p.steady1 * turn, p.steady2 * turn
    c1 = free_amplitude(x1, v1, steady1, p.pole1, p.forcing_pole)
    c2 = free_amplitude(x2, v2, steady2, p.pole2, p.forcing_pole)
    zero = complex(0.0, 0.0)
    first = Modes(c1, zero, steady1, p.pole1, p.pole2, p.forcing_pole)
    second = Modes(zero, c2, steady2, p.pole1, p.pole2, p.forcing_pole)
    return first, second


@jit
def difference(first, second):
    """Modes of g = ξ₂ − ξ₁."""
    return Modes(
        second.c1 - first.c1,
        second.c2 - first.c2,
        second.c3 - first.c3,
        first.pole1,
        first.pole2,
        first.pole3,
    )


@jit
def joined(p, tau, x, v):
    """Modes of the common displacement in permanent contact, from the state at τ."""
    steady = p.steady3 * cexp(p.forcing_pole, tau)
    c = free_amplitude(x, v, steady, p.pole3, p.forcing_pole)
    zero = complex(0.0, 0.0)
    return Modes(c, zero, steady, p.pole3, p.pole3, p.forcing_pole)


@jit
def contact_force(p, common):
    """Modes of λ = μ/(1+μ) [(κ² − 1) ξ + 2 (d₂κ − d₁) ξ′] in permanent contact (MODEL.md)."""
    a, b = p.force_position, p.force_velocity
    return Modes(
        (a + b * common.pole1) * common.c1,
        (a + b * common.pole2) * common.c2,
        (a + b * common.pole3) * common.c3,
        common.pole1,
        common.pole2,
        common.pole3,
    )
