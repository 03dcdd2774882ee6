"""The tab Your code: what a code sets, its input, the table of rules, and the study behind it."""

import re

import numpy as np
import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.codes.rules import AS_SET, Rule, RuleOutcome, rules
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import Move
from vibroscope.app.page.your_code.rules import HEIGHT, WIDTH, rows_of
from vibroscope.app.page.your_code.tab import YourCode
from vibroscope.app.studies import your_code
from vibroscope.app.studies.your_code import (
    Judged,
    PartialCode,
    code_lines,
    code_texts,
    grow_code,
    question_of,
    rule_texts,
)

from tests.app.explanations import explained
from tests.app.fakes import QueueingHost, send
from tests.served import ROOT

COARSE = Setting(eta=2.76, K=12000.0, D=18.0, steps=200)
STEADY = Setting(eta=1.08, steps=400)  # its motions repeat
ITERATED = read_setting({"integrator": "hht", "status": "end", "without_solution": "keep"}, STEADY)
FEW = ("sap-hundred", "mathworks-penetration")
ELEMENTS = 5.0  # EA/h in units of k₁


@pytest.fixture
def few_rules(monkeypatch):
    monkeypatch.setattr(your_code, "rules", lambda: {key: rules()[key] for key in FEW})


@pytest.mark.parametrize(
    "path", ["app/page/your_code/rules.js", "app/page/explore/suggest.py", "app/commands/codes.py"]
)
def test_no_head_says_ours_or_in_its_words(path):
    """A new user does not know who "we" are."""
    text = (ROOT / path).read_text()
    assert not re.search(r"[\"'`](What )?ours |[\"'`]In the words of|[\"'`]in its words", text, re.IGNORECASE)


@pytest.mark.parametrize("key", codes())
def test_choosing_a_code_sets_what_it_does_and_leaves_the_numbers(key):
    """Whatever code was looked at before: the verdict on a code is about the K, D and step that the user set."""
    code = codes()[key]
    setting = read_setting(code_texts(code), COARSE)
    penalty, own = setting.penalty, code.method(setting.K, setting.D, setting.steps)
    assert penalty == own
    assert (setting.K, setting.D, setting.steps) == (COARSE.K, COARSE.D, COARSE.steps)
    for before in codes().values():
        assert read_setting(code_texts(code), read_setting(code_texts(before), COARSE)).penalty == penalty


def test_the_input_is_in_the_units_that_are_shown():
    code = codes()["code-aster"]
    assert "RIGI_NOR=2500," in " ".join(code_lines(code, ITERATED))
    shown = code_lines(code, ITERATED._replace(units="si", omega1=10.0, m1=2.0))
    assert f"RIGI_NOR={2500 * 2 * 100}," in " ".join(shown)


@pytest.mark.parametrize("key", ["abaqus-standard", "abaqus-explicit", "ansys", "calculix"])
def test_a_pressure_is_the_force_over_the_contact_area(key):
    """The keyword is per area: without that it says so, with 120 mm² the stiffness is divided by it."""
    setting = ITERATED._replace(units="mm-t-s", omega1=10.0, m1=2000.0, amplitude=3.0)
    stiffness = setting.scale.physical("contact_stiffness", setting.K)  # N/mm
    lines = " ".join(code_lines(codes()[key], setting))
    assert f"<{stiffness:g} divided by the contact area>" in lines
    area = setting.scale.model("area", 120.0)
    numbers = re.findall(r"(?<![\w.])[0-9.]+(?:e-?[0-9]+)?", " ".join(code_lines(codes()[key], setting, area)))
    assert any(float(number) == pytest.approx(stiffness / 120, rel=1e-5) for number in numbers)


def test_the_tab_asks_for_the_contact_area_and_the_elements(few_rules):
    host = QueueingHost()
    tab = YourCode(host)
    tab.build()
    setting = ITERATED._replace(units="si", omega1=10.0, m1=2.0, amplitude=3.0)
    tab.show(Move(1, setting))
    assert [each["name"] for each in tab.panel.spec["numbers"]] == ["area", "elements", "words", "mass", "speed"]
    tab.panel.chosen = tab.panel.chosen | {"code": "calculix"}
    tab.panel.receive({"choose": {"area": "120 mm²", "elements": "2e4 N/m"}})
    assert tab.panel.chosen["area"] == pytest.approx(120e-6 / 9e-6)
    assert tab.question(setting).element_stiffness == pytest.approx(2e4 / 200)
    assert f"{2500 * 200 / 120e-6:.6g}".replace("e+0", "e") in tab.rules.code["lines"]
    tab.close()


