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
    compare,
    motion,
    simulate,
    verdict,
)
from vibroscope.engine.divergence.blame import best_experiment, blame_sentence
from vibroscope.engine.divergence.experiments import Experiment, changed_choices, run_experiments, with_enough_steps
from vibroscope.engine.divergence.time_step import with_located_steps

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
    found = compare(SYSTEM, 1.08, method, **SHORT)
    parts = found.split_time_step()
    rest = parts.status + parts.integrator - found.parts.time_step
    assert np.abs(rest).max() < 1e-12
    assert found.parts.relative(parts.status) > 1e-5


def test_each_part_of_the_time_step_responds_to_its_own_choice_alone():
    """A located step has no part of the status; the rest of Newmark's is of second order, the status is not."""
    located = compare(SYSTEM, 1.08, Newmark(2500, 8, 500, located=True), **SHORT).split_time_step()
    assert np.abs(located.status).max() == 0

    def sizes(n):
        found = compare(SYSTEM, 1.08, TimeStepping(2500, 8, n), **SHORT)
        parts = found.split_time_step()
        assert parts.in_step
        return [found.parts.relative(part) for part in (parts.status, parts.integrator)]

    coarse, fine = np.array([sizes(n) for n in (1000, 4000)])
    order = np.log(coarse / fine) / math.log(4)
    assert order[1] == pytest.approx(2, abs=0.3)
    assert order[0] < 1.6


def test_the_integrators_part_is_the_rest_of_what_the_status_alone_changes():
    method = TimeStepping(2500, 8, 500, HHT(-0.3))
    found = compare(SYSTEM, 1.08, method, **SHORT)
    parts = found.split_time_step()
    assert parts.located == TimeStepping(2500, 8, 500, HHT(-0.3), "located")
    runs = [compare(SYSTEM, 1.08, each, **SHORT).parts.runs.penalty for each in (method, parts.located)]
    np.testing.assert_allclose(parts.status, runs[0] - runs[1], atol=1e-12)


@pytest.mark.parametrize("law", ["cut", "limited"])
def test_the_split_of_another_law(law):
    found = compare(SYSTEM, 1.08, TimeStepping(2500, 8, 500, law=law), **SHORT)
    parts = found.split_time_step()
    assert parts.located == TimeStepping(2500, 8, 500, status="located", law=law)
    np.testing.assert_allclose(parts.status + parts.integrator, found.parts.time_step, atol=1e-12)
    assert np.abs(parts.status).max() > 0


def test_the_same_method_under_both_names_has_the_same_parts_and_motion():
    """The contact steps are the same, so that both differ by rounding alone."""
    newmark, stepping = (compare(SYSTEM, 1.08, kind(2500, 8, 500), **SHORT) for kind in (Newmark, TimeStepping))
    assert stepping.total == pytest.approx(newmark.total, rel=1e-6)
    found = [motion(SYSTEM, 1.08, each.runs.penalty.method) for each in (newmark, stepping)]
    assert [each.type for each in found] == ["periodic"] * 2
    np.testing.assert_allclose(found[1].multipliers, found[0].multipliers, atol=1e-5)


def test_scatter_by_the_status_is_an_artefact_of_the_step():
    found = motion(SYSTEM, 2.76, TimeStepping(12000, 18, 500, status="end", without_solution="keep"))
    assert found.type == "periodic"
    assert "artefact of the time step" in found.reason


@pytest.mark.parametrize("status", ["start", "end"])
def test_the_contact_status_is_to_blame_and_what_is_advised_leaves_what_it_says(status):
    method = TimeStepping(12000, 18, 500, status=status, without_solution="keep")
    compared = compare(SYSTEM, 2.76, method, periods=200)
    found = verdict(compared)
    assert f"The contact status at the {status} of the step is to blame" in found.headline
    assert (found.blame, found.change) == ("status", {"status": "located"})
    advised = compare(SYSTEM, 2.76, with_located_steps(method), periods=200)
    assert advised.total == pytest.approx(found.left, rel=0.05)
    assert advised.total < compared.total


def test_one_method_under_two_names_gets_one_verdict():
    """The paper's Newmark is a choice of status, integrator and law like any other."""
    options = {"periods": 600, "keep": 50}
    found = [verdict(compare(SYSTEM, 2.76, kind(12000, 18, 2000), **options)) for kind in (Newmark, TimeStepping)]
    blamed = "The contact status at the start of the step is to blame: steps cut where contact changes would leave"
    assert all(blamed in each.headline for each in found)
    assert [each.blame for each in found] == ["status", "status"]
    assert [each.change for each in found] == [{"located": True}, {"status": "located"}]
    assert found[1].left == pytest.approx(found[0].left, rel=0.1)


