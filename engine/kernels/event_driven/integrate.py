"""From event to event in closed form: the reference and the exact penalty solution (MODEL.md, "Motion").

The state of the solver is its last event, or the beginning of the block in which it looks for the next one: period,
time within the period, motion, and the mode that follows. Displacements between events are evaluated only where a
record asks for them. Time is counted in whole periods and a remainder, so that the phase of the excitation stays exact
over any number of periods.
"""

import numpy as np

from ..compile.options import bare, inlined
from ..compile.record import no_room, unfold_record
from ..linear.first_root import NEWTON_LIMIT, first_root
from ..linear.tables import INTEGRAL, POINTS, dot, first_at, gap_at, moved
from .events import ROUNDING, parts, release, settle, strike
from .state import (
    CALM,
    COLLIDING,
    SEPARATED,
    TOUCHING,
    Anchor,
    Touch,
    after,
    anchor_of,
    clock,
    keep_anchor,
    state,
    touches,
    unfold,
    untouched,
)

# how a march ends
DONE, FULL, PILED_UP, UNRESOLVED, PAUSED = range(5)
MOST_EFFORT = 300_000  # intervals examined in one call, which then takes some hundredths of a second
LOST = 2.0**-44
MOST_EVENTS = 100_000  # in one period; chatter at e = 0.99 down to a closing speed of 1e-12 has 2,750


@bare
def pressed_on(p, phase, a, begin, end):
    """The anchor with the impulse that the open contact has gathered between two states, ∫λ = K ∫(−g) − 2D Δg."""
    squeezed = 0.0
    for i in range(6):
        squeezed += phase.rows[i, INTEGRAL] * (end[i] - begin[i])
    t = a.touch
    impulse = t.impulse - p.force_gap * squeezed + p.force_rate * (end[2] - begin[2])
    carried = Touch(t.begun, t.closing, t.position, t.speed1, t.speed2, impulse)
    return Anchor(a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events, carried)


@inlined
def calmed(p, a):
    """The anchor without its fast part, once that is lost in the rounding of the penetration."""
    if a.mode != TOUCHING or a.order > 0.0 or not p.stiff:
        return a
    z = state(p, a)
    x1, v1, gap, rate = dot(p.fast[0], z), dot(p.fast[1], z), dot(p.fast[2], z), dot(p.fast[3], z)
    if abs(gap) + abs(rate) * p.touching.spacing > LOST * abs(a.gap):
        return a
    return Anchor(a.period, a.tau, a.x1 - x1, a.v1 - v1, a.gap - gap, a.rate - rate, CALM, 0.0, a.events, a.touch)


@inlined
def end_of_phase(p, phase, a, z, i, u, slope):
    """The anchor where a phase ends."""
    x1, v1 = first_at(phase, moved(phase, z, i), u, p.scratch)
    s = (i + u) * phase.spacing
    if touches(a):
        return release(p, a, s, x1, v1, slope)
    return after(p, a, s, (x1, v1, 0.0, slope), COLLIDING, 0.0, untouched())


@inlined
def end_of_block(p, phase, a, z):
    """The anchor at which the search goes on."""
    return after(p, a, POINTS * phase.spacing, moved(phase, z, POINTS)[:4], a.mode, 0.0, a.touch)


@bare
def state_at(p, phase, z, s):
    """(ξ₁, ξ₁′, g, g′) at s within the block that begins at z."""
    h = phase.spacing
    i = min(max(int(s / h), 0), POINTS - 1)
    u = s / h - i
    z = moved(phase, z, i)
    x1, v1 = first_at(phase, z, u, p.scratch)
    gap, rate = gap_at(phase, z, u, p.scratch)
    return x1, v1, gap, rate


@bare
def emit(p, phase, a, z, s, window, record):
    """Write the section rows and samples that fall into [anchor, anchor + s], s within the block."""
    origin, sampled_from = window
    # the slack covers an event on the section itself: its two phases must not both think the other has it
    slack = -1e-13 * p.period
    k = max(a.period, origin + 1.0)
    while k - origin <= record.section.shape[0] and (k - a.period) * p.period - a.tau <= s:
        t = (k - a.period) * p.period - a.tau
        if t >= slack:
            x1, v1, gap, rate = state_at(p, phase, z, max(t, 0.0))
            row = record.section[int(k - origin) - 1]
            row[0], row[1], row[2], row[3] = x1, v1, x1 + gap, v1 + rate
        k += 1.0
    m = record.phases.shape[0]
    j = max(0, int(a.period - sampled_from) * m + np.searchsorted(record.phases, a.tau / p.period) - 1)
    while j < record.samples.shape[0]:
        whole, part = divmod(j, m)
        t = (sampled_from + whole - a.period + record.phases[part]) * p.period - a.tau
        if t > s:
            return
        if t >= slack:
            x1, v1, gap, rate = state_at(p, phase, z, max(t, 0.0))
            row = record.samples[j]
            row[0], row[1], row[2], row[3], row[4] = x1, v1, x1 + gap, v1 + rate, 0.0
            if touches(a):
                row[4] = p.force_position * x1 + p.force_velocity * v1 + p.force_gap * gap + p.force_rate * rate
        j += 1