def test_partial_results_come_one_rule_after_the_other_and_go_on(few_rules):
    question = question_of(ITERATED._replace(units="si"))
    assert question == question_of(ITERATED)
    found = list(grow_code(question, None, lambda: False))
    assert [len(each.judged) for each in found] == [0, 1, 2, 3]
    assert found[-1].judged[0].outcome.rule is AS_SET
    assert found[-1].judged[0].outcome.total > 0
    assert "has no solution" in found[-1].solvable
    again = list(grow_code(question, found[1], lambda: False))
    assert [len(each.judged) for each in again] == [1, 2, 3]
    assert again[0] is found[1]
    whole = compute_runs(question.setting, lambda: False).penalty.orbit
    small = found[-1].judged[0].orbit  # a row of the table has so many points at most
    assert small.shape == (2, 240)
    np.testing.assert_array_equal(
        small[:, [0, -1]], [each[1, [0, -1]] for each in (whole.displacement, whole.velocity)]
    )
    assert found[-1].data()["rules"].keys() == {"as-set", *FEW}


def alone(rule, monkeypatch):
    """What is found of one rule, which no code has."""
    monkeypatch.setattr(your_code, "rules", lambda: {rule.key: rule})
    *_, found = grow_code(question_of(COARSE), None, lambda: False)
    return found.judged[-1]


def test_a_rule_that_gives_none_or_too_many_steps_is_a_sentence(few_rules, monkeypatch):
    still = COARSE._replace(base=0.0, start_xi2=1.0)
    judged = list(grow_code(question_of(still), None, lambda: False))[-1].judged
    assert "nothing drives the bodies" in judged[-1].outcome.why
    rule = Rule("key", "title", "steps_per_contact", 1e6, "claim", "source")
    found = alone(rule, monkeypatch)
    assert found.outcome.holds is None
    assert found.orbit.shape == (2, 0)


def test_a_rule_that_asks_for_more_than_the_server_computes_is_shown_but_not_set(monkeypatch):
    rule = Rule("key", "title", "steps_per_contact", 1e5, "claim", "source")
    with pytest.raises(Refused):
        read_setting(rule_texts(rule, question_of(COARSE)), COARSE)
    found = alone(rule, monkeypatch)
    (row,) = rows_of([found], np.empty((2, 0)), [], COARSE)["rows"]
    assert row["numbers"] != []
    assert not row["settable"]


@pytest.mark.parametrize("key", codes())
def test_what_a_code_sets_is_a_row_of_the_table(key):
    """Also where the damper follows from the restitution, so that there is no D."""
    setting = read_setting(code_texts(codes()[key]), COARSE)
    outcome = RuleOutcome(AS_SET, setting.penalty, "repeats every period", 0.1, 0.1, None, "why.")
    (row,) = rows_of([Judged(outcome, np.empty((2, 0)))], np.empty((2, 0)), [], setting)["rows"]
    given = [number.split(" = ")[0] for number in row["numbers"]]
    assert given == (["K", "Δτ"] if setting.penalty.damping is None else ["K", "D", "Δτ"])


def judged(holds=True, motion="repeats every period", why="K and D cause 1 % of difference.", without=0):
    method = rules()["abaqus-ten"].method(question_of(COARSE, ELEMENTS).asked)
    outcome = RuleOutcome(rules()["abaqus-ten"], method, motion, 0.01, 0.01, holds, why, without)
    return Judged(outcome, np.array([[0.0, 1.0, 9.0], [0.0, 2.0, 0.0]]))


def test_the_rows_of_the_table_hold_numbers_words_and_pictures():
    set_now = Judged(RuleOutcome(AS_SET, COARSE.penalty, "", 0.1, 0.1, None, "why."), np.empty((2, 0)))
    reference = np.array([[0.0, 1.0], [0.0, 2.0]])
    found = rows_of([judged(without=1), set_now], reference, ["abaqus-ten"], COARSE)
    first, second = found["rows"]
    assert (first["key"], first["settable"], first["path"]) == ("as-set", False, "")
    assert (second["own"], second["settable"], second["holds"], second["total"]) == (True, True, "yes", "1 %")
    assert second["numbers"] == [f"K = {judged().outcome.method.stiffness:.4g}"]
    assert second["why"] == "K and D cause 1 % of difference. 1 step without a solution."
    numbers = [float(x) for x in second["path"].replace("M", "").replace("L", " ").split()]
    assert len(numbers) == 6  # three points, cut off where they leave the reference far behind
    assert all(-0.2 * WIDTH <= x <= 1.2 * WIDTH for x in numbers[::2])
    assert all(-0.2 * HEIGHT <= y <= 1.2 * HEIGHT for y in numbers[1::2])


@pytest.mark.parametrize(
    ("handled", "end"),
    [("halve", "; such steps are halved."), ("keep", "; the status of the step before is kept."), ("stop", "'halve'.")],
)
def test_a_step_without_a_solution_is_said_with_what_becomes_of_it(few_rules, handled, end):
    """Not with the advice to do what is done already."""
    question = question_of(ITERATED._replace(without_solution=handled))
    found = next(each.solvable for each in grow_code(question, None, lambda: False) if each.solvable)
    assert "has no solution: with contact it ends open" in found
    assert found.endswith(end)


