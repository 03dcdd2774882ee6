"""The law of a spring of two stiffnesses: closed form to forty digits, energy, limits, steps, cells, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from vibroscope.engine import (
    Cells,
    ExactPenalty,
    Excitation,
    HHTInterpolated,
    NewmarkBeta,
    System,
    TimeStepping,
    damping_of_restitution,
    restitution_of_damping,
    run_cells,
    simulate,
    steady,
)
from vibroscope.engine.contact import spring_duration, spring_energy
from vibroscope.engine.energy.balance import energy_balance

from tests.naive import drive, matrices_of

LAW = {"law": "bilinear", "penetration": 0.02, "stiffening": 4.0}
APART = (0.0, 0.0, 1.0, -1.0)
WALL = System(wall=True, d1=0.05, clearance=0.4, excitation=Excitation(base=0.0, force1=2.0, constant1=0.3))
CASES = [
    (System(), 2.76, APART, 8.0),
    (System(mu=0.6, clearance=0.2), 1.3, APART, 0.0),
    (WALL, 1.3, (0.0, 0.5, 0.0, 0.0), 8.0),
]
FLIGHT, SOFT, STIFF = range(3)
STEP = "0.005"  # within which no piece begins and ends


class Truth:
    """The motion to forty digits: y = (ξ₁, ξ₂, ξ₁′, ξ₂′, cos ητ, sin ητ, 1) is linear in each piece."""

    def __init__(self, system, eta, method):
        self.knee, self.clearance, self.contacts = mpf(method.penetration), mpf(system.clearance), []
        k, c, r = mpf(method.stiffness), 2 * mpf(method.damping), mpf(method.stiffening)
        self.generators = [self.generator(system, eta, 0, 0, 0), self.generator(system, eta, k, c, 0)]
        self.generators.append(self.generator(system, eta, r * k, c, (1 - r) * k * self.knee))
        self.step = mpf(STEP)
        self.steps = [mp.expm(a * self.step, method="taylor") for a in self.generators]

    def generator(self, system, eta, k, c, push):
        """Of a piece with the contact force kδ + cδ′ + push, δ = ξ₁ − ξ₂ − clearance."""
        mass, dampers, springs = matrices_of(system)
        loads, a = drive(system, eta), mp.zeros(7)
        a[0, 2], a[1, 3], a[4, 5], a[5, 4] = 1, 1, -mpf(eta), mpf(eta)
        for i in range(1 if system.wall else 2):
            m, side, ((cosine, sine), constant) = mpf(mass[i, i]), (-1, 1)[i], loads[i]
            a[2 + i, i], a[2 + i, 2 + i] = -mpf(springs[i, i]) / m, -mpf(dampers[i, i]) / m
            for j, sign in ((0, 1), (1, -1)):
                a[2 + i, j] += side * sign * k / m
                a[2 + i, 2 + j] += side * sign * c / m
            a[2 + i, 4], a[2 + i, 5] = mpf(cosine), mpf(sine)
            a[2 + i, 6] = mpf(constant) + side * (push - k * self.clearance) / m
        if system.wall:
            a[1, 3] = 0
        return a

    def depth(self, y):
        return y[0] - y[1] - self.clearance

    def piece(self, y):
        depth = self.depth(y)
        return FLIGHT if depth < 0 else SOFT if depth < self.knee else STIFF

    def run(self, start, end):
        """The state at τ = ``end``: ξ₁, ξ₁′, ξ₂, ξ₂′."""
        x1, v1, x2, v2 = map(mpf, start)
        tau, y, end = mpf(0), mp.matrix([x1, x2, v1, v2, 1, 0, 1]), mpf(end)
        piece = self.piece(y)
        while tau < end:
            left = end - tau
            whole = left > self.step
            after = (self.steps[piece] if whole else mp.expm(self.generators[piece] * left)) * y
            size, then = min(self.step, left), self.piece(after)
            if then != piece:
                level = self.knee if piece == STIFF or (piece, then) == (SOFT, STIFF) else mpf(0)
                size = self.crossing(piece, y, level, size)
                after = mp.expm(self.generators[piece] * size) * y
                then = {FLIGHT: SOFT, STIFF: SOFT}.get(piece, STIFF if level else FLIGHT)
                if FLIGHT in (piece, then):
                    self.contacts.append(tau + size)
            tau, y, piece = tau + size, after, then
        return [float(y[i]) for i in (0, 2, 1, 3)]

    def crossing(self, piece, y, level, size):
        """When the penetration passes a level: bisection, then Newton's method."""

        def excess(t):
            return self.depth(mp.expm(self.generators[piece] * t) * y) - level

        low, high, sign = mpf(0), size, mp.sign(excess(size))
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (low, middle) if mp.sign(excess(middle)) == sign else (middle, high)
        return mp.findroot(excess, (low, high), solver="secant", tol=mpf(10) ** -60)


