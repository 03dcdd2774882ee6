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


def newmark(system, eta, stiffness, damping, n, steps, cut=False, start=None):
    """Textbook Newmark (α = ½, β = ¼) with matrices: states (steps + 1, 4), and whether each step is with contact.

    A wall is body 2 with its rows and columns struck out: its acceleration is zero. ``cut``: a step at whose end the
    contact would pull is taken without its force (with one stop). ``start``: ξ₁, ξ₁′, ξ₂, ξ₂′, by default rest.
    """
    h, mu = 2 * math.pi / eta / n, 1.0 if system.wall else system.mass_ratio
    free = slice(0, 1) if system.wall else slice(0, 2)
    mass, dampers, springs = matrices_of(system)
    side, pair = np.array([1.0, -1.0]), np.array([[1.0, -1.0], [-1.0, 1.0]])
    (load1, constant1), (load2, constant2) = drive(system, eta)
    stops = [(1.0, system.clearance, stiffness, damping)]  # sign of ξ₂ − ξ₁ in the gap, clearance, K, D
    if system.clearance2 is not None:
        numbers = stiffness * system.stiffness_factor2, damping * system.damping_factor2
        stops.append((-1.0, system.clearance2, *numbers))

    def met(x):
        return [stop for stop in stops if stop[1] + stop[0] * (x[1] - x[0]) <= 0]

    def acting(i, touched):
        """Dampers, springs and load with the stops that are touched."""
        c, s = math.cos(eta * i * h), math.sin(eta * i * h)
        load = np.array([load1[0] * c + load1[1] * s + constant1, mu * (load2[0] * c + load2[1] * s + constant2)])
        d, k = dampers, springs
        for sign, clearance, by_k, by_d in touched:
            d, k, load = d + 2 * by_d * pair, k + by_k * pair, load + sign * by_k * clearance * side
        return d, k, load

    def solve(matrix, right):
        out = np.zeros(2)
        out[free] = np.linalg.solve(matrix[free, free], right[free])
        return out

    def step(i, touched, p, q):
        d, k, load = acting(i, touched)
        a = solve(mass + h / 2 * d + h * h / 4 * k, load - d @ q - k @ p)
        return p + h * h / 4 * a, q + h / 2 * a, a

    x1, v1, x2, v2 = system.rest if start is None else start
    x, v = np.array([x1, x2]), np.array([v1, v2])
    touched = met(x)  # pressed together at rest, the gap is zero but for rounding
    d, k, load = acting(0, touched)
    a = solve(mass, load - d @ v - k @ x)
    states, contacts = [[x[0], v[0], x[1], v[1]]], [bool(touched)]
    for i in range(1, steps + 1):
        p, q = x + h * v + h * h / 4 * a, v + h / 2 * a
        x, v, a = step(i, touched, p, q)
        pull = stiffness * (x[0] - x[1] - system.clearance) + 2 * damping * (v[0] - v[1]) < 0
        if cut and touched and pull:
            x, v, a = step(i, [], p, q)
        touched = met(x)
        states.append([x[0], v[0], x[1], v[1]])
        contacts.append(bool(touched))
    return np.array(states), np.array(contacts)
