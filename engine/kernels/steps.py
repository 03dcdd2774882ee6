"""Newmark's step as a linear map, and its powers: what many steps with one contact state do at once.

As long as contact does not change, a step maps

    z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁, C, S),    C = cos ητ,  S = sin ητ,

the predictors of :mod:`.newmark`, linearly, z → M z, and the gap at its end is a row ρ times z. So the gaps at the ends
of the next HELD steps are rows ρ Mʲ⁻¹ times one state, and Mʲ moves it on.

**Levels.** The same at every s-th step reaches s times as far. M is the exponential of Ã Δτ: the motion of a linear
system z′ = Ã z, read at the steps, in which |g″| has a bound. At the share u of a stride the gap then lies no more than
4u(1 − u) b below its chord, b = (sΔτ)²/8 · sup|g″|: where it exceeds b at both ends, it has no zero within. Where Δτ is
short beside every oscillation the eigenvalues of M lie near 1, and Ã Δτ = log M is a short series. A level is made of
the entries of the one below.

In contact the gap's negative is tabulated, so that for both contact states the **margin**, what is tabulated, is
positive until contact changes.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit
from .matrices import add, exponential, identity, logarithm, powers, raise_along, row_times, rows_times, spread

FREE, PRESSED = 0, 1  # contact states
LEVELS = 3
HELD = 128  # entries of a level
REACHES = 0.15, 1.0  # |λ| times the longest stride, free and pressed: bounds are then tight enough for most flights …
SAMPLED = 0.25  # … if sup|g″| is taken over instants that lie no further apart than this
LONGEST = HELD * HELD // 2  # no stride is longer, so that every step is an entry of each level away


class Map(NamedTuple):
    """One step with one contact state; rows to be multiplied by the z before it."""

    move: np.ndarray  # (6, 6) M
    accelerations: np.ndarray  # (2, 6) Δτ² ξ″ at its end
    force: np.ndarray  # (6,) λ at its end
    gap: np.ndarray  # (6,) ρ


class Tables(NamedTuple):
    """What many steps do; first index: FREE or PRESSED, second: the level, from single steps on."""

    margins: np.ndarray  # (2, LEVELS, 6, HELD) ±g after 1 … HELD strides
    moves: np.ndarray  # (2, LEVELS, HELD, 6, 6) Mˢ, M²ˢ, …
    bends: np.ndarray  # (2, LEVELS, 6) bound of |g″| (sΔτ)²/8 between
    accelerations: np.ndarray  # (2, 2, 6) Δτ² ξ″ at the end of the next step
    sums: np.ndarray  # (LEVELS, HELD, 6) Δτ Σλ over the steps up to each entry, pressed
    strides: np.ndarray  # (2, LEVELS) steps from entry to entry; 0 if there is no such level


SHAPES = (2, LEVELS, 6, HELD), (2, LEVELS, HELD, 6, 6), (2, LEVELS, 6), (2, 2, 6), (LEVELS, HELD, 6), (2, LEVELS)


@jit
def step_map(m, eta, contact):
    """The map of a step, from the coefficients of :class:`.newmark.Scheme`."""
    turn = eta * m.h
    accelerations, force, gap, move = np.zeros((2, 6)), np.zeros(6), np.zeros(6), np.zeros((6, 6))
    cosine, sine = math.cos(turn), math.sin(turn)
    a1, a2 = accelerations[0], accelerations[1]
    a1[0], a1[1] = -m.stiffness1, -m.damping1
    a2[0] = a2[2] = -m.stiffness2
    a2[1] = a2[3] = -m.damping2
    a1[4], a1[5] = m.load1 * cosine, -m.load1 * sine
    a2[4], a2[5] = m.load2 * cosine, -m.load2 * sine
    if contact:
        for i in range(6):
            force[i] = m.contact_a * (a1[i] - a2[i])
        force[2] -= m.contact_p
        force[3] -= m.contact_q
        for i in range(6):
            a1[i] -= m.react1 * force[i]
            a2[i] += m.react2 * force[i]
    for i in range(6):
        move[0, i] = move[1, i] = a1[i]
        move[2, i] = move[3, i] = a2[i] - a1[i]
        gap[i] = 0.25 * (a2[i] - a1[i])
    # p + Q + A, Q + A, and the same of the differences
    for i in (0, 2):
        move[i, i] += 1.0
        move[i, i + 1] += 1.0
        move[i + 1, i + 1] += 1.0
    gap[2] += 1.0
    move[4, 4] = move[5, 5] = cosine
    move[5, 4], move[4, 5] = sine, -sine
    return Map(move, accelerations, force, gap)


@jit
def fill_level(tables, state, level, margin, pressed, strider):
    """Write the entries of a level: ``margin`` and ``pressed`` after the first of them, which ``strider`` leads to."""
    moves, margins, sums = tables.moves[state, level], tables.margins[state, level], tables.sums[level]
    moves[:] = powers(strider, HELD)
    later = np.empty((HELD, 6))
    rows_times(later, margin, moves, 1.0)
    for i in range(6):
        margins[i, 0] = margin[i]
        for j in range(1, HELD):
            margins[i, j] = later[j - 1, i]
    if state == PRESSED:
        rows_times(later, pressed, moves, 1.0)
        for i in range(6):
            sums[0, i] = pressed[i]
            for j in range(1, HELD):
                sums[j, i] = sums[j - 1, i] + later[j - 1, i]


@jit
def bend(moves, a, here, spacing, parts):
    """Bound of |f″| h²/8 for f = ``here``·z in the motion z′ = A z, over the entries of a level, ``spacing`` apart.

    The supremum over ``parts`` instants of each stride is carried to those between.
    """
    curve, bound = row_times(row_times(here, a, 1.0), a, 1.0), np.zeros(6)
    onward = exponential(a, spacing / parts)
    for _ in range(parts):
        raise_along(bound, curve, moves)
        curve = row_times(curve, onward, 1.0)
    bound = spread(bound, a, 0.5 * spacing / parts)
    for i in range(6):
        bound[i] *= spacing * spacing / 8
    return bound


@jit
def ladder(longest):
    """Strides of the levels above the first, of which the last is about the longest; 0 for a level too many."""
    longest = min(longest, LONGEST)
    if longest <= 4 * HELD:
        return (min(longest, HELD) if longest > 1 else 0), 0
    middle = int(math.sqrt(longest))
    return middle, longest // middle * middle


@jit
def fill_tables(tables, m, eta, state, pole):
    """Write all levels of one contact state; ``pole`` is the largest |λ| of its motion, the excitation included."""
    one, sign = step_map(m, eta, state == PRESSED), -1.0 if state == PRESSED else 1.0
    tables.accelerations[state] = one.accelerations
    strides = tables.strides[state]
    strides[0] = 1
    strides[1], strides[2] = ladder(int(REACHES[state] / (pole * m.h)))
    margin, force, strider = row_times(one.gap, identity(), sign), row_times(one.force, identity(), m.h), one.move
    a, here = np.zeros((6, 6)), np.zeros(6)
    if strides[1] > 0:
        add(a, logarithm(one.move), 1.0 / m.h)
        here = row_times(one.gap, exponential(a, -m.h), 1.0)  # ρ M⁻¹
    for level in range(LEVELS):
        if strides[level] == 0:
            break
        if level > 0:
            k = int(strides[level] / strides[level - 1]) - 1
            margin, force = tables.margins[state, level - 1, :, k].copy(), tables.sums[level - 1, k].copy()
            strider = tables.moves[state, level - 1, k].copy()
        fill_level(tables, state, level, margin, force, strider)
        if level > 0:
            parts = math.ceil(REACHES[state] / SAMPLED)
            tables.bends[state, level] = bend(tables.moves[state, level], a, here, strides[level] * m.h, parts)
