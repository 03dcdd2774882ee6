"""The largest Lyapunov exponent against two runs side by side and against multipliers, and its uncertainty."""

import numpy as np
import pytest
from vibroscope.engine import (
    Cancelled,
    Cells,
    ExactPenalty,
    Newmark,
    Reference,
    System,
    lyapunov,
    motion,
    simulate,
    steady,
)
from vibroscope.engine.motions.description import Kind
from vibroscope.engine.motions.judge import classify
from vibroscope.engine.motions.lyapunov import EXPONENT_BATCHES, SETTLING, Lyapunov, average_growth, follow_cells
from vibroscope.engine.motions.poincare_map import PoincareMap

from tests.share import every

SYSTEM = System()


def state_on_attractor(eta, method):
    return simulate(SYSTEM, eta, method, periods=1000, keep=1).section[-1]


@pytest.mark.parametrize("method", every([Reference(), ExactPenalty(2500, 8)]), ids=lambda method: method.name)
def test_the_exponent_of_a_chaotic_motion_is_the_rate_at_which_two_runs_separate(method):
    """Benettin's method: two runs, 1e-8 apart and rescaled each period, without a Jacobian."""
    state, width, growth = state_on_attractor(1.70, method), 1e-8, []
    found = lyapunov(SYSTEM, 1.70, method, initial=state, periods=4096)
    apart = width * np.array([0.5, 0.5, 0.5, 0.5])
    for n in range(600):
        ends = [
            simulate(SYSTEM, 1.70, method, periods=1, keep=1, initial=start).section[-1]
            for start in (state, state + apart)
        ]
        state, apart = ends[0], ends[1] - ends[0]
        length = np.linalg.norm(apart)
        if n >= 20:
            growth.append(np.log(length / width))
        apart *= width / length
    batches = [batch.mean() for batch in np.array_split(growth, EXPONENT_BATCHES)]
    error = np.hypot(found.error, np.std(batches, ddof=1) / np.sqrt(EXPONENT_BATCHES))
    assert abs(np.mean(growth) - found.exponent) < 4 * error
    assert error < 0.03


@pytest.mark.parametrize(("eta", "method"), [(2.76, Reference()), (3.25, Reference()), (1.08, ExactPenalty(2500, 8))])
def test_the_exponent_of_a_cycle_is_that_of_its_multipliers(eta, method):
    cycle = steady(SYSTEM, eta, method)
    found = lyapunov(SYSTEM, eta, method, initial=cycle.state, periods=512)
    expected = np.log(np.abs(cycle.multipliers).max()) / cycle.period
    assert found.exponent == pytest.approx(expected, abs=1e-3)
    assert found.regular
    assert found.sign == -1


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(2500, 8)], ids=lambda method: method.name)
def test_the_exponents_of_many_motions_are_those_of_each_followed_by_itself(method):
    """The kernel of many cells against a plain loop over the periods, and against a single exponent."""
    cells, found = Cells(SYSTEM, [1.70, 1.08, 2.76], method), {}
    starts = np.array([state_on_attractor(eta, method) for eta in cells.eta])
    follow_cells(cells, np.array([0, 2]), starts[[0, 2]], 300, found.__setitem__, threads=2)
    assert sorted(found) == [0, 2]
    for i, followed in found.items():
        poincare = PoincareMap(SYSTEM, cells.eta[i], method, None)
        y, direction = poincare.coordinates(starts[i]), np.full(4, 0.5)
        poincare.follow(y, direction, SETTLING)
        growth, states = zip(*(poincare.follow(y, direction, 100) for _ in range(3)), strict=True)
        own = average_growth(np.concatenate(growth), poincare.displacements(np.concatenate(states)))
        single = lyapunov(SYSTEM, cells.eta[i], method, initial=starts[i], periods=300)
        numbers = (followed.exponent, followed.error, followed.drift)
        assert numbers == (single.exponent, single.error, single.drift)
        assert own.exponent == pytest.approx(followed.exponent, rel=1e-12)
        for other in (own, single):
            np.testing.assert_array_equal(followed.section, other.section)


def test_runs_of_the_same_motion_differ_by_about_their_standard_errors():
    states = simulate(SYSTEM, 1.70, Reference(), periods=4000, keep=3000).section[::300]
    found = [lyapunov(SYSTEM, 1.70, Reference(), initial=state, periods=2048) for state in states]
    exponents, errors = np.array([(each.exponent, each.error) for each in found]).T
    off = (exponents - exponents.mean()) / errors
    assert 0.4 < np.sqrt(np.mean(off**2)) < 2.0


