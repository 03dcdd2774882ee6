"""The reference: closed form between events, Newton's impact law, permanent contact (MODEL.md; paper, section 2).

The state of the solver is its last event: period, time within the period, motion, and the mode that follows. The
march goes from event to event; displacements between events are evaluated only where a record asks for them. Time is
counted in whole periods and a remainder, so that the phase of the excitation stays exact over any number of periods.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit
from .modes import at, at_anchor, bounds, combined, derivative
from .pendulums import contact_force, difference, flight, joined
from .record import no_room
from .root import HIGHEST_ORDER, ROUNDING, first_order, first_root

SEPARATED, JOINED, COLLIDING = 0.0, 1.0, 2.0
# how a march ends
DONE, FULL, PILED_UP, UNRESOLVED = range(4)
MOST_EVENTS = 100_000  # in one period; chatter at e = 0.99 down to a closing speed of 1e-12 has 2,750


class Anchor(NamedTuple):
    """Where a phase begins. Of pendulum 2 it holds gap and rate instead, so that a chatter keeps its digits."""

    period: float  # whole periods since the start of the run
    tau: float  # time since the beginning of that period
    x1: float
    v1: float
    gap: float  # g = ξ₂ − ξ₁
    rate: float  # g′
    mode: float  # SEPARATED, JOINED, or COLLIDING: an impact is due
    order: float  # of the first derivative of gap (or force) that is not zero


@jit
def classify(p, a):
    """The phase that follows a touch without approach (g = 0, g′ ≥ 0 within rounding).

    The first derivative of the free gap that is not zero decides: positive, the pendulums part; negative, or if all
    are zero, they stay together. A speed within rounding of zero counts as zero.
    """
    first, second = flight(p, a.tau, a.x1, a.v1, 0.0, a.rate)
    order, value = first_order(difference(first, second), 1)
    if value > 0.0:
        return Anchor(a.period, a.tau, a.x1, a.v1, 0.0, a.rate, SEPARATED, float(order))
    # the force behaves as −g″: one derivative of the gap less two is the force's
    return join(p, a, float(max(0, min(order, HIGHEST_ORDER) - 2)))


@jit
def join(p, a, order):
    """Permanent contact begins, at the velocity (ξ₁′ + μξ₂′)/(1 + μ) that conserves momentum."""
    return Anchor(a.period, a.tau, a.x1, a.v1 + p.mass_share * a.rate, 0.0, 0.0, JOINED, order)


@jit
def impact(p, a):
    """Newton's law at g = 0, g′ < 0; sticks as the paper does, if g′⁺ ≤ ε and the force is compressive.

    The impulse is ξ₁′ before less ξ₁′ after: the last impact of a chatter takes the whole relative velocity,
    μ/(1 + μ) |g′⁻|, any other μ/(1 + μ) (1 + e) |g′⁻|.
    """
    parting = -p.restitution * a.rate
    common = a.v1 + p.mass_share * a.rate
    compressed = p.force_position * a.x1 + p.force_velocity * common > 0.0
    if parting <= p.threshold and compressed:
        return join(p, a, 0.0)
    return Anchor(a.period, a.tau, a.x1, common - p.mass_share * parting, 0.0, parting, SEPARATED, 1.0)


@jit
def phase(p, a):
    """Modes of ξ₁, ξ₂ and of the function whose zero ends the phase: the gap, or the contact force."""
    if a.mode == JOINED:
        common = joined(p, a.tau, a.x1, a.v1)
        return common, common, contact_force(p, common)
    first, second = flight(p, a.tau, a.x1, a.v1, a.gap, a.rate)
    return first, second, difference(first, second)


@jit
def end_of_phase(p, a, first, arrival):
    """The anchor where a phase ends: separated pendulums collide; joined ones part, g, g′ and g″ vanishing together."""
    x1, v1, _ = combined(first, arrival.e1, arrival.e2, arrival.e3)
    tau = a.tau + arrival.s
    whole = math.floor(tau / p.period)
    if a.mode == JOINED:
        return Anchor(a.period + whole, tau - whole * p.period, x1, v1, 0.0, 0.0, SEPARATED, 3.0)
    return Anchor(a.period + whole, tau - whole * p.period, x1, v1, 0.0, arrival.rate, COLLIDING, 0.0)


@jit
def clock(p, a):
    """τ of an anchor since the start of the run."""
    return a.period * p.period + a.tau


@jit
def state_at(first, second, s):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at s after the anchor."""
    x1, v1, _ = at(first, s)
    x2, v2, _ = at(second, s)
    return x1, v1, x2, v2


