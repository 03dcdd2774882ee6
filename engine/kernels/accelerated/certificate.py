"""How far contact surely does not change: the tables of :mod:`.step_map`, read from where the discrete solution stands.

The margins at the next steps, or at every s-th of them, are rows of tables times one state, and the processor forms
them side by side. Where a coarse level's bound leaves no change of contact between its entries, its strides are
skipped; where that ends, the next finer level takes over, and at last single steps show the one with which contact
changes, by the sign of the gap, as in the plain loop.

A leap ends with that step or, where the gap there is so near to zero that rounding could turn its sign, before it.
"""

from typing import NamedTuple

from ..compile.options import inlined
from ..linear.tables import carried, dot
from ..time_stepping.newmark import LIMIT
from .step_map import HELD

TINY = -5e-324  # the first number below zero: a gap of zero is contact
FAR = 1e-3 * LIMIT  # beyond it every step is looked at

# what follows a leap: another one; a step of which it is not known whether contact changes; a change, in its last step
GO_ON, LOOK, FLIP = range(3)
CERTAIN = 2.0**-40  # a gap beyond this share of the displacements has a sign that rounding cannot change
CHUNK = 32  # entries that are looked at together


class Leap(NamedTuple):
    """Steps with the same contact state: entries of each level, and what follows."""

    coarse: int
    middle: int
    fine: int
    then: int  # GO_ON, LOOK or FLIP
    before: float  # the margin before its last step
    margin: float  # and after it
    beginning: tuple  # z before its single steps


@inlined
def margin_at(t, contact, level, z, j):
    """The margin after so many strides, one at least."""
    m = t.margins[contact, level, :, j - 1]
    return m[0] * z[0] + m[1] * z[1] + m[2] * z[2] + m[3] * z[3] + m[4] * z[4] + m[5] * z[5]


@inlined
def lasting(t, contact, level, z, bound, begin):
    """Entries of a chunk, counted from the level's first, whose margins exceed the bound."""
    m, end = t.margins[contact, level], begin + CHUNK
    z0, z1, z2, z3, z4, z5 = z
    m0, m1, m2 = m[0, begin:end], m[1, begin:end], m[2, begin:end]
    m3, m4, m5 = m[3, begin:end], m[4, begin:end], m[5, begin:end]
    first = CHUNK
    for j in range(CHUNK):
        margin = m0[j] * z0 + m1[j] * z1 + m2[j] * z2 + m3[j] * z3 + m4[j] * z4 + m5[j] * z5
        first = min(first, CHUNK if margin > bound else j)  # without a branch: vector instructions
    return begin + first


@inlined
def certified(t, contact, level, z):
    """Entries of a level up to which contact surely does not change; 0 where single steps do as well."""
    if t.strides[contact, level] == 0:
        return 0
    b = t.bends[contact, level]
    bound = dot(b, (abs(z[0]), abs(z[1]), abs(z[2]), abs(z[3]), abs(z[4]), abs(z[5])))
    # from a small margin to m₁ within the first stride: its chord, above u m₁, exceeds its bow, 4u(1 − u) · bound
    near = margin_at(t, contact, 0, z, 1)
    if not (near > bound or (near > 0.0 and margin_at(t, contact, level, z, 1) > 4.0 * bound)):
        return 0
    entries = 0
    for begin in range(0, HELD, CHUNK):
        entries = lasting(t, contact, level, z, bound, begin)
        if entries < begin + CHUNK:
            break
    return entries if entries * t.strides[contact, level] > CHUNK else 0


@inlined
def single_steps(t, contact, z, margin):
    """Steps up to the first with which contact changes by the sign of the gap; what follows; the last two margins."""
    limit, lasts = (TINY if contact else 0.0), HELD
    for begin in range(0, HELD, CHUNK):
        lasts = lasting(t, contact, 0, z, limit, begin)
        if lasts < begin + CHUNK:
            break
    before = margin_at(t, contact, 0, z, lasts) if lasts > 0 else margin
    if lasts == HELD:
        return lasts, GO_ON, before, before
    change = margin_at(t, contact, 0, z, lasts + 1)
    if min(before, -change) > CERTAIN * (abs(z[0]) + abs(z[2])):
        return lasts + 1, FLIP, before, change
    fine = max(lasts - 1, 0)
    before = margin_at(t, contact, 0, z, fine) if fine > 0 else margin
    return fine, LOOK, before, before


@inlined
def look_ahead(p, contact, z, margin):
    """The leap from z; none where the motion is about to blow up."""
    t = p.tables
    if not abs(z[0]) + abs(z[2]) + p.steps * (abs(z[1]) + abs(z[3])) < FAR:
        return Leap(0, 0, 0, LOOK, margin, margin, z)
    coarse = certified(t, contact, 2, z)
    if coarse > 0:
        margin = margin_at(t, contact, 2, z, coarse)
        z = carried(t.moves[contact, 2], z, coarse)
    if coarse == HELD:
        return Leap(coarse, 0, 0, GO_ON, margin, margin, z)
    middle = certified(t, contact, 1, z)
    if middle > 0:
        margin = margin_at(t, contact, 1, z, middle)
        z = carried(t.moves[contact, 1], z, middle)
    if middle == HELD:
        return Leap(coarse, middle, 0, GO_ON, margin, margin, z)
    fine, then, before, margin = single_steps(t, contact, z, margin)
    return Leap(coarse, middle, fine, then, before, margin, z)


@inlined
def steps_of(t, contact, ahead):
    """Steps that a leap takes."""
    strides = t.strides[contact]
    return ahead.coarse * int(strides[2]) + ahead.middle * int(strides[1]) + ahead.fine
