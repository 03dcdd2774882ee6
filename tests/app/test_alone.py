"""The curves over each number alone: what is drawn, what a click sets, and that they come and go with the verdict."""

import math

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import explain
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.explore import explainer
from vibroscope.app.page.explore.alone import NUMBERS, AloneView
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.shared.figure import write
from vibroscope.app.page.tab import Move
from vibroscope.engine import percent

from tests.app.fakes import Document, QueueingHost

OPENING = opening_setting()
UNITS = read_setting({"units": "si", "omega1": "30", "m1": "2"}, OPENING)


@pytest.fixture(scope="module")
def found():
    """The explanation of the opening scene, and the curves that came before it."""
    partial = []
    return explain(compute_runs(OPENING), on_alone=partial.append), partial


def shown(facts, setting=OPENING):
    view = AloneView()
    view.show(facts, setting, write)
    return view


def marks(view, name):
    return {column: float(values[0]) for column, values in view.marks[name].data.items()}


def tapped(view, name, x):
    sets = []
    view.set_texts = sets.append
    view.take(name, x)
    return sets[0]


def test_the_curves_show_what_is_left_and_where_one_is(found):
    facts = found[0].alone
    view = shown(facts)
    assert view.view.visible
    for name in NUMBERS:
        curve = facts["curves"][name]
        np.testing.assert_allclose(view.curves[name].data["x"], curve["values"], rtol=1e-6)
        left = [math.nan if each is None else 100 * each for each in curve["left"]]
        np.testing.assert_allclose(view.curves[name].data["left"], left, rtol=1e-6)
        assert marks(view, name)["now"] == getattr(OPENING, name)
        assert marks(view, name)["now_left"] == pytest.approx(100 * found[0].parts["total"])
        assert marks(view, name)["floor"] == pytest.approx(100 * found[0].parts["joint_damping"])
        assert view.figures[name].title.text.startswith(f"now {percent(facts['total'])}; at best ")
    assert np.isnan(view.curves["K"].data["left"]).any()  # the stiffest runs end early: a gap
    assert len({id(plot.y_range) for plot in view.figures.values()}) == 1
    assert view.figures["K"].xaxis[0].axis_label == "penalty stiffness K / k₁"


def test_the_best_values_are_those_of_the_verdict(found):
    explanation = found[0]
    view = shown(explanation.alone)
    (name, text), *_ = explanation.change.items()
    assert marks(view, name)["best"] == pytest.approx(float(text))
    assert f"{name} = {text} leaves" in explanation.headline
    assert f": {name} = {text}" in view.figures[name].title.text


def test_conditions_are_marked(found):
    facts, view = found[0].alone, shown(found[0].alone)
    for name in ("K", "D"):
        assert marks(view, name)["equal"] == pytest.approx(facts["curves"][name]["equal_restitution"])
    assert math.isnan(marks(view, "steps")["equal"])
    assert marks(view, "K")["from"] == pytest.approx(facts["curves"]["K"]["resolved"])  # a stiffer contact is shorter
    assert marks(view, "steps")["to"] == pytest.approx(facts["curves"]["steps"]["resolved"])
    assert math.isnan(marks(view, "D")["from"])


def test_a_click_on_a_minimum_sets_it_and_elsewhere_the_value_there(found):
    facts, view = found[0].alone, shown(found[0].alone)
    for name in ("K", "D"):
        best = facts["curves"][name]["best"]["value"]
        assert tapped(view, name, best) == {name: f"{best:g}"}
        equal = facts["curves"][name]["equal_restitution"]
        assert float(tapped(view, name, 0.98 * equal)[name]) == pytest.approx(equal, rel=0.01)
    assert tapped(view, "K", 432.1) == tapped(shown(facts, UNITS), "K", 432.1 * 2 * 30**2) == {"K": "430"}
    assert tapped(view, "steps", 5123.4) == {"steps": "5100"}


