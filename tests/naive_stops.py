"""Plain twins of motions before a stop or between two: both surfaces in one place, with nothing mirrored.

Stop 1 has the gap c₁ + ξ₂ − ξ₁, stop 2 the gap c₂ − ξ₂ + ξ₁.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from tests.naive import drive, matrices_of, oscillator, scan

SIDES = (1.0, -1.0)  # sign of ξ₂ − ξ₁ in the gap of each stop


def gap(system, k, x):
    return (system.clearance, system.clearance2)[k] + SIDES[k] * (x[1] - x[0])


def reference(system, eta, d3, threshold, periods, start=None):
    """Events [(τ, kind, stop, closing speed)] and the state at the end; kind 0 impact, 1 contact begins, 2 it ends.

    From rest in contact at τ = 0, or from a start with open gaps.
    """
    wall, mu, kappa = system.wall, 1.0 if system.wall else system.mass_ratio, system.kappa
    stops = 1 if system.clearance2 is None else 2
    e, end = (system.restitution, system.second_restitution), periods * 2 * math.pi / eta
    (load1, constant1), (load2, constant2) = drive(system, eta)
    tau, (x1, v1, x2, v2), first = 0.0, start or system.rest, 1e-3
    stop, events = (None, []) if start else (0, [(0.0, 1, 0, 0.0)])

    def offset(k):  # ξ₁ − ξ₂ in contact
        return system.clearance if k == 0 else -system.clearance2

    def pressing(t, x, v, k):
        """The force of the joined bodies, over the reduced mass."""
        c, s = math.cos(eta * t), math.sin(eta * t)
        one = load1[0] * c + load1[1] * s + constant1 - 2 * system.d1 * v - x
        two = load2[0] * c + load2[1] * s + constant2 - 2 * system.d2 * kappa * v - kappa**2 * (x - offset(k))
        return SIDES[k] * (one if wall else one - two)

    while True:
        if stop is not None:
            if wall:

                def body(t, x=x1):
                    return x, 0.0
            else:
                joint = tuple((one + mu * two) / (1 + mu) for one, two in zip(load1, load2, strict=True))
                constant = (constant1 + mu * (constant2 + kappa**2 * offset(stop))) / (1 + mu)
                body = oscillator(system.kappa3, d3, eta, tau, x1, v1, joint, constant)
            tau = scan(lambda t, body=body, k=stop: pressing(t, *body(t), k), tau, end, first=1e-3)
            x1, v1 = body(min(tau, end))
            x2, v2 = (0.0, 0.0) if wall else (x1 - offset(stop), v1)
            if tau == math.inf:
                return events, (x1, v1, x2, v2)
            events.append((tau, 2, stop, 0.0))
            stop, first = None, 1e-3
            continue
        one = oscillator(1.0, system.d1, eta, tau, x1, v1, load1, constant1)
        two = (lambda t: (0.0, 0.0)) if wall else oscillator(kappa, system.d2, eta, tau, x2, v2, load2, constant2)
        found = [
            scan(lambda t, k=k, one=one, two=two: gap(system, k, (one(t)[0], two(t)[0])), tau, end, first)
            for k in range(stops)
        ]
        k, tau, first = found.index(min(found)), min(found), 1e-7
        (x1, v1), (x2, v2) = one(min(tau, end)), two(min(tau, end))
        if tau == math.inf:
            return events, (x1, v1, x2, v2)
        share, closing = (1.0 if wall else mu / (1 + mu)), SIDES[k] * (v1 - v2)
        common, parting = v1 - share * (v1 - v2), -e[k] * (v1 - v2)
        events.append((tau, 0, k, closing))
        x1, x2 = (offset(k), 0.0) if wall else (x1, x1 - offset(k))
        v1, v2 = common + share * parting, 0.0 if wall else common - parting / (1 + mu)
        if e[k] * closing <= threshold and pressing(tau, x1, common, k) > 0:
            v1, v2, stop = common, common, k
            events.append((tau, 1, k, 0.0))


def penalty(system, eta, method, periods, start):
    """The state after a run of an exact penalty solution of spring and damper, by DOP853 from event to event."""
    (load1, constant1), (load2, constant2) = drive(system, eta)
    mass, damper, spring = matrices_of(system)
    free, end = np.array([1.0, 0.0 if system.wall else 1.0]), periods * 2 * math.pi / eta

    def slope(t, y, inside):
        x, v = y[:2], y[2:]
        c, s = math.cos(eta * t), math.sin(eta * t)
        load = np.array([load1[0] * c + load1[1] * s + constant1, load2[0] * c + load2[1] * s + constant2])
        push = 0.0
        for k, (by_k, by_d) in enumerate(((1.0, 1.0), (system.stiffness_factor2, system.damping_factor2))):
            if inside[k]:
                rate = SIDES[k] * (v[1] - v[0])
                push -= SIDES[k] * (-by_k * method.stiffness * gap(system, k, x) - 2 * by_d * method.damping * rate)
        a = load - (damper @ v + spring @ x) / np.diag(mass) + push * np.array([1.0, -1.0]) / np.diag(mass)
        return np.concatenate([v * free, a * free])

    t, y, inside = 0.0, np.array([start[0], start[2], start[1], start[3]]), [False, False]
    while t < end:
        events = []
        for k in range(2):

            def event(t, y, inside, k=k):
                return gap(system, k, y[:2])

            event.terminal, event.direction = True, 1.0 if inside[k] else -1.0
            events.append(event)
        run = solve_ivp(slope, (t, end), y, "DOP853", rtol=1e-13, atol=1e-14, args=(list(inside),), events=events)
        t, y = run.t[-1], run.y[:, -1]
        for k in range(2):
            if len(run.t_events[k]):
                inside[k] = not inside[k]
    return y[0], y[2], y[1], y[3]