def test_the_number_of_steps_that_is_named_leaves_what_is_said():
    for method in (Newmark(12000, 18, 500), TimeStepping(12000, 18, 500, CentralDifference())):
        found = verdict(compare(SYSTEM, 2.76, method))
        steps, said = re.search(r"([\d,]+) steps a period (?:leave )?([\d.]+) %", found.headline).groups()
        advised = compare(SYSTEM, 2.76, replace(method, steps=int(steps.replace(",", "")))).total
        assert 100 * advised == pytest.approx(float(said), rel=0.15)
        assert advised <= 1.3 * 0.04  # what no time step leaves


def test_steps_that_are_not_enough_are_not_proposed():
    method = Newmark(12000, 18, 500)
    compared = compare(SYSTEM, 2.76, method, **SHORT)
    nothing_else = [Experiment("steps", compared.total / 1000)]
    tried = with_enough_steps(compared, nothing_else)
    assert (tried.enough, tried.method.steps) == (False, 20 * 500)
    sentence, change = blame_sentence(compared, [*nothing_else, tried], nothing_else[0])
    assert "; even 10,000 steps a period leave" in sentence
    assert change == {}


def test_trying_more_steps_and_choices_can_be_cancelled():
    compared = compare(SYSTEM, 2.76, Newmark(12000, 18, 500), **SHORT)
    for search in (with_enough_steps, lambda *arguments: run_experiments(arguments[0], arguments[2])):
        with pytest.raises(Cancelled):
            search(compared, [Experiment("steps", 0.03)], lambda: True)


def test_a_located_step_has_a_verdict():
    found = verdict(compare(SYSTEM, 2.76, TimeStepping(12000, 18, 50, status="located")))
    assert (found.blame, list(found.change)) == ("steps", ["steps"])


def test_the_dampers_jump_is_blamed_where_the_law_without_it_leaves_least():
    system, options = System(kappa=0.6, mu=0.8, d1=0.03, d2=0.03, d3=None), {"periods": 300, "keep": 20}
    method = Newmark(224, 4.8, 2000)
    found = verdict(compare(system, 0.76, method, **options))
    assert (found.blame, found.change) == ("law", {"law": "limited"})
    assert "The damper's jump at touch is to blame" in found.headline
    advised = compare(system, 0.76, TimeStepping(224, 4.8, 2000, law="limited"), **options)
    assert advised.total == pytest.approx(found.left, rel=1e-9)


def test_numerical_damping_is_to_blame_where_the_undamped_step_leaves_less():
    method = TimeStepping(12000, 16.1, 1000, NewmarkBeta(0.49, 0.9))
    compared = compare(SYSTEM, 2.76, method, **SHORT)
    experiments = run_experiments(compared)
    best = best_experiment(compared, experiments, 0.0)
    assert best.changed == "integrator"
    # the step scatters the section, so rounding changes by a tenth what is left; K that differ as little say how much
    stiffnesses = 12000 * (1 + 1e-10 * np.arange(8))
    left = [compare(SYSTEM, 2.76, TimeStepping(k, 16.1, 1000), **SHORT).total for k in stiffnesses]
    assert 0.95 * min(left) < best.remaining < 1.05 * max(left)
    assert max(left) < 0.5 * compared.total
    sentence, change = blame_sentence(compared, experiments, best)
    assert sentence.startswith("The numerical damping of newmark ")
    assert change == {"integrator": "newmark", "beta": 0.25, "gamma": 0.5}


def test_a_choice_is_blamed_only_if_it_does_nearly_as_much_as_no_time_step():
    compared = compare(SYSTEM, 2.76, TimeStepping(12000, 18, 500), **SHORT)
    steps = Experiment("steps", 0.03)
    halfway = Experiment("status", compared.total / 2, TimeStepping(12000, 18, 500, status="end"))
    nearly = Experiment("status", 0.035, halfway.method)
    assert halfway.remaining > 0.05
    assert best_experiment(compared, [steps, halfway], 0.0) is steps
    assert best_experiment(compared, [steps, nearly, halfway], 0.0) is nearly


def test_every_choice_is_changed_alone():
    method = TimeStepping(100.0, 1.0, 200, HHT(-0.2), "end", "keep")
    for name, changed in changed_choices(method):
        differing = [each for each in vars(method) if getattr(changed, each) != getattr(method, each)]
        assert differing == [name]
    assert dict(changed_choices(method))["integrator"].integrator == NewmarkBeta()


def test_a_run_without_a_solution_says_when_why_and_what_finishes():
    compared = compare(SYSTEM, 2.76, TimeStepping(12000, 18, 500, status="end"), periods=100, keep=10)
    found = verdict(compared)
    assert (found.agree, found.blame) == ("unknown", "law")
    stopped = compared.runs.penalty
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
