"""What is printed of a recommendation is true of runs that know nothing of the search; more: tests/release."""

import math
from dataclasses import fields

import pytest
from vibroscope.engine import Newmark, TimeStepping, recommend, simulate
from vibroscope.engine.divergence.encounters import delivered_restitution
from vibroscope.engine.recommendation.contacts import Contacts, Tolerances
from vibroscope.engine.recommendation.question import Limits, round_numbers

from tests.recommended import FORCED, PAPER, SOFTER, WALL, Question, question
from tests.share import every


@pytest.mark.parametrize(
    ("system", "eta", "tolerance"), every([(PAPER, 2.45, 0.05), (WALL, 2.71, 0.1), (SOFTER, 2.3, 0.05)])
)
def test_what_is_printed_is_true_of_runs_from_rest(system, eta, tolerance):
    found = recommend(question(system, eta, tolerance=tolerance))
    assert found.met
    assert Question(system, eta, tolerance).complaints(found, 20) == []


def test_no_setting_nearby_does_with_half_the_steps():
    """A strong damper makes up for few steps in a contact."""
    found = recommend(question(PAPER, 1.08, tolerance=0.1))
    assert found.met
    assert next(Question(PAPER, 1.08, 0.1).cheaper(found, 0.55), None) is None


def test_numbers_are_rounded_to_ten_digits_and_no_further():
    noisy = FORCED.__class__(**{**vars_of(FORCED), "d1": 0.0276 * (1 + 1e-13)})
    assert noisy != FORCED
    assert round_numbers(noisy) == round_numbers(FORCED)
    assert round_numbers(0.123456789012) == 0.123456789
    assert round_numbers(1.18 * (1 + 1e-9)) != 1.18


def vars_of(system):
    return {each.name: getattr(system, each.name) for each in fields(system)}


def test_the_displacements_alone_hide_contacts_that_gain_energy():
    """A heat exchanger's tube at its support: 4 % off, yet its bodies part faster than they meet, and 44 % too hard."""
    asked = Tolerances()
    gained = Contacts(1.1, 0.8, 1691.0, 1175.0, 3.9)
    assert gained.excess(asked) > 1
    assert gained.excess(Tolerances(0.05, None, None)) > 1  # whatever is switched off
    assert Contacts(0.75, 0.8, 1691.0, 1175.0, 3.9).excess(asked) == pytest.approx(0.43915 / 0.2, rel=1e-3)
    assert Contacts(0.75, 0.8, 1691.0, 1175.0, 3.9).excess(Tolerances(force=None)) == pytest.approx(0.5)
    assert Contacts(0.6, 0.8, 1180.0, 1175.0, 30.0).excess(asked) == pytest.approx(2.0)
    assert Contacts(1.0, 1.0, 1.0, math.nan, math.nan).excess(asked) == 0


def test_without_tolerances_of_contacts_fewer_steps_do():
    asked = {"tolerance": 0.5, "steps_max": 256, "stiffness": 100.0}
    strict = recommend(question(PAPER, 3.25, **asked))
    loose = recommend(question(PAPER, 3.25, **asked, restitution_tolerance=None, force_tolerance=None))
    assert strict.met
    assert loose.met
    assert loose.best.setting.steps < strict.best.setting.steps
    run = simulate(PAPER, 3.25, Newmark(*strict.best.setting))
    assert strict.best.contacts.restitution == pytest.approx(delivered_restitution(run), rel=1e-12)
    assert abs(delivered_restitution(run) - 0.5) <= 0.1


def test_the_largest_stiffness_is_one_rule():
    assert Limits().of(WALL).stiffness_max == 1e6
    assert Limits().of(PAPER).stiffness_max == 5.1e6  # of the stiffer spring, μκ² = 5.07
    assert Limits(stiffness_max=300.0).of(PAPER).stiffness_max == 300.0


def test_the_contacts_of_a_run_without_a_solution_are_counted():
    method = TimeStepping(100.0, 3.68, 64, status="end", without_solution="halve")
    run = simulate(PAPER, 1.08, method)
    held = {"stiffness": 100.0, "damping": 3.68, "steps_max": 64}
    free = {"restitution_tolerance": None, "force_tolerance": None}
    found = recommend(question(PAPER, 1.08, tolerance=1.0, scheme=method, **held, **free))
    if found.best.setting.steps == 64:
        assert found.best.contacts.unsolved == run.steps_without_solution
