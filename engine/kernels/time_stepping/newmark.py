"""Newmark's method for the penalty model, α = ½, β = ¼, constant step, one step after the other (paper, section 4).

**One step.** With the predictors p = ξ + Δτ ξ′ + Δτ² ξ″/4 and q = ξ′ + Δτ ξ″/2 the displacement and velocity at the end
of a step are ξ = p + Δτ² a/4 and ξ′ = q + Δτ a/2. The equations of motion there (:mod:`..equations.motion`) give the
acceleration a: with m = 1 + cΔτ/2 + kΔτ²/4, c and k those of the body,

    m a = l cos(ητ + ψ) − c q − k p ∓ λ                                                   (10)

(λ for body 1, −λ/μ for body 2; l and ψ amplitude and phase of what drives the body, η² and 0 in the paper). ξ is
counted from the static equilibrium of the separated bodies, so that constant forces and the clearance have no part in
(10): the gap is g = gₛ + ξ₂ − ξ₁ with gₛ there, and the bodies touch where ξ₂ − ξ₁ is at most −gₛ. The next predictors
are q + Δτ a and p + Δτ (q + Δτ a). They do not depend on the contact state, so the same four numbers serve a step with
contact and one without. They are stored as p and Q = Δτ q, the acceleration as A = Δτ² a: then a step is A by (10),
Q += A, p += Q.

**Contact.** Inserting (10) into the contact law λ = K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′) at the end of the step gives λ from the
accelerations without contact (index f),

    λ = [K (p₁ − p₂ − gₛ) + 2D (q₁ − q₂) + σ (a₁f − a₂f)] / (1 + σ (1/m₁ + 1/(μ m₂))),   σ = KΔτ²/4 + DΔτ  (11)

A step is with contact if the gap at its start is not positive (paper, section 4).
"""

import math
from typing import NamedTuple

from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_uncontracted
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import (
    OpenContact,
    no_contact,
    no_room,
    record_contact,
    unrecorded_contact,
    with_impulse,
)
from vibroscope.engine.kernels.equations.contact_law import ContactLaw, contact_law_of, force, force_of_law
from vibroscope.engine.kernels.equations.motion import (
    accelerations,
    coefficients,
    contact_coordinates,
    users_displacements,
)
from vibroscope.engine.kernels.parameters import unpack_parameters
from vibroscope.engine.kernels.status import CROSSED, DIVERGED, FULL, OK

LIMIT = 1e9  # a gap of 1e9 base amplitudes is no motion; far enough from overflow that no NaN is ever made
# Share of the play between two stops beyond which steps are seen from the other one: not the half, so that rounding
# does not send them back.
FAR_FROM_STOP = 0.75


class Scheme(NamedTuple):
    """Coefficients of a step of size ``h``, Eqs. (10) and (11), for A = Δτ² a; 1 and 2: the bodies."""

    h: float
    damping1: float  # c₁Δτ/m₁
    stiffness1: float  # k₁Δτ²/m₁
    load1: float  # η²Δτ²/m₁
    react1: float  # Δτ²/m₁
    damping2: float
    stiffness2: float
    coupling: float  # of the place of a wall, as in equations.motion
    load2: float
    react2: float  # Δτ²/(μ m₂)
    damper: float  # D
    contact_p: float  # K / (1 + σ (1/m₁ + 1/(μ m₂)))
    contact_q: float  # 2D/Δτ / (…)
    contact_a: float  # σ/Δτ² / (…)
    contact_gap: float  # −K gₛ / (…)
    touch: float  # −gₛ, at which ξ₂ − ξ₁ the bodies touch
    law: ContactLaw
    cosine1: float  # cos ψ and sin ψ of each body
    sine1: float
    cosine2: float
    sine2: float
    offset1: float  # of the cosine of each body, for a constant force that no equilibrium holds
    offset2: float
    rest1: float  # static equilibrium of the separated bodies: ξ₁ and ξ₂
    rest2: float
    clearance: float
    wall: float  # 1 if body 1 is a wall, else 0
    late: float  # share of λ at the end of a step, times Δτ, that is felt after it: ½ of the trapezoidal rule
    sign: float  # as in ..parameters
    play: float  # distance between two stops, inf of one
    reach: float  # gap beyond which steps are seen from another stop, less the one at the equilibrium; else LIMIT


SCHEME = Layout(Scheme, law=Layout(ContactLaw))


