"""Newmark's step as a linear map, and its powers: what many steps with one contact state do at once.

As long as contact does not change, a step maps

    z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁, C, S),    C = cos ητ,  S = sin ητ,

the predictors of :mod:`.newmark`, linearly, z → M z, and the gap at its end is a row ρ times z. So the gaps at the ends
of the next HELD steps are rows ρ Mʲ⁻¹ times one state, and Mʲ moves it on.

M is the exponential of Ã Δτ: the motion of a linear system z′ = Ã z, read at the steps. Where Δτ is short beside every
oscillation, the eigenvalues of M lie near 1 and Ã Δτ = log M is a short series. Where the gap is read at every s-th
step only, the bound of its second derivative in that motion tells what it does between.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit
from .matrices import (
    add,
    exponential,
    identity,
    logarithm,
    powers,
    product,
    raise_along,
    row_times,
    rows_times,
    spread,
    unit,
)
from .phase import HELD, PHASE_SHAPES, REACH, TERMS, Phase, fill_polynomial, tabulate

MOST_STRIDE = 16
COARSE = 1.0  # |λ| times the spacing of the coarse tables in contact; the quasi-static gap is then certified


class Map(NamedTuple):
    """One step with one contact state; rows to be multiplied by the z before it."""

    move: np.ndarray  # (6, 6) M
    accelerations: np.ndarray  # (2, 6) Δτ² ξ″ at its end
    force: np.ndarray  # (6,) λ at its end
    gap: np.ndarray  # (6,) ρ


class Flight(NamedTuple):
    """Steps without contact, by strides."""

    stride: int
    phase: Phase  # of the gap at the end of the next step; its spacing is a stride
    within: np.ndarray  # (6, 4 TERMS) p₁, Q₁, p₂ − p₁ and Q₂ − Q₁ in powers of the share of a stride
    motion: np.ndarray  # (2, 6) Δτ² ξ″ at the end of the next step
    here: np.ndarray  # (6,) the gap at the step itself


class Squeeze(NamedTuple):
    """Steps in contact, ``stride`` at a time."""

    stride: int  # 0 if the tables are empty
    depths: np.ndarray  # (6, HELD) −g at the end of step j·stride, j = 1 … HELD
    moves: np.ndarray  # (HELD, 6, 6) M to the power j·stride
    sums: np.ndarray  # (HELD, 6) Δτ Σλ over the next j·stride steps
    bend: np.ndarray  # (6,) bound of |g″| (stride · Δτ)²/8 between


FLIGHT_SHAPES = (), *PHASE_SHAPES, (6, 4 * TERMS), (2, 6), (6,)
SQUEEZE_SHAPES = (), (6, HELD), (HELD, 6, 6), (HELD, 6), (6,)


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
def generator(move, h):
    """Ã = log M / Δτ, where the eigenvalues of M are near 1."""
    total = np.zeros((6, 6))
    add(total, logarithm(move), 1.0 / h)
    return total


@jit
def make_flight(m, eta, fastest):
    """Tables of flight; ``fastest`` is the largest |λ| of the free pendulums and the excitation."""
    one = step_map(m, eta, False)
    a = generator(one.move, m.h)
    stride = max(1, int(REACH / (fastest * m.h)))
    spacing = stride * m.h
    within = np.zeros((6, 4 * TERMS))
    for i in range(4):
        fill_polynomial(within, i * TERMS, unit(i), a, spacing)
    here = row_times(one.gap, exponential(a, -m.h), 1.0)  # ρ M⁻¹
    return Flight(stride, tabulate(a[:4], eta, one.gap, spacing), within, one.accelerations, here)


@jit
def make_squeeze(one, h, stride):
    """Tables of contact at every ``stride``-th step; if that is over 1, with bounds between, for which Ã must exist."""
    strider, sums, total, last = identity(), np.zeros((HELD, 6)), np.zeros(6), np.zeros(6)
    depths, bend = np.zeros((6, HELD)), np.zeros(6)
    for _ in range(stride):
        pressed = row_times(one.force, strider, h)
        for i in range(6):
            total[i] += pressed[i]
        last = row_times(one.gap, strider, 1.0)
        strider = product(one.move, strider)
    moves = powers(strider, HELD)
    rows, pressed = np.empty((HELD, 6)), np.empty((HELD, 6))
    rows_times(rows, last, moves, -1.0)
    rows_times(pressed, total, moves, 1.0)
    for i in range(6):
        depths[i, 0], sums[0, i] = -last[i], total[i]
        for j in range(1, HELD):
            depths[i, j] = rows[j - 1, i]
            sums[j, i] = pressed[j - 1, i] + sums[j - 1, i]
    if stride == 1:
        return Squeeze(stride, depths, moves, sums, bend)
    a = generator(one.move, h)
    curve = row_times(row_times(row_times(one.gap, exponential(a, -h), 1.0), a, 1.0), a, 1.0)
    quarter = exponential(a, 0.25 * stride * h)
    for _ in range(4):
        raise_along(bend, curve, moves)
        curve = row_times(curve, quarter, 1.0)
    bend = spread(bend, a, 0.125 * stride * h)
    for i in range(6):
        bend[i] *= (stride * h) ** 2 / 8
    return Squeeze(stride, depths, moves, sums, bend)


@jit
def no_squeeze():
    """Tables that are not there."""
    return Squeeze(0, np.zeros((6, HELD)), np.zeros((HELD, 6, 6)), np.zeros((HELD, 6)), np.zeros(6))


@jit
def make_squeezes(m, eta, fastest):
    """Fine and coarse tables of contact; ``fastest`` is the largest |λ| of the pressed pendulums and the excitation."""
    one = step_map(m, eta, True)
    stride = min(int(COARSE / (fastest * m.h)), MOST_STRIDE)
    coarse = make_squeeze(one, m.h, stride) if stride >= 2 else no_squeeze()
    return make_squeeze(one, m.h, 1), coarse, one.accelerations
