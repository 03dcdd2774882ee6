"""Plain twins of the contact laws: λ as its source writes it, and a motion by DOP853 from touch to touch."""

import math

import numpy as np
from scipy.integrate import solve_ivp

from tests.naive import drive

# An event and the state there are read off an interpolant, which is less exact than the steps: so they are short.
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.01}


def force(method, gain, depth, speed, sides=None):
    """λ of a penetration and its rate; ``gain``: c, or h of the laws that have it.

    ``sides``: of "impact", whether its damping is full and whether it is cut at zero (1, else −1), of "jankowski",
    whether the bodies part, where the formula of these sides shall go on beyond them.
    """
    law, k, n = method.law, method.stiffness, method.exponent
    if law == "kelvin-voigt":
        return k * depth + gain * speed
    if law == "cut":
        return max(0.0, k * depth + gain * speed)
    if law == "limited":
        return k * depth + min(max(gain * speed, -k * depth), k * depth)
    if law == "compression":
        return k * depth + (gain * speed if speed > 0 else 0.0)
    if law == "bilinear":
        knee = method.penetration
        return k * min(depth, knee) + method.stiffening * k * max(depth - knee, 0.0) + gain * speed
    depth = max(depth, 0.0)
    if law in ("hunt-crossley", "lankarani-nikravesh", "flores"):
        return k * depth**n * (1 + gain * speed)
    if law == "jankowski":
        closing = speed > 0 if sides is None else sides[0] < 0
        return k * depth**1.5 + (gain * depth**0.25 * speed if closing else 0.0)
    if law == "constant-restitution":
        return k * depth**n + gain * depth ** ((n - 1) / 2) * speed
    x = depth / method.penetration
    if x > 1.0 if sides is None else sides[0] > 0:
        x = 1.0
    inner = k * depth**n + gain * (3 * x**2 - 2 * x**3) * speed
    return 0.0 if (inner < 0 if sides is None else sides[1] > 0) else inner


def gain_of(method, e, m, closing):
    """The damper of a law whose D is None, each formula as in its source; else by D."""
    law, k, n = method.law, method.stiffness, method.exponent
    if method.damping is not None:
        h = law in ("hunt-crossley", "lankarani-nikravesh", "flores")
        return 2 * method.damping / (k if h else 1.0)
    if law == "hunt-crossley":
        return 3 / 2 * (1 - e) / closing
    if law == "lankarani-nikravesh":
        return 3 / 4 * (1 - e**2) / closing
    if law == "flores":
        return 8 / 5 * (1 - e) / e / closing
    if law == "jankowski":
        xi = 9 * math.sqrt(5) / 2 * (1 - e**2) / (e * (e * (9 * math.pi - 16) + 16))
        return 2 * xi * math.sqrt(k * m)
    alpha = math.sqrt(2 * (n + 1)) * -math.log(e) / math.sqrt(math.pi**2 + math.log(e) ** 2)
    return alpha * math.sqrt(m * k)


class Motion:
    """A motion from touch to touch: ξ₁, ξ₁′, ξ₂, ξ₂′; beside a wall the last two stay zero.

    Under a harmonic load it begins apart. Under another one, :class:`engine.Load`, ``eta`` is not read, and it begins
    anew where the load bends.
    """

    def __init__(self, system, eta, method, load=None):
        self.system, self.eta, self.method = system, eta, method
        self.mu = 1.0 if system.wall else system.mass_ratio
        self.m = 1.0 if system.wall else self.mu / (1 + self.mu)
        self.driven = drive(system, eta)
        self.contacts, self.impulses = [], []
        self.load, self.corner = load, 0

    def driving(self, t):
        """What drives each body at τ, per mass."""
        (one, p1), (two, p2) = self.driven
        if self.load is None:
            cosine, sine = math.cos(self.eta * t), math.sin(self.eta * t)
            return one[0] * cosine + one[1] * sine + p1, two[0] * cosine + two[1] * sine + p2
        begin, value, slope = self.load.segments[self.corner]
        angle, t = self.load.frequency * (t - begin), t - begin
        now = value * math.cos(angle) - slope * math.sin(angle) if self.load.frequency else value + slope * t
        shares = {"base": (-1.0, -1.0), "force1": (1.0, 0.0), "force2": (0.0, 1.0 / self.mu)}[self.load.on]
        return p1 + shares[0] * now, p2 + shares[1] * now

    def rates(self, t, y, gain, sides):
        c = self.system
        x1, v1, x2, v2, _ = y
        driven1, driven2 = self.driving(t)
        push = 0.0 if gain is None else force(self.method, gain, x1 - x2 - c.clearance, v1 - v2, sides)
        a1 = driven1 - 2 * c.d1 * v1 - x1 - push
        a2 = driven2 - 2 * c.d2 * c.kappa * v2 - c.kappa**2 * x2 + push / self.mu
        return [v1, a1, 0.0, 0.0, push] if c.wall else [v1, a1, v2, a2, push]

    def run(self, start, end):
        """The state at τ = ``end``; contacts and their impulses are noted."""
        t, begun, y, gain, sides = 0.0, 0.0, np.array([*start, 0.0]), None, [-1.0, -1.0]
        law = self.method.law

        def gap(t, y, gain, sides):
            return self.system.clearance + y[2] - y[0]

        def full(t, y, gain, sides):  # "impact": whether its damping is full, and whether it is cut at zero
            return -gap(t, y, gain, sides) - self.method.penetration

        def cut(t, y, gain, sides):
            depth = -gap(t, y, gain, sides)
            if gain is None or depth <= 0:
                return -1.0
            x = min(depth / self.method.penetration, 1.0)
            damper = gain * (3 * x**2 - 2 * x**3) / depth**self.method.exponent
            return -self.method.stiffness - damper * (y[1] - y[3])

        def parting(t, y, gain, sides):  # "jankowski": whether the bodies part
            return -1.0 if gain is None else y[3] - y[1]

        kinks = (full, cut) if law == "impact" else (parting,) if law == "jankowski" else ()
        for each in (gap, *kinks):
            each.terminal = True
        corners = [] if self.load is None else self.load.segments[1:, 0].tolist()
        if self.load is not None and gap(0.0, y, None, sides) <= 0:
            gain = gain_of(self.method, self.system.restitution, self.m, 0.0)
        while True:
            until = min([end, *corners[self.corner :][:1]])
            gap.direction = -1.0 if gain is None else 1.0
            for kink, side in zip(kinks, sides, strict=False):
                kink.direction = -side
            # short where a force sets in: all stages of a long step may lie beyond the end of a contact
            first = min(1e-6, 0.5 * (until - t)) if gain is not None else None
            options = {"events": (gap, *kinks), "args": (gain, sides), "first_step": first}
            found = solve_ivp(self.rates, (t, until), y, **options, **TIGHT)
            assert found.status >= 0, found.message  # a failure of the solver is no end of a contact
            t, y = found.t[-1], found.y[:, -1]
            if found.status == 0:
                if until == end:
                    return y[:4]
                self.corner += 1
                continue
            if not found.t_events[0].size:  # a kink: on from there, with steps that do not reach over it
                sides = [-side if times.size else side for side, times in zip(sides, found.t_events[1:], strict=False)]
                continue
            sides = [-1.0, -1.0]
            if gain is None:
                begun, y[4] = t, 0.0
                gain = gain_of(self.method, self.system.restitution, self.m, y[1] - y[3])
            else:
                self.contacts.append((begun, t))
                self.impulses.append(y[4])
                gain = None
