"""The verdict blames the number whose change helps most, as independent experiments of the tests confirm."""

import math
from functools import cache

import numpy as np
import pytest
from vibroscope.engine import (
    Cancelled,
    ExactPenalty,
    Newmark,
    Reference,
    System,
    compare,
    motion,
    repetition,
    simulate,
    verdict,
)
from vibroscope.engine.divergence.error import Target

from tests.share import every

SYSTEM = System()
ZETA = math.log(2) / math.hypot(math.pi, math.log(2))


def test_a_blurred_motion_is_not_said_not_to_repeat():
    """It repeats over more periods than are kept, as its evidence shows; the sentence is of the kept ones."""
    found = compare(SYSTEM, 2.76, Newmark(12000, 18, 500)).decided()
    assert repetition(found.penalty).startswith("repeats every period, blurred")
    first = verdict(found).details[0]
    assert first == (
        "Over the 50 kept periods the penalty solution does not come close to repeating, so that the difference, an "
        "average over them, has no parts."
    )


@cache
def compared(eta, method):
    return compare(SYSTEM, eta, method)


@cache
def verdict_of(eta, method):
    return verdict(compared(eta, method))


def equal(stiffness):
    return ZETA * math.sqrt(stiffness * SYSTEM.mass_share)


FIGURE_14 = [(2.76, Newmark(12000, 18, n)) for n in (2000, 4000, 6000)]
CASES = [
    ("9 A", 1.08, Newmark(2500, 8, 2000), "joint damping"),
    ("9 B", 1.08, Newmark(100, 50, 2000), "K"),
    *((f"14, T/{method.steps}", eta, method, "status") for eta, method in FIGURE_14[:2]),
    ("step too long", 2.76, Newmark(2500, 8, 12, located=True), "steps"),
    ("D too large", 2.76, Newmark(12000, 200, 8000), "D"),
    ("D too small", 2.76, Newmark(12000, 2, 8000), "D"),
    ("K too small", 2.76, Newmark(500, equal(500), 20000), "K"),
    ("fine", 1.08, Newmark(1e6, equal(1e6), 40000), "joint damping"),
]


