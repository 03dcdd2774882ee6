"""Newmark's step as a linear map, and its powers: what many steps with one contact state do at once.

As long as contact does not change, a step maps

    z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁, C, S),    C = cos ητ,  S = sin ητ,

the predictors of :mod:`..time_stepping.newmark`, linearly, z → Φ z, and the gap at its end is a row ρ times z. All of
them are counted from the static equilibrium, in contact from that of the bodies pressed together. So the
gaps at the ends of the next ENTRIES steps are rows ρ Φʲ⁻¹ times one state, and Φʲ carries the state there.

**Levels.** The same at every s-th step reaches s times as far. Between two entries of such a level the gaps keep to a
bound: where the second differences of a sequence, gⱼ₊₁ − 2gⱼ + gⱼ₋₁, are at most B, it lies at the share u of s steps
no more below its chord than a parabola would,

    B = sup|ρ (Φ − 1)² Φʲ⁻² z|,        b = B s²/8                                                 (45)
    signed gap ≥ chord − 4u(1 − u) b                                                              (46)

So where it exceeds b at both ends, it has no zero inside. The second differences are rows too, of which the supremum
over all steps of a level is taken, element by element. The entries of a level are made from those of the level below.

**Signed gap.** In contact the gap's negative is tabulated, so that for both contact states the signed gap is positive
until contact changes. It is the tabulated one, relative to the equilibrium, less a *surface*: what is tabulated where
the bodies touch. The gap at the start of a skip is no such row: where contact has just changed, it was
computed with the other contact state. So the certificate begins with the next step.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.equations.motion import free_equilibrium, free_rate, pressed_equilibrium, pressed_rate
from vibroscope.engine.kernels.linear.matrices import fill_powers, image, raise_to_images, raise_within
from vibroscope.engine.kernels.parameters import FOR_CONTACT, FOR_FLIGHT, renew_key, unpack_parameters
from vibroscope.engine.kernels.time_stepping.newmark import SCHEME, Scheme, phased, scheme_of, step_with

FREE, PRESSED = 0, 1  # contact states
LEVELS = 3
ENTRIES = 128  # of a level
REACHES = 0.15, 1.0  # |ν| times the longest stride, free and pressed: bounds are tight enough for most flights …
SAMPLED = 0.25  # … if suprema are taken over steps no further apart than this
LONGEST = ENTRIES * ENTRIES // 2  # longest stride: every step is then one entry of each level away


class StepMap(NamedTuple):
    """One step with one contact state; rows to be multiplied by the z before it."""

    matrix: np.ndarray  # (6, 6) Φ
    accelerations: np.ndarray  # (2, 6) Δτ² ξ″ at its end
    force: np.ndarray  # (6,) λ at its end
    gap: np.ndarray  # (6,) ρ


class StepTables(NamedTuple):
    """What many steps do; first index: FREE or PRESSED, second: the level, from single steps on."""

    signed_gaps: np.ndarray  # (2, LEVELS, 6, ENTRIES) ±g after 1 … ENTRIES strides
    matrices: np.ndarray  # (2, LEVELS, ENTRIES, 6, 6) Φˢ, Φ²ˢ, …
    curvatures: np.ndarray  # (2, LEVELS, 6) bound of b between entries
    accelerations: np.ndarray  # (2, 2, 6) Δτ² ξ″ at the end of the next step
    impulses: np.ndarray  # (LEVELS, ENTRIES, 6) Δτ Σλ over the steps up to each entry, pressed, less that at rest
    surfaces: np.ndarray  # (2,) what is tabulated as signed gap where the bodies touch
    origins: np.ndarray  # (2, 3) equilibrium less that of the separated bodies: ξ₁, gap; Δτ λ there
    strides: np.ndarray  # (2, LEVELS) steps from entry to entry; 0 if there is no such level


class SkippingScheme(NamedTuple):
    """Everything that skipping needs."""

    tables: StepTables
    steps: int  # n
    scheme: Scheme


TABLES = Layout(
    StepTables,
    signed_gaps=(2, LEVELS, 6, ENTRIES),
    matrices=(2, LEVELS, ENTRIES, 6, 6),
    curvatures=(2, LEVELS, 6),
    accelerations=(2, 2, 6),
    impulses=(LEVELS, ENTRIES, 6),
    surfaces=(2,),
    origins=(2, 3),
    strides=(2, LEVELS),
)
SKIPPING = Layout(SkippingScheme, tables=TABLES, scheme=SCHEME)
unpack_skipping = SKIPPING.unpack
_write_numbers = SKIPPING.writer("steps", "scheme")


@jit
def step_map(m, eta, contact):
    """The map of a step, which is what the step makes of unit vectors; from the coefficients of its :class:`Scheme`."""
    accelerations, force, gap, matrix, z = np.zeros((2, 6)), np.zeros(6), np.zeros(6), np.zeros((6, 6)), np.zeros(6)
    turned, sine = math.cos(eta * m.h), math.sin(eta * m.h)
    for j in range(6):
        z[j] = 1.0
        c, s = turned * z[4] - sine * z[5], sine * z[4] + turned * z[5]
        predictors = z[0], z[1], z[0] + z[2], z[1] + z[3]
        # counted from an equilibrium, so that the gap at rest has no part
        a1, a2, force[j] = step_with(m, predictors, contact, phased(m, c, s), (m.coupling * z[0], 0.0))
        accelerations[0, j], accelerations[1, j], gap[j] = a1, a2, z[2] + 0.25 * (a2 - a1)
        q, drift = z[1] + a1, z[3] + (a2 - a1)
        matrix[0, j], matrix[1, j], matrix[2, j], matrix[3, j] = z[0] + q, q, z[2] + drift, drift
        matrix[4, j], matrix[5, j], z[j] = c, s, 0.0
    return StepMap(matrix, accelerations, force, gap)


@jit_no_alloc
def fill_signed_gaps(signed_gaps, first, matrices):
    """Write the signed gaps of a level, of which the first is given."""
    g = signed_gaps
    for i in range(6):
        g[i, 0] = first[i]
    for j in range(1, ENTRIES):
        g[0, j], g[1, j], g[2, j], g[3, j], g[4, j], g[5, j] = image(first, matrices[j - 1])


@jit_no_alloc
def fill_impulses(impulses, first, matrices):
    """Write the impulses over the strides of a level, of which the first is given."""
    out = impulses
    s0, s1, s2, s3, s4, s5 = first[0], first[1], first[2], first[3], first[4], first[5]
    out[0, 0], out[0, 1], out[0, 2], out[0, 3], out[0, 4], out[0, 5] = s0, s1, s2, s3, s4, s5
    for j in range(1, ENTRIES):
        f0, f1, f2, f3, f4, f5 = image(first, matrices[j - 1])
        s0, s1, s2, s3, s4, s5 = s0 + f0, s1 + f1, s2 + f2, s3 + f3, s4 + f4, s5 + f5
        out[j, 0], out[j, 1], out[j, 2], out[j, 3], out[j, 4], out[j, 5] = s0, s1, s2, s3, s4, s5


@jit
def fill_curvature(tables, state, level, one):
    """Write the bound b of a level.

    The supremum is taken over some steps of each stride, entries of the level below. It is extended to the steps that
    follow by powers of 1 + |Φ − 1|, since Φ = 1 + (Φ − 1).
    """
    below, matrices, strides = tables.matrices[state, level - 1], tables.matrices[state, level], tables.strides[state]
    bound = tables.curvatures[state, level]
    change = one.matrix.copy()
    for i in range(6):
        change[i, i] -= 1.0
        bound[i] = 0.0
    curvature = image(image(one.gap, change), change)
    entries = int(strides[level] / strides[level - 1])
    apart = math.ceil(entries * SAMPLED / REACHES[state])
    for k in range(0, entries, apart):
        moved = image(curvature, below[k - 1]) if k > 0 else curvature
        raise_to_images(bound, moved, matrices)
    raise_within(bound, change, apart * strides[level - 1])
    for i in range(6):
        bound[i] *= strides[level] ** 2 / 8


@jit
def choose_strides(longest):
    """Strides of the two levels above single steps, the last about the longest; 0 for a level that is not needed."""
    longest = min(longest, LONGEST)
    if longest <= 4 * ENTRIES:
        return (min(longest, ENTRIES) if longest > 1 else 0), 0
    middle = int(math.sqrt(longest))
    return middle, longest // middle * middle


@jit
def fill_tables(tables, m, eta, state, rate):
    """Write all levels of one contact state; ``rate`` bounds |ν| of its motion, the excitation included."""
    one, sign = step_map(m, eta, state == PRESSED), -1.0 if state == PRESSED else 1.0
    for body in range(2):
        for i in range(6):
            tables.accelerations[state, body, i] = one.accelerations[body, i]
    strides, matrices, signed_gaps = tables.strides[state], tables.matrices[state], tables.signed_gaps[state]
    strides[0] = 1
    strides[1], strides[2] = choose_strides(int(REACHES[state] / (rate * m.h)))
    gap, impulse, stride = sign * one.gap, m.h * one.force, one.matrix
    for level in range(LEVELS):
        if strides[level] == 0:
            break
        if level > 0:
            k = int(strides[level] / strides[level - 1]) - 1
            gap, impulse = signed_gaps[level - 1, :, k].copy(), tables.impulses[level - 1, k]
            stride = matrices[level - 1, k]
        fill_powers(matrices[level], stride)
        fill_signed_gaps(signed_gaps[level], gap, matrices[level])
        if state == PRESSED:
            fill_impulses(tables.impulses[level], impulse, matrices[level])
        if level > 0:
            fill_curvature(tables, state, level, one)


@jit
def set_up_skipping(packed, keys, row):
    """Write the :class:`SkippingScheme` of a run into its packed array.

    Parameters
    ----------
    packed : (SKIPPING.size,) float64
    keys : (2, len(Parameters)) float64
        The parameters for which the tables in ``packed`` were made; changed in place.
    row : (len(Parameters),) float64
    """
    p, tables = unpack_parameters(row), unpack_skipping(packed).tables
    m, rates, counts = scheme_of(p), (free_rate(p), pressed_rate(p)), (FOR_FLIGHT, FOR_CONTACT)
    _write_numbers(packed, p.steps, m)
    for state in range(2):  # a literal 0 or 1 would be compiled twice
        if renew_key(keys[state], row, counts[state]):
            fill_tables(tables, m, p.eta, state, rates[state])
    (x, gap), (x_pressed, gap_pressed) = free_equilibrium(p), pressed_equilibrium(p)
    tables.surfaces[FREE], tables.surfaces[PRESSED] = -gap, gap_pressed
    origin = tables.origins[PRESSED]
    origin[0], origin[1], origin[2] = x_pressed - x, gap_pressed - gap, -m.h * p.stiffness * gap_pressed
