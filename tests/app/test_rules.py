"""Rules of thumb: the numbers that they give, what is measured of them, and the command."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.codes.rules import Rule, RuleQuestion, judge, rules
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.your_code.rules import rows_of
from vibroscope.app.studies.your_code import Judged
from vibroscope.engine import (
    CentralDifference,
    ComparisonQuestion,
    Excitation,
    Impact,
    Newmark,
    Reference,
    System,
    TimeStepping,
    compare,
    impact,
    percent,
    simulate,
    with_located_steps,
)
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.tolerances import CLOSE_CURVE

PAPER = RuleQuestion(System(), 2.76, Newmark(12000.0, 18.0, 2000), element_stiffness=7.0)
SHORT = {"periods": 40, "keep": 8}
SHARE, PERIOD = System().mass_share, 2 * math.pi / 2.76


@pytest.mark.parametrize(
    ("key", "name", "value"),
    [
        ("ansys-mode", "steps", math.ceil(20)),  # η is the highest frequency here
        ("ansys-contact", "steps", math.ceil(30 * PERIOD * math.sqrt(12000 / SHARE) / (2 * math.pi))),
        ("radioss-step", "steps", math.ceil(PERIOD / math.sqrt(2 * 0.873 / (12000 + 5.07)))),
        ("abaqus-ten", "stiffness", 10 * 7.0),
        ("mathworks-penetration", "stiffness", 100 * 2.76**2),
        ("lsdyna-noise", "damping", 0.2 * System().mass_ratio * math.sqrt(12000 / SHARE)),
        ("lsdyna-soft", "stiffness", 0.1 * System().mass_ratio * (2000 / PERIOD) ** 2),
        ("mujoco-constant", "stiffness", SHARE * (2000 / PERIOD / 2) ** 2),
    ],
)
def test_a_rule_gives_the_numbers_of_its_formula_and_leaves_the_others(key, name, value):
    found = rules()[key].method(PAPER)
    assert getattr(found, name) == pytest.approx(value, rel=2e-3 if name == "steps" else 1e-12)
    gives = {"K": "stiffness", "D": "damping", "steps": "steps"}
    kept = [own for each, own in gives.items() if each not in rules()[key].gives]
    assert all(getattr(found, own) == getattr(PAPER.method, own) for own in kept)


def test_the_force_that_presses_is_that_on_either_body():
    drive = Excitation(base=2.0, force1=0.1, force2=-4.0)
    asked = RuleQuestion(System(mu=3.0, d3=None, excitation=drive), 1.5, PAPER.method)
    assert rules()["mathworks-penetration"].method(asked).stiffness == pytest.approx(100 * (3.0 * 2.0 * 1.5**2 + 4.0))


def test_the_restitution_rule_and_the_time_constant_are_damped_as_they_say():
    damping = rules()["restitution"].method(PAPER).damping
    ratio = damping / math.sqrt(12000 * SHARE)
    assert math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)) == pytest.approx(0.5)
    critical = rules()["mujoco-constant"].method(PAPER)
    assert critical.damping == pytest.approx(math.sqrt(critical.stiffness * SHARE))


def test_what_follows_is_what_compare_finds():
    rule = rules()["lsdyna-crash"]
    found = judge(rule, PAPER, **SHORT)
    own = compare(ComparisonQuestion(PAPER.system, PAPER.eta, rule.method(PAPER), **SHORT))
    assert found.total == own.difference.total
    assert found.part == own.difference.parts["regularisation"]
    assert found.holds == (found.part <= CLOSE_CURVE)
    known = simulate(PAPER.system, PAPER.eta, rule.method(PAPER), **SHORT)
    assert judge(rule, PAPER, responses=[known], **SHORT).as_dict() == found.as_dict()


def test_a_rule_says_what_a_contact_alone_gives_with_its_step(capsys):
    """D is as it should be, and K and D hold; the step leaves the rebound to chance."""
    asked = replace(PAPER, method=replace(PAPER.method, steps=300))
    rule, reference = rules()["restitution"], simulate(asked.system, asked.eta, Reference())
    found, method = judge(rule, asked), rule.method(asked)
    step = 2 * math.pi / (asked.eta * 300)
    one = Impact(method, mean_closing_speed(reference), SHARE, step)
    e = impact(one).restitution
    said = f"0.50 without a step, {e.least:.2f} to {e.greatest:.2f} with {one.steps_per_contact:.3g} steps in it"
    assert found.holds
    assert e.least < 0.2
    assert found.contact == f"Once its force is over, a contact alone has a restitution of {said}."
    numbers = found.as_dict()
    assert numbers["contact_alone_restitution_least"] == pytest.approx(e.least, rel=1e-9)
    assert numbers["contact_alone_steps"] == pytest.approx(one.steps_per_contact, rel=1e-12)
    main(["rules", "restitution", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "300"])
    assert said in " ".join(capsys.readouterr().out.split())
    row = rows_of([Judged(found, np.empty((2, 0)))], np.empty((2, 0)), [], Setting())["rows"][0]
    assert row["why"].endswith(found.contact)


def test_a_run_that_ends_early_fails_and_says_why():
    found = judge(rules()["ansys-mode"], PAPER, **SHORT)
    assert found.holds is False
    assert "blew up" in found.why
    assert found.as_dict()["total"] is None
    stops = TimeStepping(12000.0, 18.0, 2000, status="end")  # in period 5, at a step without a solution
    rule = Rule("key", "title", "damping_ratio", 18.0 / math.sqrt(12000 * SHARE), "claim", "source")
    found = judge(rule, RuleQuestion(System(), 2.76, stops), **SHORT)
    assert (found.holds, found.without_solution) == (False, 1)
    assert "has no solution" in found.why
    assert re.fullmatch(r"Step \d+ \(period 5\) has no solution\.", found.brief)


def test_a_step_that_is_too_long_tests_no_stiffness_and_no_damping():
    explicit = TimeStepping(12000.0, 18.0, 100, CentralDifference())
    found = {
        key: judge(rules()[key], RuleQuestion(System(), 2.76, explicit)) for key in ("lsdyna-noise", "radioss-step")
    }
    assert all("blew up" in each.why for each in found.values())
    assert found["lsdyna-noise"].holds is None
    assert found["radioss-step"].holds is False  # it gives the step


ELEMENTS = ("ansys-bending", "ansys-bulk", "abaqus-ten", "numgeo-twenty", "calculix-fifty", "sap-hundred")


@pytest.mark.parametrize("key", ELEMENTS)
def test_a_rule_about_the_elements_is_judged_where_their_stiffness_is_given(key):
    """Not by the springs that hold the bodies: those of an element are E A/h."""
    unknown = judge(rules()[key], RuleQuestion(System(), 2.76, Newmark(12000.0, 18.0, 500)), **SHORT)
    assert (unknown.holds, unknown.method, unknown.motion) == (None, None, "")
    assert "the stiffness EA/h of the elements in contact" in unknown.why
    given = RuleQuestion(System(), 2.76, Newmark(12000.0, 18.0, 500), element_stiffness=3.0)
    assert rules()[key].method(given).stiffness == pytest.approx(rules()[key].number * 3.0)
    with pytest.raises(ValueError, match=r"element_stiffness = 0\.0 is outside"):
        RuleQuestion(System(), 2.76, Newmark(12000.0, 18.0, 500), element_stiffness=0.0)


def test_a_rule_about_stability_is_judged_by_stability_with_central_differences():
    """Newmark's method with the same step has 94 % of error, which the rule does not promise to avoid."""
    undamped = RuleQuestion(System(), 2.76, Newmark(12000.0, 0.0, 2000))
    found = judge(Rule("key", "title", "nodal_step", 0.8, "claim", "source"), undamped, periods=200)
    assert isinstance(found.method.integrator, CentralDifference)
    assert (found.holds, found.motion, math.isnan(found.total)) == (True, "stays bounded", True)
    assert found.why == found.brief == "With central differences the run stays bounded over 200 periods."
    longer = judge(rules()["radioss-step"], undamped, periods=200)
    assert (longer.holds, longer.motion) == (False, "ended early")
    assert "central differences blew up" in longer.why
    assert longer.brief == "The solution by central differences blew up."


