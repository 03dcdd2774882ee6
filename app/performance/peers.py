"""Other solvers of the same two problems: a plain loop of Newmark's method, and heyoka.

The plain loop shows what a step costs where every step is taken, as in an FE code. heyoka compiles Taylor integrators
with events and is the fastest general solver known to us for such problems; it is optional (``pip install heyoka``).
Each of its settings was measured to be the fastest: accuracy of a double; the motion compiled once, with every number a
constant but the state of contact; the excitation as two more linear equations instead of a cosine; one event whose
callback touches plain memory; ``fast_math`` and ``slp_vectorize``, never compact mode.
"""

import importlib.util
import math
from collections.abc import Callable

import numba
import numpy as np
from vibroscope.engine import System

PeerSolver = Callable[[int], np.ndarray]  # periods from rest → ξ₁, ξ₁′, ξ₂, ξ₂′ (nan where the peer gave up)

# Steps per period that end a run which finds the same event for ever; an accurate run takes at most 70 in any scene.
MOST_STEPS = 2000
FASTEST = {"fast_math": True, "slp_vectorize": True, "compact_mode": False}


@numba.njit(error_model="numpy", nogil=True)
def plain_newmark(h, cosines, periods, eta, pendulums, contact):
    """Newmark's method (α = ½, β = ¼) step by step; each step in contact solves a 2 × 2 system for the accelerations.

    Parameters
    ----------
    h : float
        Time step Δτ.
    cosines : (n + 1,) ndarray
        cos ητ at the steps of one period.
    periods : int
    eta : float
    pendulums : tuple
        d₁, d₂, κ, μ.
    contact : tuple
        K, D.
    """
    (d1, d2, kappa, mu), (stiffness, damper) = pendulums, contact
    n = cosines.shape[0] - 1
    x1 = v1 = x2 = v2 = 0.0
    a1 = a2 = eta * eta
    c1, c2, k2 = 2.0 * d1, 2.0 * d2 * kappa, kappa * kappa
    m1 = 1.0 + c1 * h / 2.0 + h * h / 4.0
    m2 = 1.0 + c2 * h / 2.0 + k2 * h * h / 4.0
    s = stiffness * h * h / 4.0 + damper * h
    for _ in range(periods):
        for k in range(1, n + 1):
            touching = x2 - x1 <= 0.0
            p1, q1 = x1 + h * v1 + h * h / 4.0 * a1, v1 + h / 2.0 * a1
            p2, q2 = x2 + h * v2 + h * h / 4.0 * a2, v2 + h / 2.0 * a2
            load = eta * eta * cosines[k]
            r1, r2 = load - c1 * q1 - p1, load - c2 * q2 - k2 * p2
            if touching:
                force = stiffness * (p1 - p2) + 2.0 * damper * (q1 - q2)
                r1, r2 = r1 - force, r2 + force / mu
                determinant = (m1 + s) * (m2 + s / mu) - s * s / mu
                a1, a2 = ((m2 + s / mu) * r1 + s * r2) / determinant, ((m1 + s) * r2 + s / mu * r1) / determinant
            else:
                a1, a2 = r1 / m1, r2 / m2
            x1, v1 = p1 + h * h / 4.0 * a1, q1 + h / 2.0 * a1
            x2, v2 = p2 + h * h / 4.0 * a2, q2 + h / 2.0 * a2
    return x1, v1, x2, v2


def plain_loop(system: System, eta: float, stiffness: float, damper: float, steps: int) -> PeerSolver:
    """The plain loop, compiled, with its table of cosines prepared."""
    h = 2 * math.pi / eta / steps
    cosines = np.cos(2 * np.pi * np.arange(steps + 1) / steps)
    numbers = eta, (system.d1, system.d2, system.kappa, system.mass_ratio), (float(stiffness), float(damper))
    plain_newmark(h, cosines[:2], 1, *numbers)
    return lambda periods: np.array(plain_newmark(h, cosines, periods, *numbers))


def heyoka_version() -> str | None:
    """Version of heyoka, or None where it is not installed."""
    if importlib.util.find_spec("heyoka") is None:
        return None
    import heyoka

    return heyoka.__version__


def free_motion(hy, system: System, load, force):
    """Equations of both pendulums with a force between them: pairs of ξ₁, ξ₁′, ξ₂, ξ₂′ and their derivatives."""
    x1, v1, x2, v2 = hy.make_vars("x1", "v1", "x2", "v2")
    kappa, mu = system.kappa, system.mass_ratio
    return [
        (x1, v1),
        (v1, load - x1 - 2 * system.d1 * v1 - force),
        (x2, v2),
        (v2, load - kappa**2 * x2 - 2 * system.d2 * kappa * v2 + force / mu),
    ]


