"""Certificate that contact does not change: how many steps can be skipped from where the discrete solution stands.

The signed gaps at the next steps, or at every s-th of them, are rows of tables times one state (:mod:`.step_map`),
which the processor forms side by side. Where the bound of a coarse level excludes a change of contact between its
entries, its strides are skipped. Where that ends, the next finer level takes over. At last single steps find the step
with which contact changes, by the sign of the gap, as the plain loop does.

A skip ends with that step or, before it, where a gap is so near to zero that rounding could change its sign. Between
two stops it ends, too, before a gap from which steps are seen from the other stop: rows with the other sign say when.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear.tables import apply_transition, dot
from vibroscope.engine.kernels.time_stepping.newmark import FAR_FROM_STOP, LIMIT

FAR = 1e-3 * LIMIT  # beyond it no step is skipped

# What follows a skip: another one; a step that may change contact and is taken as in the plain loop; nothing, since
# contact changes with its last step
SKIP_ON, TAKE_STEP, CHANGE = range(3)
CERTAIN = 2.0**-40  # a gap beyond this share of the displacements has a sign that rounding cannot change
GROUP = 32  # entries that are examined together
_NONE = np.int32(GROUP)
FEW = GROUP  # steps that are searched one by one: a level saves no time there


class Skip(NamedTuple):
    """Steps with one contact state: entries of each level, and what follows."""

    coarse: int
    middle: int
    fine: int
    outcome: int  # SKIP_ON, TAKE_STEP or CHANGE
    before: float  # signed gap before the last step
    signed_gap: float  # and after it
    beginning: tuple  # z before the single steps


@jit_inlined
def signed_gap_at(t, pressed, level, z, j):
    """The signed gap after j ≥ 1 strides."""
    return dot(t.signed_gaps[pressed, level, :, j - 1], z) - t.surfaces[pressed]


@jit_inlined
def entries_above(t, pressed, level, z, bound, begin):
    """Entries of a level, up to the end of a group, before the first whose tabulated gap does not exceed the bound."""
    m, end = t.signed_gaps[pressed, level], begin + GROUP
    z0, z1, z2, z3, z4, z5 = z
    m0, m1, m2 = m[0, begin:end], m[1, begin:end], m[2, begin:end]
    m3, m4, m5 = m[3, begin:end], m[4, begin:end], m[5, begin:end]
    first = _NONE
    # without a branch, and with indices of half the size: fewer vector instructions
    for j in range(GROUP):
        signed_gap = m0[j] * z0 + m1[j] * z1 + m2[j] * z2 + m3[j] * z3 + m4[j] * z4 + m5[j] * z5
        first = min(first, _NONE if signed_gap > bound else np.int32(j))
    return begin + int(first)


@jit_no_alloc
def entries_below(t, pressed, level, z, bound, most):
    """Entries of a level, at most so many, before the first whose tabulated gap is not below the bound."""
    found, against = 0, (-z[0], -z[1], -z[2], -z[3], -z[4], -z[5])
    for begin in range(0, most, GROUP):
        found = entries_above(t, pressed, level, against, -bound, begin)
        if found < begin + GROUP:
            break
    return min(found, most)


@jit_inlined
def entries_between(t, pressed, level, z, low, high):
    """Entries of a level before the first whose tabulated gap does not lie between two bounds; high may be infinite."""
    found = 0
    for begin in range(0, ENTRIES, GROUP):
        found = entries_above(t, pressed, level, z, low, begin)
        if found < begin + GROUP:
            break
    return found if high == math.inf else entries_below(t, pressed, level, z, high, found)


@jit_inlined
def gap_bound(t, pressed, level, z):
    """b of Eq. (45)."""
    return dot(t.curvatures[pressed, level], (abs(z[0]), abs(z[1]), abs(z[2]), abs(z[3]), abs(z[4]), abs(z[5])))


@jit_inlined
def uncertainty(t, pressed, z):
    """What a signed gap in the steps after z must exceed for rounding not to change its sign."""
    return CERTAIN * (abs(z[0]) + abs(z[2]) + abs(t.surfaces[pressed]))


@jit_inlined
def certified_entries(t, pressed, level, z, far):
    """Entries of a level up to which contact certainly does not change; 0 where single steps do as well.

    ``far``: a gap that a flight does not come to, either; infinite if there is none.
    """
    if t.strides[pressed, level] == 0:
        return 0
    bound = gap_bound(t, pressed, level, z)
    # From a small signed gap to g₁ at the first entry: the chord lies above u g₁, the curve at most 4u(1 − u) · bound
    # below the chord.
    near = signed_gap_at(t, pressed, 0, z, 1)
    if not (near > bound or (near > 0.0 and signed_gap_at(t, pressed, level, z, 1) > 4.0 * bound)):
        return 0
    ceiling = math.inf if pressed else far - bound
    if near >= ceiling:
        return 0
    surface = t.surfaces[pressed]
    entries = entries_between(t, pressed, level, z, bound + surface, ceiling + surface)
    return entries if entries * t.strides[pressed, level] > FEW else 0


@jit_inlined
def single_steps(t, pressed, z, signed_gap, far):
    """Steps up to the first with which contact changes by the sign of the gap; what follows; the last signed gaps.

    A gap whose sign is not certain ends them as well, so that a graze within rounding is left to the plain step; and so
    does one that comes to ``far``.
    """
    surface, uncertain = t.surfaces[pressed], uncertainty(t, pressed, z)
    ceiling = math.inf if pressed else far - uncertain + surface
    count = entries_between(t, pressed, 0, z, uncertain + surface, ceiling)
    before = signed_gap_at(t, pressed, 0, z, count) if count > 0 else signed_gap
    if count == ENTRIES:
        return count, SKIP_ON, before, before
    change = signed_gap_at(t, pressed, 0, z, count + 1)
    if min(before, -change) > uncertain and -change < far:
        return count + 1, CHANGE, before, change
    fine = max(count - 1, 0)
    before = signed_gap_at(t, pressed, 0, z, fine) if fine > 0 else signed_gap
    return fine, TAKE_STEP, before, before


@jit_inlined
def certify_skip(p, pressed, z, signed_gap):
    """The skip from z; none where the motion is about to diverge."""
    t, far = p.tables, FAR_FROM_STOP * p.scheme.play
    if not abs(z[0]) + abs(z[2]) + p.steps * (abs(z[1]) + abs(z[3])) < FAR:
        return Skip(0, 0, 0, TAKE_STEP, signed_gap, signed_gap, z)
    coarse = certified_entries(t, pressed, 2, z, far)
    if coarse > 0:
        signed_gap = signed_gap_at(t, pressed, 2, z, coarse)
        z = apply_transition(t.matrices[pressed, 2], z, coarse)
    if coarse == ENTRIES:
        return Skip(coarse, 0, 0, SKIP_ON, signed_gap, signed_gap, z)
    middle = certified_entries(t, pressed, 1, z, far)
    if middle > 0:
        signed_gap = signed_gap_at(t, pressed, 1, z, middle)
        z = apply_transition(t.matrices[pressed, 1], z, middle)
    if middle == ENTRIES:
        return Skip(coarse, middle, 0, SKIP_ON, signed_gap, signed_gap, z)
    fine, outcome, before, signed_gap = single_steps(t, pressed, z, signed_gap, far)
    return Skip(coarse, middle, fine, outcome, before, signed_gap, z)


@jit_inlined
def steps_of(t, pressed, skip):
    """Steps that are skipped."""
    strides = t.strides[pressed]
    return skip.coarse * int(strides[2]) + skip.middle * int(strides[1]) + skip.fine
