"""The discrete solution of :mod:`.newmark`, the same steps, without walking through each of them.

**Flight.** The gap at the steps is read off a linear motion (:mod:`.steps`) whose first zero is found as that of the
reference (:mod:`.root`): the steps before it can be skipped.

**Contact.** The gaps of the next HELD steps, which the processor forms side by side, tell how many can be skipped.
Where a contact lasts, every s-th step is enough, as long as the gap stays further below zero than it could rise
between.

A leap ends with the step in which contact changes, or, where the gap there is so near to zero that rounding could turn
its sign, before it: then a step as in the plain loop decides, and plain loop and leaps may differ. Leaps do not depend
on where a run is cut: one that reaches beyond its end is not taken, what is asked for within it is read off, and the
next call begins with it.
"""

from typing import NamedTuple

import numpy as np

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
from .phase import (
    FIRST,
    HELD,
    POINTS,
    POWERS,
    SCRATCH_SHAPES,
    TERMS,
    Phase,
    Scratch,
    carried,
    circle,
    dot,
    moved,
    polynomial_at,
)
from .record import no_room, unfold_record
from .root import first_root, polished
from .steps import FLIGHT_SHAPES, SQUEEZE_SHAPES, Flight, Squeeze, make_flight, make_squeezes

GAP, CALM, SLOTS = NEWMARK_SLOTS, NEWMARK_SLOTS + 1, NEWMARK_SLOTS + 2  # the state's last slots: g, contact lasts
TINY = -5e-324  # the first number below zero: a gap of zero is contact
FAR = 1e-3 * LIMIT  # beyond it every step is looked at


# what follows a leap: another one; a step of which it is not known whether contact changes; a change, in its last step
GO_ON, LOOK, FLIP = range(3)
CERTAIN = 2.0**-40  # a gap beyond this share of the displacements has a sign that rounding cannot change
CHUNK = 32  # entries of a contact's tables that are looked at together
NOWHERE = (0.0, 0.0, 0.0, 0.0)  # a motion that nobody asks for
ROUGHLY = 1  # corrections of a zero that is wanted to a step; signs tell whether they were enough


class Leap(NamedTuple):
    """A number of steps with the same contact state."""

    strides: int
    steps: int  # in addition
    then: int  # GO_ON, LOOK or FLIP
    before: float  # the gap before its last step
    gap: float  # and after it, in contact or if it ends in a change


class Leaps(NamedTuple):
    """Everything that leaps need."""

    steps: int  # n
    flight: Flight
    fine: Squeeze
    coarse: Squeeze
    pressed: np.ndarray  # (2, 6) Δτ² ξ″ at the end of the next step in contact
    scheme: Scheme
    scratch: Scratch


_views = viewers((), *FLIGHT_SHAPES, *SQUEEZE_SHAPES * 2, (2, 6), (len(Scheme._fields),), *SCRATCH_SHAPES)
_steps, _stride, _h, _rows, _moves, _within, _motion, _here = _views[:8]
_stride1, _depths1, _moves1, _sums1, _bend1, _stride2, _depths2, _moves2, _sums2, _bend2 = _views[8:18]
_pressed, _scheme, _products, _stack = _views[18:]


@spliced
def unfold(f):
    """The leaps of an array that :func:`.folded.fold` made of them; their own arrays are views."""
    flight = Flight(int(_stride(f)), Phase(_h(f), _rows(f), _moves(f)), _within(f), _motion(f), _here(f))
    fine = Squeeze(int(_stride1(f)), _depths1(f), _moves1(f), _sums1(f), _bend1(f))
    coarse = Squeeze(int(_stride2(f)), _depths2(f), _moves2(f), _sums2(f), _bend2(f))
    m = _scheme(f)
    scheme = Scheme(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], m[12], m[13])
    return Leaps(int(_steps(f)), flight, fine, coarse, _pressed(f), scheme, Scratch(_products(f), _stack(f)))


@jit
def make_leaps(m, eta, n, free_pole, pressed_pole, scratch):
    """Tables for one scheme; the poles are the largest |λ| without and with contact."""
    fine, coarse, pressed = make_squeezes(m, eta, pressed_pole)
    return Leaps(n, make_flight(m, eta, free_pole), fine, coarse, pressed, m, scratch)


