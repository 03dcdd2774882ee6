"""A body without a spring beside a wall, a ball on a table: closed forms, an own event loop in 40 digits, units."""

import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from vibroscope.engine import (
    BranchQuestion,
    ExactPenalty,
    Excitation,
    Newmark,
    Record,
    Reference,
    System,
    TimeStepping,
    continue_branch,
    motion,
    physical_entry,
    read_system,
    repetition,
    simulate,
    steady,
    system_of_physical,
)
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.integrators import HHT, Bathe

EXACT = 1e-12
WEIGHT = 0.7
TABLE = {  # a ball of 1 g on a table that is shaken at 60 Hz
    "mass1_kg": 1e-3,
    "wall": True,
    "constant1_N": 9.81e-3,
    "restitution": 0.5,
    "base_amplitude_mm": 0.1,
    "frequency_Hz": 60.0,
}


def ball(*, height=0.0, weight=WEIGHT, base=0.0, **more):
    """A ball above a table, in a unit of time of its own."""
    return System(
        wall=True,
        **{"spring1": 0.0, "d1": 0.0, "clearance": height} | more,
        excitation=Excitation(base=base, constant1=weight),
    )


def test_a_bouncing_ball_comes_to_rest_at_the_instant_of_the_geometric_sum():
    height, e = 3.0, 0.5
    run = simulate(
        ball(height=height), 1.0, Reference(threshold=0.0), periods=4, keep=4, initial=(0, 0, 0, 0), record=Record()
    )
    fall, speed = math.sqrt(2 * height / WEIGHT), math.sqrt(2 * WEIGHT * height)
    flights = 2 * speed / WEIGHT * e ** np.arange(1, 9)
    np.testing.assert_allclose(run.impacts.time[:9], fall + np.concatenate([[0], np.cumsum(flights)]), rtol=EXACT)
    np.testing.assert_allclose(run.contacts, [[fall * (1 + e) / (1 - e), run.window[1]]], rtol=EXACT)
    assert run.trajectory.force[-1] == WEIGHT
    assert run.section[-1].tolist() == [height, 0, 0, 0]


def test_a_thrown_ball_without_weight_flies_straight():
    run = simulate(
        ball(height=2.0, weight=0.0, restitution=0.8), 1.0, Reference(), periods=2, keep=2, initial=(0, 0.5, 0, 0)
    )
    assert run.impacts.time.tolist() == pytest.approx([4.0], rel=EXACT)
    np.testing.assert_allclose(run.section[-1][:2], [2.0 - 0.4 * (4 * math.pi - 4.0), -0.4], rtol=EXACT)


@pytest.mark.parametrize("c", [1e-9, 0.01, 0.6, 1.9])
def test_a_damper_alone(c):
    run = simulate(ball(height=100.0, d1=c / 2), 1.0, Reference(), periods=2, keep=2, initial=(0, 0, 0, 0))
    t = run.period * mp.mpf(2)
    with mp.workdps(40):
        fallen = WEIGHT / mp.mpf(c) * (t - (1 - mp.exp(-c * t)) / c)
    assert run.section[-1][0] == pytest.approx(float(fallen), rel=EXACT)


@pytest.mark.parametrize("k1", [1.0, 1e-3, 1e-8, 1e-14])
def test_a_weak_spring_and_a_weight_lose_no_digits(k1):
    run = simulate(ball(height=3.0, weight=50.0, spring1=k1), 1.0, Reference(), periods=1, keep=1, initial=(0, 0, 0, 0))
    with mp.workdps(40):
        rate = mp.sqrt(k1)
        touch = mp.acos(1 - 3 * rate**2 / 50) / rate
    assert run.impacts.time[0] == pytest.approx(float(touch), rel=1e-14)


def test_a_penalty_contact_under_weight_lasts_its_closed_time():
    K, speed = 400.0, 2.0
    run = simulate(ball(), 1.0, ExactPenalty(K, 0.0), periods=1, keep=1, initial=(0, speed, 0, 0))
    rate = math.sqrt(K)
    lasts = 2 / rate * (math.pi - math.atan(speed * rate / WEIGHT))
    flies = 2 * speed / WEIGHT
    np.testing.assert_allclose(run.contacts[0], [0, lasts], rtol=EXACT, atol=EXACT)
    assert run.contacts[1][0] == pytest.approx(lasts + flies, rel=EXACT)


class Twin:
    """Impacts of a ball on a table b = B cos τ, absolute height Y″ = p, by bisection in 40 digits."""

    def __init__(self, base, weight, e):
        self.base, self.weight, self.e = mp.mpf(base), mp.mpf(weight), mp.mpf(e)

    def gap(self, start, t):
        begin, y, v = start
        return self.base * mp.cos(t) - (y + v * (t - begin) + self.weight * (t - begin) ** 2 / 2)

    def impacts(self, xi, rate, count):
        """Instants and closing speeds."""
        start, found = (mp.mpf(0), mp.mpf(xi) + self.base, mp.mpf(rate)), []
        while len(found) < count:
            t = start[0] + mp.mpf("1e-6")
            while self.gap(start, t + mp.mpf("0.01")) > 0:
                t += mp.mpf("0.01")
            t = mp.findroot(lambda at: self.gap(start, at), (t, t + mp.mpf("0.01")), solver="anderson", tol=1e-70)  # noqa: B023
            speed, wall = start[2] + self.weight * (t - start[0]), -self.base * mp.sin(t)
            found.append((t, speed - wall))
            start = t, self.base * mp.cos(t), wall - self.e * (speed - wall)
        return np.array(found, dtype=float)


