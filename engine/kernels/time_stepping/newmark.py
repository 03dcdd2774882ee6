"""Newmark's method for the penalty model, α = ½, β = ¼, constant step, one step after the other (paper, section 4).

With the predictors p = ξ + Δτ ξ′ + Δτ² ξ″/4 and q = ξ′ + Δτ ξ″/2 the step solves, for the acceleration a at its end,

    (1 + δΔτ + k²Δτ²/4) a = η² cos ητ − 2δq − k²p ∓ λ        ξ = p + Δτ² a/4,  ξ′ = q + Δτ a/2,

and the next predictors are q + Δτ a and p + Δτ (q + Δτ a). p and q do not depend on the contact state, so the same four
numbers serve both. They are kept as p and Q = Δτ q, the acceleration as A = Δτ² a: a step is then A, Q += A, p += Q.

In contact λ at the end of the step follows from the accelerations without contact (index f):

    λ = [K (p₁ − p₂) + 2D (q₁ − q₂) + σ (a₁f − a₂f)] / (1 + σ (1/m₁ + 1/(μ m₂))),   σ = KΔτ²/4 + DΔτ,

m being the bracket on the left above. A step is with contact if the gap at its start is not positive (MODEL.md).
"""

from typing import NamedTuple

from ..compile.options import jit
from ..compile.record import no_room

# slots of the state: predictors, accelerations, whether the coming step is with contact, steps done; then the contact
# that is open
P1, Q1, P2, Q2, A1, A2, CONTACT, STEP, BEGIN, CLOSING, POSITION, SPEED1, SPEED2, IMPULSE, SLOTS = range(15)
# how a march ends
DONE, FULL, DIVERGED = range(3)
LIMIT = 1e9  # a gap of 1e9 base amplitudes is no motion; short of overflow, so that no NaN is ever made


class Scheme(NamedTuple):
    """Coefficients of a step of size ``h``; 1 and 2: the pendulums."""

    h: float
    damping1: float  # 2δ₁Δτ/m₁
    stiffness1: float  # k₁²Δτ²/m₁
    load1: float  # η²Δτ²/m₁
    react1: float  # Δτ²/m₁
    damping2: float
    stiffness2: float
    load2: float
    react2: float  # Δτ²/(μ m₂)
    stiffness: float  # K
    damper: float  # D
    contact_p: float  # K / (1 + σB)
    contact_q: float  # 2D/Δτ / (1 + σB)
    contact_a: float  # σ/Δτ² / (1 + σB)


@jit
def step(m, p1, q1, p2, q2, contact, cosine):
    """Accelerations A₁, A₂ and the contact force λ at the end of a step."""
    a1 = m.load1 * cosine - m.damping1 * q1 - m.stiffness1 * p1
    a2 = m.load2 * cosine - m.damping2 * q2 - m.stiffness2 * p2
    if not contact:
        return a1, a2, 0.0
    force = m.contact_p * (p1 - p2) + m.contact_q * (q1 - q2) + m.contact_a * (a1 - a2)
    return a1 - m.react1 * force, a2 + m.react2 * force, force


@jit
def advance(m, cosines, state, stop):
    """Run whole periods to the end of step ``stop``, leaving nothing behind but the state; returns DONE or DIVERGED.

    Parameters
    ----------
    m : Scheme
    cosines : (n + 1,) float64
        cos ητ at the steps of one period.
    state : (SLOTS,) float64
        Changed in place; ``state[STEP]`` counts the steps since the start of the run.
    stop : int
    """
    p1, q1, p2, q2, contact = state[P1], state[Q1], state[P2], state[Q2], state[CONTACT] > 0.0
    a1, a2 = state[A1], state[A2]
    n, done, status = cosines.shape[0] - 1, int(state[STEP]), DONE
    while done < stop and status == DONE:
        for k in range(1, n + 1):
            a1, a2, _ = step(m, p1, q1, p2, q2, contact, cosines[k])
            g = p2 - p1 + 0.25 * (a2 - a1)
            q1 += a1
            q2 += a2
            p1 += q1
            p2 += q2
            if (g <= 0.0) != contact:
                contact = not contact
                if contact:  # outside the kept periods its impact is not asked for
                    state[BEGIN], state[CLOSING] = done + k, 0.0
            if not abs(g) < LIMIT:
                status, n = DIVERGED, k
                break
        done += n
    state[P1], state[Q1], state[P2], state[Q2] = p1, q1, p2, q2
    state[A1], state[A2], state[CONTACT], state[STEP] = a1, a2, (1.0 if contact else 0.0), done
    return status


