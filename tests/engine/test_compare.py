"""Period, shares and the difference of two responses."""

from dataclasses import replace

import numpy as np
import pytest

from engine import Newmark, Record, Reference, System, compare, motion, simulate
from engine.motion import repeats_after


def test_period_is_found():
    rng = np.random.default_rng(1)
    cycle = rng.normal(size=(3, 4))
    assert repeats_after(np.tile(cycle, (16, 1))) == 3
    assert repeats_after(np.tile(cycle[:1], (10, 1))) == 1
    assert repeats_after(rng.normal(size=(50, 4))) == 0
    assert repeats_after(cycle[:1]) == 0


def test_a_solution_agrees_with_itself_and_not_with_another_damping():
    record = Record(2, 500)
    table = simulate(System(), 2.76, Reference(), record=record)
    derived = simulate(System(), 2.76, Reference("derived"), record=record)
    assert compare(table, table).rms == 0
    assert compare(table, derived).rms < 1e-10  # one impact, no permanent contact: the joint never acts
    table = simulate(System(), 1.08, Reference(), record=record)
    derived = simulate(System(), 1.08, Reference("derived"), record=record)
    assert 1e-3 < compare(table, derived).rms < 0.1


def test_a_motion_of_two_periods_may_run_one_period_behind():
    record = Record(2, 500)
    even = simulate(System(), 3.25, Reference(), periods=2050, record=record)
    odd = simulate(System(), 3.25, Reference(), periods=2051, record=record)
    found = compare(even, odd)
    assert (found.shift, found.pointwise) == (1, True)
    assert found.rms < 1e-9


def test_aperiodic_motion_is_not_compared_pointwise():
    record = Record(2, 500, steps=2000)
    found = compare(
        simulate(System(), 1.7, Reference(), record=record),
        simulate(System(), 1.7, Newmark(12000, 18, 2000), record=record),
    )
    assert not found.pointwise
    assert np.isnan(found.rms)


def test_rates_are_those_of_whole_cycles():
    """Three periods with four impacts in them, from any start; 50 kept periods are no multiple of three."""
    found = motion(simulate(System(), 3.78, Reference(), periods=4000))
    assert found.period == 3
    assert found.impacts_per_period == pytest.approx(4 / 3, rel=1e-12)


def test_what_cannot_be_compared_is_refused():
    good = simulate(System(), 2.76, Reference(), record=Record(2, 500))
    with pytest.raises(ValueError, match="no samples"):
        compare(good, simulate(System(), 2.76, Reference()))
    with pytest.raises(ValueError, match="diverged"):
        motion(simulate(System(), 2.76, Newmark(60000, 1, 100)))


def test_a_cycle_that_was_not_sampled_is_not_compared():
    short = simulate(System(), 3.25, Reference(), record=Record(1, 400))
    assert not compare(short, short).pointwise


def test_scatter_of_the_time_step_is_forgiven_but_not_denied():
    found = motion(simulate(System(), 2.76, Newmark(12000, 18, 8000)))
    assert (found.period, found.near_period) == (0, 1)
    assert found.spread > 0.01
    assert motion(simulate(System(), 1.7, Reference())).near_period == 0


def test_the_difference_is_that_of_the_curves():
    """A known difference: the same solution, its displacements stretched by a tenth."""
    one = simulate(System(), 2.76, Reference(), record=Record(2, 500))
    stretched = replace(one.trajectory, displacement=1.1 * one.trajectory.displacement)
    assert compare(one, replace(one, trajectory=stretched)).rms == pytest.approx(0.1)


def test_contact_share_of_the_penalty_model_counts_the_ends_of_the_window_once():
    response = simulate(System(), 1.08, Newmark(100, 50, 2000))
    sampled = simulate(System(), 1.08, Newmark(100, 50, 2000), record=Record(50, 2000)).trajectory
    touching = np.mean(sampled.displacement[1, :-1] <= sampled.displacement[0, :-1])
    assert motion(response).contact_share == pytest.approx(touching, abs=1e-3)
