"""Where a branch seemed to end, to go round or to shrink its steps, and where it really ends."""

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, Reference, System, continue_branch, simulate

BOUNCES = System(restitution=0.6)
CHATTERS = System(
    kappa=2.9160648550086643,
    d1=0.09027342153255409,
    d2=0.12646091069024318,
    restitution=0.3193175935469777,
    clearance=0.5014234872152326,
)


@pytest.mark.parametrize(
    ("eta", "began", "ends"),
    [(0.69, 0.6772341253, 0.678079514), (0.67, 0.6727847627, 0.6727847627)],
    ids=["from above", "from below"],
)
def test_a_branch_goes_on_where_the_motion_bounces_instead_of_sticking(eta, began, ends):
    """Of three sequences that end at the second place two go on as the third: there the branch really ends."""
    branch = continue_branch(BranchQuestion(BOUNCES, eta, Reference(), low=0.5, high=4.0, max_period=1))
    assert np.abs([point.value - began for point in branch.points if point.kind == "sticking ends"]).min() < 1e-9
    (end,) = (end for end in branch.ends if f"eta = {ends:.9f}"[:-1] in end)
    assert end.endswith("the orbits that go on from there are those of the branch before")


def test_an_impact_may_begin_to_stick_until_after_the_end_of_the_cycle():
    branch = continue_branch(
        BranchQuestion(CHATTERS, 1.0, Reference(threshold=0.0005), low=0.81, high=1.2, max_period=1)
    )
    assert all("leaves the range" in end for end in branch.ends)
    assert np.abs([point.value - 0.8602292441 for point in branch.points]).min() < 1e-9


def test_orbits_return_though_a_step_of_newtons_method_shrank_less_than_foreseen():
    """One in 80 was off by 2.4e-9 of its size, with a multiplier of 0.3."""
    method = Reference(threshold=0.0005)
    branch = continue_branch(
        BranchQuestion(CHATTERS, 1.000654263686753, method, low=0.8005234109494025, high=1.2508178296084413)
    )
    for value, (state,) in zip(branch.values, branch.sections, strict=True):
        run = simulate(CHATTERS, float(value), method, periods=1, keep=1, initial=tuple(state))
        assert np.abs(run.section[-1] - state).max() < 1e-9


def test_a_solution_next_to_a_flight_that_vanishes_is_none():
    """At η = 1.470977025 Newton's method hovered at 1e-7 where the curve had turned; the next step found nothing."""
    system = System(
        kappa=2.9404343900423333, d1=0.1140122947473728, d2=0.15188223037346046, clearance=0.595553776474898
    )
    eta, method = 1.8020428339431587, ExactPenalty(3059.4115534006764, 15.296869671114568)
    branch = continue_branch(BranchQuestion(system, eta, method, low=0.8 * eta, high=1.25 * eta, max_period=4))
    assert all("leaves the range" in end for end in branch.ends)
    opens = [point.value for point in branch.points if point.kind == "contact opens"]
    assert np.abs(np.subtract(opens, 1.4709770249)).min() < 1e-9


def test_a_branch_without_threshold_ends_where_grazings_accumulate():
    """There a chatter completes as its force falls to zero. It went back and forth over 136 points for 5000 orbits."""
    branch = continue_branch(BranchQuestion(System(), 0.72, Reference(threshold=0.0), low=0.5, high=4.0, max_period=1))
    (end,) = (end for end in branch.ends if "chatter completes at eta = 0.66999" in end)
    assert end.endswith("beyond are only the orbits of the branch before")
    limits = [point.value for point in branch.points if point.kind == "chatter completes"]
    assert np.abs(np.subtract(limits, 0.66999570348)).min() < 1e-9
    points = {(point.kind, round(point.value, 10)) for point in branch.points}
    assert len(points) == len(branch.points)


def test_a_branch_that_is_given_up_says_after_how_many_orbits():
    branch = continue_branch(
        BranchQuestion(System(), 2.76, Reference(), low=2.5, high=3.0, max_period=1, most_orbits=3)
    )
    assert any(end.startswith("given up after 3 ") for end in branch.ends)
