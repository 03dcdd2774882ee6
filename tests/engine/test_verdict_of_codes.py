"""Parts and verdict of what codes choose: contact status, integrator, law, and steps without a solution."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    Cancelled,
    CentralDifference,
    Newmark,
    NewmarkBeta,
    System,
    TimeStepping,
    attractors,
    motion,
    simulate,
    verdict,
    with_located_steps,
)
from vibroscope.engine.divergence.alone import Alone, Change
from vibroscope.engine.divergence.blame import find_blame
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.search import changed_choices, enough_steps, search_alone

from tests.answers import compared, verdict_of

SYSTEM = System()
SHORT = {"periods": 300, "keep": 10}


@pytest.mark.parametrize(
    "method",
    [
        TimeStepping(2500, 8, 500, HHT(-0.1), "end", "keep"),
        TimeStepping(2500, 8, 500, CentralDifference()),
        TimeStepping(2500, 8, 500, status="end", without_solution="keep"),
        Newmark(2500, 8, 500),
    ],
    ids=repr,
)
def test_status_and_integrator_add_up_to_the_time_step_at_every_instant(method):
    found = compared(SYSTEM, 1.08, method, **SHORT)
    parts = found.split_time_step()
    rest = parts.status + parts.integrator - found.parts.time_step
    assert np.abs(rest).max() < 1e-12
    assert found.parts.relative(parts.status) > 1e-5


def test_each_part_of_the_time_step_responds_to_its_own_choice_alone():
    """A located step has no part of the status; the rest of Newmark's is of second order, the status is not."""
    located = compared(SYSTEM, 1.08, Newmark(2500, 8, 500, located=True), **SHORT).split_time_step()
    assert np.abs(located.status).max() == 0

    def sizes(n):
        found = compared(SYSTEM, 1.08, TimeStepping(2500, 8, n), **SHORT)
        parts = found.split_time_step()
        assert parts.in_step
        return [found.parts.relative(part) for part in (parts.status, parts.integrator)]

    coarse, fine = np.array([sizes(n) for n in (1000, 4000)])
    order = np.log(coarse / fine) / math.log(4)
    assert order[1] == pytest.approx(2, abs=0.3)
    assert order[0] < 1.6


def test_the_integrators_part_is_the_rest_of_what_the_status_alone_changes():
    method = TimeStepping(2500, 8, 500, HHT(-0.3))
    found = compared(SYSTEM, 1.08, method, **SHORT)
    parts = found.split_time_step()
    assert parts.located == TimeStepping(2500, 8, 500, HHT(-0.3), "located")
    runs = [compared(SYSTEM, 1.08, each, **SHORT).parts.runs.penalty for each in (method, parts.located)]
    np.testing.assert_allclose(parts.status, runs[0] - runs[1], atol=1e-12)


@pytest.mark.parametrize("law", ["cut", "limited"])
def test_the_split_of_another_law(law):
    found = compared(SYSTEM, 1.08, TimeStepping(2500, 8, 500, law=law), **SHORT)
    parts = found.split_time_step()
    assert parts.located == TimeStepping(2500, 8, 500, status="located", law=law, resolves_contacts=law == "cut")
    np.testing.assert_allclose(parts.status + parts.integrator, found.parts.time_step, atol=1e-12)
    assert np.abs(parts.status).max() > 0


def test_scatter_by_the_status_is_an_artefact_of_the_step():
    found = motion(SYSTEM, 2.76, TimeStepping(12000, 18, 500, status="end", without_solution="keep"))
    assert found.type == "periodic"
    assert "artefact of the time step" in found.reason


@pytest.mark.parametrize("status", ["start", "end"])
def test_the_contact_status_is_to_blame_and_what_is_advised_leaves_what_it_says(status):
    method = TimeStepping(12000, 18, 500, status=status, without_solution="keep")
    comparison = compared(SYSTEM, 2.76, method, periods=200)
    found = verdict(comparison)
    assert f"The contact status at the {status} of the step is to blame" in found.headline
    change = {"located": True} if status == "start" else {"status": "located"}
    assert (found.blame[0], found.change) == ("status", change)
    advised = compared(SYSTEM, 2.76, with_located_steps(method), periods=200)
    assert advised.total == pytest.approx(found.left, rel=0.05)
    assert advised.total < comparison.total


def test_the_status_of_the_papers_method_is_a_choice_like_that_of_any_other():
    """HHT-α with α = 0 is Newmark's method, and takes the loop of all integrators."""
    options = {"periods": 600, "keep": 50}
    methods = Newmark(12000, 18, 2000), TimeStepping(12000, 18, 2000, HHT(0.0))
    found = [verdict_of(SYSTEM, 2.76, method, **options) for method in methods]
    blamed = "The contact status at the start of the step is to blame: steps cut where contact changes would leave"
    assert all(blamed in each.headline for each in found)
    assert [each.blame for each in found] == [("status",), ("status",)]
    assert [each.change for each in found] == [{"located": True}, {"status": "located"}]
    assert found[1].left == pytest.approx(found[0].left, rel=0.1)


