"""Newmark's step as a linear map, and its powers: what many steps with one contact state do at once.

As long as contact does not change, a step maps

    z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁, C, S),    C = cos ητ,  S = sin ητ,

the predictors of Newmark's method, linearly, z → M z, and the gap at its end is a row ρ times z. So the gaps at the
ends of the next HELD steps are rows ρ Mʲ⁻¹ times one state, and Mʲ moves it on.

**Levels.** The same at every s-th step reaches s times as far. Between two entries the steps keep to a bound: where the
second differences of a sequence, gⱼ₊₁ − 2gⱼ + gⱼ₋₁, are at most B, it lies at the share u of s steps no more than
4u(1 − u) b below its chord, b = B s²/8, as a parabola would. So where it exceeds b at both ends, it has no zero within.
The second differences are rows too, ρ (M − 1)² Mʲ⁻², of which the supremum over all steps of a level is taken, element
by element. A level is made of the entries of the one below.

In contact the gap's negative is tabulated, so that for both contact states the **margin**, what is tabulated, is
positive until contact changes. The gap at a step itself is no such row: where contact has just changed, it came about
with the acceleration of the other state. So what is certified begins with the next step.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compile.options import bare, jit
from ..linear.matrices import fill_powers, raise_along, row_image, row_times, spread

FREE, PRESSED = 0, 1  # contact states
LEVELS = 3
HELD = 128  # entries of a level
REACHES = 0.15, 1.0  # |λ| times the longest stride, free and pressed: bounds are then tight enough for most flights …
SAMPLED = 0.25  # … if suprema are taken over steps that lie no further apart than this
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
    bends: np.ndarray  # (2, LEVELS, 6) bound of b between
    accelerations: np.ndarray  # (2, 2, 6) Δτ² ξ″ at the end of the next step
    sums: np.ndarray  # (LEVELS, HELD, 6) Δτ Σλ over the steps up to each entry, pressed
    strides: np.ndarray  # (2, LEVELS) steps from entry to entry; 0 if there is no such level


SHAPES = (2, LEVELS, 6, HELD), (2, LEVELS, HELD, 6, 6), (2, LEVELS, 6), (2, 2, 6), (LEVELS, HELD, 6), (2, LEVELS)


@jit
def step_map(m, eta, contact):
    """The map of a step, from the coefficients of :class:`..time_stepping.newmark.Scheme`."""
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


@bare
def fill_margins(margins, first, moves):
    """Write the margins of a level, of which the first is given."""
    for i in range(6):
        margins[i, 0] = first[i]
    for j in range(1, HELD):
        (margins[0, j], margins[1, j], margins[2, j], margins[3, j], margins[4, j], margins[5, j]) = row_image(
            first, moves[j - 1]
        )


@bare
def fill_sums(sums, first, moves):
    """Write the sums of the contact force over the strides of a level, of which the first is given."""
    s0, s1, s2, s3, s4, s5 = first[0], first[1], first[2], first[3], first[4], first[5]
    sums[0, 0], sums[0, 1], sums[0, 2], sums[0, 3], sums[0, 4], sums[0, 5] = s0, s1, s2, s3, s4, s5
    for j in range(1, HELD):
        f0, f1, f2, f3, f4, f5 = row_image(first, moves[j - 1])
        s0, s1, s2, s3, s4, s5 = s0 + f0, s1 + f1, s2 + f2, s3 + f3, s4 + f4, s5 + f5
        sums[j, 0], sums[j, 1], sums[j, 2], sums[j, 3], sums[j, 4], sums[j, 5] = s0, s1, s2, s3, s4, s5


@jit
def fill_bend(tables, state, level, one):
    """Write the bound b of a level.

    The supremum is taken over some steps of each stride, entries of the level below. From there it is carried to those
    that follow, M being 1 + (M − 1), by powers of 1 + |M − 1|.
    """
    below, moves, bound = tables.moves[state, level - 1], tables.moves[state, level], tables.bends[state, level]
    change = one.move.copy()
    for i in range(6):
        change[i, i] -= 1.0
        bound[i] = 0.0
    curve = row_times(row_times(one.gap, change), change)
    entries = int(tables.strides[state, level] / tables.strides[state, level - 1])
    apart = math.ceil(entries * SAMPLED / REACHES[state])
    for k in range(0, entries, apart):
        raise_along(bound, row_times(curve, below[k - 1]) if k > 0 else curve, moves)
    spread(bound, change, apart * tables.strides[state, level - 1])
    for i in range(6):
        bound[i] *= tables.strides[state, level] ** 2 / 8


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
    strides, moves, margins = tables.strides[state], tables.moves[state], tables.margins[state]
    strides[0] = 1
    strides[1], strides[2] = ladder(int(REACHES[state] / (pole * m.h)))
    margin, impulse, strider = sign * one.gap, m.h * one.force, one.move
    for level in range(LEVELS):
        if strides[level] == 0:
            break
        if level > 0:
            k = int(strides[level] / strides[level - 1]) - 1
            margin, impulse, strider = margins[level - 1, :, k].copy(), tables.sums[level - 1, k], moves[level - 1, k]
        fill_powers(moves[level], strider)
        fill_margins(margins[level], margin, moves[level])
        if state == PRESSED:
            fill_sums(tables.sums[level], impulse, moves[level])
        if level > 0:
            fill_bend(tables, state, level, one)
