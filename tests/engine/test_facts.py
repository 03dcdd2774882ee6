"""A statement is its text, keeps its facts wherever it goes, and is printed in any units from them alone."""

import copy
import json
import math
import pickle
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.engine import (
    HHT,
    ComparisonQuestion,
    Limits,
    Newmark,
    Reference,
    SettingQuestion,
    Statement,
    System,
    TimeStepping,
    Tolerances,
    Units,
    compare,
    motion,
    print_statement,
    recommend,
    repetition,
    synthetic_measurement,
    verdict,
)
from vibroscope.engine.facts import (
    Amount,
    Choice,
    Dimensionless,
    Ending,
    Reason,
    Symbol,
    as_json,
    equation,
    joined,
    message_of,
    parts_of,
    read_statement,
    sentence,
    span,
    stated,
)
from vibroscope.engine.measurement.comparison import compare_measured, measured_verdict
from vibroscope.engine.units import QUANTITIES

UNITS = Units(20.0, 3.0, 2.5, "mm-t-s")
LAWS = Units(20.0, 3.0, 2.5, "si", law="hunt-crossley")

numbers = st.floats(1e-6, 1e12)
words = st.text("Kab :;=.,%±", max_size=8)
kinds = st.sampled_from(sorted(QUANTITIES))
amounts = st.builds(Amount, numbers, kinds, st.integers(1, 12), bare=st.just(False))
symbols = st.builds(Symbol, st.sampled_from(["K", "D", "eta", "η", "ξ₁", "ξ₂", "omega1"]))
choices = st.sampled_from([Choice("law", ("cut", "flores")), Choice("status", ("located",), "status located")])
parts = st.one_of(words, amounts, symbols, choices, st.just(Dimensionless("τ = ")))
statements = st.lists(parts, max_size=6).map(lambda each: Statement(*each))


@given(statements)
def test_a_statement_is_the_text_of_its_parts(text):
    assert text == "".join(map(str, text.parts)) == print_statement(text)
    assert hash(text) == hash(str(text))
    assert all(part for part in text.parts if isinstance(part, str))
    assert json.loads(json.dumps(text)) == text  # as plain text, for a script


@given(statements, statements, words)
def test_joining_keeps_every_part(one, other, between):
    both = stated("{}{}{}", one, between, other)
    assert both == f"{one}{between}{other}"
    assert both.facts == one.facts + other.facts
    assert (one + between + other).parts == both.parts == joined(between, [one, other]).parts
    assert (between + one).facts == one.facts
    total = Statement(one)
    total += other
    assert total.facts == both.facts


@given(statements)
def test_a_statement_is_kept_and_read_back(text):
    for found in (
        json.loads(json.dumps(as_json({"of": [text, "plain", 1.5]})), object_hook=read_statement)["of"][0],
        pickle.loads(pickle.dumps(text)),
        copy.deepcopy(text),
    ):
        assert type(found) is Statement
        assert (found, found.parts) == (text, text.parts)


@given(amounts)
def test_each_quantity_has_its_unit(amount):
    for units in (UNITS, LAWS):
        shown = print_statement(Statement("x ", amount), units)
        if amount.quantity == "time":
            assert re.fullmatch(r"x \S+ (µs|ms|s)", shown)
            continue
        number, unit = shown.removeprefix("x ").split(" ")
        assert unit == units.unit(amount.quantity)
        last_digit = 10.0 ** (1 - min(amount.digits, 4))  # of a number that begins with 1
        assert float(number) == pytest.approx(units.physical(amount.quantity, amount.value), rel=last_digit)


