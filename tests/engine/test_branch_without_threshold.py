"""Branches of the reference whose chatter is summed (threshold 0), or whose contact opens where the cycle ends.

Every orbit is held against the run that starts on it.
"""

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, Excitation, Reference, System, continue_branch, simulate

WALL = System(wall=True, d1=0.05, clearance=-0.5, excitation=Excitation(base=0.0))
FORCED = {"eta": 1.9, "over": "clearance", "low": -0.5, "high": -0.2, "max_period": 1}


def departures(branch, system, eta, method, every=1):
    """By how much the run from every so-many-th orbit misses it after a cycle."""
    for k in range(0, len(branch.values), every):
        there = system.changed({branch.over: float(branch.values[k])})
        run = simulate(there, eta, method, periods=branch.period, keep=1, initial=tuple(branch.sections[k, 0]))
        yield np.abs(run.section[-1] - branch.sections[k, 0]).max()


def test_a_chatter_is_summed_only_where_the_sum_is_exact():
    """With growing restitution the sum must begin at a later impact: 2 impacts at e = 0.006, 20 at e = 0.5."""
    method = Reference(threshold=0.0)
    branch = continue_branch(
        BranchQuestion(System(), 1.08, method, over="restitution", low=0.0, high=0.5, max_period=1)
    )
    assert branch.values.max() == 0.5
    assert branch.values.min() < 1e-3
    assert max(departures(branch, System(), 1.08, method, every=4)) < 1e-12
    assert {point.kind for point in branch.points} <= {"grazing", "contact opens", "sticking ends", "sticking begins"}


def test_a_chatter_that_would_not_end_is_no_orbit():
    """Newton's method may try instants at which the gap would grow: its sum lies 10⁷ periods back or more."""
    system = System(wall=True, d1=0.05, clearance=-0.3, excitation=Excitation(base=0.0, force1=0.5))
    method, numbers = Reference(threshold=0.0), {"low": -0.1, "high": 0.1, "max_period": 2, "most_orbits": 400}
    branch = continue_branch(BranchQuestion(system, 2.76, method, over="constant1", **numbers))
    assert len(branch.values) > 100
    assert max(departures(branch, system, 2.76, method, every=20)) < 1e-9


@pytest.mark.parametrize("force", [0.3, -0.3])
def test_contact_opens_wherever_in_the_cycle_its_force_is_least(force):
    """Pressed by 0.3 against a force 0.3 cos ητ, which pulls most at τ = 0 or half a period later."""
    system = System(wall=True, d1=0.05, clearance=-0.5, excitation=Excitation(base=0.0, force1=force))
    branch = continue_branch(BranchQuestion(system, method=Reference(), **FORCED))
    assert (branch.points[0].kind, branch.points[0].value) == ("contact opens", pytest.approx(-0.3, abs=1e-10))
    assert (branch.values.min(), branch.values.max()) == (-0.5, -0.2)
    assert max(departures(branch, system, 1.9, Reference(), every=8)) < 1e-9


@pytest.mark.parametrize("threshold", [0.0, 0.002])
def test_bodies_at_rest_touch_as_long_as_they_are_pressed(threshold):
    method = Reference(threshold=threshold)
    branch = continue_branch(BranchQuestion(WALL, 1.9, method, over="clearance", low=-0.5, high=0.1, max_period=1))
    assert branch.values.max() < 1e-9
    assert branch.points[-1].value == pytest.approx(0.0, abs=1e-10)
