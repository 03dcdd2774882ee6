"""The error as one number: equal to a slow computation, independent of the grid and of the starting period."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    ComparisonQuestion,
    ExactPenalty,
    Excitation,
    Newmark,
    Record,
    Reference,
    System,
    compare,
    simulate,
)
from vibroscope.engine.divergence.error import Target

DOUBLED = 3.25  # two periods
PENALTY = Newmark(12000, 18, 2000)


def slow_error(reference, penalty, grid=3000):
    """The same by interpolation between finely sampled curves, period by period."""
    total = size = 0.0
    for period in range(-penalty.keep, 0):
        curves = []
        for response in (reference, penalty):
            time = (response.trajectory.time - response.trajectory.time[-1]) / response.period
            instants = period + np.arange(grid) / grid
            curves.append([np.interp(instants, time, row) for row in response.trajectory.displacement])
        total += np.sum(np.subtract(*curves) ** 2)
        size += np.sum(np.square(curves[0]))
    return np.sqrt(total / size)


@pytest.mark.parametrize(("eta", "method"), [(2.76, PENALTY), (1.08, Newmark(2500, 8, 500, located=True))])
def test_the_error_is_that_of_the_interpolated_curves(eta, method):
    fine = Record(10, 4000, steps=4000)
    reference = simulate(System(), eta, Reference(), keep=10, record=fine)
    penalty = simulate(System(), eta, method, keep=10, record=Record(10, 2000))
    assert Target(reference).error(penalty) == pytest.approx(slow_error(reference, penalty), rel=2e-4)


def test_the_error_depends_little_on_the_grid_and_on_how_the_cycle_was_found():
    target, long = Target.find(System(), 2.76), Target(simulate(System(), 2.76, Reference()))
    penalty = simulate(System(), 2.76, PENALTY)
    errors = [target.error(penalty), long.error(penalty)]
    errors += [
        target.error(simulate(System(), 2.76, PENALTY, record=Record(50, samples))) for samples in (60, 333, 2000)
    ]
    assert errors == pytest.approx([errors[0]] * len(errors), rel=2e-3)
    assert errors[1] == pytest.approx(errors[0], rel=1e-6)


def test_a_motion_of_two_periods_may_start_with_either_of_them():
    target = Target.find(System(), DOUBLED)
    even = target.error(simulate(System(), DOUBLED, ExactPenalty(12000, 18), periods=2050))
    odd = target.error(simulate(System(), DOUBLED, ExactPenalty(12000, 18), periods=2051))
    assert target.period == 2
    assert odd == pytest.approx(even, rel=1e-9)
    assert 0.01 < even < 0.05


def test_a_solution_has_no_error_against_itself_and_a_known_one_when_scaled():
    run = simulate(System(), DOUBLED, Reference(), keep=10, record=Record(10, 100))
    stretched = replace(run.trajectory, displacement=1.1 * run.trajectory.displacement)
    assert Target(run).error(run) < 1e-12
    assert Target(run).error(replace(run, trajectory=stretched)) == pytest.approx(0.1)


def test_an_error_that_does_not_exist_is_refused_or_infinite():
    target = Target.find(System(), 2.76)
    assert target.error(simulate(System(), 2.76, Newmark(60000, 1, 100))) == np.inf
    with pytest.raises(ValueError, match="different systems"):
        target.error(simulate(System(restitution=0.4), 2.76, PENALTY))
    chaotic = Target.find(System(), 1.7)
    assert not chaotic.periodic
    with pytest.raises(ValueError, match="does not repeat"):
        chaotic.error(simulate(System(), 1.7, PENALTY))


def test_a_relative_difference_does_not_depend_on_where_the_bodies_rest():
    shifted = System(clearance=30.0, excitation=Excitation(constant1=30.0))
    assert shifted.static_gap == 0
    method = Newmark(2500.0, 8.0, 500)
    found = [compare(ComparisonQuestion(system, 1.08, method)).difference for system in (System(), shifted)]
    assert found[1].total == pytest.approx(found[0].total, rel=1e-6)
    errors = [Target.find(system, 1.08).error(simulate(system, 1.08, method)) for system in (System(), shifted)]
    assert errors[1] == pytest.approx(errors[0], rel=1e-6)
