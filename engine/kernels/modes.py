"""Sums of three complex exponentials: what every quantity of a linear phase of the motion is.

Between two events each displacement, the gap and the contact force have the form

    f(s) = Re Σₖ cₖ exp(λₖ s),     s = τ − τ_anchor,

where λₖ = −δₖ + iνₖ are the poles of the free oscillators and iη is the forcing. Derivatives multiply the
amplitudes by λₖ. Since no λₖ has a positive real part, |f⁽ⁿ⁾(s)| ≤ Mₙ = Σ |cₖ| |λₖ|ⁿ for all s ≥ 0: the bounds
on which the certified root search rests.

The search needs exp(λₖ s) at the ends of steps whose length is its own choice. It chooses from a ladder of lengths
whose exponentials are known beforehand, so that a step is three complex products, and no sine, cosine or exponential.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit

RUNGS_PER_OCTAVE = 4  # a step is at most 2^(1/4) shorter than what was asked for
OCTAVES = 20
TERMS = 12  # of a Taylor series about any point, good to rounding up to |λ| s = REACH
REACH = 0.25
_RECIPROCALS = 1.0 / np.arange(1.0, TERMS + 1.0)  # a division on the critical path would cost more than all the rest


class Modes(NamedTuple):
    """Amplitudes c and poles λ of f(s) = Re Σ cₖ exp(λₖ s)."""

    c1: complex
    c2: complex
    c3: complex
    pole1: complex
    pole2: complex
    pole3: complex


class Ladder(NamedTuple):
    """Step lengths and their exponentials, and room for a Taylor series."""

    lengths: np.ndarray  # (n,), falling
    factors: np.ndarray  # (2, n, 3) exp(λₖ h) for two sets of poles: separated, joined
    fastest: float  # largest |λₖ|
    terms: np.ndarray  # (TERMS,) scratch, so that no kernel allocates


def make_ladder(separated: tuple[complex, ...], joined: tuple[complex, ...]) -> Ladder:
    """Ladder for two sets of three poles, from about two thirds of a turn of the slowest downwards."""
    sizes = np.abs([separated, joined])
    lengths = 4.0 / sizes.min() * 2.0 ** (-np.arange(RUNGS_PER_OCTAVE * OCTAVES) / RUNGS_PER_OCTAVE)
    factors = np.exp([np.outer(lengths, poles) for poles in (separated, joined)])
    return Ladder(lengths, factors, float(sizes.max()), np.zeros(TERMS))


@jit
def rung(lengths, h):
    """Index of the longest step of the ladder that is not longer than h; beyond its end if there is none."""
    fraction, octave = math.frexp(min(h / lengths[0], 1.0))
    j = -RUNGS_PER_OCTAVE * octave
    if fraction < 2.0**-0.75:
        j += 4
    elif fraction < 2.0**-0.5:
        j += 3
    elif fraction < 2.0**-0.25:
        j += 2
    elif fraction < 1.0:
        j += 1
    # the quotient is rounded, so its neighbour may be the one
    return j if j >= lengths.shape[0] or lengths[j] <= h else j + 1


@jit
def cexp(pole, s):
    """exp(λ s) for a complex pole and real s."""
    size = math.exp(pole.real * s)
    angle = pole.imag * s
    return complex(size * math.cos(angle), size * math.sin(angle))


@jit
def enough(x):
    """How many terms of a Taylor series are good to rounding where |λ| s ≤ x ≤ REACH: xⁿ/n! < 2·10⁻¹⁷."""
    if x > 0.03:
        return TERMS
    return 8 if x > 0.004 else 6


@jit
def nearby(pole, s, count):
    """exp(λ s) by ``count`` terms of its Taylor series."""
    x, y = pole.real * s, pole.imag * s
    re, im = 1.0, 0.0
    for k in range(count - 1, -1, -1):
        share = _RECIPROCALS[k]
        a, b = share * x, share * y
        re, im = 1.0 + a * re - b * im, a * im + b * re
    return complex(re, im)


@jit
def at(modes, s):
    """f, f′ and f″ at s."""
    e1, e2, e3 = cexp(modes.pole1, s), cexp(modes.pole2, s), cexp(modes.pole3, s)
    return combined(modes, e1, e2, e3)


@jit
def combined(modes, e1, e2, e3):
    """f, f′ and f″ where the exponentials are e₁, e₂, e₃."""
    z1, z2, z3 = modes.c1 * e1, modes.c2 * e2, modes.c3 * e3
    dz1, dz2, dz3 = modes.pole1 * z1, modes.pole2 * z2, modes.pole3 * z3
    ddz = modes.pole1 * dz1 + modes.pole2 * dz2 + modes.pole3 * dz3
    return z1.real + z2.real + z3.real, dz1.real + dz2.real + dz3.real, ddz.real


@jit
def scaled(z, factor):
    """A complex times a real number, which the compiler would take for two complex ones."""
    return complex(z.real * factor, z.imag * factor)


@jit
def taylor(modes, e1, e2, e3, terms, count):
    """The first ``count`` terms[k] = f⁽ᵏ⁾/k! where the exponentials are e₁, e₂, e₃."""
    z1, z2, z3 = modes.c1 * e1, modes.c2 * e2, modes.c3 * e3
    for k in range(count):
        terms[k] = z1.real + z2.real + z3.real
        share = _RECIPROCALS[k]
        z1, z2, z3 = z1 * scaled(modes.pole1, share), z2 * scaled(modes.pole2, share), z3 * scaled(modes.pole3, share)


@jit
def derivative(modes):
    """Modes of f′."""
    return Modes(
        modes.c1 * modes.pole1,
        modes.c2 * modes.pole2,
        modes.c3 * modes.pole3,
        modes.pole1,
        modes.pole2,
        modes.pole3,
    )


@jit
def at_anchor(modes):
    """f(0), without an exponential."""
    return modes.c1.real + modes.c2.real + modes.c3.real


@jit
def size(z):
    """|z| without the care for overflow that these numbers do not need."""
    return math.sqrt(z.real * z.real + z.imag * z.imag)


@jit
def bounds(modes):
    """M₀, M₁, M₂ and M₃, with Mₙ ≥ |f⁽ⁿ⁾(s)| for all s ≥ 0."""
    a1, a2, a3 = size(modes.c1), size(modes.c2), size(modes.c3)
    w1, w2, w3 = size(modes.pole1), size(modes.pole2), size(modes.pole3)
    b1, b2, b3 = a1 * w1, a2 * w2, a3 * w3
    c1, c2, c3 = b1 * w1, b2 * w2, b3 * w3
    return a1 + a2 + a3, b1 + b2 + b3, c1 + c2 + c3, c1 * w1 + c2 * w2 + c3 * w3
