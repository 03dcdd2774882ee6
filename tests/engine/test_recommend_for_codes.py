"""Recommendations for what a code has: integrator, contact status and law."""

import pytest
from vibroscope.engine import HHT, ExactPenalty, System, TimeStepping, recommend, simulate

from tests.answers import compared, recommended
from tests.recommended import question

# Of the displacements alone: contacts have too few of these steps for a restitution or a force.
ALONE = {"restitution_tolerance": None, "force_tolerance": None}
FEW = {"stiffness": 100.0, "damping": 3.68, "steps_max": 32, **ALONE}
KEEP = TimeStepping(1, 0, 1000, HHT(-0.1), "end", "keep")


def test_every_setting_on_the_front_was_run_with_the_method():
    found = recommended(question(System(), 1.08, tolerance=0.3, scheme=KEEP, **FEW))
    assert found.met
    k, d, n = found.best.setting
    assert found.method == TimeStepping(k, d, n, HHT(-0.1), "end", "keep")
    assert compared(System(), 1.08, found.method).total == pytest.approx(found.best.error, rel=1e-9)


def test_a_setting_that_stops_without_a_solution_is_not_offered():
    """With this K and D every run stops sooner or later, whatever its number of steps."""
    assert simulate(System(), 1.08, TimeStepping(100, 3.68, 32, HHT(-0.1), "end")).status == "without-solution"
    found = recommend(question(System(), 1.08, tolerance=1.0, scheme=TimeStepping(1, 0, 1000, HHT(-0.1), "end"), **FEW))
    assert (found.met, found.best, found.front) == (False, None, ())
    assert "a step has no solution sooner or later" in found.reason


def test_a_range_is_served_by_the_method():
    found = recommend(question(System(), [1.07, 1.09], tolerance=0.5, scheme=KEEP, **FEW))
    assert found.met
    assert found.method_at(1.07).integrator == HHT(-0.1)


def test_what_has_no_time_step_is_refused():
    with pytest.raises(ValueError, match="has no time step"):
        recommend(question(System(), 1.08, scheme=ExactPenalty(1, 0)))
