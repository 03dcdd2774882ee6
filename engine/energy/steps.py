"""Energy balance of Newmark's discrete solution with a constant step, summed step by step."""

import numpy as np

from ..drivers.parameters import loads
from ..result import Response
from .result import EnergyBalance


def balance_of_steps(response: Response) -> EnergyBalance:
    """Balance the discrete solution, in which each step obeys Δξ = Δτ·mean ξ′ and Δξ′ = Δτ·mean ξ″."""
    sampled, c, method = response.trajectory, response.system, response.method
    if sampled is None or not np.isclose(sampled.time[1] - sampled.time[0], response.period / method.steps, rtol=1e-3):
        raise ValueError("Newmark's energy is balanced step by step: record every step of the sampled periods")
    periods = (len(sampled.time) - 1) // method.steps
    mu, kappa, h = (0.0 if c.wall else c.mass_ratio), c.kappa, response.period / method.steps
    x, v, force = sampled.displacement, sampled.velocity, sampled.force
    rest = c.separate_rest
    mean = 0.5 * (v[:, 1:] + v[:, :-1])
    phase = np.arange(len(sampled.time)) % method.steps * (2 * np.pi / method.steps)
    cosine, sine = np.cos(phase), np.sin(phase)
    one, two = (load[0] * cosine + load[1] * sine for load in loads(c, response.eta))
    gap, rate = c.gap(x[0], x[1]), mean[1] - mean[0]
    # the contact damper dissipates the work of λ on the pendulums, less the energy that the contact spring stores
    spring = 0.5 * method.stiffness * np.minimum(gap, 0.0) ** 2
    contact = -h * 0.5 * (force[1:] + force[:-1]) * rate - np.diff(spring)
    springs = (x[0] - rest[0]) ** 2 + mu * (kappa * (x[1] - rest[1])) ** 2
    stored = 0.5 * (v[0] ** 2 + mu * v[1] ** 2 + springs) + spring

    def per_period(of_steps: np.ndarray) -> np.ndarray:
        return of_steps.reshape(periods, method.steps).sum(axis=1)

    return EnergyBalance(
        gain=np.diff(stored[:: method.steps]),
        work=per_period(h * 0.5 * ((one[1:] + one[:-1]) * mean[0] + mu * (two[1:] + two[:-1]) * mean[1])),
        dampers=per_period(2 * h * (c.d1 * mean[0] ** 2 + mu * c.d2 * kappa * mean[1] ** 2)),
        contact=per_period(contact),
        impacts=np.zeros(periods),
        stored=float(stored.max()),
    )
