"""The hybrid state of an event-driven solution, and the hybrid system that it belongs to.

A *phase* is a stretch of the motion without events: flight, or contact. A *hybrid state* says which phase comes next
and from where: it is the state at an event, or at the beginning of the block in which the next event is sought.

The load of a run: cos ητ for ever, or segments that follow one another.

In z = (…, C, S) the load is C. Of a harmonic C = cos ητ and S = sin ητ. Any other load is a sequence of segments with
one generator, so that one table of each phase serves them all; only C and S begin anew with each segment:

    linear in time      C′ = S,  S′ = 0         between two samples of a record, on a ramp
    pulse               C′ = −ωS, S′ = ωC       half a sine with ω = π/duration; C = S = 0 before and after it

The segments are rows (τ at the beginning, C, S), one after the other in one array; a jump of the load is a new segment.
The last one lasts to the end of the run, which is its only period.

Plain twin: tests/naive_load.py.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import OpenContact, no_contact
from vibroscope.engine.kernels.equations.motion import displacements
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import PHASE, SCRATCH, Phase, Scratch

# Of the segment that a run stands in: whether there are any, ω, τ at its beginning, C and S there, τ at its end, and
# the number of the next one
GIVEN, FREQUENCY, BEGIN, COSINE, SINE, END, NEXT = range(7)
NUMBERS = NEXT + 1
SEGMENT_NUMBERS = 3


@jit_inlined
def load_at(p, tau, share):
    """C and S at a time τ of the period, ``share`` of it."""
    now = p.load
    if now[GIVEN] == 0.0:
        return cos_sin(share)
    t, c, s = tau - now[BEGIN], now[COSINE], now[SINE]
    if now[FREQUENCY] == 0.0:
        return c + s * t, s
    cosine, sine = math.cos(now[FREQUENCY] * t), math.sin(now[FREQUENCY] * t)
    return c * cosine - s * sine, s * cosine + c * sine


@jit_inlined
def load_integral(p, begin, end, length):
    """What the last two factors of ∫z dτ are multiplied with, of two states in one segment.

    They are the changes of C and S, as for the rest of z, but ∫C and ∫S where the load is linear in time.
    """
    if p.load[GIVEN] > 0.0 and p.load[FREQUENCY] == 0.0:
        return 0.5 * (begin[4] + end[4]) * length, begin[5] * length
    return end[4] - begin[4], end[5] - begin[5]


@jit_inlined
def time_to_load_change(p, tau):
    """Time from τ to the next segment."""
    return p.load[END] - tau if p.load[GIVEN] > 0.0 else math.inf


@jit_no_alloc
def advance_load(p, segments, tau):
    """Go on to the segment of τ; returns whether it is another one."""
    now = p.load
    if now[GIVEN] == 0.0 or tau < now[END]:
        return False
    k, last = int(now[NEXT]), segments.shape[0] // SEGMENT_NUMBERS - 1
    while k < last and segments[SEGMENT_NUMBERS * (k + 1)] <= tau:
        k += 1
    k = min(k, last)
    for i in range(SEGMENT_NUMBERS):
        now[BEGIN + i] = segments[SEGMENT_NUMBERS * k + i]
    now[END] = segments[SEGMENT_NUMBERS * (k + 1)] if k < last else max(p.period, tau * (1.0 + 1e-15))
    now[NEXT] = k + 1.0
    return True


# What follows a hybrid state. SLOW_CONTACT: a contact whose fast modes have decayed; COLLISION: an impact or a touch is
# due.
FLIGHT, CONTACT, SLOW_CONTACT, COLLISION = 0.0, 1.0, 2.0, 3.0
MOST_EFFORT = 300_000  # intervals examined in one call, which then takes some hundredths of a second
MOST_EVENTS = 100_000  # in one period; chatter at e = 0.99 down to a closing speed of 1e-12 has 2,750
ROUNDING = 16 * 2.0**-52  # a number below this share of its terms cannot be distinguished from zero


class HybridSystem(NamedTuple):
    """The phases and the laws between them.

    Bodies in contact are joined (reference) or pressed together by a spring and a damper (exact penalty).
    """

    period: float
    rigid: bool  # whether the contact is the reference's
    flight: Phase  # its watched quantity is the gap
    contact: Phase  # its watched quantity is the contact force (reference) or the penetration −g (penalty)
    slow_contact: Phase  # contact once its fast modes have decayed, see .setup
    stiff: bool  # whether there is such a phase
    fast: np.ndarray  # (4, 6) projector on the fast modes of contact
    force_position: float  # contact force λ = force_position ξ₁ + force_velocity ξ₁′ + force_gap g + force_rate g′
    force_velocity: float
    force_gap: float
    force_rate: float
    mass_share: float  # μ/(1 + μ), what body 1 gains of a relative velocity; 0 of a wall
    force_cosine: float  # + force_cosine cos ητ + force_sine sin ητ + force_constant, of the reference
    force_sine: float
    force_constant: float
    wall: float  # 1 if body 1 is a wall, else 0
    clearance: float
    restitution: float  # of the reference, as are the next two
    threshold: float
    completion: float  # how far a chatter must have come to be summed up (see events.py)
    load: np.ndarray  # (7,) the segment that the run stands in; zeros: the load is cos ητ
    play: float  # distance between two stops, as in ..parameters, and so the next one
    sign: float
    scratch: Scratch


SYSTEM = Layout(
    HybridSystem, flight=PHASE, contact=PHASE, slow_contact=PHASE, fast=(4, 6), load=(NUMBERS,), scratch=SCRATCH
)
unpack_system = SYSTEM.unpack


class HybridState(NamedTuple):
    """Where a phase begins, or where the search for its end goes on.

    It holds gap and gap rate instead of ξ₂ and ξ₂′, so that a short flight keeps its digits. They and ξ₁ are absolute;
    tables count from the equilibrium of their phase (:func:`linear_state`). Time is counted in whole
    periods and a remainder, so that the phase of the excitation stays exact over any number of periods.
    """

    period: float  # whole periods since the start of the run
    tau: float  # time since the beginning of that period
    x1: float
    v1: float
    gap: float  # g
    rate: float  # g′
    mode: float  # FLIGHT, CONTACT, SLOW_CONTACT or COLLISION
    order: float  # of the first derivative of the watched quantity that is not zero
    events: float  # in this period, or in this segment of the load, so far
    contact: OpenContact


STATE = Layout(HybridState, contact=Layout(OpenContact))
unpack_state, write_state = STATE.unpack, STATE.write
SEEN_FROM = STATE.size  # the number after a packed state is that of the stop from which it is seen, 0 or 1


@jit_inlined
def in_contact(a):
    """Whether the bodies touch from this state on."""
    return a.mode in (CONTACT, SLOW_CONTACT)


@jit_inlined
def linear_state(p, phase, a):
    """z of a hybrid state, relative to the equilibrium of a phase (see :mod:`..linear.tables`)."""
    c, s = load_at(p, a.tau, a.tau / p.period)
    return a.x1 - phase.position, a.v1, a.gap - phase.gap, a.rate, c, s


@jit_inlined
def absolute(phase, z):
    """(ξ₁, ξ₁′, g, g′) of z."""
    return z[0] + phase.position, z[1], z[2] + phase.gap, z[3]


@jit_inlined
def time_of(p, a):
    """τ since the start of the run."""
    return a.period * p.period + a.tau


@jit_inlined
def later_state(p, a, s, y, mode, order, contact):
    """The hybrid state s after a, where the motion is y = (ξ₁, ξ₁′, g, g′)."""
    x1, v1, gap, rate = y
    tau = a.tau + s
    whole = np.floor(tau / p.period)
    events = a.events if whole == 0.0 else 0.0
    return HybridState(a.period + whole, tau - whole * p.period, x1, v1, gap, rate, mode, order, events, contact)


@jit_inlined
def at_once(a, v1, gap, rate, mode, order, contact):
    """The hybrid state at the same instant and place after what changes at once."""
    return HybridState(a.period, a.tau, a.x1, v1, gap, rate, mode, order, a.events, contact)


@jit_inlined
def with_contact(a, contact):
    """The hybrid state with another open contact."""
    return HybridState(a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events, contact)


@jit_inlined
def at_load_change(p, a, y, order, contact):
    """The hybrid state at the end of the segment of the load that a stands in, where the motion is y."""
    return HybridState(a.period, p.load[END], y[0], y[1], y[2], y[3], a.mode, order, 0.0, contact)


@jit_inlined
def count_event(a):
    """The hybrid state with one more event in its period."""
    return HybridState(a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events + 1.0, a.contact)


@jit_inlined
def start_state(p, y):
    """The hybrid state of a run that starts at τ = 0; a gap within rounding of the displacements counts as zero."""
    x1, v1, gap, rate = y
    one, _, two, _ = displacements(p, x1, v1, gap, rate)
    small = ROUNDING * (abs(one) + abs(two) + abs(p.clearance))
    mode = FLIGHT if gap > small else CONTACT if gap < -small else COLLISION
    return HybridState(0.0, 0.0, x1, v1, 0.0 if mode == COLLISION else gap, rate, mode, 0.0, 0.0, no_contact())
