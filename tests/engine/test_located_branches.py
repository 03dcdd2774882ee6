"""Branches of Newmark's method with located steps against runs of these steps, and against the exact penalty."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Excitation, Newmark, System, continue_branch, continue_point, simulate
from vibroscope.engine.continuation.orbit import orbit_of_run
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.drivers.orbit_equations import equations_of
from vibroscope.engine.motions.floquet import multipliers

PAPER = System()
WALL = System(wall=True, clearance=0.3, d1=0.05, excitation=Excitation(base=1.0))
WALLED = WALL, 1.7, Newmark(200.0, 3.0, 100, located=True)
COARSE, FINE = Newmark(12_000.0, 18.0, 200, located=True), Newmark(12_000.0, 18.0, 2000, located=True)
SOFT = Newmark(2500.0, 8.0, 200, located=True)


def at(branch, system, eta, method, k):
    """The problem of the k-th orbit."""
    value = branch.values[k]
    if branch.over == "eta":
        return system, value, method
    assert branch.over == "K"
    return system, eta, Newmark(value, method.damping, method.steps, located=True)


def branch_of(system, eta, method, over, low, high):
    return continue_branch(system, eta, method, over=over, low=low, high=high, max_period=2)


def is_smooth(problem, start, period):
    """Whether differences to either side agree: near a kink of the map, `multipliers` takes the mean of both."""

    def end(state):
        return simulate(*problem, periods=period, keep=1, initial=state).section[-1]

    moves, here = 1e-5 * max(np.abs(start).max(), 1e-3) * np.eye(4)[: 2 if problem[0].wall else 4], end(start)
    ahead, behind = (np.array([end(start + side * move) - here for move in moves]) for side in (1.0, -1.0))
    return np.abs(ahead + behind).max() < 1e-3 * np.abs(ahead).max()


@pytest.mark.parametrize(
    ("system", "eta", "method", "over", "low", "high"),
    [
        (PAPER, 2.0, SOFT, "eta", 1.6, 2.4),
        (PAPER, 1.65, SOFT, "eta", 1.5, 1.66),
        (PAPER, 2.81, FINE, "eta", 2.79, 2.84),
        (PAPER, 2.6, COARSE, "K", 6000.0, 20_000.0),
        (*WALLED, "eta", 1.2, 2.5),
    ],
)
def test_orbits_return_in_runs_and_have_the_multipliers_of_the_steps(system, eta, method, over, low, high):
    branch = branch_of(system, eta, method, over, low, high)
    assert branch.values.min() == low
    assert branch.values.max() == high
    compared = 0
    for k in range(0, len(branch.values), max(1, len(branch.values) // 12)):
        problem, states = at(branch, system, eta, method, k), branch.sections[k]
        start = states[0]
        run = simulate(*problem, periods=branch.period, keep=1, initial=start)
        size = np.abs(start).max()
        assert np.abs(run.section[-1] - start).max() < 1e-9 * size * max(1.0, np.abs(branch.multipliers[k]).max())
        if k % 3 == 0 and is_smooth(problem, start, branch.period):
            found = multipliers(*problem, start, branch.period)
            own = branch.multipliers[k]
            assert max(np.abs(found - each).min() for each in own) < 1e-4 * max(1.0, np.abs(own).max())
            compared += 1
    assert compared >= 2


@pytest.mark.parametrize(
    ("system", "eta", "method"),
    [(PAPER, 2.0, SOFT), (PAPER, 1.12, SOFT), WALLED],
)
def test_the_jacobian_is_that_of_the_equations(system, eta, method):
    """Differences of the residual of fourth order, within the steps in which the events lie."""
    run = simulate(system, eta, method, periods=600, keep=1)
    orbit = orbit_of_run((system, eta, method), contact_state(system, run.section[-1]), 1)
    equations = equations_of(system, eta, method)
    sequence, x = (orbit.kinds, orbit.first, 1), orbit.unknowns
    found, sizes = equations(*sequence, x), np.where(np.arange(len(x)) < 4, 1e-3, 1e-6)  # linear in the state

    def central(step):
        residuals = equations(*sequence, x + step).residual, equations(*sequence, x - step).residual
        return (residuals[0] - residuals[1]) / (2 * step.sum())

    differences = [(4 * central(step) - central(2 * step)) / 3 for step in np.diag(sizes)]
    units = np.abs(found.jacobian).max(axis=0) + (np.arange(len(x)) < 2) * system.wall
    moving = np.ones(len(x), bool) if not system.wall else np.arange(len(x)) >= 2
    assert len(orbit.kinds) > 0
    off = np.abs(found.jacobian - np.transpose(differences)) / units
    assert off[:, moving].max() < 1e-7  # rounding over the smaller step


def test_points_tend_to_those_of_the_exact_penalty_with_the_square_of_the_step():
    """A period doubling and a fold; a kink of the map moves each by a small share of the error."""

    def last_point(method, eta, low, high, kind):
        branch = continue_branch(PAPER, eta, method, low=low, high=high, max_period=1)
        return max(point.value for point in branch.points if point.kind == kind)

    for case in ((1.7, 1.64, 1.75, "period doubling"), (1.3, 1.23, 1.32, "fold")):
        exact = last_point(ExactPenalty(12_000.0, 18.0), *case)
        errors = [abs(last_point(Newmark(12_000.0, 18.0, n, located=True), *case) - exact) for n in (250, 2000)]
        assert errors[1] < 1e-5
        assert 1.95 < np.log2(errors[0] / errors[1]) / 3 < 2.05


def test_a_branch_is_followed_across_grazings_and_contacts_that_open():
    branch = continue_branch(PAPER, 2.0, Newmark(2500.0, 8.0, 2000, located=True), low=0.5, high=4.0, max_period=1)
    assert branch.ends == ("eta leaves the range at 0.5", "eta leaves the range at 4")
    exact = {"grazing": 1.55947666738, "period doubling": 2.75965062939, "fold": 1.24187565852}
    for kind, value in exact.items():  # of the exact penalty, K = 2500 and D = 8
        assert min(abs(point.value - value) for point in branch.points if point.kind == kind) < 1e-5


def test_points_are_not_followed_along_a_second_number():
    branch = continue_branch(PAPER, 2.76, COARSE, low=2.7, high=2.85, max_period=1)
    ranges = {"low": 2.7, "high": 2.85, "along": "K", "along_low": 6000.0, "along_high": 20_000.0}
    with pytest.raises(ValueError, match="has kinks"):
        continue_point(PAPER, 2.76, COARSE, branch.points[0], **ranges)