def test_a_rule_about_a_linear_spring_is_not_judged_by_another():
    asked = RuleQuestion(System(), 2.76, TimeStepping(12000.0, 18.0, 500, law="impact", penetration=0.01), 7.0)
    for key in ("ansys-contact", "abaqus-ten", "restitution", "lsdyna-soft"):
        found = judge(rules()[key], asked, **SHORT)
        assert found.holds is None
        assert "a linear contact spring, which the law impact does not have" in found.why


def test_a_force_that_is_cut_is_compared_and_what_gives_no_number_is_said():
    method = Newmark(12000.0, 18.0, 500, law="cut")
    found = judge(rules()["lsdyna-noise"], RuleQuestion(System(), 2.76, method), **SHORT)
    assert found.motion
    assert found.total > 0
    still = System(excitation=Excitation(base=0.0))
    found = judge(rules()["mathworks-penetration"], RuleQuestion(still, 2.76, PAPER.method))
    assert found.method is None
    assert "nothing drives the bodies" in found.why
    with pytest.raises(ValueError, match="rule key"):
        Rule("key", "title", "magic", 1.0, "claim", "source")


@pytest.mark.parametrize(
    ("system", "key", "words"),
    [
        (System(wall=True, clearance=-60.0), "ansys-mode", "The reference does not move"),
        (System(clearance=-0.5, excitation=Excitation(base=0.0)), "abaqus-ten", "The reference does not move"),
        (System(wall=True, clearance=1000.0), "abaqus-ten", "Nothing touches"),
    ],
)
def test_a_motion_that_cannot_show_whether_a_rule_holds_says_so(system, key, words):
    found = judge(rules()[key], RuleQuestion(system, 1.2, Newmark(1000.0, 5.0, 500), 5.0))
    assert found.holds is None
    assert words in found.why
    assert "not known" not in found.why


