"""SciPy's solutions of the same problems: ``solve_ivp`` with events, restarted at each event.

Implicit methods get the Jacobian. Siconos, the field's platform for non-smooth mechanics, is not among the peers: it
has no wheel, and its Debian package (python3-siconos) works with the system's own Python only, so that it cannot run in
one process with the others.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

MAX_STEP = 0.1  # so that no two crossings of the surface lie in one step; tried with and without
MOST_PHASES = 100  # per period; a run that needs more finds the same event for ever
NO_STATE = np.full(4, math.nan)


class Solver:
    """``solve_ivp`` with its settings."""

    def __init__(self, method, rtol, limited):
        self.options = {
            "method": method,
            "rtol": rtol,
            "atol": rtol * 1e-3,
            "max_step": MAX_STEP if limited else math.inf,
        }
        self.implicit = method in ("Radau", "BDF", "LSODA")

    def phase(self, matrix, load, eta, event, direction, begin, end, state):
        """Solve y′ = matrix·y + load·cos ητ until ``event·y`` crosses zero in ``direction``.

        A phase starts where its event function is zero within rounding, of either sign. There the sign is set to what
        it must be, or the event would fire again at once.
        """
        rows, dimension = np.column_stack([matrix, load]).tolist(), len(load)
        weights = event.tolist()
        if dimension == 4:

            def rates(t, y):
                a, b, c, d = y.tolist()
                f = math.cos(eta * t)
                return [r[0] * a + r[1] * b + r[2] * c + r[3] * d + r[4] * f for r in rows]
        else:

            def rates(t, y):
                a, b = y.tolist()
                f = math.cos(eta * t)
                return [r[0] * a + r[1] * b + r[2] * f for r in rows]

        def fires(t, y):
            if t <= begin + 1e-9:
                return -direction
            return sum(weight * value for weight, value in zip(weights, y.tolist(), strict=True))

        fires.terminal, fires.direction = True, direction
        jacobian = {"jac": lambda t, y: matrix} if self.implicit else {}
        run = solve_ivp(rates, (begin, end), state, events=fires, **jacobian, **self.options)
        if run.status < 0:
            raise ArithmeticError(run.message)
        return run.t[-1], run.y[:, -1], run.status == 1


def motions(system, stiffness=0.0, damper=0.0):
    """Matrix and load of y = (ξ₁, ξ₁′, ξ₂, ξ₂′) with a spring and a damper between the pendulums; load per η²."""
    mu, kappa = system.mass_ratio, system.kappa
    spring, dashpot = np.array([1.0, 0.0, -1.0, 0.0]) * stiffness, np.array([0.0, 1.0, 0.0, -1.0]) * 2 * damper
    force = spring + dashpot
    first = np.array([-1.0, -2 * system.d1, 0.0, 0.0]) - force
    second = np.array([0.0, 0.0, -(kappa**2), -2 * system.d2 * kappa]) + force / mu
    return np.array([[0.0, 1, 0, 0], first, [0.0, 0, 0, 1], second]), np.array([0.0, 1, 0, 1])


GAP = np.array([-1.0, 0.0, 1.0, 0.0])


def scipy_reference(system, eta, d3, threshold, periods, rtol=1e-9, method="DOP853", limited=True):
    """The reference, phase by phase: the state at the end, nan where it is not reached."""
    solver, end, share = Solver(method, rtol, limited), periods * 2 * math.pi / eta, system.mass_share
    apart, load = motions(system)
    joined = np.array([[0.0, 1.0], [-(system.kappa3**2), -2 * d3 * system.kappa3]])
    force = share * np.array([system.kappa**2 - 1, 2 * (system.d2 * system.kappa - system.d1)])
    t, state, together = 0.0, np.zeros(4), True
    for _ in range(MOST_PHASES * periods):
        if together:
            t, pair, ended = solver.phase(joined, load[:2] * eta**2, eta, force, -1, t, end, state[:2])
            state, together = np.tile(pair, 2), False
        else:
            t, state, ended = solver.phase(apart, load * eta**2, eta, GAP, -1, t, end, state)
            if ended:
                closing, common = state[1] - state[3], state[1] + share * (state[3] - state[1])
                parting = system.restitution * closing
                together = parting <= threshold and force @ [state[0], common] > 0
                parting = 0.0 if together else parting
                state = np.array([state[0], common - share * parting, state[0], common + (1 - share) * parting])
        if not ended:
            return state
    return NO_STATE


def scipy_penalty(system, eta, stiffness, damper, periods, rtol=1e-9, method="DOP853", limited=True):
    """The penalty model, restarted at each contact change: the state at the end, nan where it is not reached."""
    solver, end = Solver(method, rtol, limited), periods * 2 * math.pi / eta
    phases = {False: (motions(system)[0], -1), True: (motions(system, stiffness, damper)[0], 1)}
    load = motions(system)[1] * eta**2
    t, state, contact = 0.0, np.zeros(4), True
    for _ in range(MOST_PHASES * periods):
        matrix, direction = phases[contact]
        t, state, ended = solver.phase(matrix, load, eta, GAP, direction, t, end, state)
        contact = not contact
        if not ended:
            return state
    return NO_STATE