def test_the_input_says_that_it_has_no_dimension_until_there_are_units(few_rules):
    tab = YourCode(QueueingHost())
    tab.build()
    tab.panel.chosen = tab.panel.chosen | {"code": "calculix"}
    tab.draw(ITERATED, None)
    assert "2D" in tab.rules.code["units"]
    tab.draw(ITERATED._replace(units="si"), None)
    assert tab.rules.code["units"] == ""
    tab.close()


def test_the_tab_sets_a_code_and_a_rule_and_says_what_is_other(few_rules):
    host = QueueingHost()
    tab = YourCode(host)
    tab.build()
    tab.show(Move(1, ITERATED))
    tab.panel.receive({"choose": {"code": "opensees"}})
    assert host.settings[-1]["integrator"] == "newmark"
    assert tab.choice() == {"code": "opensees"}
    send(tab.rules, {"set": "mathworks-penetration"})
    assert host.settings[-1] == rule_texts(rules()["mathworks-penetration"], question_of(ITERATED))
    count = len(host.settings)
    for message in ({"set": "rumour"}, {"set": 3}, "set"):
        send(tab.rules, message)
    assert len(host.settings) == count
    tab.hide()
    tab.reset()
    assert tab.choice() == {}
    tab.panel.chosen = tab.panel.chosen | {"code": "opensees"}
    result = PartialCode(question_of(ITERATED), compute_runs(ITERATED), "Every step of 5 periods has a solution.")
    said = dict(tab.describe(ITERATED, result))
    assert "Integrator" in said["Other than in OpenSees"]
    assert "HHT-α" in said["What is set"]
    assert said["Do its steps have solutions?"].startswith("Every step of 5 periods has a solution.")
    tab.close()


@pytest.mark.parametrize("texts", [{"K": "100", "D": "50"}, {"K": "100", "D": "50", "steps": "407"}, {"units": "si"}])
def test_the_motions_are_those_that_explore_names(texts, monkeypatch):
    monkeypatch.setattr(your_code, "rules", dict)
    setting = read_setting({"eta": "1.08", "steps": "2000", **texts}, Setting())
    (*_, found) = grow_code(question_of(setting), None, lambda: False)
    tab = YourCode(QueueingHost())
    tab.build()
    said = dict(tab.describe(setting, found))
    kinds = explained(setting).in_units(setting.scale).kinds
    assert (said["Reference"], said["Penalty"]) == (kinds["reference"], kinds["penalty"])
    assert found.judged[0].outcome.motion.lower() in explained(setting).kinds["penalty"].lower()


def test_steps_that_are_cut_where_contact_changes_have_solutions():
    setting = read_setting({"law": "limited", "located": "yes", "steps": "100"}, STEADY)
    found = next(each for each in grow_code(question_of(setting), None, lambda: False) if each.solvable)
    assert found.solvable.startswith("Steps are cut where contact changes")


def typed_words(setting, **chosen):
    """The tab with words of a code."""
    tab = YourCode(QueueingHost())
    tab.build()
    tab.show(Move(1, setting))
    tab.panel.chosen = tab.panel.chosen | {"code": "mujoco"}
    tab.panel.receive({"choose": chosen})
    return tab


def test_words_of_a_code_are_translated_and_can_be_set(few_rules):
    setting = ITERATED._replace(units="si", omega1=10.0, m1=2.0, amplitude=3.0)
    tab = typed_words(setting, words='solref="-250 -4"', target="bullet")
    *_, result = grow_code(tab.question(setting), None, lambda: False)
    said = dict(tab.describe(setting, result))
    mass = 2.0 * setting.system.mass_share
    assert f"contactStiffness={250 * mass:g}" in said["In Bullet"]
    assert "K = " in said["What MuJoCo says"]
    assert "words" not in tab.choice()
    tab.draw(setting, None)
    assert tab.rules.rows[0]["settable"]
    send(tab.rules, {"set": "words"})
    with_words = read_setting(tab.host.settings[-1], setting)
    assert with_words.law == "cut"
    assert setting.scale.physical("contact_stiffness", with_words.K) == pytest.approx(250 * mass)
    assert setting.own_units.physical("contact_damping", with_words.D) == pytest.approx(4 * mass)
    tab.close()


def test_words_that_say_nothing_are_a_sentence_and_without_units_nothing_is_set(few_rules):
    tab = typed_words(ITERATED, words="solref", mass="1 kg")
    *_, result = grow_code(tab.question(ITERATED), None, lambda: False)
    assert "name=value" in dict(tab.describe(ITERATED, result))["Words"]
    tab.panel.receive({"choose": {"words": "solref=-250 -4"}})
    tab.draw(ITERATED, None)
    assert not tab.rules.rows[0]["settable"]
    assert "Units" in tab.rules.rows[0]["why"]
    tab.panel.receive({"choose": {"code": "nastran"}})
    assert "words" in tab.away(ITERATED)
    assert "Words" not in dict(tab.describe(ITERATED, result))
    tab.close()