def test_the_standard_error_of_random_growth_is_the_known_one():
    """For a sequence with a short memory it is known in closed form."""
    rng, n, memory = np.random.default_rng(5), 2**16, 0.8
    noise = rng.normal(size=n)
    growth = np.empty(n)
    growth[0] = noise[0]
    for k in range(1, n):
        growth[k] = memory * growth[k - 1] + noise[k]
    found = average_growth(growth + 0.3, rng.normal(size=(n, 4)))
    exact = 1 / (1 - memory) / np.sqrt(n)
    assert found.error == pytest.approx(exact, rel=0.35)
    assert abs(found.exponent - 0.3) < 4 * exact
    assert found.drift < 5


def test_the_error_of_a_regular_motion_is_half_the_difference_of_its_halves():
    angle = np.arange(4096) * (1 + 5**0.5) * np.pi
    circle = np.stack([np.cos(angle), np.sin(angle), np.cos(angle), np.sin(angle)], axis=1)
    found = average_growth(np.linspace(0.0, 1.0, len(angle)), circle)
    assert found.regular
    assert (found.exponent, found.error) == pytest.approx((0.5, 0.25), rel=1e-3)


def type_of(exponent, error, drift, irregularity):
    section = np.random.default_rng(1).normal(size=(8192, 4))
    return classify(Lyapunov(exponent, error, drift, irregularity, section))[0]


def test_a_motion_is_chaotic_only_if_all_evidence_agrees():
    assert type_of(0.27, 0.003, 1.0, 1e-3) is Kind.CHAOTIC
    assert type_of(0.005, 0.003, 1.0, 1e-3) is Kind.UNDECIDED  # not significantly positive
    assert type_of(0.27, 0.003, 9.0, 1e-3) is Kind.UNDECIDED  # changes during the run: a transient
    assert type_of(0.27, 0.003, 1.0, 1e-9) is Kind.UNDECIDED  # regular, yet growing: it leaves an unstable motion
    assert type_of(-0.01, 0.001, 1.0, 1e-3) is Kind.UNDECIDED  # contracts, but has not reached a cycle
    assert type_of(1e-8, 1e-9, 1.0, 1e-9) is Kind.QUASI_PERIODIC
    assert type_of(1e-8, 1e-9, 1.0, 1e-3) is Kind.UNDECIDED


def test_a_long_chaotic_transient_is_not_called_chaotic():
    """A run of 2,050 periods finds no cycle; the motion settles to one of a single period while it is followed."""
    system, method = System(d1=0.00038, d2=0.0008, restitution=0.93), Reference("derived")
    assert not steady(system, 0.94, method, max_period=64).periodic
    found = motion(system, 0.94, method)
    assert (found.type, found.period) == ("periodic", 1)
    assert "2050 periods did not find it" in found.reason


def test_unsuitable_methods_and_periods_are_refused():
    with pytest.raises(ValueError, match="has a time step"):
        lyapunov(SYSTEM, 1.70, Newmark(12000, 18, 2000))
    with pytest.raises(ValueError, match="periods = 3"):
        lyapunov(SYSTEM, 1.70, Reference(), periods=3)
    with pytest.raises(Cancelled):
        lyapunov(SYSTEM, 1.70, Reference(), cancelled=lambda: True)


HELD = System(wall=True, clearance=-60.0)  # a preload that never opens
STICKS = System(wall=True, d1=0.05, restitution=0.3, clearance=-0.4)  # in each period


@pytest.mark.parametrize(("system", "eta"), [(HELD, 1.3), (STICKS, 0.7)], ids=["held", "sticks"])
def test_a_body_that_sticks_to_a_wall_forgets_every_disturbance(system, eta):
    state = simulate(system, eta, Reference(), periods=200, keep=1).section[-1]
    found = lyapunov(system, eta, Reference(), initial=state, periods=256)
    assert (found.exponent, found.error, found.sign, found.is_chaotic) == (-np.inf, 0.0, -1, False)
    starts = state, state - np.array([1e-3, 0.0, 0.0, 0.0])
    one, other = (simulate(system, eta, Reference(), periods=4, keep=1, initial=start).section for start in starts)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
