"""The discrete solution of :mod:`.newmark`, the same steps, without walking through each of them.

The margins at the next steps, or at every s-th of them, are rows of tables times one state (:mod:`.steps`), and the
processor forms them side by side. Where a coarse level's bound leaves no change of contact between its entries, its
strides are skipped; where that ends, the next finer level takes over, and at last single steps show the one with which
contact changes, by the sign of the gap, as in the plain loop.

A leap ends with that step or, where the gap there is so near to zero that rounding could turn its sign, before it: then
a step as in the plain loop decides, and plain loop and leaps may differ. Leaps do not depend on where a run is cut: one
that reaches beyond its end is not taken, what is asked for within it is read off, and the next call begins with it.
"""

import math
from typing import NamedTuple

from .folded import viewers
from .jit import bare, inlined, jit, spliced
from .newmark import (
    A1,
    A2,
    BEGIN,
    CLOSING,
    CONTACT,
    DIVERGED,
    DONE,
    FULL,
    IMPULSE,
    LIMIT,
    P1,
    P2,
    Q1,
    Q2,
    STEP,
    Scheme,
    close_contact,
    motion,
    motion_of,
    open_contact,
    sample,
    step,
)
from .newmark import SLOTS as NEWMARK_SLOTS
from .phase import carried, circle, dot
from .record import no_room, unfold_record
from .steps import FREE, HELD, PRESSED, SHAPES, Tables

GAP, SLOTS = NEWMARK_SLOTS, NEWMARK_SLOTS + 1  # the state's last slot: g
TINY = -5e-324  # the first number below zero: a gap of zero is contact
FAR = 1e-3 * LIMIT  # beyond it every step is looked at

# what follows a leap: another one; a step of which it is not known whether contact changes; a change, in its last step
GO_ON, LOOK, FLIP = range(3)
CERTAIN = 2.0**-40  # a gap beyond this share of the displacements has a sign that rounding cannot change
CHUNK = 32  # entries that are looked at together
NOWHERE = (0.0, 0.0, 0.0, 0.0)  # a motion that nobody asks for


class Leap(NamedTuple):
    """Steps with the same contact state: entries of each level, and what follows."""

    coarse: int
    middle: int
    fine: int
    then: int  # GO_ON, LOOK or FLIP
    before: float  # the margin before its last step
    margin: float  # and after it
    beginning: tuple  # z before its single steps


class Leaps(NamedTuple):
    """Everything that leaps need."""

    tables: Tables
    steps: int  # n
    scheme: Scheme


_SHAPES = *SHAPES, (), (len(Scheme._fields),)
SIZE = sum(math.prod(shape) for shape in _SHAPES)
_margins, _moves, _bends, _accelerations, _sums, _strides, _steps, _scheme = viewers(*_SHAPES)


@spliced
def tables_in(f):
    """The tables that lie in one array (:mod:`.folded`), as views."""
    return Tables(_margins(f), _moves(f), _bends(f), _accelerations(f), _sums(f), _strides(f))


@spliced
def unfold(f):
    """The leaps that lie in one array; their own arrays are views."""
    m = _scheme(f)
    scheme = Scheme(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], m[12], m[13])
    return Leaps(tables_in(f), int(_steps(f)), scheme)


@jit
def write_scheme(f, n, m):
    """Write what stands behind the tables."""
    at = SIZE - 1 - len(m)
    f[at] = n
    for k in range(len(m)):
        f[at + 1 + k] = m[k]


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
def later(t, contact, z, coarse, middle, fine):
    """z after so many entries of each level, all of them with the same contact state."""
    z = carried(t.moves[contact, 1], carried(t.moves[contact, 2], z, coarse), middle)
    return carried(t.moves[contact, 0], z, fine)


