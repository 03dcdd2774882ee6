"""Parting the fast motion of a stiff or strongly damped contact from the slow one.

Pressed together, the pendulums have modes of very different speed: on the contact spring and damper, and with their own
springs. The fast ones die away, and then need not be followed at their pace: what is left of the state lies in the
invariant subspace of the slow eigenvalues and obeys z′ = A P z, P the projector on it,

    P = 1/(2πi) ∮ (ζ − A)⁻¹ dζ

around a circle between the two groups. The trapezoidal rule on it converges as the q-th power of the ratio of a radius
and an eigenvalue, q the number of its nodes, whether or not eigenvalues within a group coincide. With the pendulums'
B and the excitation's R, A = [B C; 0 R], of (ζ − A)⁻¹ the upper rows are (ζ − B)⁻¹ [1  C (ζ − R)⁻¹].
"""

import cmath
import math

import numpy as np

from ..compile.options import jit

APART = 30.0  # least ratio of the two groups: less is not worth a table of its own
NODES = 32  # APART to the power −NODES/2 is far below rounding
_HALF = NODES // 2  # the nodes below the real axis give the complex conjugate


@jit
def eliminate(m):
    """Turn (4, 10) complex [M X] into [1 M⁻¹X], by Gauss and Jordan with pivots from the column."""
    for k in range(4):
        pivot = k
        for i in range(k + 1, 4):
            if abs(m[i, k]) > abs(m[pivot, k]):
                pivot = i
        for j in range(k, 10):
            m[k, j], m[pivot, j] = m[pivot, j], m[k, j]
        scale = 1.0 / m[k, k]
        for j in range(k, 10):
            m[k, j] *= scale
        for i in range(4):
            if i != k:
                factor = m[i, k]
                for j in range(k, 10):
                    m[i, j] -= factor * m[k, j]


@jit
def fast_part(generator, eta, radius):
    """The part of a state that is fast, (4, 6): upper rows of 1 − P, the others being zero.

    Parameters
    ----------
    generator : (4, 6) float64
        Upper rows of A.
    eta : float
    radius : float
        Of a circle that has the slow eigenvalues within and the fast ones without.
    """
    fast, m = np.zeros((4, 6)), np.zeros((4, 10), dtype=np.complex128)
    for k in range(_HALF):
        node = radius * cmath.exp(1j * math.pi * (k + 0.5) / _HALF)
        turning = 1.0 / (node * node + eta * eta)
        for i in range(4):
            for j in range(4):
                m[i, j] = -generator[i, j]
                m[i, 4 + j] = 0.0
            m[i, i] += node
            m[i, 4 + i] = 1.0
            c, s = generator[i, 4], generator[i, 5]
            m[i, 8] = (c * node + s * eta) * turning
            m[i, 9] = (s * node - c * eta) * turning
        eliminate(m)
        for i in range(4):
            for j in range(6):
                fast[i, j] -= (node * m[i, 4 + j]).real / _HALF
    for i in range(4):
        fast[i, i] += 1.0
    return fast
