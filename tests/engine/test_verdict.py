"""The verdict blames the numbers whose change alone helps most, as independent runs of the tests confirm."""

import math

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Newmark,
    System,
    motion,
    repetition,
    simulate,
    verdict,
)
from vibroscope.engine.divergence.conditions import contact_conditions
from vibroscope.engine.divergence.encounters import delivered_restitution
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.sentences import detail_sentences
from vibroscope.engine.wording import percent

from tests.answers import compared, verdict_of
from tests.share import every

SYSTEM = System()
ZETA = math.log(2) / math.hypot(math.pi, math.log(2))


def test_a_blurred_motion_is_not_said_not_to_repeat():
    """It repeats over more periods than are kept, as its evidence shows; the sentence is of the kept ones."""
    found = compared(SYSTEM, 2.76, Newmark(12000, 18, 500)).decided()
    assert repetition(found.penalty).startswith("repeats every period, blurred")
    first = verdict_of(SYSTEM, 2.76, Newmark(12000, 18, 500)).details[0]
    assert first == (
        "Over the 50 kept periods the penalty solution does not come back within 3 % of the section's size, so that "
        "the difference, an average over them, has no parts."
    )


def equal(stiffness):
    return ZETA * math.sqrt(stiffness * SYSTEM.mass_share)


FINE = Newmark(1e5, equal(1e5), 100, located=True)
FIGURE_14 = [(2.76, Newmark(12000, 18, n)) for n in (2000, 4000, 6000)]
CASES = [  # each number; others like them below
    ("9 B", 1.08, Newmark(100, 50, 2000), {"K", "D"}),
    ("14, T/2000", *FIGURE_14[0], {"status"}),
    ("step too long", 2.76, Newmark(2500, 8, 12, located=True), {"steps"}),
    ("D too small", 2.76, Newmark(12000, 2, 2000), {"D"}),
    ("fine", 1.08, Newmark(1e4, equal(1e4), 2000), {"joint damping"}),
]
ALIKE = [
    ("9 A", 1.08, Newmark(2500, 8, 2000), {"joint damping"}),
    ("14, T/4000", *FIGURE_14[1], {"K", "D"}),  # without a step 58 % of it are left
    ("D too large", 2.76, Newmark(12000, 200, 2000), {"D"}),
    ("K too small", 2.76, Newmark(500, equal(500), 4000), {"K", "D"}),
]


@pytest.mark.parametrize(
    ("eta", "method", "blame"),
    [pytest.param(*case, id=name) for name, *case in CASES]
    + [pytest.param(*case, id=name, marks=pytest.mark.release) for name, *case in ALIKE],
)
def test_the_verdict_names_the_number_that_is_to_blame(eta, method, blame):
    found = verdict_of(SYSTEM, eta, method)
    assert blame <= set(found.blame)
    assert found.blame[0] in blame
    assert len(found.headline) <= 400
    assert found.headline.count(". ") + found.headline.endswith(".") <= 3
    assert "nan" not in found.headline + " ".join(found.details)


@pytest.mark.parametrize(("eta", "method"), FIGURE_14)
def test_only_a_smaller_or_located_step_removes_the_scatter(eta, method):
    for stiffness, damping in ((12000, 18), (12000, equal(12000)), (120_000, 18), (120_000, equal(120_000))):
        assert motion(simulate(SYSTEM, eta, Newmark(stiffness, damping, method.steps))).spread > 0.01
    assert motion(simulate(SYSTEM, eta, ExactPenalty(12000, 18))).spread < 1e-9
    assert motion(simulate(SYSTEM, eta, Newmark(12000, 18, method.steps, located=True))).spread < 1e-9


@pytest.mark.parametrize(
    ("eta", "method"),
    [case[1:3] for case in CASES if case[3] != {"joint damping"}]
    + [pytest.param(*case[1:3], marks=pytest.mark.release) for case in ALIKE[1:]],
)
def test_following_the_advice_leaves_what_the_verdict_says(eta, method):
    found = verdict_of(SYSTEM, eta, method)
    new = {"stiffness": found.change.get("K", method.stiffness), "damping": found.change.get("D", method.damping)}
    located = found.change.get("located", method.located)
    advised = Newmark(**new, steps=found.change.get("steps", method.steps), located=located)
    before, after = (compared(SYSTEM, eta, each).total for each in (method, advised))
    assert after < before
    assert after == pytest.approx(found.left, rel=0.05)


