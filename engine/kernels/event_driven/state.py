"""The state of a march in closed form, and what it needs to know about the pendulums and their contact."""

import math
from typing import NamedTuple

import numpy as np

from ..compile.options import inlined, spliced
from ..compile.packing import viewers
from ..linear.cos_sin import circle
from ..linear.tables import PHASE_SHAPES, SCRATCH_SHAPES, Phase, Scratch

# what follows an anchor. CALM: pressed together, what was fast in it having died away; COLLIDING: an impact or a touch
# is due
SEPARATED, TOUCHING, CALM, COLLIDING = 0.0, 1.0, 2.0, 3.0


class Contact(NamedTuple):
    """The two phases and the laws between them.

    Touching pendulums are joined (reference) or pressed together by a spring and a damper (exact penalty).
    """

    period: float
    rigid: bool  # whether the contact is the reference's
    flight: Phase  # its watched quantity is the gap
    touching: Phase  # its watched quantity is the contact force (reference) or the penetration −g (penalty)
    calm: Phase  # what touching is left with when its fast modes have died away, see engine.drivers.slow
    stiff: bool  # whether there is such a phase
    fast: np.ndarray  # (4, 6) what of z is fast
    force_position: float  # contact force λ = force_position ξ₁ + force_velocity ξ₁′ + force_gap g + force_rate g′
    force_velocity: float
    force_gap: float
    force_rate: float
    mass_share: float  # μ/(1 + μ)
    restitution: float  # of the reference, as all that follows
    threshold: float
    completion: float  # how far a chatter must have come to be completed (see chatter.py)
    scratch: Scratch


_laws = [()] * 8
_views = viewers((), (), *PHASE_SHAPES * 3, (), (4, 6), *_laws, *SCRATCH_SHAPES)
_period, _rigid, _h1, _rows1, _moves1, _h2, _rows2, _moves2, _h3, _rows3, _moves3, _stiff, _fast = _views[:13]
_law1, _law2, _law3, _law4, _law5, _law6, _law7, _law8, _products, _stack = _views[13:]


@spliced
def unfold(f):
    """The contact of an array that :func:`..compile.packing.fold` made of it; its own arrays are views."""
    flight = Phase(_h1(f), _rows1(f), _moves1(f))
    touching = Phase(_h2(f), _rows2(f), _moves2(f))
    calm = Phase(_h3(f), _rows3(f), _moves3(f))
    scratch = Scratch(_products(f), _stack(f))
    force = _law1(f), _law2(f), _law3(f), _law4(f)
    laws = _law5(f), _law6(f), _law7(f), _law8(f)
    return Contact(
        _period(f), _rigid(f) > 0.0, flight, touching, calm, _stiff(f) > 0.0, _fast(f), *force, *laws, scratch
    )


class Touch(NamedTuple):
    """The contact that is open."""

    begun: float  # τ since the start of the run
    closing: float  # closing speed at its beginning; 0 if it began without an impact, or before the kept periods
    position: float  # ξ₁ at its beginning
    speed1: float  # ξ₁′
    speed2: float  # ξ₂′
    impulse: float  # ∫λ dτ so far


class Anchor(NamedTuple):
    """Where a phase begins, or where the search for its end goes on.

    Of pendulum 2 it holds gap and rate instead, so that a short flight keeps its digits.
    """

    period: float  # whole periods since the start of the run
    tau: float  # time since the beginning of that period
    x1: float
    v1: float
    gap: float  # g = ξ₂ − ξ₁
    rate: float  # g′
    mode: float  # SEPARATED, TOUCHING, CALM or COLLIDING
    order: float  # of the first derivative of the watched quantity that is not zero
    events: float  # in this period so far
    touch: Touch


@inlined
def untouched():
    """No contact is open."""
    return Touch(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def touches(a):
    """Whether the pendulums touch from this anchor on."""
    return a.mode in (TOUCHING, CALM)


@inlined
def state(p, a):
    """z of an anchor (see :mod:`..linear.tables`)."""
    c, s = circle(a.tau / p.period)
    return a.x1, a.v1, a.gap, a.rate, c, s


@inlined
def clock(p, a):
    """τ of an anchor since the start of the run."""
    return a.period * p.period + a.tau


@inlined
def after(p, a, s, y, mode, order, touch):
    """An anchor s later, where the motion is y = (ξ₁, ξ₁′, g, g′)."""
    x1, v1, gap, rate = y
    tau = a.tau + s
    whole = math.floor(tau / p.period)
    events = a.events if whole == 0.0 else 0.0
    return Anchor(a.period + whole, tau - whole * p.period, x1, v1, gap, rate, mode, order, events, touch)


@inlined
def anchor_of(numbers):
    """The anchor that an array holds."""
    n = numbers
    opened = Touch(n[9], n[10], n[11], n[12], n[13], n[14])
    return Anchor(n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], opened)


@inlined
def keep_anchor(numbers, a):
    """Write an anchor into an array."""
    n, t = numbers, a.touch
    n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7] = a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order
    n[8], n[9], n[10], n[11], n[12], n[13] = a.events, t.begun, t.closing, t.position, t.speed1, t.speed2
    n[14] = t.impulse