class StepState(NamedTuple):
    """The discrete solution at the end of a step, counted from the static equilibrium of the separated bodies."""

    p1: float  # predictors of the coming step
    q1: float
    p2: float
    q2: float
    a1: float  # Δτ² ξ₁″ at the end of the last step; not known after a skip
    a2: float
    gap: float  # there, less the one at the equilibrium
    pressed: bool  # whether the coming step is with contact
    step: int  # steps done
    contact: OpenContact


STATE = Layout(StepState, contact=Layout(OpenContact))
unpack_state, write_state = STATE.unpack, STATE.write
SEEN_FROM = STATE.size  # behind the state: the number of the stop from which it is seen


@jit_inlined
def with_contact(s, contact):
    """The state with another open contact."""
    return StepState(s.p1, s.q1, s.p2, s.q2, s.a1, s.a2, s.gap, s.pressed, s.step, contact)


@jit_uncontracted
def scheme_of(p):
    """Coefficients of one step, from :class:`..parameters.Parameters`."""
    h = 2 * math.pi / p.eta / p.steps
    c = coefficients(p)
    m1 = 1 + c.c1 * h / 2 + c.k1 * h * h / 4
    m2 = 1 + c.c2 * h / 2 + c.k2 * h * h / 4
    sigma = p.stiffness * h * h / 4 + p.damping * h
    shared = 1 + sigma * (c.react1 / m1 + 1 / (c.mu * m2))
    load1, cosine1, sine1, offset1 = amplitude_and_phase(c.load1[0], c.load1[1], c.pull1)
    load2, cosine2, sine2, offset2 = amplitude_and_phase(c.load1[0] + c.push[0], c.load1[1] + c.push[1], c.pull2)
    return Scheme(
        h,
        c.c1 * h / m1,
        c.k1 * h * h / m1,
        load1 * h * h / m1,
        c.react1 * h * h / m1,
        c.c2 * h / m2,
        c.k2 * h * h / m2,
        c.coupling * h * h / m2,
        load2 * h * h / m2,
        h * h / (c.mu * m2),
        p.damping,
        p.stiffness / shared,
        2 * p.damping / h / shared,
        sigma / (h * h) / shared,
        -p.stiffness * p.free_gap / shared,
        -p.free_gap,
        contact_law_of(p),
        cosine1,
        sine1,
        cosine2,
        sine2,
        offset1,
        offset2,
        p.free_position,
        p.free_position + p.free_gap - p.clearance,
        p.clearance,
        p.wall,
        0.5,
        p.sign,
        p.play,
        min(FAR_FROM_STOP * p.play - p.free_gap, LIMIT),
    )


@jit_uncontracted
def amplitude_and_phase(cosine, sine, pull):
    """l, cos ψ, sin ψ and o with cosine · cos ητ + sine · sin ητ + pull = l (cos(ητ + ψ) + o)."""
    if sine == 0.0 and cosine == 0.0 and pull != 0.0:  # without a cosine
        return 1.0, 0.0, 0.0, pull
    if sine == 0.0:
        return cosine, 1.0, 0.0, pull / cosine if pull != 0.0 else 0.0
    size = math.hypot(cosine, sine)
    return size, cosine / size, -sine / size, pull / size


@jit_inlined
def phased(m, cosine, sine):
    """cos(ητ + ψ) of both bodies from cos ητ and sin ητ, numbers or arrays."""
    return m.cosine1 * cosine - m.sine1 * sine, m.cosine2 * cosine - m.sine2 * sine


@jit_uncontracted
def start_state(m, p, start):
    """The discrete solution at τ = 0, its accelerations from the equations of motion; ``start``: ξ₁, ξ₁′, ξ₂, ξ₂′."""
    x1, v1, gap, rate = contact_coordinates(m, start[0], start[1], start[2], start[3])
    h, pressed = m.h, gap <= 0.0
    push = contact_force(m, start[0], start[1], start[2], start[3]) if pressed else 0.0
    x1, v2 = x1 - m.rest1, v1 + rate
    x2 = m.touch + gap + x1
    a1, a2 = accelerations(coefficients(p), x1, v1, x2, v2, push, 1.0, 0.0)
    a1, a2 = h * h * a1, h * h * a2
    p1, p2 = x1 + h * v1 + 0.25 * a1, x2 + h * v2 + 0.25 * a2
    return StepState(p1, h * v1 + 0.5 * a1, p2, h * v2 + 0.5 * a2, a1, a2, x2 - x1, pressed, 0, no_contact())