def test_the_verdict_mentions_time_step_scatter():
    scattered = verdict_of(SYSTEM, 2.76, Newmark(12000, 18, 2000))
    assert "The time step blurs each point of the section" in scattered.headline
    assert 0.05 < scattered.scatter < 0.4  # over 50 periods its size depends on rounding
    assert verdict_of(SYSTEM, 2.76, FINE).scatter == 0


SHORT_SEARCH = System(kappa=2.62, mu=1.57, restitution=0.45, clearance=1.0), 2.85, Newmark(6360, 37.8, 100)


@pytest.mark.parametrize("asked", [(SYSTEM, 3.25, Newmark(12000, 18, 8000)), SHORT_SEARCH])
def test_numbers_that_do_nothing_alone_are_changed_together(asked):
    """What they leave is what a comparison with them has; the runs of the second search are a quarter as long."""
    found, total = verdict_of(*asked), compared(*asked).total
    assert "to be changed together" in found.headline
    assert found.together
    assert {"K", "D"} <= set(found.blame) == set(found.change)
    method = asked[2]
    steps = found.change.get("steps", method.steps)
    advised = compared(*asked[:2], Newmark(found.change["K"], found.change["D"], steps)).difference
    assert f"steps a period leave about {percent(advised.total)}" in found.headline
    assert f"steps a period about {percent(advised.total)} are left: {advised.certainty}." in found.details[-1]
    assert found.left == pytest.approx(advised.total, rel=0.02)  # scatter depends on rounding
    assert advised.total < 0.5 * total


def test_contacts_that_do_not_rebound_as_asked_are_named_where_motions_agree():
    """Without contacts that rebound, the lasting contact of this motion is still there."""
    found = verdict_of(SYSTEM, 1.08, Newmark(100, 5, 2000))
    assert found.agree == "partly"
    assert "But a contact alone rebounds with 0.0" in found.headline
    assert not found.contact.rebounds


def test_a_damper_is_said_to_give_the_restitution_only_where_it_does():
    """Where other forces act during a contact, or the step is too long for it, that of a contact alone does not."""
    cases = ((12000, 4, 2000, True), (12000, 60, 2000, True), (300, 1, 2000, False), (12000, 60, 200, False))
    for stiffness, damping, steps, gives in cases:
        comparison = compared(SYSTEM, 2.76, Newmark(stiffness, damping, steps))
        details = " ".join(map(str, detail_sentences(comparison, None, contact_conditions(comparison), None)))
        delivered = delivered_restitution(simulate(SYSTEM, 2.76, Newmark(stiffness, equal(stiffness), steps)))
        assert (abs(delivered - SYSTEM.restitution) < 0.05 * SYSTEM.restitution) == gives
        assert ("alone gives" in details) == gives


def test_agreement_is_graded():
    fine = verdict_of(SYSTEM, 2.76, FINE)
    assert (fine.agree, fine.headline.startswith("They agree: ")) == ("yes", True)
    near, far = (verdict_of(SYSTEM, 1.08, method) for method in (Newmark(2500, 8, 2000), Newmark(100, 50, 2000)))
    assert (near.agree, near.headline.startswith("They agree roughly: ")) == ("partly", True)
    assert (far.agree, far.headline.startswith("They disagree: ")) == ("no", True)


