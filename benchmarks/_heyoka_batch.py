"""heyoka's batch mode: several η at once, one in each lane of a vector register.

All lanes share one right-hand side, so η and the state of contact are parameters of each lane, and c and s carry the
load's factor η². The cost of a lane is the cost of one η in a sweep; a single run gains nothing from it.
"""

from collections.abc import Sequence

import numpy as np
from vibroscope.app.performance.peers import FASTEST, MOST_STEPS, PeerSolver, free_motion
from vibroscope.engine import System


def reference_batch(system: System, etas: Sequence[float], threshold: float, tolerance: float = 0.0) -> PeerSolver:
    """The reference with derived joint damping at several η at once, one in each lane of a vector register.

    All lanes share one right-hand side, so the joined pendulums are two pendulums with the contact force between them.
    That is the same motion because derived joint damping comes from their two dampers alone.
    """
    import heyoka as hy

    x1, v1, x2, c, s = hy.make_vars("x1", "v1", "x2", "c", "s")
    mu, share, restitution = system.mass_ratio, system.mass_share, system.restitution
    spring, damper = share * (system.kappa**2 - 1), share * 2 * (system.d2 * system.kappa - system.d1)
    opposite = 1 / (1 + mu)
    contact, eta = hy.par[0], hy.par[1]
    force = contact * (spring * x1 + damper * v1)

    def event(_, sign, lane):
        first = state[1, lane]
        if touching[0, lane] != 0.0:
            touching[0, lane] = 0.0
            state[2, lane], state[3, lane] = state[0, lane], first
            return True
        apart = state[3, lane] - first
        common, parting = first + share * apart, -restitution * apart
        if parting <= threshold and spring * state[0, lane] + damper * common > 0:
            touching[0, lane], parting = 1.0, 0.0
        state[1, lane], state[3, lane] = common - share * parting, common + opposite * parting
        state[2, lane] = state[0, lane]
        return True

    lanes = len(etas)
    frequencies = np.array(etas, dtype=float)
    solver = hy.taylor_adaptive_batch(
        [*free_motion(hy, system, c, force), (c, -eta * s), (s, eta * c)],  # c and s carry the load's factor η²
        np.zeros((6, lanes)),
        pars=np.zeros((2, lanes)),
        t_events=[
            hy.t_event_batch((1.0 - contact) * (x2 - x1) + force, callback=event, direction=hy.event_direction.negative)
        ],
        tol=tolerance,
        **FASTEST,
    )
    state, touching = memoryview(solver.state), memoryview(solver.pars)

    return _from_rest(hy, solver, frequencies)


def penalty_batch(
    system: System, etas: Sequence[float], stiffness: float, damper: float, tolerance: float = 0.0
) -> PeerSolver:
    """The penalty model at several η at once, one in each lane of a vector register."""
    import heyoka as hy

    x1, v1, x2, v2, c, s = hy.make_vars("x1", "v1", "x2", "v2", "c", "s")
    contact, eta = hy.par[0], hy.par[1]
    force = contact * (float(stiffness) * (x1 - x2) + 2.0 * damper * (v1 - v2))

    def change(_, sign, lane):
        touching[0, lane] = 1.0 - touching[0, lane]
        return True

    lanes = len(etas)
    frequencies = np.array(etas, dtype=float)
    gap = (1.0 - 2.0 * contact) * (x2 - x1)
    solver = hy.taylor_adaptive_batch(
        [*free_motion(hy, system, c, force), (c, -eta * s), (s, eta * c)],
        np.zeros((6, lanes)),
        pars=np.zeros((2, lanes)),
        t_events=[hy.t_event_batch(gap, callback=change, direction=hy.event_direction.negative)],
        tol=tolerance,
        **FASTEST,
    )
    touching = memoryview(solver.pars)

    return _from_rest(hy, solver, frequencies)


def _from_rest(hy, solver, frequencies: np.ndarray) -> PeerSolver:
    """A function that runs all lanes from rest, in contact."""

    def run(periods):
        solver.state[:] = 0.0
        solver.state[4] = frequencies**2
        solver.pars[0], solver.pars[1] = 1.0, frequencies
        return _run_lanes(hy, solver, periods * 2 * np.pi / frequencies, periods)

    return run


def _run_lanes(hy, solver, ends, periods):
    solver.set_time(0.0)
    solver.reset_cooldowns()
    solver.propagate_until(ends, max_steps=MOST_STEPS * periods)
    states = solver.state[:4].T.copy()
    states[[result[0] != hy.taylor_outcome.time_limit for result in solver.propagate_res]] = np.nan
    return states