def test_a_click_where_no_step_is_best_cuts_the_steps_at_contact(found):
    facts, view = found[0].alone, shown(found[0].alone)
    assert facts["curves"]["steps"]["best"]["value"] is None
    assert "no time step" in view.figures["steps"].title.text
    assert tapped(view, "steps", marks(view, "steps")["best"]) == {"located": "yes"}


def test_units_are_those_of_the_page(found):
    view, factor = shown(found[0].alone, UNITS), 2 * 30**2
    plain = shown(found[0].alone)
    assert view.figures["K"].xaxis[0].axis_label.endswith("K / (N/m)")
    assert view.figures["D"].xaxis[0].axis_label.endswith("2D / (N·s/m)")
    np.testing.assert_allclose(view.curves["K"].data["x"], factor * plain.curves["K"].data["x"], rtol=1e-6)
    best = found[0].alone["curves"]["K"]["best"]["value"]
    assert tapped(view, "K", factor * best) == tapped(plain, "K", best)


def test_a_part_of_rounding_is_no_floor(found):
    view = shown(found[0].alone | {"floor": 1e-15})
    assert math.isnan(marks(view, "K")["floor"])
    assert not view.head.floor
    assert view.figures["K"].y_range.start > 1


def test_coarse_curves_come_first_and_name_no_best(found):
    _, partial = found
    assert [[*each["curves"]] for each in partial[:3]] == [["K"], ["K", "D"], ["K", "D", "steps"]]
    view = shown(partial[0])
    assert view.head.state == "searching: coarse so far …"
    assert math.isnan(marks(view, "K")["best"])
    assert "best" not in view.figures["K"].title.text
    assert not view.curves["D"].data["x"].size
    assert not any(each["done"] for each in partial)
    assert shown(found[0].alone).head.state == ""


def test_without_a_search_there_is_no_card_and_a_new_setting_has_no_curves_yet(found):
    view = shown(found[0].alone)
    view.wait(write)
    assert (view.view.visible, view.head.state) == (True, "computing …")
    assert not any(source.data["x"].size for source in view.curves.values())
    view.show(None, OPENING, write)
    assert not view.view.visible


def test_a_curve_is_taken_away_as_a_table(found):
    facts, view = found[0].alone, shown(found[0].alone)
    for name in NUMBERS:
        table = {series.label: series.columns for series in view.table(name)}
        np.testing.assert_array_equal(table["alone"][name], facts["curves"][name]["values"])
        assert table["present"]["left"] == [facts["total"]]
        assert table["at best"]["left"] == [facts["curves"][name]["best"]["left"]]
    assert "resolved up to" in {series.label for series in view.table("K")}
    (in_units, *_) = table_in_units(view.table("K"), UNITS.scale)
    assert "K [N/m]" in in_units.columns


def test_the_figures_are_offered_once_there_are_curves(found, monkeypatch):
    known = {}
    monkeypatch.setattr(explainer, "known_explanation", known.get)
    tab = Explore(QueueingHost(doc=Document()))
    tab.build()
    tab.show_if_ready(Move(1, OPENING))
    assert not [each for each in tab.figures() if each.name.startswith("alone")]
    known[OPENING] = found[0]
    tab.show_if_ready(Move(2, OPENING))
    offered = [each.name for each in tab.figures() if each.name.startswith("alone")]
    assert offered == ["alone_K", "alone_D", "alone_steps"]
    assert tab.data()["alone"] == found[0].alone
    tab.close()


def test_there_is_no_curve_over_d_where_the_law_takes_its_damper_from_the_restitution(found):
    facts = found[0].alone
    facts = facts | {"curves": {name: facts["curves"][name] for name in ("K", "steps")}}
    view = shown(facts, read_setting({"law": "hunt-crossley", "damper": "restitution"}, OPENING))
    assert [pane.visible for pane in view.panes.values()] == [True, False, True]
    assert not view.curves["D"].data["x"].size
