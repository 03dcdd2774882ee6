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
that is missing, misplaced or wrong leaves a residual. For a constant step the sums are those of the discrete solution
(:mod:`.steps`). Their residual is the energy that the time-stepping creates, or removes if it is negative: where
contact changes, and by numerical damping. The losses of such a solution include what it creates.

With another contact law the contact takes ∫λδ′ dτ less what its spring stores, Kδⁿ⁺¹/(n + 1); the integrals are
those of the solution itself (:mod:`.law`).
"""

from collections.abc import Callable

import numpy as np

from ..drivers.law_driven import needs_law
from ..result import Response
from .events import balance_between_events
from .law import balance_of_law
from .result import EnergyBalance
from .steps import balance_of_steps


def energy_balance(
    response: Response,
    start: tuple[float, float, float, float] | None = None,
    cancelled: Callable[[], bool] | None = None,
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
        If the run ended early, if too few periods are kept, or if not every step of a constant one was recorded.
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
        return balance_of_law(response, rows)
    return balance_between_events(response, rows, cancelled)
