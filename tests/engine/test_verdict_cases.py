"""Settings of which a verdict said what is not so; what it says now, beside runs of the test's own."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from vibroscope.engine import (
    Excitation,
    Kind,
    Newmark,
    Record,
    Reference,
    System,
    TimeStepping,
    motion,
    simulate,
    verdict,
)
from vibroscope.engine.divergence.grid import repeats
from vibroscope.engine.drivers.section import period_of

from tests.answers import compared, verdict_of
from tests.claims.runs import Runs, energy_lost
from tests.claims.sentences import apply, changes_in
from tests.claims.settings import Setting
from tests.share import every

PAPER = System()
NEVER_MEETS = System(kappa=1.773, mu=1.152, d1=0.0293, d2=0.00816, d3=0.054, restitution=0.385, clearance=1.04)
WALL = System(wall=True, d1=0.0107, restitution=0.129, clearance=-0.658)
FORCED = System(
    kappa=2.389, mu=0.9817, d1=0.0276, d2=0.0305, d3=0.0501, restitution=0.515, clearance=-0.58,
    excitation=Excitation(force1=0.79, force2=1.98, force2_phase=3.58, constant1=0.0634),
)  # fmt: skip
APART = System(kappa=3.617, mu=3.377, d1=0.0175, d2=0.00398, d3=0.0522, restitution=0.74, clearance=1.04)
TOUCHING = System(kappa=0.9117, mu=0.2788, d1=0.0405, d2=0.0444, d3=None, restitution=0.789)


@cache
def judged(*setting):
    """The comparison and verdict of a setting, and runs of the same periods."""
    found = compared(*setting)
    return found, verdict_of(*setting), Runs(Setting(*setting), found.runs.penalty.periods, found.runs.penalty.keep)


K_ALONE = [  # every time it said that D is to blame, or no single number
    (PAPER, 3.69, Newmark(66, 21, 3600), 0.08),
    (PAPER, 2.3, Newmark(70000, 6, 1000), 0.1),
    (WALL, 2.71, Newmark(61.3, 38.4, 1000), 0.03),
    (PAPER, 2.48, Newmark(90, 40, 6000), 0.06),
]


@pytest.mark.parametrize(("system", "eta", "method", "left"), every(K_ALONE))
def test_k_is_named_where_k_alone_removes_what_no_other_number_does(system, eta, method, left):
    _, words, runs = judged(system, eta, method)
    assert "K is to blame" in words.headline
    first = changes_in(words.headline)[0]
    assert first.name == "K"
    assert runs.error(apply(method, first)) < left


def test_both_numbers_are_named_that_do_the_same():
    """Figure 9 [B]: the contact is overdamped; it said that K alone is to blame, although D does as well."""
    setting = PAPER, 1.08, Newmark(100, 50, 2000)
    _, words, runs = judged(*setting)
    assert "D and K are to blame, each alone" in words.headline
    said = changes_in(words.headline)
    assert {each.name for each in said} == {"K", "D"}
    assert all(runs.error(apply(setting[2], each)) < 0.082 for each in said)
    assert "rebounds with 0 of its speed" in words.headline
    assert "soft" not in words.headline


LONG = [(APART, 1.22, Newmark(81.3, 0.815, 214)), (PAPER, 3.74, Newmark(5400, 5, 8000))]


@pytest.mark.parametrize(("system", "eta", "method"), LONG)
def test_a_long_transient_of_the_reference_is_not_compared(system, eta, method):
    """The reference moves irregularly for more than ten thousand periods, and then repeats itself."""
    found, later = compared(system, eta, method), compared(system, eta, method, periods=20_000)
    late = simulate(system, eta, Reference(), periods=40_000, keep=200)
    impacts = len(late.impacts) / late.keep
    assert found.difference.measure == "displacements"
    assert found.reference.impacts_per_period == pytest.approx(impacts, rel=0.02)
    assert found.motions.reference.period > 0
    if system is PAPER:
        assert (found.runs.reference.periods, found.reference.period) == (32_800, 2)
        assert later.total == pytest.approx(found.total, rel=1e-3)


@pytest.mark.parametrize(("system", "eta", "method"), every(LONG))
def test_a_verdict_is_that_of_longer_runs_and_says_how_long_its_own_are(system, eta, method):
    _, words, _ = judged(system, eta, method)
    long = verdict_of(system, eta, method, periods=20_000)
    assert words.blame == long.blame
    assert words.change == pytest.approx(long.change, rel=0.1)
    assert any("after 2,050 the motions had not settled" in each for each in words.details)


def test_what_other_numbers_mend_is_not_charged_to_the_joint_damping():
    _, words, runs = judged(APART, 1.22, Newmark(81.3, 0.815, 214))
    assert runs.error(Newmark(100_000, 26.5, 4000, located=True)) < 0.01
    assert "joint damping" not in words.blame
    assert "mends it" not in words.headline


def test_nothing_touches_is_said_of_both_solutions():
    setting = NEVER_MEETS, 3.3, Newmark(1000, 0.1, 1000)
    found, words, _ = judged(*setting)
    assert len(simulate(*setting).impacts) > 0
    assert found.penalty.contact_share > 0
    assert "Nothing touches" not in words.headline


def test_d_alone_leaves_nothing_where_nothing_meets_in_the_reference():
    _, words, runs = judged(NEVER_MEETS, 3.3, Newmark(1000, 0.1, 1000))
    assert words.blame[0] == "D"
    assert runs.error(apply(runs.method, changes_in(words.headline)[0])) < 0.001


@pytest.mark.parametrize(
    ("eta", "method"),
    [(3.3, Newmark(4000, 9, 60_000)), (3.25, Newmark(2320, 2.03, 60_000)), (3.25, Newmark(2320, 2.03, 19_900))],
)
def test_energy_is_of_whole_cycles_whatever_the_step(eta, method):
    found = motion(PAPER, eta, method)
    run = simulate(PAPER, eta, method, keep=found.near_period, record=Record(found.near_period, method.steps))
    work = energy_lost(PAPER, eta, run)[0]
    assert found.energy_lost - found.energy_created == pytest.approx(work, rel=0.02)
    impulse = float(np.sum(run.impacts.impulse)) / found.near_period
    assert found.impulse == pytest.approx(impulse, rel=0.03)


def test_two_chaotic_motions_are_of_one_kind():
    """The section of one came near to itself after some periods; both are chaotic."""
    words = verdict(compared(PAPER, 3.77, Newmark(2000, 5.4, 900)).with_evidence())
    assert "differ in kind" not in words.headline
    assert words.reference.type == words.penalty.type == Kind.CHAOTIC


def test_bodies_that_never_meet_do_not_part():
    found, words, _ = judged(NEVER_MEETS, 2.83, Newmark(15_700, 1.33, 2500))
    if len(found.runs.penalty.impacts) == 0:
        assert not [text for text in words.details if text.startswith("In the motion the bodies part with")]


@pytest.mark.parametrize(
    ("eta", "method"),
    [(2.99, Newmark(61.9, 0.191, 266)), (2.98, Newmark(10_000, 0.9, 1000)), (2.71, Newmark(600, 2, 200))],
)
def test_no_time_step_leaves_what_a_run_without_one_has(eta, method):
    """It was in step with the penalty solution, not with the reference."""
    _, words, runs = judged(PAPER, eta, method)
    for each in changes_in(" ".join((words.headline, *words.details))):
        if each.name == "limit":
            assert runs.error(method.limit) == pytest.approx(each.left, rel=0.05)


def test_a_status_that_stops_a_run_is_not_said_to_leave_anything():
    setting = FORCED, 1.54, Newmark(33_000, 0.142, 2170, law="cut")
    _, words, runs = judged(*setting)
    for each in changes_in(" ".join((words.headline, *words.details))):
        assert np.isfinite(runs.error(apply(setting[2], each))), each.words


def test_what_finishes_does_so_for_frequencies_nearby():
    """962 steps finished at η = 3.91 alone."""
    method = TimeStepping(27.7, 2.38, 481, status="end")
    words = verdict_of(TOUCHING, 3.91, method)
    ways = re.search(r"each tried alone: (.*)\.$", words.headline).group(1).split(", or ")
    kinds = {"without-solution": "without_solution", "D": "damping", "law": "law", "status": "status"}
    for way in ways:
        name, value = re.match(r"([\w,-]+)(?: =)? ([\w.-]+)$", way).groups()
        numbers = {"steps": int(name.replace(",", ""))} if value == "steps" else {kinds[name]: value}
        numbers = {name: float(value) if name == "damping" else value for name, value in numbers.items()}
        changed = replace(method, **numbers)
        assert all(simulate(TOUCHING, 3.91 + shift, changed).ok for shift in (-1e-5, 0, 1e-5)), way


REBOUNDS = [
    (PAPER, 1.87, TimeStepping(1890, 0.108, 1030)),
    (System(wall=True, d1=0.00771, restitution=0.207, clearance=0.225), 3.28, Newmark(422, 4.39, 1080)),
]


@pytest.mark.parametrize(("system", "eta", "method"), every(REBOUNDS))
def test_a_value_that_is_said_to_give_the_restitution_does_so_in_the_motion(system, eta, method):
    """Own springs, weights and the drive act in a soft contact, too: what the formula gives rebounds otherwise."""
    _, words, runs = judged(system, eta, method)
    text = next((text for text in words.details if "the restitution e asks for" in text), "")
    proposed = re.findall(r"\b(K|D) = ([\d.e+-]+)", text)
    assert proposed
    for name, value in proposed:
        changed = replace(method.limit, **{{"K": "stiffness", "D": "damping"}[name]: float(value)})
        run = runs.run(changed)
        closing, parting = (np.diff(each, axis=1) for each in (run.impacts.velocity_before, run.impacts.velocity_after))
        assert -parting.sum() / closing.sum() == pytest.approx(system.restitution, rel=0.1), (name, value)


def test_a_spiral_that_comes_back_by_chance_has_not_settled():
    """Its points turn by a quarter and draw nearer: they are one point in the end."""
    turns = np.exp((-0.01 + 0.5j * np.pi) * np.arange(50))
    spiral = 1.0 + 2e-4 * np.column_stack([turns.real, turns.imag, turns.real, turns.imag])
    assert period_of(spiral) == 4
    assert not repeats(spiral, 50)
    square = 1.0 + 1e-2 * np.column_stack([(1j ** np.arange(50)).real] * 4)
    assert repeats(square, 50)


def test_a_damper_that_lets_nothing_rebound_is_no_cure_of_a_contact_that_does():
    """D = 220 agrees better by luck of 640 steps: with twice as many it is off by a quarter, with a peak 36 times."""
    parts = System(kappa=2.5, mu=0.375, d1=0.02, d2=0.02, d3=None, restitution=0.6, clearance=0.4)
    words = verdict_of(parts, 25 / 12, TimeStepping(640, 2.9, 640, law="cut"))
    assert words.blame != ("D",)
    assert "by errors that cancel" not in str(words.headline).partition("at best")[0]
    named = words.change
    assert named["D"] < 0.5 * np.sqrt(named["K"] * 0.375 / 1.375)  # it rebounds, and so much as asked
