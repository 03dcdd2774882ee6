"""Slow, obvious twin of runs under a load: matrix exponentials over short pieces, dense scanning, bisection."""

import math

import numpy as np

SCAN = 2e-3
KNOWN = {}  # exponentials that have been made
GAP = np.array([-1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])  # less the clearance
RATE = np.array([0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0])
ONE = np.eye(7)[6]


def expm(a):
    """The matrix exponential by its series, of a matrix whose norm is at most some units."""
    total, term = np.eye(len(a)), np.eye(len(a))
    for k in range(1, 30):
        term = term @ a / k
        total = total + term
    return total


def acceleration_rows(system, on):
    """Rows of ξ₁″ and ξ₂″ over (ξ₁, ξ₁′, ξ₂, ξ₂′, L, L′, 1) without contact; zeros for a wall."""
    e, mu = system.excitation, 1.0 if system.wall else system.mass_ratio
    push = {"base": (-1.0, -1.0), "force1": (1.0, 0.0), "force2": (0.0, 1.0 / mu)}[on]
    one = [-system.spring1, -2 * system.d1, 0.0, 0.0, push[0], 0.0, e.constant1]
    two = [0.0, 0.0, -(system.kappa**2), -2 * system.damper2, push[1], 0.0, e.constant2 / mu]
    return np.array(one), np.zeros(7) if system.wall else np.array(two)


def flow_matrix(one, two, omega):
    """The generator of (ξ₁, ξ₁′, ξ₂, ξ₂′, L, L′, 1)."""
    a = np.zeros((7, 7))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[1], a[3], a[5, 4] = one, two, -(omega**2)
    return a


def contact_of(system, method, one, two, omega):
    """The generator of the bodies in contact, and the contact force as a row of the same seven numbers."""
    mu, g0 = (1e300 if system.wall else system.mass_ratio), system.clearance
    share = 1.0 if system.wall else mu / (1 + mu)
    if not method.rigid:
        push = -method.stiffness * (GAP + g0 * ONE) - 2 * method.damping * RATE
        return flow_matrix(one - push, two + (0.0 if system.wall else 1.0) * push / mu, omega), push
    push = -share * (two - one)  # −μ/(1 + μ) times the acceleration of the free gap
    if system.wall:
        joined = flow_matrix(np.zeros(7), np.zeros(7), omega)
        joined[0, 1] = 0.0
        return joined, push
    both = (one + mu * two) / (1 + mu)
    both[0] += both[2]
    both[6] += -both[2] * g0
    both[2] = both[3] = 0.0
    both[1] = -2 * system.joint_damping(method.joint_damping) * system.kappa3
    return flow_matrix(both, both, omega), push


def struck(system, method, push, w):
    """The state after an impact, in place, and whether the bodies then stay together."""
    closing = -(RATE @ w)
    mu = 1e300 if system.wall else system.mass_ratio
    common = 0.0 if system.wall else (w[1] + mu * w[3]) / (1 + mu)
    after = system.restitution * closing
    still = w.copy()
    still[1], still[3] = common, 0.0 if system.wall else common
    if after <= method.threshold and push @ still > 0:
        return still, True
    w[1] = -after if system.wall else common - mu / (1 + mu) * after
    w[3] = w[3] if system.wall else common + after / (1 + mu)
    return w, False


def run(system, load, method, end, start=None):
    """Events [(τ, kind)] (0 impact or touch, 1 contact begins, 2 it ends) and (ξ₁, ξ₁′, ξ₂, ξ₂′) at the end.

    The load is :class:`engine.Load`, of which only ``segments``, ``frequency`` and ``on`` are read.
    """
    one, two = acceleration_rows(system, load.on)
    free, gap = flow_matrix(one, two, load.frequency), GAP + system.clearance * ONE
    joined, push = contact_of(system, method, one, two, load.frequency)
    w = np.array([*(system.rest if start is None else start), 0.0, 0.0, 1.0])
    events, tau, touching, first = [], 0.0, bool(gap @ w <= 1e-15), SCAN / 2**12
    bounds = [*load.segments[:, 0], math.inf]
    if bounds[0] > 0.0:
        raise ValueError("the first segment begins at 0")
    for k, (begin, value, slope) in enumerate(load.segments):
        until = min(bounds[k + 1], end)
        if until <= begin:
            continue
        w[4], w[5] = value, -load.frequency * slope if load.frequency else slope
        settle = True
        while tau < until:
            if touching and settle and method.rigid and push @ w <= 1e-13 * np.abs(push) @ np.abs(w):
                touching = _pushes_soon(push, joined, w)
                events += [] if touching else [(tau, 2)]
                first = SCAN
            settle = False
            a = joined if touching else free
            watched = (push if method.rigid else -gap) if touching else gap
            s, w = _to_root(a, watched, w, until - tau, first)
            first = SCAN / 2**12
            tau += s
            if tau >= until - 1e-14:
                tau = until
                break
            if touching:
                touching, first = False, SCAN  # g grows as the third power of time: below rounding at first
                events.append((tau, 2))
            elif not method.rigid:
                touching = True
                events.append((tau, 0))
            else:
                events.append((tau, 0))
                w, touching = struck(system, method, push, w)
                events += [(tau, 1)] if touching else []
    return events, w[:4]


def _pushes_soon(push, joined, w):
    """Whether a contact force that is zero within rounding grows, by the first derivative that is not zero."""
    row, size = push, np.abs(push)
    for _ in range(7):
        value, scale = row @ w, size @ np.abs(w)
        if abs(value) > 1e-12 * max(scale, 1e-300):
            return value > 0
        row, size = row @ joined, size @ np.abs(joined)
    return True


def _to_root(a, watched, w, length, first):
    """The time to the first fall of what is watched to zero, at most ``length``, and the state there.

    Not within the ``first`` step, if what is watched begins at zero.
    """
    step, done = first, 0.0
    value, known = watched @ w, KNOWN.setdefault(a.tobytes(), {})
    while done < length:
        s = min(step, length - done)
        if s not in known:
            known[s] = expm(a * s)
        later = known[s] @ w
        if watched @ later <= 0 and (value > 0 or done > 0):
            low, high = 0.0, s
            for _ in range(45):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if watched @ (expm(a * middle) @ w) > 0 else (low, middle)
            return done + high, expm(a * high) @ w
        done, w, value = done + s, later, watched @ later
        step = min(2 * step, SCAN)
    return done, w
