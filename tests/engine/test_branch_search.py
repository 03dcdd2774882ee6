"""The search for all branches: its orbits are motions, it finds what sweeps show, and it takes up what is known."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Excitation, Reference, System, find_branches, simulate

PAPER, EXACT = System(), ExactPenalty(12_000.0, 18.0)


@pytest.fixture(scope="module")
def period_one():
    return find_branches(PAPER, 2.76, Reference(), low=0.5, high=4.0, max_period=1)


def test_every_orbit_of_a_wide_range_returns_also_where_events_pass_the_end_of_its_cycle(period_one):
    compared = 0
    for branch in period_one:
        for eta, rows, factors in zip(branch.values, branch.sections, branch.multipliers, strict=True):
            if not np.abs(factors).max() < 1e4:  # close to grazing
                continue
            start = rows[0] - [max(PAPER.overlap_of(rows[0]), 0.0), 0, 0, 0]  # by rounding
            end = simulate(PAPER, eta, Reference(), periods=1, keep=1, initial=start).section[0]
            assert np.abs(end - start).max() < 1e-9 * np.abs(start).max() * max(1.0, np.abs(factors).max()), eta
            compared += 1
    assert compared > 500


def test_the_events_of_a_point_lie_within_its_cycle(period_one):
    points = [point for branch in period_one for point in branch.points if len(point.instants)]
    assert len(points) > 50
    assert min(point.instants[0] for point in points) >= 0
    assert max(point.instants[-1] for point in points) < 1


def test_a_branch_goes_on_where_the_flight_grazes_together_with_its_impact():
    force = Excitation(base=0.0, force1=0.5)
    wall = System(wall=True, d1=0.05, clearance=1.0, restitution=0.8, excitation=force)
    (branch,) = find_branches(wall, 1.0, Reference(), low=0.3, high=3.0, max_period=1)
    assert [end.split(" at ")[0] for end in branch.ends] == ["eta leaves the range"] * 2
    assert [point.kind for point in branch.points] == ["grazing", "period doubling", "fold", "grazing"]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.values))))
    assert len(turns) == 2  # the fold and the grazing, each once
    fold = branch.points[2]
    assert branch.values[turns + 1].max() == fold.value  # the orbit at the fold is one of the branch