def excitation(hy, eta):
    """Equations of cos ητ and sin ητ as two more unknowns; they are linear and so cheaper than a cosine's series."""
    c, s = hy.make_vars("c", "s")
    return [(c, -eta * s), (s, eta * c)]


def heyoka_reference(system: System, eta: float, d3: float, threshold: float, tolerance: float = 0.0) -> PeerSolver:
    """The reference: one integrator for free flight, another for permanent contact.

    ``tolerance`` 0 is heyoka's full accuracy.
    """
    import heyoka as hy

    x1, v1, x2, c = hy.make_vars("x1", "v1", "x2", "c")
    mu, share, restitution = system.mass_ratio, system.mass_share, system.restitution
    spring, damper = share * (system.kappa**2 - 1), share * 2 * (system.d2 * system.kappa - system.d1)
    load, opposite = eta**2 * c, 1 / (1 + mu)

    def impact(_, sign):
        first = state[1]
        apart = state[3] - first
        common, parting = first + share * apart, -restitution * apart
        if parting <= threshold and spring * state[0] + damper * common > 0:
            return False
        state[1], state[3], state[2] = common - share * parting, common + opposite * parting, state[0]
        return True

    options = {"tol": tolerance, **FASTEST}
    down = hy.event_direction.negative
    free = hy.taylor_adaptive(
        [*free_motion(hy, system, load, 0.0), *excitation(hy, eta)],
        [0.0] * 4 + [1.0, 0.0],
        t_events=[hy.t_event(x2 - x1, callback=impact, direction=down)],
        **options,
    )
    joined = hy.taylor_adaptive(
        [(x1, v1), (v1, load - system.kappa3**2 * x1 - 2 * d3 * system.kappa3 * v1), *excitation(hy, eta)],
        [0.0, 0.0, 1.0, 0.0],
        t_events=[hy.t_event(spring * x1 + damper * v1, direction=down)],
        **options,
    )
    state, pair = memoryview(free.state), memoryview(joined.state)

    def run(periods):
        end, most, over = periods * 2 * math.pi / eta, MOST_STEPS * periods, hy.taylor_outcome.time_limit
        pair[0], pair[1], pair[2], pair[3] = 0.0, 0.0, 1.0, 0.0
        joined.time = 0.0
        for _ in range(most):
            joined.reset_cooldowns()
            outcome = joined.propagate_until(end, max_steps=most)[0]
            if outcome == over:
                return np.array([pair[0], pair[1], pair[0], pair[1]])
            state[0] = state[2] = pair[0]
            state[1] = state[3] = pair[1]
            state[4], state[5] = pair[2], pair[3]
            free.time = joined.time
            free.reset_cooldowns()
            outcome = free.propagate_until(end, max_steps=most)[0]
            if outcome == over:
                return np.array(state[:4])
            if outcome == hy.taylor_outcome.step_limit:
                break
            pair[0], pair[1], pair[2], pair[3] = state[0], state[1] + share * (state[3] - state[1]), state[4], state[5]
            joined.time = free.time
        return np.full(4, math.nan)

    return run


def heyoka_penalty(system: System, eta: float, stiffness: float, damper: float, tolerance: float = 0.0) -> PeerSolver:
    """The penalty model: one integrator with the state of contact as a parameter, which the event switches.

    The event function is the gap with the sign that it must lose, so that the root at the start, at rest, does not
    count.
    """
    import heyoka as hy

    x1, v1, x2, v2, c = hy.make_vars("x1", "v1", "x2", "v2", "c")
    contact = hy.par[0]
    force = contact * (float(stiffness) * (x1 - x2) + 2.0 * damper * (v1 - v2))

    def change(_, sign):
        touching[0] = 1.0 - touching[0]
        return True

    solver = hy.taylor_adaptive(
        [*free_motion(hy, system, eta**2 * c, force), *excitation(hy, eta)],
        [0.0] * 4 + [1.0, 0.0],
        pars=[1.0],
        t_events=[
            hy.t_event((1.0 - 2.0 * contact) * (x2 - x1), callback=change, direction=hy.event_direction.negative)
        ],
        tol=tolerance,
        **FASTEST,
    )
    touching = memoryview(solver.pars)

    def run(periods):
        solver.state[:] = 0.0, 0.0, 0.0, 0.0, 1.0, 0.0
        touching[0], solver.time = 1.0, 0.0
        solver.reset_cooldowns()
        outcome = solver.propagate_until(periods * 2 * math.pi / eta, max_steps=MOST_STEPS * periods)[0]
        return np.array(solver.state[:4]) if outcome == hy.taylor_outcome.time_limit else np.full(4, math.nan)

    return run