@pytest.mark.parametrize(
    ("text", "plain", "shown"),
    [
        (equation("K", 1e4) + " leaves 5 %", "K = 10000 leaves 5 %", "K = 12000 N/mm leaves 5 %"),
        (equation("D", 25.3, 3, " ≈ "), "D ≈ 25.3", "2D ≈ 3.036 N·s/mm"),
        (equation("K", 100, relation=" up to "), "K up to 100", "K up to 120 N/mm"),
        (equation("steps", 8000), "steps = 8000", "steps = 8000"),
        (equation("eta", 1.08), "eta = 1.08", "f = 3.438 Hz"),
        (span("η", 0.5, 4.0), "η = 0.5 to 4", "f = 1.592 to 12.73 Hz"),
        (span("K", 100.0, 1e5), "K = 100 to 100000", "K = 120 to 120000 N/mm"),
        (span("steps", 100, 8000), "steps = 100 to 8000", "steps = 100 to 8000"),
        (
            stated("±{} in {}", Amount(0.04, "displacement", 2), Symbol("ξ₂")),
            "±0.04 in ξ₂",
            "±0.1 mm in x₂",
        ),
        (Statement("lasts ", Dimensionless("τ = "), Amount(0.5, "time")), "lasts τ = 0.5", "lasts 25 ms"),
        (Statement("off by ", Amount(math.nan, "displacement")), "off by not known", "off by not known"),
    ],
)
def test_texts_with_and_without_units(text, plain, shown):
    assert (str(text), print_statement(text, UNITS)) == (plain, shown)


def test_names_of_choices_and_symbols_are_those_of_the_reader():
    text = stated("{}, law {}", Symbol("omega1"), Choice("law", ("cut", "flores")))
    assert text == "omega1, law cut or flores"
    for units in (None, UNITS):
        assert print_statement(text, units, lambda part: f"“{part}”") == "“omega1”, law “cut or flores”"
    assert print_statement("plain", UNITS, lambda part: "") == "plain"


def test_a_sentence_and_an_error_keep_their_facts():
    text = sentence(stated(" the least {} ", equation("K", 100)))
    assert (text, text.facts) == ("The least K = 100.", equation("K", 100).facts)
    assert [sentence(each) for each in ("", "so it is.", "x")] == [".", "So it is.", "X."]
    assert message_of(ValueError(text)).facts == text.facts
    assert message_of(ValueError("plain")) == "plain"
    with pytest.raises(ValueError, match="zip"):
        stated("{} and {}", "one")


def test_an_ending_is_said_in_full_and_in_brief():
    what, cause = "it blew up", "the gap passed 1e9"
    advice = stated("take a smaller {}", equation("D", 50, relation=" than "))
    plain, known = Ending(what, cause, advice), Ending(what, cause, advice, "unstable in contact")
    assert plain == "it blew up: the gap passed 1e9; take a smaller D than 50"
    assert known == plain + ": unstable in contact"
    assert (plain.brief, known.brief) == ("it blew up", "it blew up: unstable in contact")
    assert known.without_advice == "it blew up: the gap passed 1e9"
    assert known.facts == advice.facts
    for found in (pickle.loads(pickle.dumps(known)), copy.deepcopy(known)):
        assert (found, found.parts, found.brief) == (known, known.parts, known.brief)


def test_a_reason_has_a_head_for_where_there_is_little_room():
    found = Reason("K is to blame", stated(": up to {}", Amount(1e4, "contact_stiffness")))
    assert (found, found.head) == ("K is to blame: up to 10000", "K is to blame")
    assert Statement("all of it").head == "all of it"
    for each in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert (each, each.parts, each.head) == (found, found.parts, found.head)


def test_a_number_that_nobody_has_written_is_no_part():
    with pytest.raises(TypeError, match="no part 5"):
        stated("{} steps", 5)


# --- of results -------------------------------------------------------------------------------------------------------

# What a quantity looks like in words that have lost it.
LOST = re.compile(r"(?<!\w)(?:[KDηf]|eta) (?:[=≈]|up to|than) [0-9]|±[0-9]|τ = [0-9]|[ξx][₁₂]")


def check(text):
    """The words of a statement hold no quantity, and it is printed with units in which none is without one."""
    bare = "|".join(part if isinstance(part, str) else "" for part in parts_of(text))
    assert not LOST.search(bare), bare
    assert "ξ" not in print_statement(text, UNITS)


