"""Where the sequence of events of a branch ends: what follows does not depend on where the branch began."""

from functools import cache

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, Reference, System, continue_branch, find_branches
from vibroscope.engine.continuation import follow

from tests.few_seeds import few_seeds
from tests.share import every

PAPER = System()


@cache
def followed(eta, low, high, method=None, **more):
    """The branch of period one."""
    return continue_branch(
        BranchQuestion(PAPER, eta, method or Reference(), low=low, high=high, **{"max_period": 1, **more})
    )


def values(branch, kind):
    """Where a branch has points of this kind, sorted."""
    return np.sort([point.value for point in branch.points if point.kind == kind])


def test_a_branch_goes_on_where_events_lie_beyond_the_end_of_the_cycle():
    # at η = 0.7258958692 the impact that begins to stick has passed τ = pT
    branch = followed(0.75, 0.715, 0.76)
    assert all("leaves the range" in end for end in branch.ends)
    np.testing.assert_allclose(values(branch, "sticking ends")[0], 0.72589586923, atol=1e-10)


@pytest.mark.parametrize(
    ("system", "method", "starts"),
    every(
        [
            (PAPER, Reference(threshold=0.0005), (2.0, 0.9)),
            (PAPER, Reference(), (2.0, 0.9)),
            (PAPER.changed({"restitution": 0.7}), Reference(), (2.0, 0.55)),
        ]
    ),
)
def test_a_branch_has_the_same_points_whichever_way_it_jumps(system, method, starts):
    """With ε = 0.0005 two sequences end at 1.13214 where a third begins; from above it went back the way it came."""
    one, other = (
        continue_branch(BranchQuestion(system, eta, method, low=0.5, high=2.0, max_period=1)) for eta in starts
    )
    assert all("leaves the range" in end for end in one.ends + other.ends)
    kinds = {point.kind for point in one.points} - {"Neimark-Sacker"}
    assert {"sticking begins", "sticking ends"} <= kinds
    for kind in kinds:
        np.testing.assert_allclose(values(one, kind), values(other, kind), atol=1e-10)


@pytest.mark.parametrize("low", [0.5, 0.7])
def test_a_branch_does_not_step_to_another_leg_of_its_own(low):
    """At η = 0.74817, τ = 0 lies in a contact, and the branch passes nearly the same states again."""
    branch = followed(2.0, low, 4.0, ExactPenalty(12000.0, 18.0))
    assert all("leaves the range" in end for end in branch.ends)
    assert branch.values.min() == low


def test_a_flight_may_vanish_where_steps_see_no_more_than_rounding():
    """With these ranges a step ends 3e-7 before the end of a flight, of which the length is then all rounding."""
    branches = [followed(2.0, 0.5, high, ExactPenalty(12000.0, 18.0)) for high in (2.0, 4.0)]
    for branch in branches:
        assert all("leaves the range" in end for end in branch.ends)
        assert (np.diff(branch.values) != 0).all()
        assert np.abs(values(branch, "contact opens") - 0.59586534664).min() < 1e-10


def test_a_contact_begins_shortly_before_the_end_of_the_cycle():
    """The gap is smallest 0.02 periods before it, in the last whole interval of the tables of a flight."""
    system = System(
        kappa=2.2908712827715254, d1=0.12369545684173879, d2=0.042931821766504036, clearance=0.44926696652842224
    )
    method = ExactPenalty(2213.2531679076756, 39.313372664295684)
    branch = continue_branch(BranchQuestion(system, 3.323706177366, method, low=2.658965, high=4.154633, max_period=2))
    assert np.abs(values(branch, "grazing") - 3.62331294321).min() < 1e-9


def test_a_jump_may_lead_to_an_orbit_at_the_same_value():
    system = System(wall=True, d1=0.041394931778305444, restitution=0.39242713049940436)
    branch = continue_branch(
        BranchQuestion(system, 3.0205232624032, Reference(threshold=0.01), low=2.4, high=3.8, max_period=4)
    )
    assert "sticking begins" in {point.kind for point in branch.points}


