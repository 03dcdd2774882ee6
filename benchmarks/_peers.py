"""The same problems as others solve them: a plain Numba loop, and SciPy's solve_ivp with events."""

import math

import numba
import numpy as np
from scipy.integrate import solve_ivp


@numba.njit(error_model="numpy")
def plain_newmark(h, cosines, periods, eta, d1, d2, kappa, mu, stiffness, damper):
    """Newmark as one writes it down: displacement, velocity, acceleration, a 2 × 2 system in each step of contact."""
    n = cosines.shape[0] - 1
    x1 = v1 = x2 = v2 = 0.0
    a1 = a2 = eta * eta
    c1, c2, k2 = 2.0 * d1, 2.0 * d2 * kappa, kappa * kappa
    m1 = 1.0 + c1 * h / 2.0 + h * h / 4.0
    m2 = 1.0 + c2 * h / 2.0 + k2 * h * h / 4.0
    s = stiffness * h * h / 4.0 + damper * h
    for _ in range(periods):
        for k in range(1, n + 1):
            contact = x2 - x1 <= 0.0
            p1, q1 = x1 + h * v1 + h * h / 4.0 * a1, v1 + h / 2.0 * a1
            p2, q2 = x2 + h * v2 + h * h / 4.0 * a2, v2 + h / 2.0 * a2
            load = eta * eta * cosines[k]
            r1, r2 = load - c1 * q1 - p1, load - c2 * q2 - k2 * p2
            if contact:
                force = stiffness * (p1 - p2) + 2.0 * damper * (q1 - q2)
                r1, r2 = r1 - force, r2 + force / mu
                determinant = (m1 + s) * (m2 + s / mu) - s * s / mu
                a1, a2 = ((m2 + s / mu) * r1 + s * r2) / determinant, ((m1 + s) * r2 + s / mu * r1) / determinant
            else:
                a1, a2 = r1 / m1, r2 / m2
            x1, v1 = p1 + h * h / 4.0 * a1, q1 + h / 2.0 * a1
            x2, v2 = p2 + h * h / 4.0 * a2, q2 + h / 2.0 * a2
    return x1, v1, x2, v2


def solve(rates, function, direction, begin, end, state, rtol):
    """One phase by DOP853, up to the zero of ``function(t, y)`` that it reaches in ``direction``.

    A phase starts where its function is zero within rounding, on either side: there its sign is taken as it must be,
    or the event fires again at once. With no largest step a chatter loses impacts.
    """

    def event(t, y):
        return function(t, y) if t > begin + 1e-9 else -direction

    event.terminal, event.direction = True, direction
    run = solve_ivp(rates, (begin, end), state, "DOP853", events=event, rtol=rtol, atol=rtol * 1e-3, max_step=0.1)
    return run.t[-1], run.y[:, -1], run.status == 1


def scipy_reference(system, eta, d3, threshold, periods, rtol=1e-9):
    """The reference, phase by phase."""
    mu, kappa, end = system.mass_ratio, system.kappa, periods * 2 * math.pi / eta
    share = mu / (1 + mu)

    def apart(t, y):
        load = eta**2 * math.cos(eta * t)
        return [y[1], load - 2 * system.d1 * y[1] - y[0], y[3], load - 2 * system.d2 * kappa * y[3] - kappa**2 * y[2]]

    def joined(t, y):
        return [y[1], eta**2 * math.cos(eta * t) - 2 * d3 * system.kappa3 * y[1] - system.kappa3**2 * y[0]]

    def gap(t, y):
        return y[2] - y[0]

    def force(t, y):
        return share * ((kappa**2 - 1) * y[0] + 2 * (system.d2 * kappa - system.d1) * y[1])

    t, state, together, ended = 0.0, np.zeros(4), True, True
    while ended:
        if together:
            t, pair, ended = solve(joined, force, -1, t, end, state[:2], rtol)
            state, together = np.tile(pair, 2), False
            continue
        t, state, ended = solve(apart, gap, -1, t, end, state, rtol)
        if ended:
            closing, common = state[1] - state[3], state[1] + share * (state[3] - state[1])
            parting = system.restitution * closing
            together = parting <= threshold and force(t, [state[0], common]) > 0
            parting = 0.0 if together else parting
            state = np.array([state[0], common - share * parting, state[0], common + parting / (1 + mu)])
    return state


def scipy_penalty(system, eta, stiffness, damper, periods, rtol=1e-9):
    """The penalty model, restarted at each contact change."""
    mu, kappa, end = system.mass_ratio, system.kappa, periods * 2 * math.pi / eta

    def motion(contact):
        def rates(t, y):
            load = eta**2 * math.cos(eta * t)
            force = stiffness * (y[0] - y[2]) + 2 * damper * (y[1] - y[3]) if contact else 0.0
            first = load - 2 * system.d1 * y[1] - y[0] - force
            return [y[1], first, y[3], load - 2 * system.d2 * kappa * y[3] - kappa**2 * y[2] + force / mu]

        return rates

    t, state, contact, ended = 0.0, np.zeros(4), True, True
    while ended:
        t, state, ended = solve(motion(contact), lambda t, y: y[2] - y[0], 1 if contact else -1, t, end, state, rtol)
        contact = not contact
    return state