@pytest.mark.parametrize(("system", "eta", "start", "damping"), CASES, ids=["paper", "apart", "wall"])
def test_the_motion_is_that_of_forty_digits(system, eta, start, damping):
    method = ExactPenalty(1200.0, damping, **LAW)
    run = simulate(system, eta, method, periods=1, keep=1, initial=start)
    with mp.workdps(40):
        truth = Truth(system, eta, method)
        expected = truth.run(start, run.period)
    found = run.contacts.ravel()
    assert len(truth.contacts) >= 2
    np.testing.assert_allclose(found[: len(truth.contacts)], np.array(truth.contacts, float), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.section[-1], expected, rtol=0, atol=3e-12 * max(1.0, np.abs(expected).max()))


def contact_alone(k, c, r, knee, mass, closing):
    """Duration and restitution of a contact alone, from zeros of its three parts' closed forms."""
    k, c, r, knee, mass, v = map(mpf, (k, c, r, knee, mass, closing))

    def part(stiffness, middle, depth, speed, level):
        """When the motion about ``middle`` first comes to a level after its start, and its speed there."""
        decay = c / (2 * mass)
        omega = mp.sqrt(stiffness / mass - decay**2)
        a, b = depth - middle, (speed + decay * (depth - middle)) / omega

        def at(t):
            return mp.exp(-decay * t) * (a * mp.cos(omega * t) + b * mp.sin(omega * t)) + middle

        t = mp.pi / omega * mpf("1e-6")
        while mp.sign(at(t) - level) == mp.sign(at(t + mp.pi / omega / 500) - level):
            t += mp.pi / omega / 500
        t = mp.findroot(lambda t: at(t) - level, (t, t + mp.pi / omega / 500), solver="anderson")
        return t, mp.diff(at, t)

    first, v1 = part(k, mpf(0), mpf(0), v, knee)
    second, v2 = part(r * k, knee - knee / r, knee, v1, knee)
    third, v3 = part(k, mpf(0), knee, v2, mpf(0))
    return first + second + third, -v3 / v


@pytest.mark.parametrize("closing", [0.7, 3.0])
@pytest.mark.parametrize("r", [1.5, 40.0])
def test_duration_and_restitution_are_those_of_the_closed_form(closing, r):
    k, knee, mass, numbers = 900.0, 0.01, 0.7, {"penetration": 0.01, "stiffening": r}
    with mp.workdps(40):
        undamped, _ = contact_alone(k, 0.0, r, knee, mass, closing)
        _, restitution = contact_alone(k, 5.0, r, knee, mass, closing)
    found = restitution_of_damping("bilinear", 2.5, k, mass=mass, closing_speed=closing, **numbers)
    assert found == pytest.approx(float(restitution), rel=1e-11)
    again = damping_of_restitution("bilinear", found, k, mass=mass, closing_speed=closing, **numbers)
    assert again == pytest.approx(2.5, rel=1e-8)
    system = System(mu=mass / (1 - mass))
    method = ExactPenalty(k, 0.0, "bilinear", **numbers)
    assert spring_duration(system.mass_share, method, closing) == pytest.approx(float(undamped), rel=1e-13)


