"""No sentence of the page keeps a number without dimension while units are shown, or a name of the command line."""

import re
from dataclasses import replace

import pytest
from vibroscope.app.codes.rules import AS_SET, RuleQuestion, judge, rules
from vibroscope.app.explorer.explanation import describe, paragraphs
from vibroscope.app.explorer.field_units import shown_text, words_of_change
from vibroscope.app.explorer.method_words import words_of_method
from vibroscope.app.explorer.motion_kind import describe_kind
from vibroscope.app.explorer.parameters import FIELDS, LAW_NAMES
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import CONTACT_LAWS, INTEGRATORS, Units, motion
from vibroscope.engine.facts import OMEGA1, Choice, Symbol, equation, parts_of, stated
from vibroscope.engine.methods import WITHOUT_SOLUTION

from tests.app.explanations import explained, runs_of

UNITS = {"units": "mm-t-s", "omega1": 20.0, "m1": 3.0, "amplitude": 2.5}
SCALE = Units(20.0, 3.0, 2.5, "mm-t-s")
NO_SOLUTION = {"integrator": "hht", "alpha": -0.1, "status": "end", "law": "cut", "K": 100.0, "D": 3.68, "steps": 32}


@pytest.mark.parametrize(
    ("field", "values"),
    [
        ("law", CONTACT_LAWS),
        ("integrator", INTEGRATORS),
        ("status", ("start", "end")),
        ("without_solution", WITHOUT_SOLUTION),
    ],
)
def test_each_choice_has_the_name_of_its_control(field, values):
    for value in values:
        shown = shown_text(stated("by {}", Choice(field, (value,))), None)
        assert shown.startswith(f"by “{FIELDS[field].choices[value]}”")
        assert shown_text(stated("by {}", Choice(field, (value,))), SCALE) == shown


@pytest.mark.parametrize(
    ("choice", "expected"),
    [
        (Choice("status", ("located",), "status located"), "cutting the step where contact changes"),
        (
            Choice("without_solution", ("keep", "halve"), "without_solution = 'keep' or 'halve'"),
            "“keep status” or “halve step” for a step without a solution",
        ),
    ],
)
def test_a_choice_with_a_text_of_its_own_is_shown_in_words(choice, expected):
    assert shown_text(stated("{}", choice), None) == expected


def test_symbols_of_a_terminal_are_those_of_the_page():
    text = stated("check {} and {}, {}", equation("eta", 1.08), OMEGA1, Symbol("tau"))
    assert text == "check eta = 1.08 and omega1, tau"
    assert shown_text(text, None) == "check η = 1.08 and ω₁, τ"
    assert shown_text(text, SCALE) == "check f = 3.438 Hz and ω₁, τ"


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_text_of_the_page_stays(law):
    text = f"contact law {LAW_NAMES[law]}; {words_of_method(Setting(law=law).penalty)}."
    assert shown_text(text, SCALE) == text


def test_the_sentences_on_a_step_without_a_solution_have_no_word_of_the_command_line():
    setting = Setting(**UNITS, **NO_SOLUTION)
    runs = runs_of(setting)
    shown = " ".join(paragraphs(describe(runs), explained(setting).in_units(setting.scale)).values())
    assert "“halve step”" in shown
    assert "2D than 0.44" in shown
    assert not re.findall(r"without[-_]solution|'|\blaw [a-z]|\bstatus (?:start|end)", shown.replace("'s", ""))


def test_a_change_is_offered_in_units():
    change = {"K": "2500", "D": "8", "steps": "4000", "located": "yes"}
    words = "T/Δτ = 4000, cutting the step where contact changes"
    assert words_of_change(change, Setting()) == f"K = 2500, D = 8, {words}"
    assert words_of_change(change, Setting(**UNITS)) == f"K = 3000 N/mm, 2D = 0.96 N·s/mm, {words}"
    assert words_of_change({}, Setting()) == ""


@pytest.mark.parametrize(
    "numbers", [{}, {"eta": 2.76, "K": 12000.0, "D": 18.0}, {"eta": 3.25, "K": 12000.0, "D": 18.0}, {"eta": 1.7}]
)
def test_no_sentence_keeps_a_number_without_dimension(numbers):
    setting = Setting(**numbers, **UNITS)
    runs = runs_of(setting)
    plain = explained(setting)
    found = plain.in_units(setting.scale)
    text = " ".join(paragraphs(describe(runs), found).values())
    assert "ξ" not in text
    units = re.findall(r"\b[KD] = \S+ (\S+)", text) + re.findall(r"±\S+ (\S+)", text)
    assert all(unit.startswith(("N/mm", "N·s/mm", "mm")) for unit in units), text
    # details and headline name choices, which have other words on the page
    assert replace(plain.in_units(None), details=(), headline="") == replace(plain, details=(), headline="")


@pytest.mark.parametrize("law", ["cut", "hunt-crossley"])
def test_the_parts_of_a_difference_name_the_law_by_its_control(law):
    found = explained(Setting(**UNITS, law=law, K=5000.0, D=20.0, eta=2.76))
    (parts,) = (text for text in found.in_units(None).details if text.startswith("Of the "))
    assert f"K and D (law “{LAW_NAMES[law]}”)" in parts


def test_the_evidence_for_a_kind_of_motion_is_in_units():
    setting = Setting(eta=3.25, K=12000.0, D=18.0)
    found = describe_kind(motion(setting.system, setting.eta, setting.penalty))
    assert re.search(r"\(±0\.02\d* at T/2000, ", found.evidence)
    assert re.search(r"\(±0\.0[56]\d* mm at T/2000, ", shown_text(found.evidence, SCALE))


@pytest.mark.parametrize("numbers", [{"eta": 3.25, "K": 12000.0, "D": 18.0}, NO_SOLUTION])
def test_what_follows_from_a_rule_is_in_units(numbers):
    setting = Setting(**numbers)
    asked = RuleQuestion(setting.system, setting.eta, setting.penalty)
    for rule in (AS_SET, rules()["ansys-contact"]):
        found = judge(rule, asked, periods=400, keep=50)
        for text in (found.motion, found.why):
            words = "|".join(part for part in parts_of(text) if isinstance(part, str))
            assert not re.search(r"±[0-9]|[ξx][₁₂]|\b[KD] (?:=|than) [0-9]", words)
            assert "ξ" not in shown_text(text, SCALE)
