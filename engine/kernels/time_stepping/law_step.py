"""The contact force of a step, or of one of any length, whose law is not spring and damper alone.

Where the law takes them, the gap and its rate at the end of a stage are linear in λ, g = g₀ + aλ and g′ = r₀ + bλ with
a, b ≥ 0, so that one scalar equation is left,

    λ = L(−g₀ − aλ, −r₀ − bλ),                                                            (27)

L by Eqs. (6) and (16) to (21) of :mod:`..equations.contact_law`. L falls with λ, hence the root lies between zero and
L(−g₀, −r₀), and that of the larger, or the smaller, of two forces is the larger, or the smaller, of their roots: so
are those of the laws that are piecewise linear,

    max(0, Kδ + cv),   Kδ + min(max(cv, −Kδ), Kδ) = max(0, min(Kδ + cv, 2Kδ)),   Kδ + c max(v, 0) = max(Kδ + cv, Kδ).

For the others the secants of a bracket that always holds the root find it (Illinois: Dowell & Jarratt, BIT 11 (1971)
168), across the kinks of a law as well, to the last digits. Only the law of constant restitution does not fall
everywhere: where a contact is about to end, it pulls by √δ or more, and the root lies beyond L(−g₀, −r₀).
"""

from ..compile.options import jit_inlined, jit_no_alloc
from ..equations.contact_law import COMPRESSION, CUT, LIMITED, law_force

SOLVES = 100  # secants, of which 6 to 10 are needed
WIDENINGS = 200  # of a bracket, each twice as far
CLOSE = 4 * 2.0**-52


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
        Of :mod:`.newmark` or :mod:`.located_law`.
    gain : float
        c, or h of Eq. (18).
    gap, rate : float
        g₀ and r₀.
    by_gap, by_rate : float
        a and b.
    """
    if m.law == CUT or m.law == LIMITED or m.law == COMPRESSION:
        both = linear_root(m.stiffness, gain, gap, rate, by_gap, by_rate)
        if m.law == CUT:
            return max(0.0, both)
        if m.law == COMPRESSION:
            return max(both, linear_root(m.stiffness, 0.0, gap, rate, by_gap, by_rate))
        return max(0.0, min(both, linear_root(2.0 * m.stiffness, 0.0, gap, rate, by_gap, by_rate)))
    return bracketed_root(m, gain, gap, rate, by_gap, by_rate)


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