@pytest.mark.parametrize("phase", [0, 1])
def test_a_branch_ends_at_a_doubling_though_an_impact_lies_at_the_end_of_the_cycle(phase):
    """The velocities of both halves then differ by that impact; it went on as the same orbits, half a cycle later."""
    eta = 0.858974358974
    begun = followed(eta, 0.5, 4.0, max_period=2)
    start = begun.sections[int(np.argmin(np.abs(begun.values - eta)))][phase]
    begun = followed(eta, 0.5, 4.0, max_period=2, initial=tuple(start))
    joined = sorted(float(end.removeprefix("joins a branch of period 1 at eta = ")) for end in begun.ends)
    np.testing.assert_allclose(joined, [0.842448978561, 0.864758334378], atol=1e-9)
    assert np.abs(np.subtract.outer(values(begun, "fold"), joined)).min(initial=1.0) > 1e-9


def test_a_branch_that_meets_a_shorter_period_does_not_go_round():
    """At 1.668124 that of period 8 goes on as its own orbits four periods later: 130 times, until it was given up."""
    with few_seeds():
        branches = find_branches(BranchQuestion(PAPER, 1.75, Reference(), low=1.6, high=1.85, max_period=8))
    (eight,) = (branch for branch in branches if branch.period == 8)
    assert eight.ends[1].startswith("grazing at eta = 1.668124229: the orbits that go on")
    (double,) = (point for point in eight.points if point.kind == "period doubling")
    np.testing.assert_allclose(double.value, 1.708006884, atol=1e-9)


@pytest.mark.parametrize("high", [0.72, 0.75, 0.8])
def test_a_flight_is_followed_until_it_is_too_short_for_differences(high):
    # it lasts 4e-6 periods at its last orbit, since the gap is of third order in that; the point is beyond
    branch = followed(high, 0.657, high)
    assert [point.kind for point in branch.points if point.value < 0.659] == ["contact opens", "fold"]
    found = [values(branch, "fold")[0], values(branch, "contact opens")[0]]
    np.testing.assert_allclose(found, [0.65844491719674, 0.65844504558761], atol=1e-11)


@pytest.mark.parametrize("off", [1e-8, -1e-8, 1e-12, -1e-12])
@pytest.mark.parametrize(("eta", "low", "high"), [(0.75, 0.71, 0.76), (2.0, 1.5, 2.0)])
def test_a_start_next_to_a_grazing_is_followed_both_ways(eta, low, high, off):
    point = next(point for point in followed(eta, low, high).points if point.kind == "grazing")
    begun = followed(point.value + off, point.value - 0.005, point.value + 0.005, initial=tuple(point.state))
    assert all("leaves the range" in end for end in begun.ends)
    assert np.abs(values(begun, "grazing") - point.value).min() < 1e-12


@pytest.mark.parametrize(
    ("method", "low", "high"),
    [
        (Reference(threshold=0.01), 1.2, 1.6),
        (ExactPenalty(12_000.0, 18.0), 1.2, 1.6),
    ],
    ids=["reference", "exact"],
)
def test_a_branch_ends_where_that_of_half_the_period_doubles(method, low, high):
    # where neither doubling is known, since nothing of the shorter period was followed
    width = high - low
    branch = followed(0.5 * (low + high), low, high, method, max_period=2)
    starts = low + 0.1 * width, high - 0.1 * width
    doublings = [values(followed(eta, low, high, method), "period doubling") for eta in starts]
    for end in branch.ends:
        joined = float(end.removeprefix("joins a branch of period 1 at eta = "))
        assert np.abs(np.concatenate(doublings) - joined).min() < 1e-10 * width


@pytest.mark.parametrize("first", [0.001, 0.003])
def test_a_branch_does_not_depend_on_its_steps(first, monkeypatch):
    # between 0.6702387 and 0.6702456 an impact would stick; an orbit on either side of that shows nothing of it
    usual = followed(0.69, 0.66, 0.69)
    monkeypatch.setattr(follow.BranchTracer, "control", follow.BranchTracer.control._replace(first=first))
    other = followed(0.69, 0.66, 0.69)
    assert [point.kind for point in other.points] == [point.kind for point in usual.points]
    np.testing.assert_allclose(*([point.value for point in each.points] for each in (other, usual)), rtol=0, atol=1e-12)
    assert other.ends == usual.ends
    assert all("leaves the range" in end for end in usual.ends)
