"""Steady motion: the Jacobian against differences, and the orbits against the long runs that they replace."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Newmark, Record, Reference, System, motion, simulate, steady
from vibroscope.engine.drivers.event_driven import LinearFlow, set_up

SYSTEM = System()
WIDTH = 1e-6  # of a difference; the error of a central one is of the order of its square


def map_state(system, y, periods):
    flow = LinearFlow(system)
    end, jacobian, _ = flow.with_jacobian(flow.start(y), float(periods))
    return end, jacobian


def transient_state(eta, method, periods=40):
    """A state ξ₁, ξ₁′, g, g′ of a run before it is steady."""
    x1, v1, x2, v2 = simulate(SYSTEM, eta, method, periods=periods, keep=1).section[-1]
    return np.array([x1, v1, x2 - x1, v2 - v1])


def differences(tables, y, periods, columns):
    for k in columns:
        step = WIDTH * np.eye(4)[k]
        ahead, back = (map_state(tables, y + sign * step, periods)[0] for sign in (1, -1))
        yield (ahead - back) / (2 * WIDTH)


JACOBIANS = [
    pytest.param(1.70, Reference(), 1, id="one impact"),
    pytest.param(1.70, Reference("derived"), 2, id="impacts"),
    pytest.param(2.76, Reference(), 2, id="an impact a period"),
    pytest.param(3.25, Reference("derived"), 2, id="an impact in two periods"),
    pytest.param(1.08, Reference(), 1, id="chatter, sticking, release"),
    pytest.param(0.70, Reference("derived"), 2, id="the same, four contacts"),
    pytest.param(1.08, Reference(threshold=0.0), 1, id="endless chatter"),
    pytest.param(0.70, Reference("derived", threshold=0.0), 1, id="endless chatter twice"),
    pytest.param(2.76, ExactPenalty(12000, 18), 1, id="a contact"),
    pytest.param(1.08, ExactPenalty(2500, 8), 1, id="contacts, one across the section"),
    pytest.param(1.08, ExactPenalty(100, 50), 1, id="an overdamped contact"),
    pytest.param(1.08, ExactPenalty(1e5, 3000), 1, id="its fast part is dropped"),
]


@pytest.mark.parametrize(("eta", "method", "periods"), JACOBIANS)
def test_the_jacobian_is_the_derivative_of_the_map(eta, method, periods):
    y, tables = transient_state(eta, method), set_up(SYSTEM, eta, method)
    end, jacobian = map_state(tables, y, periods)
    start = y[0], y[1], y[0] + y[2], y[1] + y[3]
    section = simulate(SYSTEM, eta, method, periods=periods, keep=1, initial=start).section[-1]
    np.testing.assert_allclose([end[0], end[1], end[0] + end[2], end[1] + end[3]], section, atol=1e-12)
    joined = isinstance(method, Reference) and y[2] == 0
    columns = (0, 1) if joined else (0, 1, 2, 3)  # joined pendulums can only be disturbed together
    measured = np.transpose(list(differences(tables, y, periods, columns)))
    np.testing.assert_allclose(jacobian[:, columns], measured, atol=2e-8 * np.abs(jacobian).max())


@pytest.mark.parametrize("eta", [0.70, 1.08])
@pytest.mark.parametrize("damping", ["table", "derived"])
def test_the_jacobian_includes_the_completed_part_of_a_chatter(eta, damping):
    """Completed as early as at its first impacts, that part is long, and so its derivative matters."""
    method = Reference(damping, threshold=0.0)
    y, tables = transient_state(eta, method), set_up(SYSTEM, eta, method, completion=0.3)
    coarse, jacobian = map_state(tables, y, 1)
    fine, _ = map_state(set_up(SYSTEM, eta, method), y, 1)
    assert np.abs(coarse - fine).max() > 1e-7, "the completed part is too short to matter"
    measured = np.transpose(list(differences(tables, y, 1, (0, 1))))
    np.testing.assert_allclose(jacobian[:, :2], measured, atol=1e-8 * np.abs(jacobian).max())


def test_the_jacobian_holds_at_any_phase_and_within_the_completed_part_of_a_chatter():
    """The kernel integrates fractions of a period just as whole ones."""
    eta, method = 1.08, Reference(threshold=0.0)
    y, fine = transient_state(eta, method), set_up(SYSTEM, eta, method)
    tables, within = set_up(SYSTEM, eta, method, completion=0.3), 0
    run = simulate(SYSTEM, eta, method, periods=1, keep=1, initial=(y[0], y[1], y[0] + y[2], y[1] + y[3]))
    joined = run.contacts[-1, 0] / run.period
    for stop in [*np.linspace(0.05, 1.0, 77), *(joined - np.geomspace(1e-4, 1e-2, 7))]:
        end, jacobian = map_state(tables, y, stop)
        measured = np.transpose(list(differences(tables, y, stop, (0, 1))))
        np.testing.assert_allclose(jacobian[:, :2], measured, atol=1e-7 * np.abs(jacobian).max(), err_msg=f"{stop}")
        within += end[2] == 0 < map_state(fine, y, stop)[0][2]
    assert within > 0


def test_the_volume_shrinks_by_damping_and_restitution():
    """Liouville: det DP = exp(−∫ tr of the dampers) times e² for each impact, which multiplies g and g′ by −e."""
    eta = 2.76
    y, tables = transient_state(eta, Reference()), set_up(SYSTEM, eta, Reference())
    _, jacobian = map_state(tables, y, 1)
    damped = np.exp(-2 * (SYSTEM.d1 + SYSTEM.d2 * SYSTEM.kappa) * 2 * np.pi / eta)
    assert np.linalg.det(jacobian) == pytest.approx(damped * SYSTEM.restitution**2, rel=1e-12)


def test_permanent_contact_leaves_two_multipliers_and_penalty_contact_four():
    joined = steady(SYSTEM, 1.08, Reference())
    assert np.abs(joined.multipliers[2:]).max() == 0
    pressed = steady(SYSTEM, 1.08, ExactPenalty(100, 50))
    assert (np.abs(pressed.multipliers) > 0).all()


LONG_RUNS = [
    *((eta, Reference("table"), period) for eta, period in ((1.08, 1), (2.76, 1), (3.25, 2))),
    *((eta, Reference("derived"), period) for eta, period in ((1.08, 1), (2.76, 1), (3.25, 2))),
    (1.08, Reference(threshold=0.0), 1),
    (2.76, ExactPenalty(12000, 18), 1),
    (1.08, ExactPenalty(2500, 8), 1),
    (1.08, ExactPenalty(100, 50), 1),
]


@pytest.mark.parametrize(("eta", "method", "period"), LONG_RUNS)
def test_the_steady_motion_is_the_one_that_the_long_run_converges_to(eta, method, period):
    found, long = steady(SYSTEM, eta, method), simulate(SYSTEM, eta, method)
    assert (found.periodic, found.message, found.period, found.stable) == (True, "", period, True)
    size = np.abs(long.section).max()
    assert found.residual <= 1e-12 * size
    np.testing.assert_allclose(found.state, long.section[-1], atol=1e-10)  # 2,050 is a multiple of the period
    np.testing.assert_allclose(found.response.section, long.section[-period:], atol=1e-10)
    assert found.periods < long.periods / 5
    described, response = motion(long), found.response
    assert len(response.impacts) == described.impacts_per_period * period
    begin, end = response.window
    assert np.sum(response.contacts[:, 0] > begin) == described.contacts_per_period * period
    spans = np.clip(response.contacts, begin, end)
    share = np.sum(spans[:, 1] - spans[:, 0]) / (end - begin)
    assert share == pytest.approx(described.contact_share, abs=1e-10)


def test_the_papers_motions_a_and_c_have_their_known_states():
    """ξ₁, ξ₁′, ξ₂, ξ₂′ from an independent prototype."""
    a, c = steady(SYSTEM, 1.08, Reference()), steady(SYSTEM, 2.76, Reference())
    np.testing.assert_allclose(a.state, [1.68339, 0.59798, 1.68339, 0.59798], atol=6e-6)
    np.testing.assert_allclose(c.state, [-5.56905, -0.59972, 0.62677, 3.90177], atol=6e-6)
    assert (len(a.response.impacts), len(a.response.contacts), len(c.response.impacts)) == (10, 2, 1)


@pytest.mark.parametrize(
    ("eta", "method"),
    [(1.08, Reference()), (2.76, Reference()), (3.25, Reference("derived")), (2.76, ExactPenalty(12000, 18))],
)
def test_the_largest_multiplier_is_the_rate_at_which_the_long_run_converges(eta, method):
    """The distance from the orbit falls by this factor per cycle, on average over many cycles."""
    found = steady(SYSTEM, eta, method)
    section = simulate(SYSTEM, eta, method, periods=400, keep=400).section
    distance = np.linalg.norm(section[found.period - 1 :: found.period] - found.state, axis=1)
    linear = np.flatnonzero((distance < 1e-3) & (distance > 1e-10))
    rate = np.exp(np.polyfit(linear, np.log(distance[linear]), 1)[0])
    assert len(linear) > 30
    assert rate == pytest.approx(abs(found.multipliers[0]), rel=0.02)


def test_a_chaotic_motion_returns_the_long_run():
    found, long = steady(SYSTEM, 1.70, Reference()), simulate(SYSTEM, 1.70, Reference())
    assert (found.periodic, found.stable, found.period) == (False, False, 0)
    assert found.message.startswith("no periodic motion found: ")
    assert found.message.endswith("this is the run of 2050 periods, the last 50 kept")
    np.testing.assert_array_equal(found.response.section, long.section)
    np.testing.assert_array_equal(found.state, long.section[-1])
    assert len(found.multipliers) == 0
    assert found.periods > long.periods


def test_an_unstable_orbit_is_accepted_only_on_request():
    """The chaotic run at [B] passes orbits that it does not stay on."""
    found = steady(SYSTEM, 1.70, Reference(), stable_only=False)
    assert (found.periodic, found.stable) == (True, False)
    assert np.abs(found.multipliers[0]) > 1
    assert found.residual < 1e-11
    np.testing.assert_allclose(found.response.section[-1], found.state, atol=1e-11)


def test_a_cycle_longer_than_max_period_is_reported():
    found = steady(SYSTEM, 3.25, Reference(), max_period=1)
    assert not found.periodic
    assert "repeats itself after 2 periods, more than max_period = 1" in found.message


def test_steady_finds_every_periodic_motion_of_a_sweep_and_no_other():
    """Compared with long runs, as far as their own slowest decay has come."""
    periodic = 0
    for eta in np.linspace(0.5, 4.0, 36):
        found, long = steady(SYSTEM, eta, Reference()), simulate(SYSTEM, eta, Reference())
        period = motion(long).period
        assert found.period == (period if period <= 8 else 0), f"eta = {eta}"
        if not found.periodic:
            continue
        periodic += 1
        left = np.abs(found.multipliers[0]) ** (long.periods / period)
        size = np.abs(long.section).max()
        expected = np.roll(long.section[-period:], long.periods % period, axis=0)
        np.testing.assert_allclose(found.response.section, expected, atol=(1e-10 + 10 * left) * size)
    assert periodic > 20


def test_a_run_that_ends_early_says_why():
    system = System(restitution=0.9999)
    found = steady(system, 1.08, Reference(threshold=1e-12), initial=(3.0, 0.0, 3.0, 1e-4))
    assert not found.periodic
    assert found.message.startswith("the run ended as piled-up: ")
    assert np.isnan(found.state).all()


def test_the_samples_span_one_cycle():
    found = steady(SYSTEM, 3.25, Reference(), record=Record(5, 200))
    trajectory = found.response.trajectory
    assert trajectory.time[-1] - trajectory.time[0] == pytest.approx(found.period * found.response.period)
    np.testing.assert_allclose(trajectory.displacement[:, 0], trajectory.displacement[:, -1], atol=1e-11)
    np.testing.assert_allclose(trajectory.displacement[:, 0], found.state[[0, 2]], atol=1e-11)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"method": Newmark(12000, 18, 100)}, "has a time step"),
        ({"eta": np.nan}, "eta = nan is outside"),
        ({"max_period": 0}, "max_period = 0 is outside"),
        ({"max_period": 1.5}, "not a whole number"),
        ({"initial": (1, 2)}, "four numbers"),
        ({"initial": (1, 0, 0, 0)}, "gap"),
        ({"initial": simulate(SYSTEM, 2.76, Reference(), periods=1, keep=1).checkpoint}, "not a sequence"),
    ],
)
def test_bad_input_is_refused(arguments, words):
    given = {"system": SYSTEM, "eta": 2.76, "method": Reference()} | arguments
    with pytest.raises(ValueError, match=words):
        steady(**given)


def test_the_steps_of_newtons_method_are_counted():
    assert 1 <= steady(SYSTEM, 2.76, Reference()).iterations <= 12
