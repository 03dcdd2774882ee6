"""What verdicts say of a contact alone with the step: against `impact`, asked by itself with the same numbers."""

import json
import math
import re

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import (
    CentralDifference,
    ComparisonQuestion,
    Impact,
    Newmark,
    System,
    TimeStepping,
    compare,
    equal_restitution_damping,
    impact,
    verdict,
)
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.tolerances import SAME_RESTITUTION
from vibroscope.engine.one_impact.of_system import contact_alone

SYSTEM, ETA, K = System(), 2.76, 12000.0
D = float(equal_restitution_damping(SYSTEM, K))
FEW = Newmark(K, D, 700)  # six steps in a contact
COUNTED = r"([\d.]+) without a step, ([\d.]+) to ([\d.]+) with ([\d.]+) steps in it"


def own(method, speed):
    """The contact as `vibroscope impact` is asked for it."""
    step = 2 * math.pi / (ETA * method.steps)
    return Impact(method, speed, SYSTEM.mass_share, step, restitution=SYSTEM.restitution)


def compared(method):
    return compare(ComparisonQuestion(SYSTEM, ETA, method, periods=200, keep=20))


@pytest.mark.parametrize(
    "method", [FEW, TimeStepping(K, 700.0, 500, law="hunt-crossley"), TimeStepping(K, D, 2000, CentralDifference())]
)
def test_the_evidence_has_what_impact_gives_with_this_step(method):
    comparison = compared(method)
    speed = mean_closing_speed(comparison.runs.reference)
    asked, found = own(method, speed), verdict(comparison)
    e = impact(asked).restitution
    (said,) = (text for text in found.details if "a contact alone has a restitution" in text)
    *restitutions, steps = map(float, re.search(COUNTED, said).groups())
    assert restitutions == pytest.approx([asked.without_step.restitution, e.least, e.greatest], abs=0.0051)
    assert steps == pytest.approx(asked.steps_per_contact, rel=5e-3)
    contact = found.contact.as_dict()
    assert [contact[f"restitution_{end}"] for end in ("least", "mean", "greatest")] == pytest.approx(list(e), rel=1e-9)
    assert contact["steps"] == pytest.approx(asked.steps_per_contact, rel=1e-12)
    assert contact["duration"] == pytest.approx(asked.contact_time, rel=1e-12)


def test_the_step_is_said_to_be_too_coarse_where_K_and_D_are_as_asked(capsys):
    call = f"compare --eta {ETA} --K {K:g} --D {D} --steps {FEW.steps} --periods 200 --keep 20"
    main(call.split())
    printed = " ".join(capsys.readouterr().out.split())
    main([*call.split(), "--json"])
    found = json.loads(capsys.readouterr().out)["contact"]
    assert found["restitution"] == pytest.approx(found["asked"])
    assert found["asked"] - found["restitution_least"] > SAME_RESTITUTION
    span = f"{found['restitution_least']:.2f} to {found['restitution_greatest']:.2f}"
    assert f"a contact takes only {found['steps']:.3g} steps, with which bodies keep {span} of their speed" in printed
    assert f"has a restitution of 0.50 without a step, {span} with {found['steps']:.3g} steps in it" in printed


def test_a_run_that_the_step_blows_up_says_so_of_its_contact():
    found = verdict(compared(Newmark(K, 18.0, 100)))
    said = "0.46 without a step, none at any touch with 0.886 steps in it; 100 % of the touches blow up."
    assert said in found.details[-1]


def test_where_the_step_does_not_decide_nothing_is_said_of_it():
    cut, long = contact_alone(SYSTEM, ETA, Newmark(K, D, 300, located=True), 1.0), Newmark(100.0, 0.0, 200_000)
    assert (cut.found, cut.words) == (None, "0.50 without a step")
    assert contact_alone(SYSTEM, ETA, long, 1.0).found is None
    hertz = TimeStepping(K, 18.0, 2000, law="hunt-crossley")
    assert contact_alone(SYSTEM, ETA, hertz, math.nan) is None  # nothing collides, so there is no closing speed
    assert contact_alone(SYSTEM, ETA, FEW, math.nan).words == contact_alone(SYSTEM, ETA, FEW, 7.0).words


def test_the_largest_stiffness_that_is_resolved_has_ten_steps_in_a_contact():
    found = verdict(compared(Newmark(K, 60.0, 2000))).alone.curves["K"]  # ζ = 0.8 at this K
    changed = own(Newmark(found.resolved, 60.0, 2000), 1.0)
    assert changed.steps_per_contact == pytest.approx(10.0)
