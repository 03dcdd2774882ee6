"""Separation of the fast motion of a stiff or strongly damped contact from the slow one.

Pressed together, the bodies have modes of very different speed: that of the contact spring and damper, and those of
their own springs. The fast modes decay, and then the solver need not follow them at their pace: what is left of the
state lies in the invariant subspace of the slow eigenvalues and obeys z′ = A P_s z, P_s the spectral projector on it,

    P_s = 1/(2πi) ∮ (ν − A)⁻¹ dν                                                                 (44)

around a circle between the two groups. The trapezoidal rule on the circle converges as the q-th power of the ratio of a
radius and an eigenvalue, q the number of its nodes, whether or not eigenvalues within a group coincide. With the
bodies' B and the excitation's R, A = [B C; 0 R], the upper rows of (ν − A)⁻¹ are (ν − B)⁻¹ [1  C (ν − R)⁻¹].

Plain twin: integration without the separation, which gives the same motion and takes longer
(tests/engine/kernels/test_slow_subspace.py).
"""

import cmath
import math

import numpy as np
from vibroscope.engine.kernels.compile.options import jit

SEPARATION = 30.0  # least ratio of the two groups that is worth a table of its own
NODES = 32  # SEPARATION to the power −NODES/2 is far below rounding
_HALF = NODES // 2  # the nodes below the real axis give the complex conjugate


@jit
def eliminate(m):
    """Turn (4, 10) complex [M X] into [1 M⁻¹X], by Gauss-Jordan elimination with column pivots."""
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
def fast_projector(generator, eta, radius):
    """Upper rows of P_f = 1 − P_s, (4, 6), which give the fast part of a state; the other rows are zero.

    Parameters
    ----------
    generator : (4, 6) float64
        Upper rows of A.
    eta : float
    radius : float
        Of a circle that encloses the slow eigenvalues and none of the fast ones.
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