def test_a_ball_on_a_shaken_table_meets_it_when_its_twin_does():
    system = ball(base=1.0, weight=0.4, restitution=0.9)
    run = simulate(system, 1.0, Reference(threshold=0.0), periods=12, keep=12, initial=(-0.8, -0.3, 0, 0))
    with mp.workdps(40):
        times, speeds = Twin(1.0, 0.4, 0.9).impacts(-0.8, -0.3, 5).T
    np.testing.assert_allclose(run.impacts.time[:5], times, rtol=EXACT)
    np.testing.assert_allclose(run.impacts.closing_speed[:5], speeds, rtol=1e-11)
    balance = energy_balance(run, (-0.8, -0.3, 0, 0))
    assert np.abs(balance.residual).max() < 1e-12 * balance.stored


def orbit_of_one_impact(base, weight, e):
    """ξ₁, ξ₁′ at τ = 0 of the stable orbit with one impact a period, and the trace of its Poincaré map."""
    theta = math.pi - math.asin((1 - e) / (1 + e) * math.pi * weight / base)
    t = 2 * math.pi - theta
    y = base * math.cos(theta) - weight * math.pi * t + weight * t**2 / 2
    return (y - base, weight * (t - math.pi), 0.0, 0.0), 1 + e**2 + (1 + e) ** 2 * base * math.cos(theta) / weight


def test_the_multipliers_of_one_impact_a_period():
    system, *_ = system_of_physical(TABLE)
    start, trace = orbit_of_one_impact(1.0, system.excitation.constant1, 0.5)
    found = steady(system, 1.0, Reference(), initial=start)
    assert found.period == 1
    np.testing.assert_allclose(found.state, start, atol=1e-10)
    roots = np.roots([1, -trace, 0.25])
    np.testing.assert_allclose(np.sort_complex(found.multipliers[:2]), np.sort_complex(roots), rtol=1e-9)


def test_the_branch_of_one_impact_doubles_and_folds_where_the_closed_form_does():
    """At 60 Hz and e = 0.5 from 0.072283 to 0.105389 mm."""
    system, units, *_ = system_of_physical(TABLE)
    weight, e = system.excitation.constant1, 0.5
    start, _ = orbit_of_one_impact(0.9, weight, e)
    system = system.changed({"base": 0.9})
    branch = continue_branch(BranchQuestion(system, 1.0, Reference(), over="base", low=0.7, high=1.15, initial=start))
    fold = (1 - e) / (1 + e) * math.pi * weight
    doubling = math.hypot(fold, 2 * (1 + e**2) / (1 + e) ** 2 * weight)
    assert (fold, doubling) == (pytest.approx(0.72283, abs=1e-5), pytest.approx(1.05389, abs=1e-5))
    found = {point.kind: point.value for point in branch.points}
    assert found["fold"] == pytest.approx(fold, rel=1e-9)
    assert found["period doubling"] == pytest.approx(doubling, rel=1e-9)
    assert units.base_amplitude == 0.1


METHODS = {
    "reference": (Reference(threshold=0.0),) * 2,
    "exact": (ExactPenalty(900.0, 4.0),) * 2,
    "hunt-crossley": (
        ExactPenalty(900.0, 8.0, law="hunt-crossley"),
        ExactPenalty(900.0 / 2**0.5, 8.0 / 2**1.5, law="hunt-crossley"),
    ),
    "newmark": (Newmark(900.0, 4.0, 4000),) * 2,
    "newmark, every step": (Newmark(900.0, 4.0, 4000, every_step=True),) * 2,
    "located": (Newmark(900.0, 4.0, 400, located=True),) * 2,
    "hht, end": (TimeStepping(900.0, 4.0, 400, HHT(), status="end", without_solution="keep"),) * 2,
    "bathe": (TimeStepping(900.0, 4.0, 4000, Bathe()),) * 2,
}


@pytest.mark.parametrize("name", METHODS)
def test_counted_from_touch_a_motion_is_what_it_is_counted_from_rest(name):
    """The same system in two units of length: in the smaller one its rest lies too far away to count from."""
    near = System(wall=True, d1=0.05, excitation=Excitation(base=1.0, constant1=20.0))
    far = replace(near, excitation=Excitation(base=2.0, constant1=40.0))
    assert (near.rests_afar, far.rests_afar) == (False, True)
    one, other = (
        simulate(system, 6.0, method, periods=4, keep=4)
        for system, method in zip((near, far), METHODS[name], strict=True)
    )
    assert len(one.impacts.time) > 0
    np.testing.assert_allclose(2 * one.section, other.section, atol=1e-10)