@inlined
def later(p, contact, z, entries, rest):
    """p₁, Q₁, p₂ − p₁ and Q₂ − Q₁ after so many strides and ``rest`` steps, all of them with the same contact state."""
    if contact:
        return carried(p.fine.moves, carried(p.coarse.moves, z, entries), rest)[:4]
    f = p.flight
    z = moved(f.phase, z, entries)
    if rest == 0:
        return z[:4]
    terms = p.scratch.products[: 4 * TERMS]
    z0, z1, z2, z3, z4, z5 = z
    w0, w1, w2, w3, w4, w5 = f.within[0], f.within[1], f.within[2], f.within[3], f.within[4], f.within[5]
    for k in range(4 * TERMS):
        terms[k] = w0[k] * z0 + w1[k] * z1 + w2[k] * z2 + w3[k] * z3 + w4[k] * z4 + w5[k] * z5
    u = rest / f.stride
    p1, q1 = polynomial_at(terms[:TERMS], u)[0], polynomial_at(terms[TERMS : 2 * TERMS], u)[0]
    apart, drift = polynomial_at(terms[2 * TERMS : 3 * TERMS], u)[0], polynomial_at(terms[3 * TERMS :], u)[0]
    return p1, q1, apart, drift


@inlined
def crossing(f, u, scratch):
    """Whole steps in the interval up to its zero at u, and the gap at the ends of the steps before and after it."""
    powers = scratch.products[POWERS:FIRST]
    whole = min(int(u * f.stride), f.stride - 1)
    share = 1.0 / f.stride
    return whole, polynomial_at(powers, whole * share)[0], polynomial_at(powers, (whole + 1) * share)[0]


@inlined
def glide(f, z, scratch):
    """The leap through a flight."""
    if not dot(f.phase.rows[:, POWERS], z) > 0.0:
        return Leap(0, 0, LOOK, 0.0, 0.0)
    i, u, _, _ = first_root(f.phase, z, 0, ROUGHLY, scratch)
    if i == POINTS:
        return Leap(POINTS, 0, GO_ON, 0.0, 0.0)
    # f is the gap at the end of the step that begins there: positive after ``whole`` steps, and not after one more
    certain = CERTAIN * (abs(z[0]) + abs(z[2]))
    whole, above, below = crossing(f, u, scratch)
    if not min(above, -below) > certain:
        u = polished(u, scratch)
        whole, above, below = crossing(f, u, scratch)
    if min(above, -below) > certain:
        over = whole + 2 > f.stride
        return Leap(i + 1 if over else i, whole + 2 - f.stride if over else whole + 2, FLIP, above, below)
    return Leap(i, max(whole - 1, 0), LOOK, 0.0, 0.0)


@inlined
def endure(b, z, level, scratch):
    """Entries of a contact's tables up to which it lasts; ``scratch.products`` holds the depths, one more included."""
    z0, z1, z2, z3, z4, z5 = z
    d0, d1, d2, d3, d4, d5 = b.depths[0], b.depths[1], b.depths[2], b.depths[3], b.depths[4], b.depths[5]
    depths = scratch.products
    for begin in range(0, HELD, CHUNK):
        low = 0
        for j in range(begin, begin + CHUNK):
            depth = d0[j] * z0 + d1[j] * z1 + d2[j] * z2 + d3[j] * z3 + d4[j] * z4 + d5[j] * z5
            depths[j] = depth
            low += not (depth > level)
        if low > 0:
            j = begin
            while depths[j] > level:
                j += 1
            return j
    return HELD


@inlined
def hold(p, z, gap, calm):
    """The leap through a contact, which is ``calm`` if it has lasted through the tables of the leap before."""
    coarse, depths = p.coarse, p.scratch.products
    if calm and coarse.stride > 0:
        level = 0.0
        for i in range(6):
            level += coarse.bend[i] * abs(z[i])
        entries = endure(coarse, z, level, p.scratch) if -gap > level else 0
        if entries > 0:
            return Leap(entries, 0, GO_ON, gap, -depths[entries - 1])
    steps = endure(p.fine, z, TINY, p.scratch)
    before = -depths[steps - 1] if steps > 0 else gap
    if steps == HELD:
        return Leap(0, steps, GO_ON, gap, before)
    if -depths[steps] > CERTAIN * (abs(z[0]) + abs(z[2])):
        return Leap(0, steps + 1, FLIP, before, -depths[steps])
    return Leap(0, steps, LOOK, gap, before)


