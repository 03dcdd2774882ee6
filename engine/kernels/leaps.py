"""The discrete solution of :mod:`.newmark`, the same steps, without walking through each of them.

**Flight.** With α = ½, β = ¼ Newmark is the trapezoidal rule, and its free solution is known: where the oscillator has
the pole λ, displacements at the steps are samples of exp(λ̃ s) with

    exp(λ̃ Δτ) = (1 + λΔτ/2) / (1 − λΔτ/2),    and iη̂ = (2i/Δτ) tan(ηΔτ/2) stands for iη in the steady amplitude.

So the gap at the steps is a sum of exponentials read at multiples of Δτ, and its first zero is found as that of the
reference (:mod:`.root`): the first step with contact is the first multiple of Δτ beyond it where the sum is not
positive.

**Contact.** The step is z → z + C z + load on z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁), with a steady part known in closed form.
What is left of z moves by powers of 1 + C. The gaps of the next BLOCK steps are BLOCK independent products of known
rows with one state, which the processor forms side by side; the state then moves as many steps at once by
(1 + C)ᵐ − 1. (Increments, since 1 + C is so near to 1 that two digits would be lost.)

Both only say how many steps can be skipped; the step at which contact changes is taken as in the plain loop, and its
gap decides. Where rounding decides, plain loop and leaps may differ.
"""

import math
from typing import NamedTuple

import numpy as np

from .jit import jit
from .modes import Modes, at, bounds, cexp
from .newmark import A1, A2, BEGIN, CLOSING, CONTACT, DIVERGED, DONE, LIMIT, P1, P2, Q1, Q2, STEP, step
from .pendulums import free_amplitude
from .root import first_root

BLOCK = 64


class Flight(NamedTuple):
    """The discrete free motion of one pendulum."""

    pole: complex  # λ
    discrete: complex  # λ̃
    tangent: complex  # iη̂
    steady: complex  # amplitude
    damping: float  # 2δ
    stiffness: float  # k²
    load: float  # η²


class Squeeze(NamedTuple):
    """The discrete motion in contact."""

    steady: np.ndarray  # (4,) complex amplitude of the steady z
    rows: np.ndarray  # (4, BLOCK) the gap after 1 … BLOCK steps, from what is left of z
    moves: np.ndarray  # (BLOCK, 4, 4) (1 + C)ᵐ − 1 for m = 1 … BLOCK
    gaps: np.ndarray  # (n + BLOCK + 1,) the steady gap at the steps of a period, and on
    scratch: np.ndarray  # (BLOCK,)


@jit
def release(f, h, p, q, turn):
    """Free and steady amplitudes of a pendulum with predictors p, q (Q/Δτ) and excitation phase ``turn`` = e^{iητ}."""
    a = (f.load * turn.real - f.damping * q - f.stiffness * (p - h * q)) / (
        1.0 - 0.5 * f.damping * h + 0.25 * f.stiffness * h * h
    )
    steady = f.steady * turn
    return free_amplitude(p - h * q + 0.25 * h * h * a, q - 0.5 * h * a, steady, f.pole, f.tangent), steady


@jit
def predictors(f, h, free, steady):
    """p and Q where the free and the steady part are as given."""
    forced = f.tangent * steady
    v = f.pole * free
    a = (f.pole * v + f.tangent * forced).real
    x, v = free.real + steady.real, v.real + forced.real
    return x + h * v + 0.25 * h * h * a, h * v + 0.5 * h * h * a


@jit
def glide(first, second, ladder, h, z, turn, pole, most):
    """Steps of a flight that can be skipped, at most ``most``, and the predictors after them."""
    free1, steady1 = release(first, h, z[0], z[1] / h, turn)
    free2, steady2 = release(second, h, z[2], z[3] / h, turn)
    gap = Modes(-free1, free2, steady2 - steady1, first.discrete, second.discrete, pole)
    if not at(gap, 0.0)[0] > 0.0 or bounds(gap)[0] > 0.1 * LIMIT:
        return 0, z
    skipped = 0
    while True:
        arrival = first_root(gap, ladder, False, 0, 0.0, (most - skipped + 1.0) * h)
        if math.isnan(arrival.s):
            return 0, z
        if arrival.s == math.inf:
            skipped = most
            break
        # the first step beyond the zero has a gap that is not positive, or else the dip ended before it
        more = int(arrival.s / h)
        skipped = min(skipped + more, most)
        if skipped == most or at(gap, (more + 1.0) * h)[0] <= 0.0:
            break
        skipped += 1
        ahead = (more + 1.0) * h
        gap = Modes(
            gap.c1 * cexp(gap.pole1, ahead), gap.c2 * cexp(gap.pole2, ahead), gap.c3 * cexp(pole, ahead), *gap[3:]
        )
    s = skipped * h
    swing = cexp(pole, s)
    p1, q1 = predictors(first, h, free1 * cexp(first.discrete, s), steady1 * swing)
    p2, q2 = predictors(second, h, free2 * cexp(second.discrete, s), steady2 * swing)
    return skipped, (p1, q1, p2, q2)


