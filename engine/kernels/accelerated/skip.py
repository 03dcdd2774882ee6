"""The discrete solution of :mod:`..time_stepping.newmark`, the same steps, without walking through each of them.

Leaps skip the steps of which :mod:`.certificate` knows that contact does not change; what a record asks of them
:mod:`.output` reads off. Where rounding could turn the sign of the gap, a step as in the plain loop decides, and plain
loop and leaps may differ. Leaps do not depend on where a run is cut: one that reaches beyond its end is not taken, what
is asked for within it is read off, and the next call begins with it.
"""

import math
from typing import NamedTuple

from ..compile.options import bare, inlined, jit, spliced
from ..compile.packing import viewers
from ..compile.record import no_room, unfold_record
from ..linear.cos_sin import circle
from ..linear.tables import carried
from ..time_stepping.newmark import (
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
from ..time_stepping.newmark import SLOTS as NEWMARK_SLOTS
from .certificate import FLIP, LOOK, look_ahead, steps_of
from .output import emit, impulse_of, motion_after
from .step_map import FREE, PRESSED, SHAPES, Tables

GAP, SLOTS = NEWMARK_SLOTS, NEWMARK_SLOTS + 1  # the state's last slot: g
NOWHERE = (0.0, 0.0, 0.0, 0.0)  # a motion that nobody asks for


class Leaps(NamedTuple):
    """Everything that leaps need."""

    tables: Tables
    steps: int  # n
    scheme: Scheme


class Stand(NamedTuple):
    """Where the discrete solution stands, at the end of a step."""

    step: int  # steps done
    k: int  # steps done in the period
    cosine: float  # the excitation's phase
    sine: float
    q1: float  # predictors, in the order in which a step makes them
    p1: float
    q2: float
    p2: float
    gap: float
    contact: int  # FREE or PRESSED: of the coming step


_SHAPES = *SHAPES, (), (len(Scheme._fields),)
SIZE = sum(math.prod(shape) for shape in _SHAPES)
_margins, _moves, _bends, _accelerations, _sums, _strides, _steps, _scheme = viewers(*_SHAPES)


@spliced
def tables_in(f):
    """The tables that lie in one array (:mod:`..compile.packing`), as views."""
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
def stand_of(p, state):
    """Where a state stands."""
    i = int(state[STEP])
    k, contact = i % p.steps, PRESSED if state[CONTACT] > 0.0 else FREE
    c, s = circle(k * (1.0 / p.steps))
    return Stand(i, k, c, s, state[Q1], state[P1], state[Q2], state[P2], state[GAP], contact)


@inlined
def keep_stand(state, now):
    """Write where the solution stands into its state."""
    state[P1], state[Q1], state[P2], state[Q2], state[GAP] = now.p1, now.q1, now.p2, now.q2, now.gap
    state[CONTACT], state[STEP] = (1.0 if now.contact else 0.0), now.step


@inlined
def landed(p, now, ahead, then):
    """Where a leap up to step ``then`` leads."""
    p1, q1, apart, drift, _, _ = carried(p.tables.moves[now.contact, 0], ahead.beginning, ahead.fine)
    k = now.k + then - now.step
    if k >= p.steps:
        k %= p.steps
    c, s = circle(k * (1.0 / p.steps))
    gap = -ahead.margin if now.contact else ahead.margin
    contact = PRESSED - now.contact if ahead.then == FLIP else now.contact
    return Stand(then, k, c, s, q1, p1, q1 + drift, p1 + apart, gap, contact)


@inlined
def walked(p, now):
    """Where one step as the plain loop takes it leads, and A₁, A₂ and λ at its end."""
    k = now.k + 1 if now.k + 1 < p.steps else 0
    c, s = circle(k * (1.0 / p.steps))
    a1, a2, force = step(p.scheme, now.p1, now.q1, now.p2, now.q2, now.contact, c)
    gap = now.p2 - now.p1 + 0.25 * (a2 - a1)
    q1, q2 = now.q1 + a1, now.q2 + a2
    contact = PRESSED if gap <= 0.0 else FREE
    return Stand(now.step + 1, k, c, s, q1, now.p1 + q1, q2, now.p2 + q2, gap, contact), a1, a2, force


@inlined
def note_change(m, state, now, there, closed, kept, record):
    """Note that contact begins or ends with the last step, in which the gap fell by ``closed``."""
    if not kept:  # outside the kept periods its impact is not asked for
        if now.contact:
            state[BEGIN], state[CLOSING] = now.step, 0.0
    elif now.contact:
        open_contact(state, now.step, there, closed / m.h)
    else:
        close_contact(m, state, now.step, there, record)


@inlined
def write_step(p, now, there, window, record):
    """Write the section row and the sample of the last step, if it has any."""
    i, n = now.step, p.steps
    if now.k == 0:
        record.section[(i - window[0]) // n - 1] = there
    j = (i - window[1]) // n * record.phases.shape[0] + now.k // window[2]
    if i >= window[1] and now.k % window[2] == 0 and j < record.samples.shape[0]:
        sample(p.scheme, record.samples[j], there, now.contact)


@bare
def leap(folded, state, stop, window, flat, sizes, full):
    """Carry the discrete solution to the end of step ``stop``, as ``advance_recorded`` does.

    Parameters
    ----------
    folded : (n,) float64
        Leaps, as :func:`..compile.packing.fold` gives them.
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
    now, status = stand_of(p, state), DONE
    kept, sampled = record.section.shape[0] > 0, record.samples.shape[0] > 0
    if sampled and now.step == window[1]:
        sample(p.scheme, record.samples[0], motion_of(p.scheme, state), now.contact)
    while now.step < stop:
        if kept and no_room(record):
            status = FULL
            break
        z = (now.p1, now.q1, now.p2 - now.p1, now.q2 - now.q1, now.cosine, now.sine)
        ahead = look_ahead(p, now.contact, z, -now.gap if now.contact else now.gap)
        then = now.step + steps_of(p.tables, now.contact, ahead)
        if then > now.step:
            if sampled or (kept and now.k + then - now.step >= p.steps):
                flip = then if ahead.then == FLIP else -1
                emit(p, now.contact, z, now.step, min(then, stop), flip, window, record)
            if then >= stop:
                break
            if kept and full and now.contact:
                state[IMPULSE] += impulse_of(p.tables, z, ahead)
            before, now = now, landed(p, now, ahead, then)
            if ahead.then == FLIP:
                there = motion_after(p, before.contact, z, before.step, then) if kept and full else NOWHERE
                note_change(p.scheme, state, now, there, ahead.before - ahead.margin, kept, record)
        if ahead.then == LOOK:
            before = now
            now, a1, a2, force = walked(p, before)
            state[A1], state[A2] = a1, a2
            # the trapezoidal rule carries a force into two half steps, hence one whole step each
            state[IMPULSE] += p.scheme.h * force
            there = motion(p.scheme, now.p1, now.q1, a1, now.p2, now.q2, a2) if kept else NOWHERE
            if now.contact != before.contact:
                note_change(p.scheme, state, now, there, before.gap - now.gap, kept, record)
            if kept:
                write_step(p, now, there, window, record)
            if not abs(now.gap) < LIMIT:
                status = DIVERGED
                break
    keep_stand(state, now)
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