@inlined
def look_ahead(p, contact, z, gap, calm):
    """The leap from z; none where the motion is about to blow up."""
    if not abs(z[0]) + abs(z[2]) + p.steps * (abs(z[1]) + abs(z[3])) < FAR:
        return Leap(0, 0, LOOK, gap, gap)
    return hold(p, z, gap, calm) if contact else glide(p.flight, z, p.scratch)


@bare
def motion_after(p, m, contact, z, i, t):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of step t, from z after step i < t: rows times the z before step t."""
    c, s = circle((t - 1) % p.steps / p.steps)
    stride = p.coarse.stride if contact else p.flight.stride
    entries, rest = divmod(t - 1 - i, stride) if stride > 0 else (0, t - 1 - i)
    z = (*later(p, contact, z, entries, rest), c, s)
    rows = p.pressed if contact else p.flight.motion
    a1, a2 = dot(rows[0], z), dot(rows[1], z)
    p1, q1, p2, q2 = z[0], z[1], z[0] + z[2], z[1] + z[3]
    return p1 + 0.25 * a1, (q1 + 0.5 * a1) / m.h, p2 + 0.25 * a2, (q2 + 0.5 * a2) / m.h


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
def leap(folded, state, stop, window, flat, sizes):
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

    Returns
    -------
    int
        DONE, DIVERGED or FULL.
    """
    p, record = unfold(folded), unfold_record(flat, sizes)
    m = p.scheme
    p1, q1, p2, q2, contact = state[P1], state[Q1], state[P2], state[Q2], state[CONTACT] > 0.0
    a1, a2, impulse, gap, calm = state[A1], state[A2], state[IMPULSE], state[GAP], state[CALM] > 0.0
    n, i, status, kept = p.steps, int(state[STEP]), DONE, record.section.shape[0] > 0
    k = i % n  # steps done in the period
    share = 1.0 / n
    c, s = circle(k * share)
    if kept and i == window[1] and record.samples.shape[0] > 0:
        sample(m, record.samples[0], motion(m, p1, q1, a1, p2, q2, a2), contact)
    while i < stop:
        if kept and no_room(record):
            status = FULL
            break
        z = (p1, q1, p2 - p1, q2 - q1, c, s)
        ahead = look_ahead(p, contact, z, gap, calm)
        skipped = ahead.strides * (p.coarse.stride if contact else p.flight.stride) + ahead.steps
        if skipped > 0:
            then = i + skipped
            if kept:
                emit(p, m, contact, z, i, min(then, stop), then if ahead.then == FLIP else -1, window, record)
            if then >= stop:
                break
            p1, q1, apart, drift = later(p, contact, z, ahead.strides, ahead.steps)
            p2, q2 = p1 + apart, q1 + drift
            k += skipped
            if k >= n:
                k %= n
            c, s = circle(k * share)
            gap = ahead.gap
            if not contact and ahead.then == LOOK:
                gap = dot(p.flight.here, (p1, q1, apart, drift, c, s))
            if kept and contact:
                sums = p.coarse.sums[ahead.strides - 1] if ahead.strides > 0 else p.fine.sums[ahead.steps - 1]
                impulse += dot(sums, z)
            if ahead.then == FLIP:
                now = motion_after(p, m, contact, z, i, then) if kept else NOWHERE
                impulse = note_change(m, state, not contact, then, now, ahead.before - gap, impulse, kept, record)
            i = then
        calm = contact and ahead.then == GO_ON and ahead.strides in (0, HELD)
        contact = contact != (ahead.then == FLIP)
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
        change = (gap <= 0.0) != contact
        contact = contact != change
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
    state[IMPULSE], state[CALM] = impulse, (1.0 if calm else 0.0)
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
