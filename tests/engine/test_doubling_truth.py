"""Period doublings of orbits with one impact a cycle against their closed formula, with and without damping."""

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, Excitation, Reference, System, continue_branch

from tests.share import share

CLOSE = 1e-10


class Closed:
    """ẍ + 2dẋ + x = cos ωt against a wall at σ, restitution e: the orbit with one impact in each cycle T = 2π/ω.

    With E the free motion over T, and h the part of the state that is free, h after the impact is (1 + e)V c,
    c = (E − 1)⁻¹(0, 1), V the closing speed. The forced part P = σ − (1 + e)V c₁, P′ = −V(e + (1 + e)c₂) has the
    amplitude γ of the linear response: P² + (P′/ω)² = γ², which is quadratic in V. The Poincaré map has the
    Jacobian E S,
    S = [[−e, 0], [(a⁺ + e a⁻)/V, −e]], a∓ the acceleration before and after the impact; it doubles where
    1 + tr + det = 0.
    """

    def __init__(self, omega, d, e):
        self.omega, self.d, self.e = omega, d, e
        cycle, own = 2 * np.pi / omega, np.sqrt(1 - d**2)
        self.gamma = 1 / np.hypot(1 - omega**2, 2 * d * omega)
        self.free = self.motion(cycle, own)
        self.c = np.linalg.solve(self.free - np.eye(2), [0.0, 1.0])

    def motion(self, t, own):
        """The free motion over a time, (2, 2)."""
        c, s = np.cos(own * t), np.sin(own * t) / own
        return np.exp(-self.d * t) * np.array([[c + self.d * s, s], [-s, c - self.d * s]])

    def speed(self, sigma):
        """The larger V; nan where there is no orbit with V > 0."""
        one, other = (1 + self.e) * self.c[0], (self.e + (1 + self.e) * self.c[1]) / self.omega
        a, b, c = one**2 + other**2, -2 * sigma * one, sigma**2 - self.gamma**2
        root = b**2 - 4 * a * c
        found = (-b + np.sqrt(root)) / (2 * a) if root > 0 else np.nan
        return found if found > 0 else np.nan

    def doubling(self, sigma):
        """1 + tr + det of the Poincaré map."""
        v, e, d, free = self.speed(sigma), self.e, self.d, self.free
        forced, rate = sigma - (1 + e) * v * self.c[0], -v * (e + (1 + e) * self.c[1])
        # P″ = −ω²P is the acceleration of the forced part; that of the free one is −2dh′ − h
        before = -(self.omega**2) * forced - 2 * d * (v - rate) - (sigma - forced)
        after = -(self.omega**2) * forced - 2 * d * (-e * v - rate) - (sigma - forced)
        trace = -e * (free[0, 0] + free[1, 1]) + free[0, 1] * (after + e * before) / v
        return 1 + trace + e**2 * np.linalg.det(free)

    def state(self, sigma):
        """x and x′ where cos ωt = 1."""
        v, e = self.speed(sigma), self.e
        forced, rate = sigma - (1 + e) * v * self.c[0], -v * (e + (1 + e) * self.c[1])
        delay = np.arctan2(2 * self.d * self.omega, 1 - self.omega**2)  # P = γ cos(ωt − delay)
        phase = np.arctan2(-rate / self.omega, forced)  # of P right at the impact
        left = (-(phase + delay) % (2 * np.pi)) / self.omega  # from the impact to the next maximum of the force
        own = np.sqrt(1 - self.d**2)
        h = self.motion(left, own) @ ((1 + e) * v * self.c)
        return h + self.gamma * np.array([np.cos(delay), self.omega * np.sin(delay)])


def cases(count):
    """Random ω, d and e, and the clearance at which the orbit doubles its period."""
    random, found = np.random.default_rng(5), []
    while len(found) < count:
        omega, e = random.uniform(2.1, 3.6), random.uniform(0.5, 0.95)
        d = random.uniform(0.0, 0.1) if len(found) % 2 else 0.0
        orbit = Closed(omega, d, e)
        sigma = np.linspace(-0.9, 2.0, 400) * orbit.gamma
        values = np.array([orbit.doubling(each) for each in sigma])
        for k in np.flatnonzero(values[:-1] * values[1:] < 0)[:1]:
            low, high = sigma[k], sigma[k + 1]
            for _ in range(200):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if orbit.doubling(middle) * values[k] > 0 else (low, middle)
            found += [(omega, d, e, low)] * bool(abs(orbit.doubling(low)) < 1e-9)
    return found


@pytest.mark.parametrize(("omega", "d", "e", "sigma"), cases(share(50)))
def test_an_orbit_with_one_impact_doubles_its_period_where_the_closed_formula_says(omega, d, e, sigma):
    orbit, size = Closed(omega, d, e), 1 / np.hypot(1 - omega**2, 2 * d * omega)
    near, reach = sigma + 0.002 * size, {"low": sigma - 0.01 * size, "high": sigma + 0.01 * size}
    force = Excitation(base=0.0, force1=1.0)
    system = System(wall=True, d1=d, clearance=near, restitution=e, excitation=force)
    start = (*orbit.state(near), 0.0, 0.0)
    branch = continue_branch(
        BranchQuestion(system, omega, Reference(threshold=0), over="clearance", **reach, initial=start, max_period=1)
    )
    found = [point.value for point in branch.points if point.kind == "period doubling"]
    assert min(abs(value - sigma) for value in found) < CLOSE * size
