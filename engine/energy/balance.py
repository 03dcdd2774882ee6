"""Energy balance of a response: how much energy the excitation supplies, and where it goes.

    gain of mechanical energy = work of the excitation − dampers − contact damper − impacts

in units of m₁ω₁² times the base amplitude squared. The mechanical energy of the motion relative to the base is

    E_m = [ξ₁′² + ξ₁² + μ(ξ₂′² + κ²ξ₂²) + K min(g, 0)²]/2,        K = 0 for the reference,                 (49)

with ξᵢ less its static equilibrium without contact in the place of ξᵢ, so that E_m includes the potential of
constant forces; in the paper's system that is zero. For a body and a wall the terms with μ are left out. The powers are

- l₁(τ) ξ₁′ + μ l₂(τ) ξ₂′ of the excitation, η² cos ητ (ξ₁′ + μξ₂′) in the paper's system,
- 2d₁ξ₁′² + 2μd₂κξ₂′² of the dampers, or 2d₃κ₃(1 + μ)ξ′² in permanent contact,
- 2Dg′² of the contact damper.

An impact dissipates μ/(1 + μ) (g′⁻² − g′⁺²)/2.

The balance is independent of the integration that it checks. For the reference, the exact penalty and located steps it
follows the motion from one row of the section to the next through the events of the response (:mod:`.events`). An event
that is missing, misplaced or wrong leaves a residual. For a constant step the sums are those of the discrete solution.
Their residual is the energy that the time-stepping creates, or removes if it is negative: where
contact changes, and by numerical damping. The losses of such a solution include what it creates.

With another contact law the contact takes ∫λδ′ dτ less what its spring stores, Kδⁿ⁺¹/(n + 1); the integrals are
those of the solution itself, piece by piece (:mod:`..kernels.event_driven.law_energy`). Of located steps they begin
anew at each row of the section, so that errors do not add up; a contact that is open there does not show the closing
speed that a formula's damper needs.

A discrete solution with a constant step is summed step by step (:func:`balance_of_steps`). In a step each force does
the mean of its values at both ends times the change of its displacement,

    work = ½(l₀ + l₁) Δξ,    dampers = ½(c₀ + c₁) Δξ,    contact = −½(λ₀ + λ₁) Δg less what its spring stores,

with λ by the contact law at the ends. Average acceleration (Newmark's method, α = ½, β = ¼) has Δξ = Δτ·mean ξ′ and
Δξ′ = Δτ·mean ξ″, so that its steps balance exactly as long as contact does not change. The residual of a step of
another method is its numerical damping,

    energy created = mean ξ′ Δξ′ − mean ξ″ Δξ                                                     (51)

with ξ″ by the equations of motion at the ends. Of a
smooth motion that is sampled, all that remains is the change of a function of the state, of second order.
"""

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.contact import spring_energy
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.drivers.law_driven import law_powers, needs_law
from vibroscope.engine.drivers.parameters import loads, seen_from_stops
from vibroscope.engine.energy.events import EnergyBalance, balance_between_events, energy_forms
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
    free = any(c.free_pulls)
    constant = c.excitation.constant1 - c.spring1 * rest[0] if c.rests_afar or free else 0.0  # what holds the bodies
    constant2 = c.excitation.constant2 - c.mass_ratio * kappa**2 * rest[1] if free else 0.0
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
    springs = springs - 2 * constant2 * (x[1] - rest[1])
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


def energy_balance(
    response: Response,
    start: tuple[float, float, float, float] | None = None,
    cancelled: Poll | None = None,
) -> EnergyBalance:
    """Compute the energy balance of the kept periods of a response.

    Parameters
    ----------
    response : Response
        With a constant step it must hold every step of its sampled periods; these are balanced.
    start : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the beginning of the kept periods: the initial state, if all periods are kept. Without it
        the balance begins with the second kept period, since the section is sampled at the end of each period.
    cancelled : callable, optional
        Polled many times a second; when it returns true the balance is cancelled.

    Returns
    -------
    EnergyBalance
        If located steps are so coarse that they misplace contacts by more than their depth, the closed form deviates
        from the solution. The residual is then large, and nan where numbers overflow.

    Raises
    ------
    ValueError
        If the run ended early, if too few periods are kept, if not every step of a constant one was recorded, or if
        there is a second stop, no step, and a law other than Kelvin–Voigt.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not response.ok:
        raise ValueError(response.ending)
    if response.method.has_step and not response.method.located:
        return balance_of_steps(response)
    rows = response.section if start is None else np.vstack([np.asarray(start, dtype=float), response.section])
    if len(rows) < 2:
        raise ValueError("the balance of one kept period needs its initial state: keep two periods, or give the start")
    if needs_law(response.method.limit):
        if not is_balance_known(response):
            raise ValueError(
                f"clearance2 = {response.system.clearance2:g}: between two stops the balance of a solution without "
                "steps knows the law kelvin-voigt alone"
            )
        return _balance_of_law(response, rows)
    return balance_between_events(response, rows, cancelled)


def is_balance_known(response: Response) -> bool:
    """Whether there is a balance of a response: between two stops of constant steps, or of a spring and a damper."""
    method = response.method
    steps = method.has_step and not method.located
    return not response.system.two_stops or steps or not needs_law(method.limit)


def _balance_of_law(response: Response, rows: np.ndarray) -> EnergyBalance:
    """Balance each period between two rows of the section.

    Parameters
    ----------
    rows : (n + 1, 4) ndarray
        Of the section; the last n + 1 of the kept periods, or with the start before them.
    """
    system, method, begun = response.system, response.method, response.checkpoint.periods
    if not method.has_step:
        periods = range(begun, begun + len(response.section))
        powers = law_powers(system, response.eta, method, response.checkpoint.state, periods)[1 - len(rows) :]
    else:
        each = (law_powers(system, response.eta, method.limit, row, range(1)) for row in rows[:-1])
        powers = np.concatenate(list(each))
    forms, y = energy_forms(system, response.eta, method), contact_state(system, rows)
    z = y - np.array([forms.parameters.free_position, 0.0, forms.parameters.free_gap, 0.0])
    spring = spring_energy(method, y[:, 2])
    z = np.hstack([z, np.zeros((len(z), 2)), np.ones((len(z), 1))])
    stored = np.einsum("ki,ij,kj->k", z, forms.stored, z) + spring
    return EnergyBalance(
        gain=np.diff(stored),
        work=powers[:, 0],
        dampers=powers[:, 1],
        contact=powers[:, 2] - np.diff(spring),
        impacts=np.zeros(len(powers)),
        stored=float(stored.max()),
    )
