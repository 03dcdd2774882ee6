"""Energy balance of a discrete solution with a constant step, summed step by step.

In a step each force does the mean of its values at both ends times the change of its displacement,

    work = ½(l₀ + l₁) Δξ,    dampers = ½(c₀ + c₁) Δξ,    contact = −½(λ₀ + λ₁) Δg less what its spring stores,

with λ by the contact law at the ends. Average acceleration (Newmark's method, α = ½, β = ¼) has Δξ = Δτ·mean ξ′ and
Δξ′ = Δτ·mean ξ″, so that its steps balance exactly as long as contact does not change. The residual of a step of
another method is its numerical damping,

    energy created = mean ξ′ Δξ′ − mean ξ″ Δξ                                                     (51)

with ξ″ by the equations of motion at the ends. Of a
smooth motion that is sampled, all that remains is the change of a function of the state, of second order.
"""

import numpy as np
from vibroscope.engine.contact import spring_energy
from vibroscope.engine.drivers.parameters import loads, seen_from_stops
from vibroscope.engine.energy.result import EnergyBalance
from vibroscope.engine.result import Response

EVERY_STEP = 1e-3  # relative: samples whose spacing is a step but for so much are those of every step


def balance_of_steps(response: Response) -> EnergyBalance:
    """Balance the sampled periods; every step of them is recorded."""
    sampled, c, method = response.trajectory, response.system, response.method
    if sampled is None or not np.isclose(
        sampled.time[1] - sampled.time[0], response.period / method.steps, rtol=EVERY_STEP
    ):
        raise ValueError("the energy of steps is balanced one by one: record every step of the sampled periods")
    mu, kappa = (0.0 if c.wall else c.mass_ratio), c.kappa
    x, v, force = sampled.displacement, sampled.velocity, sampled.force
    rest, gap, change = (c.clearance, 0.0) if c.rests_afar else c.separate_rest, c.gap(x[0], x[1]), np.diff(x)
    constant = c.excitation.constant1 - c.spring1 * rest[0] if c.rests_afar else 0.0  # what holds the first there
    phase = np.arange(len(sampled.time)) % method.steps * (2 * np.pi / method.steps)
    cosine, sine = np.cos(phase), np.sin(phase)
    if c.excitation.load is not None:
        cosine, sine = c.excitation.load.at(sampled.time), 0.0 * sine
    one, two = (load[0] * cosine + load[1] * sine for load in loads(c, response.eta))
    # the contact dissipates the work of λ on the bodies, less the energy that its spring stores
    spring = spring_energy(method, gap)
    for _, own in seen_from_stops(c, method)[1:]:
        spring = spring + spring_energy(own, c.play - gap)
    springs = c.spring1 * (x[0] - rest[0]) ** 2 - 2 * constant * (x[0] - rest[0]) + mu * (kappa * (x[1] - rest[1])) ** 2
    stored = 0.5 * (v[0] ** 2 + mu * v[1] ** 2 + springs) + spring

    def per_period(of_steps: np.ndarray) -> np.ndarray:
        return of_steps.reshape(-1, method.steps).sum(axis=1)

    return EnergyBalance(
        gain=np.diff(stored[:: method.steps]),
        work=per_period(_mean(one) * change[0] + mu * _mean(two) * change[1]),
        dampers=per_period(2 * (c.d1 * _mean(v[0]) * change[0] + mu * c.damper2 * _mean(v[1]) * change[1])),
        contact=per_period(-_mean(force) * (change[1] - change[0]) - np.diff(spring)),
        impacts=np.zeros(len(change[0]) // method.steps),
        stored=float(stored.max()),
    )


def _mean(values: np.ndarray) -> np.ndarray:
    """The mean over each step."""
    return 0.5 * (values[1:] + values[:-1])