@bare
def emit_chatter(p, a, b, stop, window, record):
    """Write what falls into the rest of a chatter, from anchor a to anchor b: the pendulums' common motion."""
    x1, v1, _, rate, c, s = state(p, a)
    together = (x1, v1 + p.mass_share * rate, 0.0, 0.0, c, s)
    length = (b.period - a.period) * p.period + b.tau - a.tau
    emit(p, p.touching, a, together, min(length, (stop - a.period) * p.period - a.tau), window, record)


@bare
def note_impact(time, position, speed1, speed2, v1, v2, impulse, closing, record):
    """Append an impact to the record."""
    row = record.impacts[record.used[0]]
    row[0], row[1], row[2], row[3] = time, position, speed1, speed2
    row[4], row[5], row[6], row[7] = v1, v2, impulse, closing
    record.used[0] += 1


@bare
def note_contact(p, t, now, kept_from, record):
    """Append a contact that ends ``now`` (an anchor) to the record; a pressed one has been an impact as well."""
    end = clock(p, now)
    row = record.contacts[record.used[1]]
    row[0], row[1] = t.begun, end
    record.used[1] += 1
    if not p.rigid and t.closing > 0.0 and t.begun >= kept_from:
        v1, v2 = now.v1, now.v1 + now.rate
        note_impact(t.begun, t.position, t.speed1, t.speed2, v1, v2, t.impulse, t.closing, record)


@bare
def march(folded, state_of, stop, window, flat, sizes):
    """Carry the motion to the end of period ``stop``.

    Parameters
    ----------
    folded : (n,) float64
        A contact, as :func:`..compile.packing.fold` gives it.
    state_of : (len(Anchor) + len(Touch) − 1,) float64
        The anchor from which to go on, changed in place. A march that goes on from the anchor of an earlier one gives
        the same bits as one that never stopped.
    stop : float
        Number of periods since the start of the run.
    window : (2,) float64
        Period at which the section begins, period at which sampling begins.
    flat, sizes
        A folded record. Nothing is kept if it has no room for a section.

    Returns
    -------
    (int, int, int)
        DONE (the anchor is the last before the end of ``stop``), FULL (make room for impacts or contacts, then call
        again), PAUSED (call again), PILED_UP or UNRESOLVED; events; intervals examined.
    """
    p, record, a = unfold(folded), unfold_record(flat, sizes), anchor_of(state_of)
    kept = record.section.shape[0] > 0
    kept_from = window[0] * p.period
    events, examined = 0, 0
    phases = (p.flight, p.touching, p.calm)
    while True:
        if kept and no_room(record):
            end = FULL
            break
        before, a = a, strike(p, a)
        if kept and p.rigid and before.mode == COLLIDING and before.rate < 0.0:
            v1, v2, time = before.v1, before.v1 + before.rate, clock(p, before)
            note_impact(time, a.x1, v1, v2, a.v1, a.v1 + a.rate, v1 - a.v1, -before.rate, record)
        before, a = a, settle(p, a)
        if kept and clock(p, a) > clock(p, before):
            emit_chatter(p, before, a, stop, window, record)
        if a.order == 3.0 and not parts(p, a):
            end = UNRESOLVED
            break
        a = calmed(p, a)
        phase = phases[int(a.mode)]
        z = state(p, a)
        horizon = (stop - a.period) * p.period - a.tau
        i, u, slope, tries = first_root(phase, z, int(a.order), NEWTON_LIMIT, p.scratch)
        examined += tries
        s = (i + u) * phase.spacing
        if kept:
            emit(p, phase, a, z, min(s, horizon), window, record)
        if s >= horizon:
            end = DONE
            break
        begin = a
        a = end_of_block(p, phase, a, z) if i == POINTS else end_of_phase(p, phase, a, z, i, u, slope)
        if kept and touches(begin) and not p.rigid:
            a = pressed_on(p, phase, a, z, state(p, a))
        if i == POINTS:
            if examined > MOST_EFFORT:
                end = PAUSED
                break
            continue
        if kept and touches(begin):
            note_contact(p, a.touch, a, kept_from, record)
        events += 1
        a = Anchor(a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events + 1.0, a.touch)
        if a.events > MOST_EVENTS:
            end = PILED_UP
            break
    keep_anchor(state_of, a)
    return end, events, examined


@bare
def note_open(p, a, stop, window, record):
    """Append the contact that is open at the end of period ``stop``, as if it ended there."""
    if not touches(a):
        return
    phase = p.calm if a.mode == CALM else p.touching
    z = state(p, a)
    s = (stop - a.period) * p.period - a.tau
    now = after(p, a, s, state_at(p, phase, z, s), a.mode, 0.0, a.touch)
    if not p.rigid:
        now = pressed_on(p, phase, now, z, state(p, now))
    note_contact(p, now.touch, now, window[0] * p.period, record)


@bare
def prepare(p, x1, v1, gap, rate):
    """The anchor of a run that starts at τ = 0; a gap within rounding of zero is none."""
    small = ROUNDING * (abs(x1) + abs(x1 + gap))
    mode = SEPARATED if gap > small else TOUCHING if gap < -small else COLLIDING
    return Anchor(0.0, 0.0, x1, v1, 0.0 if mode == COLLIDING else gap, rate, mode, 0.0, 0.0, untouched())
