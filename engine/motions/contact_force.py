"""Contact force of a sampled response: its peak and its impulse."""

import numpy as np
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.result import Response

FEWEST_IN_CONTACT = 8  # in a contact, to see the peak of its force: 2 % off at most for half a sine wave


def peak_force(response: Response) -> float:
    """Largest contact force of the samples, of both stops; nan if there are too few of them in a contact."""
    sampled, method = response.trajectory, response.method
    if sampled is None:
        return np.nan
    spacing = sampled.time[1] - sampled.time[0]
    every_step = spacing * method.grid_steps < 1.5 * response.period and method.grid_steps > 0
    system = response.system
    largest = float(np.abs(sampled.force).max() if system.two_stops else sampled.force.max())
    if method.rigid or every_step:
        return largest
    contacts = response.contacts[response.contacts[:, 1] > sampled.time[0]]
    first = np.clip(np.searchsorted(sampled.time, contacts[:, 0]), 0, len(sampled.time) - 2)
    spacing = sampled.time[first + 1] - sampled.time[first]  # where each begins: under a load it varies
    if (np.diff(contacts, axis=1)[:, 0] < FEWEST_IN_CONTACT * spacing).any():
        return np.nan
    if not LAWS[method.law].jumps:
        return largest
    # the damper's force jumps when the contact begins, between two samples
    impacts = response.impacts
    damping = method.damping * np.where(impacts.impulse < 0, system.damping_factor2, 1.0)
    jumps = 2 * damping * impacts.closing_speed
    return max(largest, float(jumps[impacts.time > sampled.time[0]].max(initial=0.0)))


def impulse_per_period(response: Response) -> float:
    """∫λ dτ per sampled period, from the equation of motion ξ₁″ + 2d₁ξ₁′ + k₁x₁ = l₁(τ) − λ of body 1.

    k₁x₁ is k₁ξ₁ less the constant force. The excitation integrates to zero over whole periods, so that
    ∫λ dτ = −Δξ₁′ − 2d₁Δξ₁ − ∫k₁x₁ dτ. Where the reference is in permanent contact, its joint damping exceeds the two
    dampers, and 2κ₃(d₃ − derived d₃)Δξ₁ is subtracted. An impact with which the run begins lies before the first
    sample, and its impulse is added.

    Between two stops the impulses of both are added by their size: Σ|∫λ dτ| of the contacts that begin in the samples,
    and ∫|λ| dτ of the reference's permanent contacts.
    """
    sampled, c = response.trajectory, response.system
    if sampled is None:
        return np.nan
    if c.two_stops:
        met = response.impacts.time >= sampled.time[0]
        total = np.abs(response.impacts.impulse[met]).sum()
        total += np.trapezoid(np.abs(sampled.force), sampled.time) if response.method.rigid else 0.0
        return float(total / (sampled.time[-1] - sampled.time[0]) * response.period)
    time, x, v = sampled.time, sampled.displacement[0], sampled.velocity[0]
    total = v[0] - v[-1] + 2 * c.d1 * (x[0] - x[-1]) - np.trapezoid(c.spring1 * x - c.excitation.constant1, time)
    if response.method.rigid:
        excess = 2 * (c.joint_damper(response.method.joint_damping) - c.joint_damper("derived"))
        total -= excess * np.diff(np.interp(response.contacts, time, x), axis=1).sum()
        impacts = response.impacts
        total += impacts.impulse[impacts.time <= 0.0].sum() if time[0] <= 0.0 else 0.0
    return float(total / (time[-1] - time[0]) * response.period)