def test_the_number_of_steps_that_is_named_leaves_what_is_said():
    for method in (Newmark(12000, 18, 500), TimeStepping(12000, 18, 500, CentralDifference())):
        found = verdict_of(SYSTEM, 2.76, method)
        steps, said = re.search(r"([\d,]+) steps a period (?:leave )?([\d.]+) %", found.headline).groups()
        advised = compared(SYSTEM, 2.76, replace(method, steps=int(steps.replace(",", "")))).total
        assert 100 * advised == pytest.approx(float(said), rel=0.15)
        assert advised <= 1.3 * 0.04  # what no time step leaves


def test_steps_that_are_not_enough_are_not_proposed():
    comparison = compared(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    assert enough_steps(comparison, Remaining(comparison), comparison.total / 1000) is None


def test_the_search_and_more_steps_can_be_cancelled():
    comparison = compared(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    remaining = Remaining(comparison, lambda: True)
    for search in (lambda: enough_steps(comparison, remaining, 0.03), lambda: search_alone(comparison, remaining)):
        with pytest.raises(Cancelled):
            search()


def test_runs_side_by_side_leave_what_single_ones_do_and_can_be_cancelled():
    comparison = compared(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    methods = [replace(comparison.runs.penalty.method, stiffness=k) for k in np.geomspace(1e3, 1e6, 500)]
    alone, ahead = Remaining(comparison), Remaining(comparison, threads=3)
    ahead.run_ahead(methods[::50])
    assert [ahead(each) for each in methods[::50]] == [alone(each) for each in methods[::50]]
    polled = iter([False, False])
    with pytest.raises(Cancelled):
        Remaining(comparison, lambda: next(polled, True), threads=2).run_ahead(methods)


def test_a_located_step_has_a_verdict():
    found = verdict_of(SYSTEM, 2.76, TimeStepping(12000, 18, 50, status="located"))
    assert (found.blame, list(found.change)) == (("steps",), ["steps"])


def test_a_law_without_the_dampers_jump_is_named_only_where_no_number_does_as_well():
    comparison = compared(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    total, method = comparison.difference.total, comparison.runs.penalty.method
    law = Change("law", total / 10, total / 10, TimeStepping(12000, 18, 500, law="limited"))
    number = Change("D", total / 8, total / 8, replace(method, damping=17))
    found = [Alone(total, 0.0, {}, choices) for choices in ((law,), (law, number))]
    named = [[each.changed for each in find_blame(comparison, each, Remaining(comparison)).changes] for each in found]
    assert named == [["law"], ["D"]]


def test_what_leaves_more_than_half_is_not_blamed():
    comparison = compared(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    total, method = comparison.difference.total, comparison.runs.penalty.method
    for left, blamed in ((0.6, []), (0.4, ["D"])):
        change = Change("D", left * total, left * total, replace(method, damping=17))
        blame = find_blame(comparison, Alone(total, 0.0, {}, (change,)), Remaining(comparison))
        assert [each.changed for each in blame.changes] == blamed


def test_a_choice_is_blamed_only_if_it_does_nearly_as_much_as_no_time_step():
    comparison = compared(SYSTEM, 2.76, TimeStepping(12000, 18, 500), **SHORT)
    method = TimeStepping(12000, 18, 500, status="end")
    steps = Change("steps", 0.03, 0.03, method.limit)
    for left, blamed in ((0.06, "steps"), (0.035, "status")):
        choices = steps, Change("status", left, left, method)
        blame = find_blame(comparison, Alone(comparison.difference.total, 0.0, {}, choices), Remaining(comparison))
        assert [each.changed for each in blame.changes] == [blamed]


def test_every_choice_is_changed_alone():
    method = TimeStepping(100.0, 1.0, 200, HHT(-0.2), "end", "keep")
    for name, changed in changed_choices(method):
        differing = [each for each in vars(method) if getattr(changed, each) != getattr(method, each)]
        assert differing == [name]
    assert dict(changed_choices(method))["integrator"].integrator == NewmarkBeta()


def test_a_run_without_a_solution_says_when_why_and_what_finishes():
    comparison = compared(SYSTEM, 2.76, TimeStepping(12000, 18, 500, status="end"), periods=100, keep=10)
    found = verdict(comparison)
    assert (found.agree, found.blame) == ("unknown", ("law",))
    stopped = comparison.runs.penalty
    when = f"step {stopped.cost.steps + 1} (period {stopped.cost.steps // 500 + 1})"
    assert stopped.message.startswith(when)
    assert f"stopped at {when}, which has no solution" in found.headline
    assert "The damper's jump at touch is to blame" in found.headline
    assert found.change == {"without_solution": "halve"}
    for changes in ({"without_solution": "halve"}, {"status": "start"}):
        finished = simulate(SYSTEM, 2.76, TimeStepping(12000, 18, 500, **{"status": "end"} | changes), periods=100)
        assert finished.ok


def test_coexisting_motions_are_found_with_every_integrator():
    found = attractors(SYSTEM, 1.08, TimeStepping(2500, 8, 100, HHT(-0.05)), starts=2)
    assert sum(each.share for each in found) == 1