@pytest.mark.parametrize(("eta", "method", "blame"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_the_verdict_names_the_number_that_is_to_blame(eta, method, blame):
    found = verdict_of(eta, method)
    assert found.blame == blame
    assert len(found.headline) <= 300
    assert found.headline.count(". ") + found.headline.endswith(".") <= 3
    assert "nan" not in found.headline + " ".join(found.details)


def experiments(eta, method):
    """What remains if one number alone is corrected; the runs have more periods and other values than the verdict's."""
    target = Target.find(SYSTEM, eta)
    derived = Target.find(SYSTEM, eta, Reference("derived"))

    def left(method):
        return target.error(simulate(SYSTEM, eta, method, periods=2300))

    def penalty(stiffness, damping):
        return Newmark(stiffness, damping, method.steps)

    stiffer = 20 * method.stiffness
    return {
        "status": left(Newmark(method.stiffness, method.damping, method.steps, located=True)),
        "steps": left(ExactPenalty(method.stiffness, method.damping)),
        "D": left(penalty(method.stiffness, 1.02 * equal(method.stiffness))),
        "K": min(left(penalty(stiffer, method.damping)), left(penalty(stiffer, 20**0.5 * method.damping))),
        "joint damping": derived.error(simulate(SYSTEM, eta, method, periods=2300)),
    }


@pytest.mark.parametrize(("eta", "method", "blame"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_independent_experiments_blame_the_same_number(eta, method, blame):
    left = experiments(eta, method)
    # K and D both correct Figure 9 [B] to a per cent or two; with a step that scatters, their remainders are chance
    assert left[blame] <= (1.3 if blame in ("steps", "status") else 1.02) * min(left.values())


@pytest.mark.parametrize(("eta", "method"), FIGURE_14)
def test_only_a_smaller_or_located_step_removes_the_scatter(eta, method):
    for stiffness, damping in ((12000, 18), (12000, equal(12000)), (120_000, 18), (120_000, equal(120_000))):
        assert motion(simulate(SYSTEM, eta, Newmark(stiffness, damping, method.steps))).spread > 0.01
    assert motion(simulate(SYSTEM, eta, ExactPenalty(12000, 18))).spread < 1e-9
    assert motion(simulate(SYSTEM, eta, Newmark(12000, 18, method.steps, located=True))).spread < 1e-9


@pytest.mark.parametrize(("eta", "method"), [case[1:3] for case in CASES if case[3] in {"K", "D", "status", "steps"}])
def test_following_the_advice_leaves_what_the_verdict_says(eta, method):
    found = verdict_of(eta, method)
    new = {"stiffness": found.change.get("K", method.stiffness), "damping": found.change.get("D", method.damping)}
    located = found.change.get("located", method.located)
    advised = Newmark(**new, steps=found.change.get("steps", method.steps), located=located)
    before, after = (compared(eta, each).total for each in (method, advised))
    assert after < before
    assert after == pytest.approx(found.left, rel=0.05)


def test_the_verdict_mentions_time_step_scatter():
    scattered = verdict_of(2.76, Newmark(12000, 18, 2000))
    assert "The time step blurs each point of the section" in scattered.headline
    assert 0.05 < scattered.scatter < 0.4  # over 50 periods its size depends on rounding
    located = verdict(compare(SYSTEM, 2.76, Newmark(12000, 18, 2000, located=True)))
    assert (located.scatter, located.blame) == (0, "D")


def test_what_removes_next_to_nothing_is_no_cure():
    """Without joint damping 2.4 % of 2.4 % would be left."""
    found = verdict(compare(SYSTEM, 3.25, Newmark(12000, 18, 8000)))
    assert "No single number is to blame (at best" in found.headline
    assert (found.blame, found.change) == ("", {})


def test_agreement_is_graded():
    fine = verdict(compare(SYSTEM, 2.76, Newmark(1e6, equal(1e6), 2000, located=True)))
    assert (fine.agree, fine.headline.startswith("They agree: ")) == ("yes", True)
    assert verdict_of(1.08, Newmark(2500, 8, 2000)).agree == "partly"
    assert verdict_of(1.08, Newmark(100, 50, 2000)).agree == "no"


def test_a_run_that_diverged_gets_the_number_of_steps_that_suffices():
    method = Newmark(60000, 1, 100)
    found = verdict(compare(SYSTEM, 2.76, method))
    assert (found.agree, found.blame) == ("unknown", "steps")
    assert simulate(SYSTEM, 2.76, Newmark(60000, 1, found.change["steps"])).ok
    assert not simulate(SYSTEM, 2.76, Newmark(60000, 1, found.change["steps"] // 2)).ok
    assert np.isnan(found.left)
    assert found.as_dict()["left"] is None


def test_a_motion_that_grows_without_end_gets_a_verdict_while_it_is_still_finite():
    """It is beyond every start that may be given."""
    system = System(kappa=1.38, kappa3=1.08, d1=0.014, d2=0.0043, d3=0.049, restitution=0.6)
    comparison = compare(system, 0.6163, Newmark(2320, 0.331, 600), periods=50, keep=16)
    assert comparison.runs.penalty.ok
    assert np.abs(comparison.runs.penalty.section[-1]).max() > 1e6
    assert verdict(comparison).agree == "no"


def test_chaotic_motions_are_judged_by_statistics():
    found = verdict(compare(SYSTEM, 1.7, Newmark(12000, 18, 8000)))
    assert "statistics" in found.headline
    assert found.blame == "D"
    stiff = compare(SYSTEM, 1.7, Newmark(1e6, equal(1e6), 400, located=True))
    assert stiff.statistics.total < 0.5 * compare(SYSTEM, 1.7, Newmark(12000, 18, 8000)).statistics.total


def test_doubled_motions_are_compared_pointwise():
    compared = compare(SYSTEM, 3.25, Newmark(12000, 18, 8000))
    found = verdict(compared)
    assert compared.pointwise
    assert found.agree == "partly"
    assert "statistics" not in found.headline
    assert "repeats" not in found.headline  # both after two periods


def test_agreement_with_another_motion_of_the_reference_is_not_an_error():
    """At η = 3.2 the reference has a motion of two periods, from rest, and one of six."""
    found = verdict(compare(SYSTEM, 3.2, Newmark(2500, 8, 2000)))
    assert "different but valid" in found.headline
    assert (found.agree, found.blame) == ("partly", "")
    assert found.left < 0.1


@pytest.mark.parametrize("method", [Newmark(100, 50, 2000), Newmark(60000, 1, 100)])
def test_a_verdict_can_be_cancelled(method):
    found = compare(SYSTEM, 2.76, method)
    with pytest.raises(Cancelled):
        verdict(found, cancelled=lambda: True)


@pytest.mark.parametrize("eta", every([1.6689, 3.1566, 3.5744]))
def test_a_reference_that_repeats_only_nearly_is_compared_by_statistics(eta):
    found = compare(System(), eta, Newmark(2500, 8, 2000))
    assert not found.motions.reference.period
    assert not found.pointwise
    assert "only statistics can be compared" in verdict(found).headline