@inlined
def split(steps, stride):
    """Whole strides in so many steps, as far as their table goes, and the steps that are left."""
    strides = min(steps // stride, HELD) if stride > 0 else 0
    return strides, steps - strides * stride


@bare
def motion_after(p, m, contact, z, i, t):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of step t, from z after step i < t: rows times the z before step t."""
    c, s = circle((t - 1) % p.steps / p.steps)
    strides = p.tables.strides
    coarse, rest = split(t - 1 - i, int(strides[contact, 2]))
    middle, fine = split(rest, int(strides[contact, 1]))
    z = (*later(p.tables, contact, z, coarse, middle, fine)[:4], c, s)
    rows = p.tables.accelerations[contact]
    a1, a2 = dot(rows[0], z), dot(rows[1], z)
    p1, q1, p2, q2 = z[0], z[1], z[0] + z[2], z[1] + z[3]
    return p1 + 0.25 * a1, (q1 + 0.5 * a1) / m.h, p2 + 0.25 * a2, (q2 + 0.5 * a2) / m.h


@inlined
def impulse_of(t, z, ahead):
    """Δτ Σλ over the steps of a leap in contact."""
    total = dot(t.sums[2, ahead.coarse - 1], z) if ahead.coarse > 0 else 0.0
    z = carried(t.moves[PRESSED, 2], z, ahead.coarse)
    total += dot(t.sums[1, ahead.middle - 1], z) if ahead.middle > 0 else 0.0
    z = carried(t.moves[PRESSED, 1], z, ahead.middle)
    return total + (dot(t.sums[0, ahead.fine - 1], z) if ahead.fine > 0 else 0.0)


@bare
def emit(p, m, contact, z, i, end, flip, window, record):
    """Write the section rows and samples of the steps i + 1 … end; ``flip``: the step with which contact changes."""
    n = p.steps
    t = (max(i, window[0]) // n + 1) * n
    while t <= end:
        record.section[(t - window[0]) // n - 1] = motion_after(p, m, contact, z, i, t)
        t += n
    t, stride = max(i + 1, window[1]), window[2]
    while t <= end and record.samples.shape[0] > 0:
        late = (t % n) % stride
        if late > 0:
            t += min(stride - late, n - t % n)
            continue
        j = (t - window[1]) // n * record.phases.shape[0] + (t % n) // stride
        if j < record.samples.shape[0]:
            sample(m, record.samples[j], motion_after(p, m, contact, z, i, t), contact != (t == flip))
        t += 1


@inlined
def note_change(m, state, opens, i, now, closed, impulse, kept, record):
    """Note that contact begins or ends with step i, in which the gap falls by ``closed``; returns its impulse."""
    if not kept:  # outside the kept periods its impact is not asked for
        if opens:
            state[BEGIN], state[CLOSING] = i, 0.0
        return impulse
    if opens:
        open_contact(state, i, now, closed / m.h)
        return 0.0
    state[IMPULSE] = impulse
    close_contact(m, state, i, now, record)
    return impulse


@inlined
def write_step(p, m, contact, i, now, window, record):
    """Write the section row and the sample of one step, if it has any."""
    n, k = p.steps, i % p.steps
    if k == 0:
        record.section[(i - window[0]) // n - 1] = now
    j = (i - window[1]) // n * record.phases.shape[0] + k // window[2]
    if i >= window[1] and k % window[2] == 0 and j < record.samples.shape[0]:
        sample(m, record.samples[j], now, contact)


@bare
def leap(folded, state, stop, window, flat, sizes, full):
    """Carry the discrete solution to the end of step ``stop``, as :func:`.newmark.advance_recorded` does.

    Parameters
    ----------
    folded : (n,) float64
        Leaps, as :func:`.folded.fold` gives them.
    state : (SLOTS,) float64
        Changed in place. ``state[STEP]`` is the step from which the next call goes on: ``stop`` or, where a leap
        reaches beyond, the step before that leap.
    stop : int
    window : (3,) int64
        The step at which the kept periods begin, the step at which sampling begins, and the steps from sample to
        sample, counted anew in each period.
    flat, sizes
        A folded record. Nothing is kept if it has no room for a section.
    full : bool
        Whether motion and impulse of an impact are asked for, and not its instant and closing speed alone.

    Returns
    -------
    int
        DONE, DIVERGED or FULL.
    """
    p, record = unfold(folded), unfold_record(flat, sizes)
    m = p.scheme
    p1, q1, p2, q2, contact = state[P1], state[Q1], state[P2], state[Q2], PRESSED if state[CONTACT] > 0.0 else FREE
    a1, a2, impulse, gap = state[A1], state[A2], state[IMPULSE], state[GAP]
    n, i, status = p.steps, int(state[STEP]), DONE
    kept, sampled = record.section.shape[0] > 0, record.samples.shape[0] > 0
    k = i % n  # steps done in the period
    share = 1.0 / n
    c, s = circle(k * share)
    if sampled and i == window[1]:
        sample(m, record.samples[0], motion(m, p1, q1, a1, p2, q2, a2), contact)
    while i < stop:
        if kept and no_room(record):
            status = FULL
            break
        z = (p1, q1, p2 - p1, q2 - q1, c, s)
        ahead = look_ahead(p, contact, z, -gap if contact else gap)
        strides = p.tables.strides[contact]
        skipped = ahead.coarse * int(strides[2]) + ahead.middle * int(strides[1]) + ahead.fine
        if skipped > 0:
            then = i + skipped
            if sampled or (kept and k + skipped >= n):
                emit(p, m, contact, z, i, min(then, stop), then if ahead.then == FLIP else -1, window, record)
            if then >= stop:
                break
            p1, q1, apart, drift, _, _ = carried(p.tables.moves[contact, 0], ahead.beginning, ahead.fine)
            p2, q2 = p1 + apart, q1 + drift
            k += skipped
            if k >= n:
                k %= n
            c, s = circle(k * share)
            gap = -ahead.margin if contact else ahead.margin
            if kept and full and contact:
                impulse += impulse_of(p.tables, z, ahead)
            if ahead.then == FLIP:
                now = motion_after(p, m, contact, z, i, then) if kept and full else NOWHERE
                closed = ahead.before - ahead.margin
                impulse = note_change(m, state, not contact, then, now, closed, impulse, kept, record)
                contact = PRESSED - contact
            i = then
        if ahead.then != LOOK:
            continue
        # one step as the plain loop takes it
        before = gap
        k = k + 1 if k + 1 < n else 0
        c, s = circle(k * share)
        a1, a2, force = step(m, p1, q1, p2, q2, contact, c)
        gap = p2 - p1 + 0.25 * (a2 - a1)
        q1 += a1
        q2 += a2
        p1 += q1
        p2 += q2
        i += 1
        impulse += m.h * force  # the trapezoidal rule carries a force into two half steps, hence one whole step each
        change = (gap <= 0.0) != (contact == PRESSED)
        contact = PRESSED - contact if change else contact
        now = motion(m, p1, q1, a1, p2, q2, a2) if kept else NOWHERE
        if change:
            impulse = note_change(m, state, contact, i, now, before - gap, impulse, kept, record)
        if kept:
            write_step(p, m, contact, i, now, window, record)
        if not abs(gap) < LIMIT:
            status = DIVERGED
            break
    state[P1], state[Q1], state[P2], state[Q2], state[GAP] = p1, q1, p2, q2, gap
    state[A1], state[A2], state[CONTACT], state[STEP] = a1, a2, (1.0 if contact else 0.0), i
    state[IMPULSE] = impulse
    return status


@bare
def finish(folded, state, stop, record):
    """Walk through what is left of an open contact up to ``stop``, and note it as if it ended there."""
    p = unfold(folded)
    m = p.scheme
    k, i = int(state[STEP]) % p.steps, int(state[STEP])
    while i < stop:
        k = (k + 1) % p.steps
        cosine = circle(k / p.steps)[0]
        state[A1], state[A2], force = step(m, state[P1], state[Q1], state[P2], state[Q2], True, cosine)
        state[Q1] += state[A1]
        state[Q2] += state[A2]
        state[P1] += state[Q1]
        state[P2] += state[Q2]
        state[IMPULSE] += m.h * force
        i += 1
    close_contact(m, state, i, motion_of(m, state), record)