@jit
def write_start(rows, state, x1, v1, x2, v2):
    """Write the packed state at τ = 0, as seen from the stop that is nearer.

    ``rows``: (1, n) or (2, n), the parameters as seen from each stop.
    """
    p = unpack_parameters(rows[0])
    stop = int(contact_coordinates(p, x1, v1, x2, v2)[2] > 0.5 * p.play) if rows.shape[0] > 1 else 0
    p = unpack_parameters(rows[stop])
    state[SEEN_FROM] = stop
    write_state(state, start_state(scheme_of(p), p, (x1, v1, x2, v2)))


@jit_inlined
def turned(m, n, s, begins):
    """The state s as seen from the other stop; m and n: the scheme of this stop and of the other one.

    ``begins``: whether the impact of a contact that begins there is kept.
    """
    first, second = m.rest1 + n.rest1, m.rest2 + n.rest2
    p1, q1, p2, q2, a1, a2 = -s.p1 - first, -s.q1, -s.p2 - second, -s.q2, -s.a1, -s.a2
    gap = m.play - (s.gap - m.touch)
    contact, pressed = s.contact, gap <= 0.0
    if pressed:  # within one step across the play: the speed at its end stands for the mean over the step
        closing = -(q2 - q1 - 0.5 * (a2 - a1)) / n.h
        contact = begin_contact(n, s.step, motion(n, p1, q1, a1, p2, q2, a2), closing if begins else 0.0)
    return StepState(p1, q1, p2, q2, a1, a2, gap + n.touch, pressed, s.step, contact)


@jit_inlined
def contact_force(m, x1, v1, x2, v2):
    """λ of bodies in contact, of ξ₁, ξ₁′, ξ₂ and ξ₂′."""
    gap, rate = m.clearance + m.sign * (x2 - x1), m.sign * (v2 - v1)
    return force_of_law(m.law.kind, force(m.law.stiffness, m.damper, gap, rate))


@jit_inlined
def step(m, p1, q1, p2, q2, pressed, cosine1, cosine2):
    """A₁, A₂ and the contact force λ at the end of a step, Eqs. (10) and (11); ``cosine1``: cos(ητ + ψ₁) there."""
    # the coupling is multiplied by p₁, which is 1 where there is one
    return step_with(m, (p1, q1, p2, q2), pressed, (cosine1, cosine2), (m.coupling, m.contact_gap))


@jit_inlined
def step_with(m, predictors, pressed, cosines, constants):
    """The same, linear in predictors, cosines and constants: the coupling times p₁, and what the gap at rest gives."""
    p1, q1, p2, q2 = predictors
    a1 = m.load1 * cosines[0] - m.damping1 * q1 - m.stiffness1 * p1  # Eq. (10)
    a2 = m.load2 * cosines[1] + constants[0] - m.damping2 * q2 - m.stiffness2 * p2
    if not pressed:
        return a1, a2, 0.0
    push = m.contact_p * (p1 - p2) + (m.contact_q * (q1 - q2) + constants[1]) + m.contact_a * (a1 - a2)  # Eq. (11)
    push = force_of_law(m.law.kind, push)
    return a1 - m.react1 * push, a2 + m.react2 * push, push


@jit_inlined
def motion(m, p1, q1, a1, p2, q2, a2):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of a step, from the predictors of the next one and the accelerations."""
    x1, x2 = p1 - q1 + 0.25 * a1, p2 - q2 + 0.25 * a2
    return displaced(m, x1, (q1 - 0.5 * a1) / m.h, x2, (q2 - 0.5 * a2) / m.h)


@jit_inlined
def displaced(m, x1, v1, x2, v2):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of displacements from the equilibrium of the separated bodies."""
    return users_displacements(m, x1 + m.rest1, v1, x2 + m.rest2, v2)


@jit_inlined
def motion_of(m, s):
    """The motion at the end of the last step."""
    return motion(m, s.p1, s.q1, s.a1, s.p2, s.q2, s.a2)


@jit_inlined
def begin_contact(m, i, now, closing):
    """The contact that begins at the end of step i."""
    return OpenContact(i * m.h, closing, now[0], now[1], now[3], 0.0)


@jit_inlined
def end_contact(m, contact, i, now, push, buffers):
    """Record the contact that ends with step i, and its impact if it began with a closing speed.

    ``push``: λ at the end of the step, which the speeds after the contact have felt wholly, those of ``now`` in part.
    """
    late = m.late * push / m.h
    _, more1, _, more2 = users_displacements(m, 0.0, -m.react1 * late, 0.0, m.react2 * late)
    signed = with_impulse(contact, m.sign * contact.impulse)
    record_contact(buffers, signed, i * m.h, (now[1] + more1, now[3] + more2), True)