@jit
def motion(m, p1, q1, a1, p2, q2, a2):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of a step, from the predictors of the next one and the accelerations."""
    x1, x2 = p1 - q1 + 0.25 * a1, p2 - q2 + 0.25 * a2
    return x1, (q1 - 0.5 * a1) / m.h, x2, (q2 - 0.5 * a2) / m.h


@jit
def motion_of(m, state):
    """The motion at the end of the last step."""
    return motion(m, state[P1], state[Q1], state[A1], state[P2], state[Q2], state[A2])


@jit
def open_contact(state, i, now, closing):
    """Remember that, and how, a contact begins at the end of step i."""
    state[BEGIN], state[CLOSING], state[POSITION] = i, closing, now[0]
    state[SPEED1], state[SPEED2], state[IMPULSE] = now[1], now[3], 0.0


@jit
def close_contact(m, state, i, now, record):
    """Note the contact that ends, and its impact if it began with a closing speed within the kept periods."""
    row = record.contacts[record.used[1]]
    row[0], row[1] = state[BEGIN] * m.h, i * m.h
    record.used[1] += 1
    if state[CLOSING] > 0.0:
        impact = record.impacts[record.used[0]]
        impact[0], impact[1] = row[0], state[POSITION]
        impact[2], impact[3], impact[4], impact[5] = state[SPEED1], state[SPEED2], now[1], now[3]
        impact[6], impact[7] = state[IMPULSE], state[CLOSING]
        record.used[0] += 1


@jit
def sample(m, row, now, contact):
    """Write motion and contact force, λ by its definition, as the step that now begins will feel it."""
    row[0], row[1], row[2], row[3] = now
    squeezed = m.stiffness * (now[0] - now[2]) + 2.0 * m.damper * (now[1] - now[3])
    row[4] = squeezed if contact else 0.0


@jit
def advance_recorded(m, cosines, state, stop, window, record):
    """As :func:`advance`, step for step, and fill the record; returns DONE, DIVERGED or FULL.

    ``window``, (3,) int64: the step at which the kept periods begin, the step at which sampling begins, and the steps
    from sample to sample, counted anew in each period.
    """
    p1, q1, p2, q2, contact = state[P1], state[Q1], state[P2], state[Q2], state[CONTACT] > 0.0
    a1, a2, impulse = state[A1], state[A2], state[IMPULSE]
    n, i, status = cosines.shape[0] - 1, int(state[STEP]), DONE
    samples, section, per_period = record.samples, record.section, record.phases.shape[0]
    if i == window[1] and samples.shape[0] > 0:
        sample(m, samples[0], motion(m, p1, q1, a1, p2, q2, a2), contact)
    k = i % n  # steps done in the period
    while i < stop and status == DONE:
        gap = p2 - p1 - (q2 - q1) + 0.25 * (a2 - a1)
        a1, a2, force = step(m, p1, q1, p2, q2, contact, cosines[k + 1])
        g = p2 - p1 + 0.25 * (a2 - a1)
        q1 += a1
        q2 += a2
        p1 += q1
        p2 += q2
        i += 1
        k += 1
        # the trapezoidal rule carries a force into two half steps, hence one whole step each
        impulse += m.h * force
        if (g <= 0.0) != contact:
            contact = not contact
            now = motion(m, p1, q1, a1, p2, q2, a2)
            if contact:
                open_contact(state, i, now, (gap - g) / m.h)
                impulse = 0.0
            else:
                state[IMPULSE] = impulse
                close_contact(m, state, i, now, record)
                status = FULL if no_room(record) else DONE
        if k == n or (i >= window[1] and k % window[2] == 0):
            now = motion(m, p1, q1, a1, p2, q2, a2)
            if k == n:
                k = 0
                section[(i - window[0]) // n - 1] = now
            j = (i - window[1]) // n * per_period + k // window[2]
            if i >= window[1] and j < samples.shape[0]:
                sample(m, samples[j], now, contact)
        if not abs(g) < LIMIT:
            status = DIVERGED
    state[P1], state[Q1], state[P2], state[Q2] = p1, q1, p2, q2
    state[A1], state[A2], state[CONTACT], state[STEP], state[IMPULSE] = a1, a2, (1.0 if contact else 0.0), i, impulse
    return status
