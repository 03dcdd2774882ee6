"""Slow, obvious twins of the kernels: textbook formulas, dense scanning, nothing clever."""

import math

import numpy as np


def oscillator(k, d, eta, tau0, x0, v0):
    """ξ(τ), ξ′(τ) of ξ″ + 2dkξ′ + k²ξ = η² cos ητ from (x0, v0) at tau0, in real arithmetic."""
    # steady part a cos ητ + b sin ητ by comparing coefficients
    a, b = np.linalg.solve([[k * k - eta**2, 2 * d * k * eta], [-2 * d * k * eta, k * k - eta**2]], [eta**2, 0.0])
    w = k * math.sqrt(1 - d * d)

    def steady(t):
        c, s = math.cos(eta * t), math.sin(eta * t)
        return a * c + b * s, eta * (b * c - a * s)

    p, q = x0 - steady(tau0)[0], v0 - steady(tau0)[1]

    def motion(t):
        s = t - tau0
        decay, c, sn = math.exp(-d * k * s), math.cos(w * s), math.sin(w * s)
        r = (q + d * k * p) / w
        x = decay * (p * c + r * sn)
        v = decay * ((r * w - d * k * p) * c - (p * w + d * k * r) * sn)
        return x + steady(t)[0], v + steady(t)[1]

    return motion


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


def reference(system, eta, d3, threshold, periods):
    """Events [(τ, kind, g′ before)] and the state at the end; kind 0 impact, 1 contact begins, 2 it ends. From rest."""
    mu, e, end = system.mass_ratio, system.restitution, periods * 2 * math.pi / eta
    events, tau, x1, v1, x2, v2, joined = [(0.0, 1, 0.0)], 0.0, 0.0, 0.0, 0.0, 0.0, True
    first = 1e-3

    def force(x, v):
        return mu / (1 + mu) * ((system.kappa**2 - 1) * x + 2 * (system.d2 * system.kappa - system.d1) * v)

    while True:
        if joined:
            body = oscillator(system.kappa3, d3, eta, tau, x1, v1)
            tau = scan(lambda t, body=body: force(*body(t)), tau, end, first=1e-3)
            x1, v1 = x2, v2 = body(min(tau, end))
            if tau == math.inf:
                return events, (x1, v1, x2, v2)
            joined, first = False, 1e-3  # g grows as the third power of time: below rounding at first
            events.append((tau, 2, 0.0))
            continue
        one = oscillator(1.0, system.d1, eta, tau, x1, v1)
        two = oscillator(system.kappa, system.d2, eta, tau, x2, v2)
        tau = scan(lambda t, one=one, two=two: two(t)[0] - one(t)[0], tau, end, first)
        first = 1e-7
        (x1, v1), (x2, v2) = one(min(tau, end)), two(min(tau, end))
        if tau == math.inf:
            return events, (x1, v1, x2, v2)
        closing, common = v1 - v2, (v1 + mu * v2) / (1 + mu)
        events.append((tau, 0, -closing))
        x2, v1, v2 = x1, common - mu / (1 + mu) * e * closing, common + e * closing / (1 + mu)
        if e * closing <= threshold and force(x1, common) > 0:
            v1 = v2 = common
            joined = True
            events.append((tau, 1, 0.0))


def newmark(system, eta, stiffness, damping, n, steps, cut=False):
    """Textbook Newmark (α = ½, β = ¼) with matrices: states (steps + 1, 4), and whether each step is with contact.

    ``cut``: a step at whose end the contact would pull is taken without its force.
    """
    h, mu = 2 * math.pi / eta / n, system.mass_ratio
    mass = np.diag([1.0, mu])
    dampers = np.diag([2 * system.d1, mu * 2 * system.d2 * system.kappa])
    springs = np.diag([1.0, mu * system.kappa**2])
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])

    def matrices(contact):
        return dampers + (2 * damping * pair if contact else 0), springs + (stiffness * pair if contact else 0)

    def load(i):
        return eta**2 * math.cos(eta * i * h) * np.array([1.0, mu])

    x, v = np.zeros(2), np.zeros(2)
    contact = True  # g = 0 at rest
    c, k = matrices(contact)
    a = np.linalg.solve(mass, load(0) - c @ v - k @ x)
    states, contacts = [[x[0], v[0], x[1], v[1]]], [contact]
    for i in range(1, steps + 1):
        c, k = matrices(contact)
        p, q = x + h * v + h * h / 4 * a, v + h / 2 * a
        a = np.linalg.solve(mass + h / 2 * c + h * h / 4 * k, load(i) - c @ q - k @ p)
        x, v = p + h * h / 4 * a, q + h / 2 * a
        if cut and contact and stiffness * (x[0] - x[1]) + 2 * damping * (v[0] - v[1]) < 0:
            c, k = matrices(False)
            a = np.linalg.solve(mass + h / 2 * c + h * h / 4 * k, load(i) - c @ q - k @ p)
            x, v = p + h * h / 4 * a, q + h / 2 * a
        contact = bool(x[1] - x[0] <= 0)
        states.append([x[0], v[0], x[1], v[1]])
        contacts.append(contact)
    return np.array(states), np.array(contacts)