@pytest.mark.parametrize("name", [name for name in METHODS if name != "hunt-crossley"])
def test_the_unit_of_time_changes_no_motion(name):
    def slower(method):  # the same in a unit of time of half the length
        if method.rigid:
            return method
        return replace(method, stiffness=method.stiffness / 4, damping=method.damping / 2)

    own = System(wall=True, d1=0.07, clearance=0.5, excitation=Excitation(base=1.0, constant1=0.3))
    other = replace(own, spring1=0.25, d1=0.035, excitation=Excitation(base=1.0, constant1=0.075))
    method = METHODS[name][0]
    first, second = (
        simulate(system, eta, solver, periods=4, keep=4)
        for system, eta, solver in ((own, 2.4, method), (other, 1.2, slower(method)))
    )
    np.testing.assert_allclose(first.section, second.section * [1, 2, 1, 1], atol=1e-11)


def test_where_a_ball_rests():
    assert ball(height=2.0).rest == (2.0, 0.0, 0.0, 0.0)  # on the table
    assert ball(height=2.0, weight=-1.0).rest == (0.0, 0.0, 0.0, 0.0)  # pulled off it: nowhere
    assert ball(height=2.0, weight=0.0).rest == (0.0, 0.0, 0.0, 0.0)  # anywhere


# -- in physical units -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spring", [{}, {"stiffness1_N_per_m": 0.0}])
def test_without_a_spring_time_is_counted_by_the_excitation(spring):
    system, units, eta, _ = system_of_physical(TABLE | spring)
    assert (system.spring1, eta, units.omega1) == (0.0, 1.0, pytest.approx(120 * math.pi))
    assert system.excitation.constant1 == pytest.approx(9.81 / (1e-4 * units.omega1**2))


def test_without_a_frequency_time_is_counted_by_length_and_acceleration():
    entry = {"mass1_kg": 2.0, "wall": True, "clearance_mm": 500.0, "constant1_N": 19.62}
    system, units, eta, _ = system_of_physical(entry)
    assert (eta, 1e-3 * units.base_amplitude * units.omega1**2) == (None, pytest.approx(9.81))
    assert (system.clearance, system.excitation.constant1) == (1.0, pytest.approx(1.0))
    with pytest.raises(ValueError, match="time_s is missing: time of a body without a spring is counted in it"):
        system_of_physical({"mass1_kg": 2.0, "wall": True, "clearance_mm": 500.0})


@pytest.mark.parametrize("more", [{}, {"damping1_Ns_per_m": 0.05}, {"time_s": 0.01}, {"clearance_mm": -0.3}])
def test_an_entry_without_a_spring_comes_back(more):
    found = system_of_physical(TABLE | more)
    again = system_of_physical(physical_entry(found.system, found.units, found.eta))
    assert again.units.omega1 == pytest.approx(found.units.omega1, rel=1e-14)
    for name, value in found.system.as_dict().items():
        assert again.system.as_dict()[name] == pytest.approx(value, rel=1e-14), name


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (
            {"damping1_ratio": 0.1},
            "damping1_ratio of a body without a spring: give stiffness1_N_per_m or frequency1_Hz",
        ),
        ({"damping1_Ns_per_m": 1.0}, r"damping1_Ns_per_m must be from 0 to below 0.753982 N·s/m beside a unit of time"),
        ({"stiffness1_N_per_m": 5.0, "time_s": 0.1}, "time_s beside a spring"),
    ],
)
def test_what_goes_with_no_spring(more, words):
    with pytest.raises(ValueError, match=words):
        system_of_physical(TABLE | more)


def test_a_file_that_names_no_spring_is_told_what_is_taken(tmp_path):
    file = tmp_path / "ball.toml"
    file.write_text("[physical]\n" + "\n".join(f"{name} = {str(value).lower()}" for name, value in TABLE.items()))
    assert "it is free, and time is counted in 0.002653 s, 1/(2 pi frequency_Hz)" in read_system(file).assumed[0]


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(1e3, 2.0), Newmark(1e3, 2.0, 200)])
@pytest.mark.parametrize(
    ("system", "start"),
    [
        (
            System(mu=1.0, spring1=0.0, d1=0.0, kappa=0.0, d2=0.0, d3=None, excitation=Excitation(base=0.0)),
            (0, 1, 0, -1),
        ),
        (System(wall=True, spring1=0.0, d1=0.0), (0.0, -1.0, 0.0, 0.0)),
        (System(wall=True, spring1=0.0, d1=0.0, excitation=Excitation(constant1=-0.5)), (-1.0, 0.0, 0.0, 0.0)),
    ],
)
def test_bodies_that_nothing_pulls_back_are_not_chaotic(system, start, method):
    found = motion(system, 1.0, method, initial=start)
    assert (found.type, repetition(found)) == ("undecided", "does not repeat")
    assert found.reason == "nothing pulls the bodies back: they part, and do not meet again"