@jit
def emit(p, a, first, second, force, s, window, record):
    """Write the section rows and samples that fall into [anchor, anchor + s]."""
    origin, sampled_from = window
    # the slack covers an event on the section itself: its two phases must not both think the other has it
    slack = -1e-13 * p.period
    k = max(a.period, origin + 1.0)
    while k - origin <= record.section.shape[0] and (k - a.period) * p.period - a.tau <= s:
        t = (k - a.period) * p.period - a.tau
        if t >= slack:
            record.section[int(k - origin) - 1] = state_at(first, second, t)
        k += 1.0
    m = record.phases.shape[0]
    j = max(0, int(a.period - sampled_from) * m + np.searchsorted(record.phases, a.tau / p.period) - 1)
    while j < record.samples.shape[0]:
        whole, part = divmod(j, m)
        t = (sampled_from + whole - a.period + record.phases[part]) * p.period - a.tau
        if t > s:
            return
        if t >= slack:
            row = record.samples[j]
            row[0], row[1], row[2], row[3] = state_at(first, second, t)
            row[4] = at(force, t)[0] if a.mode == JOINED else 0.0
        j += 1


@jit
def note_impact(p, before, after, record):
    """Append an impact to the record."""
    row = record.impacts[record.used[0]]
    row[0], row[1] = clock(p, before), before.x1
    row[2], row[3] = before.v1, before.v1 + before.rate
    row[4], row[5] = after.v1, after.v1 + after.rate
    row[6], row[7] = before.v1 - after.v1, -before.rate
    record.used[0] += 1


@jit
def note_contact(p, begin, end, record):
    """Append a permanent contact to the record."""
    row = record.contacts[record.used[1]]
    row[0], row[1] = clock(p, begin), clock(p, end)
    record.used[1] += 1


@jit
def march(p, ladder, a, stop, window, record):
    """Carry the motion to the end of period ``stop``.

    Parameters
    ----------
    p : Pendulums
    ladder : Ladder
        For the poles of ``p``.
    a : Anchor
        State of the solver. A march that goes on from the anchor of an earlier one gives the same bits as one that
        never stopped.
    stop : float
        Number of periods since the start of the run.
    window : (2,) float64
        Period at which the section begins, period at which sampling begins.
    record : Record
        Nothing is kept if it has no room for a section.

    Returns
    -------
    (Anchor, int, int, int)
        The last event before the end of ``stop``; DONE, FULL (make room for impacts or contacts, then call again),
        PILED_UP or UNRESOLVED; events; evaluations.
    """
    kept = record.section.shape[0] > 0
    events, tries, burst = 0, 0, 0
    while True:
        if kept and no_room(record):
            return a, FULL, events, tries
        if a.mode == COLLIDING:
            before, a = a, impact(p, a) if a.rate < 0.0 else classify(p, a)
            if kept and before.rate < 0.0:
                note_impact(p, before, a, record)
        first, second, ending = phase(p, a)
        rate = a.rate
        if a.mode == JOINED:
            rate = at_anchor(derivative(ending))
        elif a.order == 1.0 and rate <= ROUNDING * bounds(ending)[1]:
            a = classify(p, a)  # so slow a start that rounding hides it: higher derivatives decide
            first, second, ending = phase(p, a)
        horizon = (stop - a.period) * p.period - a.tau
        arrival = first_root(ending, ladder, a.mode == JOINED, int(a.order), rate, horizon)
        tries += arrival.evaluations
        if math.isnan(arrival.s):
            return a, UNRESOLVED, events, tries
        if kept:
            emit(p, a, first, second, ending, min(arrival.s, horizon), window, record)
        if arrival.s == math.inf:
            return a, DONE, events, tries
        begin, a = a, end_of_phase(p, a, first, arrival)
        if kept and begin.mode == JOINED:
            note_contact(p, begin, a, record)
        events += 1
        burst = burst + 1 if a.period == begin.period else 0
        if burst > MOST_EVENTS:
            return a, PILED_UP, events, tries


@jit
def prepare(p, x1, v1, gap, rate):
    """The anchor of a run that starts at τ = 0 with gap ≥ 0; a gap within rounding of zero is none."""
    first, second = flight(p, 0.0, x1, v1, gap, rate)
    if first_order(difference(first, second), 0)[0] > 0:
        return Anchor(0.0, 0.0, x1, v1, 0.0, rate, COLLIDING, 0.0)
    return Anchor(0.0, 0.0, x1, v1, gap, rate, SEPARATED, 0.0)