@jit
def first_change(gaps):
    """Number of leading gaps that are those of a contact."""
    changes = 0
    for g in gaps:  # counted without a branch: the compiler turns this loop into vector instructions
        changes += not (-LIMIT < g <= 0.0)
    if changes == 0:
        return len(gaps)
    k = 0
    while -LIMIT < gaps[k] <= 0.0:
        k += 1
    return k


@jit
def endure(b, z, phasors, k, most):
    """Steps of a contact that can be skipped, at most ``most``, and the predictors after them.

    ``k`` is the number of the last step within its period.
    """
    n = phasors.shape[0]
    s0, s1, s2, s3 = b.steady
    turn = phasors[k]
    w0, w1 = z[0] - (s0 * turn).real, z[1] - (s1 * turn).real
    w2, w3 = z[2] - z[0] - (s2 * turn).real, z[3] - z[1] - (s3 * turn).real
    r0, r1, r2, r3 = b.rows
    skipped, ahead = 0, BLOCK
    while skipped < most and ahead == BLOCK:
        here = (k + skipped) % n + 1
        steady = b.gaps[here : here + BLOCK]
        for i in range(BLOCK):
            b.scratch[i] = r0[i] * w0 + r1[i] * w1 + r2[i] * w2 + r3[i] * w3 + steady[i]
        ahead = first_change(b.scratch)
        more = min(ahead, most - skipped)
        if more > 0:
            c = b.moves[more - 1]
            d0 = c[0, 0] * w0 + c[0, 1] * w1 + c[0, 2] * w2 + c[0, 3] * w3
            d1 = c[1, 0] * w0 + c[1, 1] * w1 + c[1, 2] * w2 + c[1, 3] * w3
            d2 = c[2, 0] * w0 + c[2, 1] * w1 + c[2, 2] * w2 + c[2, 3] * w3
            d3 = c[3, 0] * w0 + c[3, 1] * w1 + c[3, 2] * w2 + c[3, 3] * w3
            w0, w1, w2, w3 = w0 + d0, w1 + d1, w2 + d2, w3 + d3
            skipped += more
    turn = phasors[(k + skipped) % n]
    p1, q1 = w0 + (s0 * turn).real, w1 + (s1 * turn).real
    return skipped, (p1, q1, p1 + w2 + (s2 * turn).real, q1 + w3 + (s3 * turn).real)


@jit
def leap(m, first, second, ladder, squeeze, phasors, state, stop):
    """As :func:`.newmark.advance`: to the end of step ``stop``, leaving nothing behind but the state.

    Parameters
    ----------
    m : Scheme
    first, second : Flight
    ladder : Ladder
        For the discrete poles and iη.
    squeeze : Squeeze
    phasors : (n,) complex128
        e^{iητ} at the steps of one period.
    state : (SLOTS,) float64
        Changed in place.
    stop : int

    Returns
    -------
    int
        DONE or DIVERGED.
    """
    n = phasors.shape[0]
    pole = complex(0.0, 2.0 * math.pi / (n * m.h))
    p1, q1, p2, q2, contact = state[P1], state[Q1], state[P2], state[Q2], state[CONTACT] > 0.0
    a1, a2 = state[A1], state[A2]
    i, status = int(state[STEP]), DONE
    while i < stop:
        # one step as the plain loop takes it
        a1, a2, _ = step(m, p1, q1, p2, q2, contact, phasors[(i + 1) % n].real)
        g = p2 - p1 + 0.25 * (a2 - a1)
        q1 += a1
        q2 += a2
        p1 += q1
        p2 += q2
        i += 1
        if (g <= 0.0) != contact:
            contact = not contact
            if contact:
                state[BEGIN], state[CLOSING] = i, 0.0
        if not abs(g) < LIMIT:
            status = DIVERGED
            break
        most = stop - 1 - i
        if most <= 0:
            continue
        z = (p1, q1, p2, q2)
        if contact:
            skipped, z = endure(squeeze, z, phasors, i % n, most)
        else:
            skipped, z = glide(first, second, ladder, m.h, z, phasors[i % n], pole, most)
        p1, q1, p2, q2 = z
        i += skipped
    state[P1], state[Q1], state[P2], state[Q2] = p1, q1, p2, q2
    state[A1], state[A2], state[CONTACT], state[STEP] = a1, a2, (1.0 if contact else 0.0), i
    return status
