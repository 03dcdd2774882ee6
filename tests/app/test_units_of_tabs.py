"""Whatever tab is open: with units, no number in its words, tables and JSON keeps those of the model."""

import re
from collections.abc import Mapping

import numpy as np
import pytest
from vibroscope.app.codes.rules import AS_SET, RuleOutcome, rules
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.parameters import FIELD_QUANTITIES
from vibroscope.app.export.formats import as_csv
from vibroscope.app.export.tables import columns_in_units, table_in_units
from vibroscope.app.page.bifurcation.panel import SWEPT
from vibroscope.app.page.study.speed import error_label
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.page.your_code.rules import rows_of
from vibroscope.app.runtime.json_text import json_text
from vibroscope.app.studies.study_job import RESULTS
from vibroscope.app.studies.your_code import Judged, PartialCode, question_of
from vibroscope.engine import Units
from vibroscope.engine.facts import Amount, Symbol, stated

from tests.app.fakes import QueueingHost
from tests.app.filled_tabs import SETTING, filled  # noqa: F401 - a fixture
from tests.share import every

PHYSICAL = SETTING._replace(units="mm-t-s", omega1=20.0, m1=3.0, amplitude=2.5)
SCALE = Units(20.0, 3.0, 2.5, "mm-t-s")
_FIELDS = r"eta|K|D|xi[12]|v[12]|start_\w+|clearance|base|threshold|force[12]|longest_contact"
BARE = re.compile(rf"(?:from_|to_)?(?:{_FIELDS})")
NUMBER = r"[0-9][0-9.e+-]*"
UNITS = {"f": "Hz", "K": "N/mm", "2D": "N·s/mm"}


def check_words(text):
    assert re.search("[ξη]", text) is None, text
    assert re.search(r"(?<![\w2])D = ", text) is None, text
    for symbol, unit in re.findall(rf"(?<!\w)(f|K|2D) = {NUMBER}(?: to {NUMBER})? ?([A-Za-z·/]*)", text):
        assert unit == UNITS[symbol], text


def check_names(data):
    for name, column in data.items():
        if isinstance(column, Mapping):
            check_names(column)
        elif np.asarray(column).dtype.kind in "fi":
            assert BARE.fullmatch(name) is None, name


def check(tab):
    for text in (word for words in tab.words().items() for word in words):
        check_words(text)
    check_names(tab.data())
    json_text(tab.data())
    for figure in tab.figures():
        table = table_in_units(tab.table(figure.name), PHYSICAL.scale) if figure.tabled else []
        for series in table:
            check_names(series.columns)
        as_csv(table)


@pytest.mark.parametrize("key", ["plane", "basin", "step", "speed"])
def test_words_tables_and_json_of_a_study_have_units(filled, key):  # noqa: F811
    tab = filled(key)
    tab.show(Move(2, PHYSICAL))
    tab.hide()
    check(tab)


def test_hover_and_data_of_a_diagram_follow_the_units(filled):  # noqa: F811
    tab = filled("bifurcation")
    physical = SETTING._replace(units="mm-t-s", omega1=20.0, amplitude=2.0)
    plain, source = tab.data(), tab.view.sources["bifurcation_penalty"]
    source = source if len(source.data["eta"]) else tab.view.sources["bifurcation_reference"]
    assert "shown_eta" not in source.data
    assert tab.view.hover.tooltips[0][1] == "@eta"
    tab.show(Move(2, physical))
    assert tab.view.hover.tooltips[:2] == [
        ("frequency f / Hz, base displacement 2 mm held", "@shown_eta{%.4g}"),
        ("displacement x₂ once a period / mm", "@shown_value{%.4g}"),
    ]
    np.testing.assert_allclose(source.data["shown_eta"], source.data["eta"] * 20 / (2 * np.pi), rtol=1e-6)
    np.testing.assert_allclose(source.data["shown_value"], 2 * source.data["value"], rtol=1e-6)
    data = tab.data()
    assert data["f [Hz]"] == pytest.approx(plain["eta"] * 20 / (2 * np.pi))
    assert data["x2 [mm]"] == pytest.approx(2 * plain["xi2"], nan_ok=True)
    tab.show(Move(3, SETTING))
    assert "shown_eta" not in source.data
    assert tab.data().keys() == plain.keys()
    tab.hide()


