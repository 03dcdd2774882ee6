"""Slow, obvious twin of Newmark with located contact changes: matrices, dense scanning, bisection."""

import math

import numpy as np

from tests.naive import matrices_of


def newmark_located(system, eta, stiffness, damping, n, periods, looks=40):
    """Contact changes [(τ, begins)] and the states at the ends of the periods, (periods, 4), from rest.

    A step is halved until its pieces are short enough. Every piece is looked through by ``looks`` parts of its length:
    the first that ends on the other side of the gap is bisected.
    """
    mu, period = system.mass_ratio, 2 * math.pi / eta
    h, fastest = period / n, 2 * math.pi / max(1.0, system.kappa, eta)
    mass, dampers, springs = matrices_of(system)
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    rates = np.roots([1.0, -2 * damping * (1 + 1 / mu), stiffness * (1 + 1 / mu)])
    cycle = 2 * math.pi / np.abs(rates).max()

    def matrices(contact):
        return dampers + (2 * damping * pair if contact else 0), springs + (stiffness * pair if contact else 0)

    def acceleration(contact, tau, x, v):
        c, k = matrices(contact)
        return np.linalg.solve(mass, eta**2 * math.cos(eta * tau) * np.array([1.0, mu]) - c @ v - k @ x)

    def step(contact, tau, s, x, v, a):
        c, k = matrices(contact)
        p, q = x + s * v + s * s / 4 * a, v + s / 2 * a
        load = eta**2 * math.cos(eta * (tau + s)) * np.array([1.0, mu])
        a = np.linalg.solve(mass + s / 2 * c + s * s / 4 * k, load - c @ q - k @ p)
        return p + s * s / 4 * a, q + s / 2 * a, a

    x, v, contact, landed = np.zeros(2), np.zeros(2), True, 0.0
    a = acceleration(contact, 0.0, x, v)
    changes, states = [(0.0, True)], []
    for i in range(periods * n):
        s = 0.0
        while s < h:
            tau = i * h + s
            most = h * min(1.0, max(cycle, 2 * (tau - landed)) / fastest) if contact else h
            piece = h / 2 ** max(0, math.ceil(math.log2(h / most) - 1e-6))
            end = min(h, (math.floor(s / piece + 1e-6) + 1) * piece)
            length = end - s

            def changed(theta, contact=contact, tau=tau, x=x, v=v, a=a):
                ahead = step(contact, tau, theta, x, v, a)[0]
                return (ahead[1] - ahead[0] <= 0) != contact

            looked = [length * j / looks for j in range(1, looks + 1)]
            beyond = next((theta for theta in looked if changed(theta)), None)
            if beyond is None:
                x, v, a = step(contact, tau, length, x, v, a)
                s = end
                continue
            before = beyond - length / looks
            for _ in range(60):
                middle = (before + beyond) / 2
                before, beyond = (before, middle) if changed(middle) else (middle, beyond)
            x, v, _ = step(contact, tau, beyond, x, v, a)
            contact, s = not contact, s + beyond
            if contact:
                landed = i * h + s
            changes.append((i * h + s, contact))
            x = np.full(2, x.mean())  # what rounding leaves of the gap would be taken for a change at once
            a = acceleration(contact, i * h + s, x, v)
        if (i + 1) % n == 0:
            states.append([x[0], v[0], x[1], v[1]])
    return changes, np.array(states)
