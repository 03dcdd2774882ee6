"""A nonsmooth step, for codes without a contact spring: Newton's impact law at the velocities of each step.

The θ-method of Moreau and Jean, with the velocity v and the gap g of a reduced mass, a constant force F that closes the
gap, and the impulse P of the contact over a step,

    m(v₁ − v₀) = P − hF,        g₁ = g₀ + h(θv₁ + (1 − θ)v₀),

    v₁ + ev₀ ≥ 0,  P ≥ 0,  (v₁ + ev₀) P = 0  where  g₀ + hv₀/2 ≤ 0,  else P = 0:

one contact has v₁ = max(v₀ − hF/m, −ev₀) there. The gap itself bounds nothing: without F bodies of closing speed v
overlap by up to hv times the larger of ½ and 1½ − θ(1 + e), and with e = 0 they stay so. The contact creates no energy
for ½ ≤ θ ≤ 1/(1 + e).

Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235–257; Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical
Systems (2008); energy: Acary, ZAMM 96 (2016) 585–603. The MoreauJeanOSI of Siconos predicts the gap so, by its γ = ½
(user's guide: Event-Capturing schemes).
"""

from dataclasses import dataclass

import numpy as np
from vibroscope.engine.checks import require
from vibroscope.engine.contact import ContactUnits
from vibroscope.engine.drivers.alone import CODE, DEPTH, FOUND, GAP, PARTED, PUSH, SPEED, STEPS, STUCK
from vibroscope.engine.one_impact.question import set_checked

THETA_RANGE = (0.5, 1.0)
MOST_STEPS = 10_000  # of a contact with a force, after which it stays
PREDICTED = 0.5  # of a step, at which the gap decides whether there is contact


@dataclass(frozen=True)
class MoreauJean:
    """Two bodies meet in a code with an impact law and a time step; a question for :func:`impact`.

    Attributes
    ----------
    restitution : float
        e of Newton's law.
    time_step : float
        h.
    speed, mass, force
        As those of :class:`Impact`.
    theta : float
        θ, ½ to 1.

    Raises
    ------
    ValueError
        If a number is out of range; if the step is so long that the force makes the speed.

    Examples
    --------
    >>> from vibroscope.engine import MoreauJean, impact
    >>> found = impact(MoreauJean(0.5, time_step=1e-3, speed=2.0))
    >>> [round(e, 6) for e in found.restitution]  # whatever the step
    [0.5, 0.5, 0.5]
    >>> round(found.penetration / (2.0 * 1e-3), 6)  # of a step of flight
    0.75
    """

    restitution: float
    time_step: float
    speed: float = 1.0
    mass: float = 1.0
    force: float = 0.0
    theta: float = 0.5

    def __post_init__(self):
        set_checked(self, has_step=True)
        theta = require("theta", self.theta, *THETA_RANGE, "1/2 conserves energy in flight, 1 is Euler's")
        object.__setattr__(self, "theta", theta)

    @property
    def scheme(self) -> tuple[str, str]:
        """Its name, as that of an integrator; it has no contact status."""
        return "moreau-jean", ""

    @property
    def units(self) -> ContactUnits:
        """Those in which the step is one as well: a stiffness of m/h²."""
        return ContactUnits(self.mass, self.speed, self.mass / self.time_step**2, 1.0)

    @property
    def touches(self) -> "NonsmoothTouches":
        """Its contacts, in its units."""
        return NonsmoothTouches(self.restitution, self.theta, self.force / self.units.force)


class NonsmoothTouches:
    """Contacts by these steps, in units of mass, closing speed and step, as :class:`..drivers.alone.Touches`."""

    def __init__(self, restitution: float, theta: float, push: float):
        self.restitution, self.theta, self.flight = restitution, theta, -push

    def run(self, instants: np.ndarray) -> np.ndarray:
        """What is found of each touch, (n, FOUND): the force is that which gives the impulse over a step.

        ``instants``: (n,), of touch, in steps after one, from 0 to 1.
        """
        gap, rate = instants + 0.5 * self.flight * instants**2, -(1.0 + self.flight * instants)
        found = np.zeros((len(instants), FOUND))
        found[:, CODE] = STUCK
        going = np.ones(len(instants), dtype=bool)
        for _ in range(MOST_STEPS):
            free, bound = rate + self.flight, np.where(gap + PREDICTED * rate <= 0.0, -self.restitution * rate, -np.inf)
            after = np.maximum(free, bound)
            impulse = after - free
            gap, rate = gap + self.theta * after + (1.0 - self.theta) * rate, after
            found[:, DEPTH] = np.where(going, np.maximum(found[:, DEPTH], -gap), found[:, DEPTH])
            found[:, PUSH] = np.where(going, np.maximum(found[:, PUSH], impulse), found[:, PUSH])
            found[:, STEPS] += going & (impulse > 0.0)
            hit = going & (found[:, STEPS] > 0)
            parted = hit & (impulse == 0.0) & (rate > 0.0) & ((gap > 0.0) | (self.flight == 0.0))
            found[parted, SPEED], found[parted, GAP], found[parted, CODE] = rate[parted], gap[parted], PARTED
            going &= ~(parted | (hit & (rate == 0.0) & (self.flight == 0.0)))
            if not going.any():
                break
        return found