@pytest.mark.parametrize("steps", [100, 10])
def test_a_run_that_diverged_gets_the_number_of_steps_that_suffices(steps):
    method = Newmark(60000, 1, steps)
    found = verdict_of(SYSTEM, 2.76, method)
    assert (found.agree, found.blame) == ("unknown", ("steps",))
    assert simulate(SYSTEM, 2.76, Newmark(60000, 1, found.change["steps"])).ok
    assert not simulate(SYSTEM, 2.76, Newmark(60000, 1, found.change["steps"] // 2)).ok
    assert np.isnan(found.left)
    assert found.as_dict()["left"] is None


def test_a_motion_that_grows_without_end_is_run_until_it_is_seen_to_blow_up():
    """After 50 periods it is still finite, beyond every start that may be given."""
    system = System(kappa=1.38, kappa3=1.08, d1=0.014, d2=0.0043, d3=0.049, restitution=0.6)
    assert simulate(system, 0.6163, Newmark(2320, 0.331, 600), periods=50, keep=16).ok
    comparison = compared(system, 0.6163, Newmark(2320, 0.331, 600), periods=50, keep=16)
    assert verdict(comparison).headline.startswith("The penalty solution blew up")


def test_chaotic_motions_are_judged_by_statistics():
    found = verdict_of(SYSTEM, 1.7, Newmark(12000, 18, 2000))
    assert "statistics" in found.headline
    assert set(found.blame) & {"K", "D"}
    stiff = compared(SYSTEM, 1.7, Newmark(1e6, equal(1e6), 400, located=True))
    assert stiff.statistics.total < 0.5 * compared(SYSTEM, 1.7, Newmark(12000, 18, 2000)).statistics.total


@pytest.mark.release  # ten seconds
def test_sections_that_differ_by_no_more_than_chance_agree():
    asked = SYSTEM, 1.7, Newmark(1e7, equal(1e7), 400, located=True)
    difference, found = compared(*asked).difference, verdict_of(*asked)
    assert difference.total <= difference.chance
    assert (found.agree, found.blame) == ("yes", ())
    assert "no more than chance explains" in found.headline


def test_doubled_motions_are_compared_pointwise():
    comparison = compared(SYSTEM, 3.25, Newmark(12000, 18, 8000))
    found = verdict_of(SYSTEM, 3.25, Newmark(12000, 18, 8000))
    assert comparison.pointwise
    assert found.agree == "partly"
    assert "statistics" not in found.headline
    assert "repeats" not in found.headline  # both after two periods


def test_agreement_with_another_motion_of_the_reference_is_not_an_error():
    """At η = 3.2 the reference has a motion of two periods, from rest, and one of six."""
    found = verdict_of(SYSTEM, 3.2, Newmark(2500, 8, 2000))
    assert "different but valid" in found.headline
    assert (found.agree, found.blame) == ("partly", ())
    assert found.left < 0.1
    assert "From rest they are" in found.headline
    beside = verdict_of(SYSTEM, 3.2, Newmark(2500, 8, 2000), initial=(0.0, 1e-9, 0.0, 0.0))
    assert "From the same start they are" in beside.headline


@pytest.mark.parametrize("eta", every([1.6689, 3.5744]))
def test_a_reference_that_repeats_only_nearly_is_compared_by_statistics(eta):
    found = compared(SYSTEM, eta, Newmark(2500, 8, 2000))
    assert not found.motions.reference.period
    assert not found.pointwise
    assert "only statistics can be compared" in verdict_of(SYSTEM, eta, Newmark(2500, 8, 2000)).headline


@pytest.mark.parametrize(
    "method",
    [
        *(Newmark(1e12, 1e9, 40), Newmark(1e-6, 0.0, 40), Newmark(1e6, 1e-9, 4000), Newmark(1e3, 8, 4)),
        pytest.param(Newmark(1e6, 1e-9, 200_000), marks=pytest.mark.release),  # a minute
    ],
)
def test_numbers_at_the_ends_of_their_ranges_have_a_verdict(method):
    words = verdict_of(SYSTEM, 2.76, method, periods=60, keep=8)
    assert words.headline
    assert "nan" not in words.headline


def test_the_curves_hold_what_runs_with_their_values_leave():
    found = verdict_of(SYSTEM, 3.69, Newmark(66, 21, 3600)).alone
    assert sorted(found.curves) == ["D", "K", "steps"]
    target = Target.find(SYSTEM, 3.69)
    for name, curve in found.curves.items():
        assert (np.diff(curve.values) > 0).all()
        assert curve.values[0] < curve.present < curve.values[-1]
        for i in (0, len(curve.values) // 2, -1):
            numbers = {"K": 66.0, "D": 21.0, "steps": 3600} | {name: curve.values[i]}
            run = simulate(SYSTEM, 3.69, Newmark(numbers["K"], numbers["D"], int(numbers["steps"])))
            assert target.error(run) == pytest.approx(curve.left[i], rel=0.05)
    equal_stiffness = (21 / ZETA) ** 2 / SYSTEM.mass_share
    assert found.curves["K"].equal == pytest.approx(equal_stiffness)
    assert found.curves["D"].equal == pytest.approx(equal(66))
    assert 15_000 < found.curves["K"].best.value < 30_000
    assert found.curves["K"].best.left < 0.04