@jit_inlined
def force_at(m, now, pressed):
    """λ of a motion, as the step that now begins will feel it."""
    return m.sign * contact_force(m, now[0], now[1], now[2], now[3]) if pressed else 0.0


@jit_inlined
def write_sample(row, now, push):
    """Write the motion ξ₁, ξ₁′, ξ₂, ξ₂′ and λ."""
    row[0], row[1], row[2], row[3] = now
    row[4] = push


@jit_inlined
def ending_of(gap):
    """Why a loop ends at a gap beyond its reach."""
    return CROSSED if abs(gap) < LIMIT else DIVERGED


@jit_inlined
def write_output(i, k, n, now, push, window, buffers):
    """Write the section row and the sample of step i, the k-th of its period (k < n), if they are asked for.

    ``now``: ξ₁, ξ₁′, ξ₂, ξ₂′; ``push``: λ as the step that now begins will feel it.
    """
    kept_from, sampled_from, stride = window
    if k == 0 and i > kept_from and buffers.section.shape[0] > 0:
        row = buffers.section[(i - kept_from) // n - 1]
        row[0], row[1], row[2], row[3] = now
    j = (i - sampled_from) // n * buffers.phases.shape[0] + k // stride
    if i >= sampled_from and k % stride == 0 and j < buffers.samples.shape[0]:
        write_sample(buffers.samples[j], now, push)


@jit_inlined
def next_output(i, n, window, sampled):
    """The first step after i of which a section row or a sample is asked for."""
    k = i % n
    if sampled and i >= window[1]:
        return i + min(n - k, window[2] - k % window[2])
    return min(i + n - k, window[1]) if sampled else i + n - k


@jit
def integrate(m, cosines, state, stop, window, buffers):
    """Integrate to the end of step ``stop``, and fill the buffers if they have room for contacts.

    Parameters
    ----------
    m : Scheme
    cosines : pair of (n + 1,) float64
        cos(ητ + ψ) of both bodies at the steps of one period.
    state : (STATE.size,) float64
        A :class:`StepState`, changed in place.
    stop : int
    window : (3,) int64
        The step at which the kept periods begin, the step at which sampling begins, and the steps from sample to
        sample, counted anew in each period.
    buffers : Buffers

    Returns
    -------
    int
        OK, DIVERGED, FULL or CROSSED.
    """
    p1, q1, p2, q2, a1, a2, gap, pressed, i, contact = unpack_state(state)
    cosines1, cosines2 = cosines
    n, status, kept = cosines1.shape[0] - 1, OK, buffers.contacts.shape[0] > 0
    _, sampled_from, stride = window
    if i == sampled_from and buffers.samples.shape[0] > 0:
        now = motion(m, p1, q1, a1, p2, q2, a2)
        write_sample(buffers.samples[0], now, force_at(m, now, pressed))
    k = i % n  # steps done in the period
    impulse = contact.impulse
    while i < stop and status == OK:
        before = p2 - p1 - (q2 - q1) + 0.25 * (a2 - a1)
        a1, a2, push = step(m, p1, q1, p2, q2, pressed, cosines1[k + 1], cosines2[k + 1])
        gap = p2 - p1 + 0.25 * (a2 - a1)
        q1 += a1
        q2 += a2
        p1 += q1
        p2 += q2
        i += 1
        k += 1
        # the trapezoidal rule gives each force two half steps, hence one whole step
        impulse += m.h * push
        if (gap <= m.touch) != pressed:
            pressed = not pressed
            now = motion(m, p1, q1, a1, p2, q2, a2)
            if pressed:
                contact = begin_contact(m, i, now, (before - gap) / m.h) if kept else unrecorded_contact(i * m.h)
                impulse = 0.0
            elif kept:
                end_contact(m, with_impulse(contact, impulse), i, now, push, buffers)
                status = FULL if no_room(buffers) else OK
        if k == n or (i >= sampled_from and k % stride == 0):
            k = 0 if k == n else k
            if kept:
                now = motion(m, p1, q1, a1, p2, q2, a2)
                write_output(i, k, n, now, force_at(m, now, pressed), window, buffers)
        if not -LIMIT < gap < m.reach:
            status = ending_of(gap)
    contact = with_impulse(contact, impulse) if kept else contact
    write_state(state, StepState(p1, q1, p2, q2, a1, a2, gap, pressed, i, contact))
    return status
