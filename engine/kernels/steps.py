"""Newmark's step as a linear map, and its powers: what many steps with one contact state do at once.

As long as contact does not change, a step maps

    z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁, C, S),    C = cos ητ,  S = sin ητ,

the predictors of :mod:`.newmark`, linearly, z → M z, and the gap at its end is a row ρ times z. So the gaps at the ends
of the next POINTS steps are rows ρ Mʲ⁻¹ times one state, and Mʲ moves it on.

M is the exponential of Ã Δτ: the motion of a linear system z′ = Ã z, read at the steps. With the trapezoidal rule
behind it, (M − 1)(M + 1)⁻¹ has the eigenvalues λΔτ/2, λ those of the equations of motion, so where Δτ is short beside
every oscillation Ã Δτ = 2 artanh of it is a short series. Where the gap is read at every s-th step only, the bound of
its second derivative tells what it does between.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit
from .phase import (
    PHASE_SHAPES,
    POINTS,
    REACH,
    TERMS,
    Phase,
    exponential,
    polynomial,
    powers,
    product,
    row_times,
    tabulate,
)

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
    depths: np.ndarray  # (6, POINTS) −g at the end of step j·stride, j = 1 … POINTS
    moves: np.ndarray  # (POINTS, 6, 6) M to the power j·stride
    sums: np.ndarray  # (POINTS, 6) Δτ Σλ over the next j·stride steps
    bend: np.ndarray  # (6,) bound of |g″| (stride · Δτ)²/8 between


FLIGHT_SHAPES = (), *PHASE_SHAPES, (6, 4 * TERMS), (2, 6), (6,)
SQUEEZE_SHAPES = (), (6, POINTS), (POINTS, 6, 6), (POINTS, 6), (6,)


@jit
def step_map(m, eta, contact):
    """The map of a step, from the coefficients of :class:`.newmark.Scheme`."""
    one = np.eye(6)
    turn = eta * m.h
    cosine = math.cos(turn) * one[4] - math.sin(turn) * one[5]
    sine = math.sin(turn) * one[4] + math.cos(turn) * one[5]
    a1 = m.load1 * cosine - m.damping1 * one[1] - m.stiffness1 * one[0]
    a2 = m.load2 * cosine - m.damping2 * (one[1] + one[3]) - m.stiffness2 * (one[0] + one[2])
    force = np.zeros(6)
    if contact:
        force = m.contact_a * (a1 - a2) - m.contact_p * one[2] - m.contact_q * one[3]
        a1, a2 = a1 - m.react1 * force, a2 + m.react2 * force
    move = np.zeros((6, 6))
    move[1] = one[1] + a1
    move[0] = one[0] + move[1]
    move[3] = one[3] + (a2 - a1)
    move[2] = one[2] + move[3]
    move[4], move[5] = cosine, sine
    accelerations = np.zeros((2, 6))
    accelerations[0], accelerations[1] = a1, a2
    return Map(move, accelerations, force, one[2] + 0.25 * (a2 - a1))


@jit
def generator(move, h):
    """Ã = log M / Δτ, where the eigenvalues of M are near 1."""
    one = np.eye(6)
    x = np.linalg.solve((move + one).T, (move - one).T).T
    square, term, total = product(x, x), x.copy(), x.copy()
    for k in range(3, 60, 2):
        term = product(term, square)
        total += term / k
    return 2.0 / h * total


@jit
def make_flight(m, eta, fastest):
    """Tables of flight; ``fastest`` is the largest |λ| of the free pendulums and the excitation."""
    one = step_map(m, eta, False)
    a = generator(one.move, m.h)
    stride = max(1, int(REACH / (fastest * m.h)))
    spacing = stride * m.h
    within = np.zeros((6, 4 * TERMS))
    for i in range(4):
        row = np.zeros(6)
        row[i] = 1.0
        within[:, i * TERMS : (i + 1) * TERMS] = polynomial(row, a, spacing)
    # g here = ρ M⁻¹ z
    here = np.linalg.solve(one.move.T, one.gap)
    return Flight(stride, tabulate(a[:4].copy(), eta, one.gap, spacing, False), within, one.accelerations, here)


@jit
def make_squeeze(one, h, stride):
    """Tables of contact at every ``stride``-th step, and bounds between them, for which Ã must exist, if it is over 1."""
    strider, sums, total = np.eye(6), np.zeros((POINTS, 6)), np.zeros(6)
    for _ in range(stride):
        total += h * row_times(one.force, strider)
        last = row_times(one.gap, strider)
        strider = product(one.move, strider)
    moves, depths = powers(strider), np.zeros((6, POINTS))
    depths[:, 0], sums[0] = -last, total
    for j in range(1, POINTS):
        depths[:, j] = -row_times(last, moves[j - 1])
        sums[j] = sums[j - 1] + row_times(total, moves[j - 1])
    if stride == 1:
        return Squeeze(stride, depths, moves, sums, np.zeros(6))
    a = generator(one.move, h)
    curve = row_times(row_times(np.linalg.solve(one.move.T, one.gap), a), a)
    quarter, bend = exponential(a * (0.25 * stride * h)), np.abs(curve)
    for _ in range(4):
        for j in range(POINTS):
            bend = np.maximum(bend, np.abs(row_times(curve, moves[j])))
        curve = row_times(curve, quarter)
        bend = np.maximum(bend, np.abs(curve))
    margin = exponential(np.abs(a) * (0.125 * stride * h))
    return Squeeze(stride, depths, moves, sums, row_times(bend, margin) * ((stride * h) ** 2 / 8))


@jit
def no_squeeze():
    """Tables that are not there."""
    return Squeeze(0, np.zeros((6, POINTS)), np.zeros((POINTS, 6, 6)), np.zeros((POINTS, 6)), np.zeros(6))


@jit
def make_squeezes(m, eta, fastest):
    """Fine and coarse tables of contact; ``fastest`` is the largest |λ| of the pressed pendulums and the excitation."""
    one = step_map(m, eta, True)
    stride = min(int(COARSE / (fastest * m.h)), MOST_STRIDE)
    coarse = make_squeeze(one, m.h, stride) if stride >= 2 else no_squeeze()
    return make_squeeze(one, m.h, 1), coarse, one.accelerations
