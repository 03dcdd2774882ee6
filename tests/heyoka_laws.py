"""Twin of the contact laws that are not linear: Taylor series by heyoka, where it is installed.

Flights are integrated in τ. In contact δ = z⁴ and dτ = z³ dσ make every law with 4n and 2(n − 1) whole a polynomial in
z and the velocities, so that its series hold from touch to opening: dz/dσ = δ′/4, and all other rates times z³.
"""

import math

import heyoka as hy
import numpy as np

from tests.naive_laws import gain_of

RATIO = "hunt-crossley", "lankarani-nikravesh", "flores"
FAR = 1e9  # σ that no contact lasts
CLOSED = hy.taylor_outcome(-1)  # the first event has ended a contact
GAIN, CLOSING = hy.par[0], hy.par[1]  # c or h; 1 while the bodies close, then 0


def power(z, exponent):
    """z to a whole power."""
    product = z
    for _ in range(round(exponent) - 1):
        product = product * z
    return product


def force(method, z, speed):
    """λ of z and δ′; that of "impact" as long as it pushes and δ is below the penetration of full damping."""
    law, n = method.law, method.exponent
    spring = method.stiffness * power(z, 4 * n)
    if law in RATIO:
        return spring * (1.0 + GAIN * speed)
    if law == "jankowski":
        return spring + GAIN * z * speed * CLOSING
    if law == "constant-restitution":
        return spring + GAIN * power(z, 2 * (n - 1)) * speed
    x = power(z, 4) / method.penetration
    return spring + GAIN * x * x * (3.0 - 2.0 * x) * speed


class Motion:
    """A motion of two bodies that begins and ends apart: ξ₁, ξ₁′, ξ₂, ξ₂′."""

    def __init__(self, system, eta, method):
        self.system, self.eta, self.method = system, eta, method
        self.contacts, self.turns = 0, method.law == "jankowski"
        x1, v1, x2, v2, z, tau, c, s = hy.make_vars("x1", "v1", "x2", "v2", "z", "tau", "c", "s")

        def rates(push):
            one = eta**2 * c - 2 * system.d1 * v1 - x1 - push
            two = eta**2 * c - 2 * system.d2 * system.kappa * v2 - system.kappa**2 * x2 + push / system.mass_ratio
            return [(x1, v1), (v1, one), (x2, v2), (v2, two), (c, -eta * s), (s, eta * c)]

        touch = hy.t_event(system.clearance + x2 - x1, direction=hy.event_direction.negative)
        self.flight = hy.taylor_adaptive(rates(0.0), [0.0] * 6, t_events=[touch])
        push, slow = force(method, z, v1 - v2), power(z, 3)
        equations = [(name, slow * rate) for name, rate in rates(push)] + [(z, (v1 - v2) / 4.0), (tau, slow)]
        events = [hy.t_event(z, direction=hy.event_direction.negative)] + [hy.t_event(v1 - v2)] * self.turns
        self.contact = hy.taylor_adaptive(equations, [0.0] * 8, pars=[0.0] * (1 + self.turns), t_events=events)

    def run(self, start, end):
        """The state at τ = ``end``."""
        tau, x = 0.0, np.array(start)
        while True:
            flight = self.flight
            flight.state[:] = [*x, math.cos(self.eta * tau), math.sin(self.eta * tau)]
            flight.time = tau
            flight.reset_cooldowns()
            outcome = flight.propagate_until(end)[0]
            tau, x = flight.time, np.array(flight.state[:4])
            if outcome == hy.taylor_outcome.time_limit:
                return x
            tau, x = self.through_contact(tau, x)
            assert tau < end, "contact at the end: choose another"

    def through_contact(self, tau, x):
        """τ and the state at the end of a contact."""
        self.contacts += 1
        contact, mass = self.contact, self.system.mass_share
        contact.state[:] = [*x, math.cos(self.eta * tau), math.sin(self.eta * tau), 0.0, tau]
        contact.pars[0] = gain_of(self.method, self.system.restitution, mass, x[1] - x[3])
        contact.pars[1:] = 1.0
        contact.time = 0.0
        contact.reset_cooldowns()
        while contact.propagate_until(FAR)[0] != CLOSED:
            contact.pars[1] = 1.0 - contact.pars[1]
        return contact.state[7], np.array(contact.state[:4])
