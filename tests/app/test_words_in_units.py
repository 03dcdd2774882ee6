"""No sentence of the page keeps a number without dimension while units are shown."""

import re
from dataclasses import replace

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import describe, explain, paragraphs
from vibroscope.app.explorer.method_words import LAW_NAMES, words_of_method
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.words_in_units import in_units, words_of_change
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import CONTACT_LAWS, Units

CACHE = Cache(48)
UNITS = {"units": "mm-t-s", "omega1": 20.0, "m1": 3.0, "amplitude": 2.5}
SCALE = Units(20.0, 3.0, 2.5, "mm-t-s")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("K = 1e+04 with D = 25.3 leaves 5 %.", "K = 12000 N/mm with 2D = 3.036 N·s/mm leaves 5 %."),
        ("no K up to 100 gave a run", "no K up to 120 N/mm gave a run"),
        ("From η = 0.5 to 4", "From f = 1.592 to 12.73 Hz"),
        ("From K = 100 to 1e+05", "From K = 120 to 120000 N/mm"),
        ("From D = 8 to 10", "From 2D = 0.96 to 1.2 N·s/mm"),
        ("cell at K ≈ 100, D ≈ 8", "cell at K ≈ 120 N/mm, 2D ≈ 0.96 N·s/mm"),
        ("blurred by the time step: ξ₂ by ±0.04 over", "blurred by the time step: x₂ by ±0.1 mm over"),
        ("each point (ξ₂ by ±0.04).", "each point (x₂ by ±0.1 mm)."),
        ("blurred by the time step (±0.04 in ξ₂)", "blurred by the time step (±0.1 mm in x₂)"),
        ("it shrinks (±0.04 at T/2000, ±0.02 at T/4000)", "it shrinks (±0.1 mm at T/2000, ±0.05 mm at T/4000)"),
        ("motion at eta = 1.08 does", "motion at f = 3.438 Hz does"),
        ("T/Δτ = 500: take 2,000 steps; exponent +0.1 ± 0.01", "T/Δτ = 500: take 2,000 steps; exponent +0.1 ± 0.01"),
    ],
)
def test_numbers_of_a_sentence_are_converted(text, expected):
    assert in_units(text, SCALE) == expected
    assert in_units(text, None) == text.replace("1e+04", "10000").replace("1e+05", "100000")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "alone: without-solution halve, or law limited,",
            "“halve step” for a step without a solution, or law “limited damper”,",
        ),
        ("or without_solution = 'keep' or 'halve'", "or “keep status” or “halve step” for a step without a solution"),
        (
            "status located leaves 2 %; status start leaves",
            "cutting the step where contact changes leaves 2 %; status “start of the step” leaves",
        ),
        ("The numerical damping of tr-bdf2 is", "The numerical damping of “TR-BDF2” is"),
        ("The contact status at the end; the impact law of", "The contact status at the end; the impact law of"),
        ("a smaller D than 3.68", "a smaller D than 3.68"),
    ],
)
def test_choices_have_the_names_of_their_controls(text, expected):
    assert in_units(text, None).endswith(expected)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_a_name_of_the_page_stays(law):
    text = f"contact law {LAW_NAMES[law]}; {words_of_method(Setting(law=law).penalty)}."
    assert in_units(text, None) == text


def test_the_sentences_on_a_step_without_a_solution_have_no_word_of_the_command_line():
    setting = Setting(**UNITS, integrator="hht", alpha=-0.1, status="end", law="cut", K=100.0, D=3.68, steps=32)
    runs = compute_runs(setting, cache=CACHE)
    shown = " ".join(paragraphs(describe(runs), explain(runs).in_units(setting.scale)).values())
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
    runs = compute_runs(setting, cache=CACHE)
    plain = explain(runs)
    found = plain.in_units(setting.scale)
    text = " ".join(paragraphs(describe(runs), found).values())
    assert "ξ" not in text
    units = re.findall(r"\b[KD] = \S+ (\S+)", text) + re.findall(r"±\S+ (\S+)", text)
    assert all(unit.startswith(("N/mm", "N·s/mm", "mm")) for unit in units), text
    # details and headline name choices, which have other words on the page
    assert replace(plain.in_units(None), details=(), headline="") == replace(plain, details=(), headline="")


def test_a_fit_that_is_not_right_says_so_in_the_units_of_the_page():
    scale = Setting(units="mm-t-s", amplitude=2.0).scale
    remark = "the residual (0.5) is larger than the measurement's own noise (0.02): the reference moves otherwise"
    assert in_units(remark, scale).startswith(
        "the residual (1 mm) is larger than the measurement's own noise (0.04 mm):"
    )
