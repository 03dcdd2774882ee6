"""Plain twin of one-step methods with other laws than spring and damper: λ of a stage by Brent's method."""

import math

from scipy.optimize import brentq

from tests.naive_laws import force, gain_of
from tests.naive_stepping import Twin

EXACT = {"xtol": 1e-300, "rtol": 4 * 2.0**-52}
WIDER = 2.0  # a bracket than [0, L(−g₀, −r₀)]: rounding may decide at its end, and a law that pulls may rise


class LawTwin(Twin):
    """One run that begins apart; contact is a force that is tried until it is that of the law."""

    def __init__(self, system, eta, method):
        super().__init__(system, eta, method)
        self.reduced = 1.0 if system.wall else self.mu / (1 + self.mu)
        self.given, self.closing, self.closed = 0.0, 0.0, False

    def law(self, x, v):
        gain = gain_of(
            self.method, self.system.restitution, self.reduced, self.closing if self.closing > 0 else math.inf
        )
        depth, speed, name = -self.gap(x), v[0] - v[1], self.method.law
        if name == "constant-restitution" and self.method.exponent == 1.0:
            return self.method.stiffness * depth + gain * speed
        # a law that jumps at touch goes on beyond it, within a step; the others are zero there
        return force(self.method, gain, depth if name in ("compression", "bilinear") else max(depth, 0.0), speed)

    def spring_and_damper(self, x, v):
        """What a stage asks for: the force that is tried; an explicit method knows both numbers before."""
        self.seen = x, v
        known = self.method.integrator.name in ("central-difference", "semi-implicit-euler")
        return self.law(x, v) if known else self.given

    def stages(self, state, tau, status_of):
        x, v, _, former = state
        closed = self.gap(x) <= 0
        if not closed or (former == 0 and not self.closed):  # no force has acted: the speed before it may begin
            self.closing = v[0] - v[1]
        self.closed = closed
        yield from super().stages(state, tau, lambda end: status_of(lambda status: self.solved(end, status)))

    def solved(self, end, status):
        """The end of a stage with the force of the law, or without."""

        def excess(push):
            self.given = push
            end(True)
            return push - self.law(*self.seen)

        first = -excess(0.0) if status else 0.0
        last = WIDER * first
        while first and excess(last) * first < 0:
            last *= WIDER
        self.given = brentq(excess, *sorted((0.0, last)), **EXACT) if first else 0.0
        return end(True)