def test_a_step_is_judged_where_nothing_touches():
    apart = RuleQuestion(System(wall=True, clearance=1000.0), 1.2, Newmark(1000.0, 5.0, 500))
    assert judge(rules()["ansys-mode"], apart).holds


@pytest.mark.parametrize(
    "rule", [rules()["restitution"], Rule("key", "title", "damping_ratio", 0.2, "claim", "source")]
)
def test_the_blur_of_the_step_is_not_charged_to_a_rule_for_the_damper(rule):
    asked = RuleQuestion(System(), 1.39, Newmark(3870.0, 12.7, 654))
    found = judge(rule, asked)
    without = compare(ComparisonQuestion(asked.system, asked.eta, with_located_steps(found.method))).difference.total
    assert found.total > 2 * CLOSE_CURVE
    assert without < CLOSE_CURVE
    assert found.holds
    assert found.part < CLOSE_CURVE
    assert found.why.startswith(f"Without a time step {percent(found.part)} is left of the {percent(found.total)}.")


def test_a_rule_for_the_step_is_judged_by_what_the_step_adds():
    rule = Rule("key", "title", "steps_per_contact", 14.2, "claim", "source")
    asked = RuleQuestion(System(), 1.39, Newmark(3870.0, 9.148, 2000))
    found = judge(rule, asked)
    assert (found.holds, found.part > CLOSE_CURVE) == (False, True)
    assert found.why.startswith(f"The time step adds {percent(found.part)}: without a time step ")


def test_the_command_prints_what_each_rule_gives(capsys):
    few = ["--periods", "20", "--K", "12000", "--D", "18", "--steps", "500", "lsdyna-noise", "ansys-mode"]
    assert main(["rules", "--eta", "2.76", *few]) == 0
    printed = capsys.readouterr().out
    assert "Contact damping 20 % of critical" in printed
    assert "[ansys-mode: Ansys MAPDL" in printed
    assert main(["rules", "--eta", "2.76", "--code", "calculix", "--json", *few]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "HHT(alpha=-0.05)" in found["method"]
    assert [each["key"] for each in found["rules"]] == ["lsdyna-noise", "ansys-mode"]