def test_the_errors_of_speed_say_what_they_are_multiples_of_in_files(filled):  # noqa: F811
    tab, title = filled("speed"), "error [2.5 mm, or 50 mm/s of a velocity]"
    tab.show(Move(2, SETTING))
    assert "error" in tab.data()
    assert {"error" in series.columns for series in tab.table("speed")} == {True}
    tab.show(Move(2, PHYSICAL))
    tab.hide()
    table = table_in_units(tab.table("speed"), SCALE)
    assert tab.data().keys() & {"error", title} == {title}
    assert {title in series.columns for series in table} == {True}


@pytest.mark.parametrize("choice", every(["over:K;solver:newmark", "over:D;solver:newmark", "branches:on"]))
def test_a_diagram_over_any_number_has_units(choice):
    tab = VIEWS["bifurcation"](QueueingHost())
    tab.build()
    tab.restore(type(tab).read_view("", f"{choice};count:4;transient:20", ""))
    tab.show(Move(1, PHYSICAL))
    searched = "branches" in choice
    tab.host.catch_up_until(lambda: any(each.branches for each in tab.searches.results.values()) or not searched)
    tab.host.catch_up_until(lambda: tab.host.summary or (searched and tab.figures()))
    tab.hide()
    check(tab)
    if not searched:
        over = tab.view.over
        assert [each for each in tab.words() if each.startswith("From ")] != []
        low, high = tab.view.span
        names = {"K": ("stiffness", "K"), "D": ("damping", "2D")}
        quantity, title = names[over]
        strip = table_in_units(tab.table("bifurcation_strip"), SCALE)[0].columns
        ends = [strip[f"{end}_{title} [{SCALE.unit(quantity)}]"] for end in ("from", "to")]
        assert ends[0].min() >= SCALE.factor(quantity) * low * 0.999
        assert ends[1].max() <= SCALE.factor(quantity) * high * 1.001
        assert SWEPT[over].field.label == over
    tab.close()


def judged(method):
    why = stated("Nearly repeats every period (±{} in {}).", Amount(0.04, "displacement", 2), Symbol("ξ₂"))
    blurred = stated("blurred: {} by ±{}", Symbol("ξ₂"), Amount(0.04, "displacement", 2))
    rule = rules()["abaqus-ten"] if method is None else AS_SET
    return Judged(RuleOutcome(rule, method, blurred, 0.1, 0.1, None, why), np.empty((2, 0)))


def test_rules_have_units_in_the_page_and_in_files_also_without_a_number():
    rows = rows_of([judged(SETTING.penalty), judged(None)], np.empty((2, 0)), [], PHYSICAL)["rows"]
    assert all("±0.1 mm in x₂" in row["why"] and row["motion"] == "blurred: x₂ by ±0.1 mm" for row in rows)
    check_words(" ".join(rows[0]["numbers"]))
    tab = VIEWS["code"](QueueingHost())
    tab.build()
    both = (judged(SETTING.penalty), judged(None))
    result = PartialCode(question_of(PHYSICAL), compute_runs(SETTING), "", both)
    RESULTS.put(result.question, result)
    tab.show(Move(1, PHYSICAL))
    tab.hide()
    found, none = tab.data()["rules"].values()
    assert found["K [N/mm]"] == pytest.approx(SCALE.physical("stiffness", SETTING.K))
    assert none["K [N/mm]"] is None
    check_names(tab.data())
    table = table_in_units(tab.table("code_rules"), SCALE)
    assert len(table) == 2
    for series in table:
        check_words(str(series.columns["why"][0]))
    as_csv(table)
    tab.close()


def test_numbers_of_pins_and_the_error_of_speed_have_units():
    texts = {name: [float(value)] for name, value in SETTING.texts().items() if name in FIELD_QUANTITIES}
    assert {"clearance", "threshold", "start_v2", "force1"} <= texts.keys()
    shown = columns_in_units(texts, SCALE)
    check_names(shown)
    assert shown["clearance [mm]"] == pytest.approx(SCALE.physical("displacement", SETTING.clearance))
    assert "/ 2.5 mm, or 50 mm/s of" in error_label(PHYSICAL)
    assert "/ A, or Aω₁ of" in error_label(SETTING)
