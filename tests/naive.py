"""Slow, obvious twins of the kernels: textbook formulas, dense scanning, nothing clever."""

import math

import numpy as np


def oscillator(k, d, eta, tau0, x0, v0, load=None, constant=0.0):
    """ξ(τ), ξ′(τ) of ξ″ + 2dkξ′ + k²ξ = l₁ cos ητ + l₂ sin ητ + constant from (x0, v0) at tau0, in real arithmetic.

    ``load``: l₁ and l₂, by default those of the paper's base, η² and 0.
    """
    load, rest = load or (eta**2, 0.0), constant / (k * k)
    # steady part a cos ητ + b sin ητ by comparing coefficients
    a, b = np.linalg.solve([[k * k - eta**2, 2 * d * k * eta], [-2 * d * k * eta, k * k - eta**2]], load)
    w = k * math.sqrt(1 - d * d)

    def steady(t):
        c, s = math.cos(eta * t), math.sin(eta * t)
        return a * c + b * s + rest, eta * (b * c - a * s)

    p, q = x0 - steady(tau0)[0], v0 - steady(tau0)[1]

    def motion(t):
        s = t - tau0
        decay, c, sn = math.exp(-d * k * s), math.cos(w * s), math.sin(w * s)
        r = (q + d * k * p) / w
        x = decay * (p * c + r * sn)
        v = decay * ((r * w - d * k * p) * c - (p * w + d * k * r) * sn)
        return x + steady(t)[0], v + steady(t)[1]

    return motion


def drive(system, eta):
    """Of each body, per mass: factors of cos ητ and sin ητ in what drives it, base and force; its constant force."""
    e, mu = system.excitation, system.mass_ratio
    base = np.array([math.cos(e.base_phase), -math.sin(e.base_phase)]) * e.base * eta**2
    one, two = (
        np.array([math.cos(phase), -math.sin(phase)]) * force
        for force, phase in ((e.force1, e.force1_phase), (e.force2, e.force2_phase))
    )
    return (tuple(base + one), e.constant1), (tuple(base + two / mu), e.constant2 / mu)


def matrices_of(system):
    """Masses, dampers and springs without contact, (2, 2) each; a wall has the mass 1, and its row is struck out."""
    mu, kappa, damper1 = 1.0 if system.wall else system.mass_ratio, system.kappa, 2 * system.d1
    damper2 = 2 * mu * system.d2 * (kappa if kappa else 1.0)
    return np.diag([1.0, mu]), np.diag([damper1, damper2]), np.diag([system.spring1, mu * kappa**2])


def scan(f, begin, end, first=1e-7, coarse=1e-3):
    """First sign change of f after ``begin``: steps that grow from ``first`` to ``coarse``, then bisection."""
    step, before, t = first, begin, begin + first
    while t < end:
        if f(t) <= 0:
            return bisect(f, before, t)
        before, step = t, min(1.2 * step, coarse)
        t += step
    return math.inf


def bisect(f, above, below):
    """Zero between f(above) > 0 and f(below) ≤ 0, to the last place."""
    while True:
        middle = 0.5 * (above + below)
        if middle in (above, below):
            return below
        above, below = (middle, below) if f(middle) > 0 else (above, middle)


def reference(system, eta, d3, threshold, periods, start=None):
    """Events [(τ, kind, g′ before)] and the state at the end; kind 0 impact, 1 contact begins, 2 it ends.

    From rest in contact at τ = 0 (the paper's system), or from a start with an open gap.
    """
    if system.wall:
        return reference_at_wall(system, eta, threshold, periods, start)
    mu, e, end, g0 = system.mass_ratio, system.restitution, periods * 2 * math.pi / eta, system.clearance
    (load1, constant1), (load2, constant2) = drive(system, eta)
    joint = tuple((one + mu * two) / (1 + mu) for one, two in zip(load1, load2, strict=True))
    joint_constant = (constant1 + mu * (constant2 + system.kappa**2 * g0)) / (1 + mu)
    first, tau = 1e-3, 0.0
    if start is None:
        events, joined, (x1, v1, x2, v2) = [(0.0, 1, 0.0)], True, system.rest
    else:
        events, joined, (x1, v1, x2, v2) = [], False, start

    def force(t, x, v):
        c, s = math.cos(eta * t), math.sin(eta * t)
        one, two = (load[0] * c + load[1] * s for load in (load1, load2))
        gap = two + constant2 - 2 * system.d2 * system.kappa * v - system.kappa**2 * (x - g0)
        return -mu / (1 + mu) * (gap - (one + constant1 - 2 * system.d1 * v - x))

    while True:
        if joined:
            body = oscillator(system.kappa3, d3, eta, tau, x1, v1, joint, joint_constant)
            tau = scan(lambda t, body=body: force(t, *body(t)), tau, end, first=1e-3)
            x1, v1 = body(min(tau, end))
            x2, v2 = x1 - g0, v1
            if tau == math.inf:
                return events, (x1, v1, x2, v2)
            joined, first = False, 1e-3  # g grows as the third power of time: below rounding at first
            events.append((tau, 2, 0.0))
            continue
        one = oscillator(1.0, system.d1, eta, tau, x1, v1, load1, constant1)
        two = oscillator(system.kappa, system.d2, eta, tau, x2, v2, load2, constant2)
        tau = scan(lambda t, one=one, two=two: g0 + two(t)[0] - one(t)[0], tau, end, first)
        first = 1e-7
        (x1, v1), (x2, v2) = one(min(tau, end)), two(min(tau, end))
        if tau == math.inf:
            return events, (x1, v1, x2, v2)
        closing, common = v1 - v2, (v1 + mu * v2) / (1 + mu)
        events.append((tau, 0, -closing))
        x2, v1, v2 = x1 - g0, common - mu / (1 + mu) * e * closing, common + e * closing / (1 + mu)
        if e * closing <= threshold and force(tau, x1, common) > 0:
            v1 = v2 = common
            joined = True
            events.append((tau, 1, 0.0))