def test_a_contact_that_does_not_reach_the_knee_is_spring_and_damper():
    shallow = ExactPenalty(1200.0, 8.0, "bilinear", penetration=5.0, stiffening=4.0)
    runs = [simulate(System(), 2.76, method, periods=5, keep=5) for method in (shallow, ExactPenalty(1200.0, 8.0))]
    np.testing.assert_allclose(runs[0].section, runs[1].section, rtol=0, atol=1e-12)
    linear = spring_duration(System().mass_share, ExactPenalty(1200.0, 8.0), 1.0)
    assert spring_duration(System().mass_share, shallow, 1.0) == pytest.approx(linear, rel=1e-15)
    at_once = ExactPenalty(300.0, 8.0, "bilinear", penetration=1e-13, stiffening=4.0)
    other = simulate(System(), 2.76, at_once, periods=2, keep=2)
    np.testing.assert_allclose(other.section, runs[1].section[:2], rtol=0, atol=1e-9)


def test_the_spring_stores_what_its_force_does():
    method = ExactPenalty(700.0, 2.0, "bilinear", penetration=0.01, stiffening=3.0)
    depth = np.linspace(0.0, 0.03, 30_001)
    force = 700.0 * depth + 2.0 * 700.0 * np.maximum(depth - 0.01, 0.0)
    assert spring_energy(method, -depth[-1:])[0] == pytest.approx(np.trapezoid(force, depth), rel=1e-8)
    assert spring_energy(method, np.array([0.1, -0.005])) == pytest.approx([0.0, 0.5 * 700.0 * 0.005**2])


@pytest.mark.parametrize("system", [System(), WALL], ids=["two", "wall"])
def test_work_is_stored_or_lost(system):
    balance = energy_balance(simulate(system, 2.76, ExactPenalty(1200.0, 8.0, **LAW), periods=20, keep=20), system.rest)
    np.testing.assert_allclose(balance.work, balance.gain + balance.lost, atol=1e-10 * balance.stored)
    free = energy_balance(simulate(system, 2.76, ExactPenalty(1200.0, 0.0, **LAW), periods=20, keep=20), system.rest)
    assert np.abs(free.contact).max() < 1e-10 * free.stored


@pytest.mark.parametrize("integrator", [NewmarkBeta(), HHTInterpolated(-0.1)], ids=repr)
def test_located_steps_tend_to_it_to_second_order(integrator):
    exact = simulate(System(), 2.76, ExactPenalty(1200.0, 8.0, **LAW), periods=2, keep=1, initial=APART).section[-1]
    errors = []
    for steps in (2000, 4000, 8000):
        method = TimeStepping(1200.0, 8.0, steps, integrator, "located", **LAW)
        found = simulate(System(), 2.76, method, periods=2, keep=1, initial=APART).section[-1]
        errors.append(np.abs(found - exact).max())
    assert np.diff(-np.log2(errors)) == pytest.approx([2.0, 2.0], abs=0.3)


def test_cells_are_single_runs_and_a_steady_motion_repeats():
    etas, stiffnesses, dampings = [1.3, 2.76, 3.1], [1200.0, 900.0, 700.0], [8.0, 2.0, 0.0]
    for method in (ExactPenalty(1.0, 1.0, **LAW), TimeStepping(1.0, 1.0, 2000, **LAW)):
        cells = run_cells(Cells(System(), etas, method, stiffnesses, dampings), transient=4, sample=2)
        for eta, k, d, section in zip(etas, stiffnesses, dampings, cells.section, strict=True):
            alone = simulate(System(), eta, replace(method, stiffness=k, damping=d), periods=6, keep=2)
            np.testing.assert_array_equal(section, alone.section)
    assert steady(System(d1=0.2, d2=0.2), 2.76, ExactPenalty(1200.0, 8.0, **LAW)).periodic