@pytest.fixture
def guarded(monkeypatch):
    """An f-string, which would keep the text alone, fails where it takes a statement with facts."""

    def refuse(self, how):
        assert not self.facts, f"an f-string has lost the facts of {self!s}"
        return str(self)

    monkeypatch.setattr(Statement, "__format__", refuse)


NO_SOLUTION = TimeStepping(100.0, 3.68, 32, HHT(-0.1), "end", law="cut")
BLURRED, CHAOTIC = (3.25, Newmark(12000.0, 18.0, 2000)), (1.7, Newmark(12000.0, 18.0, 2000))
METHODS = [
    (2.76, Newmark(150.3, 9.0, 2000)),
    BLURRED,
    (1.08, NO_SOLUTION),
    (2.76, TimeStepping(5000.0, 20.0, 500, status="end")),
    pytest.param(*CHAOTIC, marks=pytest.mark.release),
    pytest.param(1.08, Newmark(123.4, 50.0, 2000), marks=pytest.mark.release),
    pytest.param(2.76, TimeStepping(5000.0, 20.0, 500, law="limited"), marks=pytest.mark.release),
]


@pytest.mark.parametrize(("eta", "method"), METHODS)
def test_no_sentence_of_a_verdict_loses_its_facts(guarded, eta, method):
    found = verdict(compare(ComparisonQuestion(System(), eta, method)))
    said = (found.headline, *found.details)
    for text in said:
        check(text)
    assert any(parts_of(text) != (text,) for text in said)


@pytest.mark.parametrize(("eta", "method"), [BLURRED, CHAOTIC, (1.08, NO_SOLUTION)])
def test_no_sentence_on_a_motion_loses_its_facts(guarded, eta, method):
    found = motion(System(), eta, method)
    for text in (found.reason, repetition(found)):
        check(text)


def test_a_motion_that_the_step_blurs_says_so_in_any_units(guarded):
    found = motion(System(), *BLURRED)
    text = repetition(found)
    assert re.fullmatch(r"repeats every 2 periods, blurred by the time step \(±0\.0\d+ in ξ₂\)", text)
    (amount,) = (fact for fact in text.facts if isinstance(fact, Amount))
    assert amount.value == found.scatter
    assert UNITS.text("displacement", found.scatter, 2) in print_statement(text, UNITS)  # rounded where it is printed


HARD = Newmark(1000.0, 10.0, 1000)
QUESTIONS = [
    ((2.76,), 0.001, {"stiffness_max": 2e3, "steps_max": 200}, HARD),
    ((2.76,), 0.01, {"stiffness": 300.0, "damping": 2.0, "steps_max": 500}, HARD),
    ((2.5, 2.76), 0.05, {"stiffness": 12000.0, "damping": 18.0, "steps_max": 500}, HARD),
    ((0.62,), 0.01, {"stiffness": 12000.0, "damping": 18.0, "steps_max": 64}, HARD),
    ((1.08,), 0.01, {"stiffness": 100.0, "damping": 50.0, "steps_max": 16}, NO_SOLUTION),
]


@pytest.mark.parametrize(("etas", "tolerance", "limits", "scheme"), QUESTIONS)
def test_no_sentence_of_a_recommendation_loses_its_facts(guarded, etas, tolerance, limits, scheme):
    asked = SettingQuestion(System(), etas, Tolerances(tolerance, None, None), Limits(**limits), scheme, Reference())
    found = recommend(asked)
    assert found.reason
    for text in (found.reason, found.limit, found.kind):
        check(text)


@pytest.mark.parametrize("eta", [2.765, 1.31])
def test_no_sentence_on_a_measurement_loses_its_facts(guarded, eta):
    measured = synthetic_measurement(System(), 2.76, noise=0.01, periods=60)
    text = measured_verdict(compare_measured(System(), eta, measured, Newmark(12000.0, 18.0, 2000)))
    check(text)
    assert f"eta = {eta:g}" in text
    assert UNITS.text("frequency", eta) in print_statement(text, UNITS)