def reference_at_wall(system, eta, threshold, periods, start=None):
    """The same of a body and a wall."""
    e, end, g0 = system.restitution, periods * 2 * math.pi / eta, system.clearance
    (load, constant), _ = drive(system, eta)
    first, tau, events, joined = 1e-3, 0.0, [], start is None
    (x, v, _, _) = system.rest if start is None else start
    if joined:
        events.append((0.0, 1, 0.0))

    def force(t):
        return load[0] * math.cos(eta * t) + load[1] * math.sin(eta * t) + constant - g0

    while True:
        if joined:
            tau, x, v = scan(force, tau, end, first=1e-3), g0, 0.0
            if tau == math.inf:
                return events, (x, v, 0.0, 0.0)
            joined, first = False, 1e-3
            events.append((tau, 2, 0.0))
            continue
        body = oscillator(1.0, system.d1, eta, tau, x, v, load, constant)
        tau = scan(lambda t, body=body: g0 - body(t)[0], tau, end, first)
        first = 1e-7
        x, v = body(min(tau, end))
        if tau == math.inf:
            return events, (x, v, 0.0, 0.0)
        events.append((tau, 0, -v))
        x, joined = g0, e * v <= threshold and force(tau) > 0
        v = 0.0 if joined else -e * v
        if joined:
            events.append((tau, 1, 0.0))


def newmark(system, eta, stiffness, damping, n, steps, cut=False, start=None):
    """Textbook Newmark (α = ½, β = ¼) with matrices: states (steps + 1, 4), and whether each step is with contact.

    A wall is body 2 with its rows and columns struck out: its acceleration is zero. ``cut``: a step at whose end the
    contact would pull is taken without its force. ``start``: ξ₁, ξ₁′, ξ₂, ξ₂′, by default rest.
    """
    h, mu, g0 = 2 * math.pi / eta / n, 1.0 if system.wall else system.mass_ratio, system.clearance
    moving = np.array([1.0, 0.0 if system.wall else 1.0])
    mass, dampers, springs = matrices_of(system)
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    (load1, constant1), (load2, constant2) = drive(system, eta)

    def matrices(contact):
        return dampers + (2 * damping * pair if contact else 0), springs + (stiffness * pair if contact else 0)

    def load(i, contact):
        c, s = math.cos(eta * i * h), math.sin(eta * i * h)
        forces = [load1[0] * c + load1[1] * s + constant1, mu * (load2[0] * c + load2[1] * s + constant2)]
        return np.array(forces) + (stiffness * g0 * np.array([1.0, -1.0]) if contact else 0.0)

    def solve(matrix, right):
        free = moving > 0
        out = np.zeros(2)
        out[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free])
        return out

    x1, v1, x2, v2 = system.rest if start is None else start
    x, v = np.array([x1, x2]), np.array([v1, v2])
    contact = bool(system.gap(x[0], x[1]) <= 0)  # pressed together at rest, the gap is zero but for rounding
    c, k = matrices(contact)
    a = solve(mass, load(0, contact) - c @ v - k @ x)
    states, contacts = [[x[0], v[0], x[1], v[1]]], [contact]
    for i in range(1, steps + 1):
        c, k = matrices(contact)
        p, q = x + h * v + h * h / 4 * a, v + h / 2 * a
        a = solve(mass + h / 2 * c + h * h / 4 * k, load(i, contact) - c @ q - k @ p)
        x, v = p + h * h / 4 * a, q + h / 2 * a
        pull = stiffness * (x[0] - x[1] - g0) + 2 * damping * (v[0] - v[1]) < 0
        if cut and contact and pull:
            c, k = matrices(False)
            a = solve(mass + h / 2 * c + h * h / 4 * k, load(i, False) - c @ q - k @ p)
            x, v = p + h * h / 4 * a, q + h / 2 * a
        contact = bool(g0 + x[1] - x[0] <= 0)
        states.append([x[0], v[0], x[1], v[1]])
        contacts.append(contact)
    return np.array(states), np.array(contacts)
