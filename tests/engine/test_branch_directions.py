"""A branch has the same points, by kind and value, whichever way it is followed."""

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, Reference, System, continue_branch

PAPER = System()
APART = System(kappa=2.9404343900423333, d1=0.1140122947473728, d2=0.15188223037346046, clearance=0.595553776474898)
ONCE = System(kappa=2.1120967991005033, d1=0.07111855688136534, d2=0.06151875683751801, clearance=0.7591608559375049)
BRANCHES = {
    "reference": (PAPER, Reference(), (0.55, 0.95)),
    "restitution 0.3": (PAPER.changed({"restitution": 0.3}), Reference(threshold=0.005), (0.55, 0.95)),
    "exact": (PAPER, ExactPenalty(12_000.0, 18.0), (0.52, 2.0)),
    "exact, soft": (PAPER, ExactPenalty(400.0, 20.0), (0.52, 2.0)),
    "exact, apart": (APART, ExactPenalty(3059.4115534006764, 15.296869671114568), (1.45, 1.95)),
}


def followed(name, eta):
    """The branch of the motion at η, a little beyond both starts."""
    system, method, (low, high) = BRANCHES[name]
    return continue_branch(BranchQuestion(system, eta, method, low=low - 0.01, high=high + 0.01, max_period=4))


@pytest.mark.parametrize("name", BRANCHES)
def test_a_branch_has_the_same_points_whichever_way_it_is_followed(name):
    up, down = (followed(name, eta) for eta in BRANCHES[name][-1])
    assert up.period == down.period
    assert len(up.points) == len(down.points) > 0
    kinds = {point.kind for point in up.points}
    for kind in kinds | {point.kind for point in down.points}:
        values = [np.sort([point.value for point in branch.points if point.kind == kind]) for branch in (up, down)]
        np.testing.assert_allclose(*values, rtol=0, atol=1e-9)


def test_a_fold_right_behind_the_beginning_of_a_flight_is_found_both_ways():
    """From below the flight began where it lasts 3e-3 periods: the fold lies 1.3e-7 beside its beginning."""
    for start in (0.64, 0.67):
        branch = continue_branch(BranchQuestion(PAPER, start, Reference(), low=0.64, high=0.67, max_period=1))
        found = {kind: [p.value for p in branch.points if p.kind == kind] for kind in ("fold", "contact opens")}
        np.testing.assert_allclose(found["fold"], [0.65844491719674], atol=1e-11)
        np.testing.assert_allclose(found["contact opens"], [0.65844504558761], atol=1e-11)


def test_a_contact_of_the_penalty_opens_on_one_side_of_a_point():
    """The flight between two contacts vanishes at a point that was a grazing from its side."""
    branch = followed("exact", 2.0)
    opens = [point for point in branch.points if point.kind == "contact opens"]
    assert len(opens) > 10
    for point in opens:
        before, after = (branch.sequences[k][1].count("touch") for k in _sequences_at(branch, point))
        assert abs(before - after) == 1
        fewer = min(before, after)
        assert fewer > 0


def test_where_the_only_contact_vanishes_is_a_grazing_from_both_sides():
    """Both events of the cycle are then at one instant, and the flight lasts the rest of it."""
    eta, method = 3.2011815257076757, ExactPenalty(1536.3857681554166, 35.57573958655012)
    limits = {"low": 2.5609452205661407, "high": 4.001476907134594, "max_period": 4}
    branch = continue_branch(BranchQuestion(ONCE, eta, method, **limits))
    k = 1 + len(branch.values) // 8
    again = continue_branch(
        BranchQuestion(ONCE, float(branch.values[k]), method, initial=tuple(branch.sections[k][0]), **limits)
    )
    for each in (branch, again):
        found = [point.value for point in each.points if point.kind == "grazing"]
        assert np.abs(np.subtract(found, 3.084367183848851)).min() < 1e-10


def _sequences_at(branch, point):
    """The numbers of the sequences before and after a point."""
    first = max(k for k, (index, _) in enumerate(branch.sequences) if index <= point.index)
    return first, first + 1
