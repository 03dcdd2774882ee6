"""The tab One impact without a browser: its answer, its figures, what it offers to take over, and its table."""

import math
import shlex
from functools import cache
from itertools import islice

import numpy as np
import pytest
from bokeh.events import Tap
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer import impact_words
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.study.impact import OneImpact, offers_of
from vibroscope.app.page.tab import Move
from vibroscope.app.studies.one_impact import STEPS, grow_impact
from vibroscope.app.studies.study_job import RESULTS
from vibroscope.engine import Cancelled, NewmarkBeta, impact, simulate, written
from vibroscope.engine.one_impact.choose import CLOSE_TO_ASKED

from tests.app.fakes import FakeHost, send

SETTING = Setting(eta=2.76, K=2500.0, D=8.0, steps=500)
LAW = SETTING._replace(law="hunt-crossley", damper="restitution", status="end")


def question(setting, **chosen):
    tab = OneImpact(FakeHost())
    tab.build()
    tab.panel.chosen = tab.panel.chosen | chosen
    return tab.question(setting)


def growing(setting, **chosen):
    return grow_impact(question(setting, **chosen), None, lambda: False)


def grown(setting=SETTING):
    """All results on the way to what is known; those of one question are the same in all units."""
    return answers(question(setting))


@cache
def answers(asked):
    return list(grow_impact(asked, None, lambda: False))


def test_the_answer_comes_first_then_the_forces_the_largest_step_the_band_and_the_table():
    results = grown()
    first, second, third, last = *results[:3], results[-1]
    assert (first.searched, len(first.forces), len(first.band), len(first.schemes)) == (False, 0, 0, 0)
    assert (second.searched, [*second.forces]) == (False, ["best", "worst", "exact"])
    assert (third.searched, len(third.band)) == (True, 0)
    assert [result.share for result in results] == sorted(result.share for result in results)
    assert (last.share, len(last.band)) == (1, len(STEPS))
    assert {one.scheme[1] for one, _ in last.schemes} == {"start", "end", "located", ""}
    assert list(grow_impact(last.question, last, lambda: False)) == [last]
    part = results[4]
    assert len(list(grow_impact(part.question, part, lambda: False))) == len(results) - 4  # it goes on from there


def test_the_next_move_ends_what_the_answer_has_left_to_search_for():
    asked, polls = question(SETTING), []
    results = grow_impact(asked, None, lambda: len(polls) > 3 or polls.append(1))
    assert [result.searched for result in (next(results), next(results))] == [False, False]
    with pytest.raises(Cancelled):
        next(results)


def test_by_default_bodies_meet_as_those_of_the_reference():
    run = simulate(SETTING.system, SETTING.eta, SETTING.reference, initial=SETTING.initial)
    result = grown()[0]
    assert result.impact.speed == np.median(run.impacts.closing_speed)
    assert result.impact.mass == SETTING.system.mass_share
    assert result.impacts == len(run.impacts.closing_speed)
    assert result.impact.time_step == pytest.approx(2 * math.pi / (SETTING.eta * SETTING.steps), rel=1e-15)


def test_a_typed_speed_and_mass_need_no_system():
    typed = question(LAW, mass=1.0, speed=2.0)
    assert typed == question(LAW._replace(kappa=2.4), mass=1.0, speed=2.0)
    result = next(growing(LAW, mass=1.0, speed=2.0))
    assert (result.impact.mass, result.impact.speed, result.impacts) == (1.0, 2.0, 0)
    assert question(LAW) != question(LAW._replace(kappa=2.4))


def test_empty_fields_show_what_the_system_gives_and_hold_it(shown):
    tab, _ = shown()
    fields, one = tab.panel.fields, tab.result.impact
    assert tab.panel.chosen == dict.fromkeys(("mass", "speed", "depth"))
    assert [fields[name]["empty"] for name in ("mass", "speed")] == [written(one.mass), written(one.speed)]
    for text, speed, why in (
        ("2", 2.0, ""),
        ("0", 2.0, "from 1e-12"),
        ("1 m/s", 2.0, "once Units is SI"),
        (" ", None, ""),
    ):
        tab.panel.receive({"choose": {"speed": text}})
        assert tab.panel.chosen["speed"] == speed
        assert why in tab.panel.refused
        assert bool(tab.panel.refused) == bool(why)
    assert tab.question(SETTING) == question(SETTING)


@pytest.mark.parametrize("located", ["no", "yes"])
def test_the_sentence_states_what_the_engine_finds(located):
    setting = SETTING._replace(located=located)
    result = grown(setting)[-1]
    said = {head: str(text) for head, text in OneImpact(FakeHost()).describe(setting, result)}
    assert result.impact.method.status == ("located" if located == "yes" else "start")
    least, greatest = result.found.restitution.least, result.found.restitution.greatest
    assert f"{least:.2f}" in said["Answer"]
    assert f"{greatest:.2f}" in said["Answer"]
    assert said["Answer"].startswith("You asked for 0.50")
    assert "steps on it stays within 0.05: a step of at most T/" in said["Answer"]
    assert "impacts of the reference" in said["Contact"]
    speeds = simulate(setting.system, setting.eta, setting.reference).impacts.closing_speed
    of_all = said["All closing speeds"]
    assert of_all.startswith(f"{len(speeds)} impacts with closing speeds of {speeds.max():.4g}: ")  # all one
    assert f"restitution {least:.2f} to {greatest:.2f}, mean" in of_all  # of a linear law the same at each


def test_what_is_taken_over_keeps_what_was_asked_for():
    result = grown()[-1]
    offers = offers_of(result, SETTING)
    assert offers.keys() == {"steps", "K", "D"}
    for name in ("steps", "K"):
        changed = SETTING._replace(**{each: float(text) for each, text in offers[name].items()})
        changed = changed._replace(steps=round(changed.steps))
        asked = question(changed)
        found = impact(asked.at(result.impact.speed)).restitution
        assert max(abs(e - 0.5) for e in found) < CLOSE_TO_ASKED + 1e-3
    alone = SETTING._replace(D=float(offers["D"]["D"]))
    assert question(alone).at(1.0).without_step.restitution == pytest.approx(0.5, abs=1e-5)


def test_a_contact_that_gives_something_else_without_a_step_is_offered_a_damper_alone():
    setting = SETTING._replace(K=12_000.0, D=18.0)
    _, result = islice(growing(setting), 2)
    assert offers_of(result, setting).keys() == {"D"}


@pytest.fixture
def shown():
    """A function from a setting to the open tab with all that is known of it, and its host."""
    tabs = []

    def show(setting=SETTING):
        result = grown(setting)[-1]
        RESULTS.put(result.question, result)
        tab = OneImpact(host := FakeHost())
        tabs.append(tab)
        tab.build()
        tab.show(Move(1, setting))
        return tab, host

    yield show
    for tab in tabs:
        tab.close()


def test_a_button_takes_the_step_to_explore_and_a_click_sets_it(shown):
    tab, host = shown()
    offers = offers_of(tab.result, SETTING)
    cells = [row["cells"] for row in tab.offers.near["rows"]]
    assert [each[0]["open"] for each in cells] == [*offers]
    assert cells[0][0]["text"] == "Take this step over"
    assert cells[0][1]["text"] == f"time step Δτ = T/{offers['steps']['steps']}"
    for name in (*offers, "mass", None, ["steps"]):
        send(tab.offers, {"open": name})
    assert [visit[:2] for visit in host.visits] == [("explore", texts) for texts in offers.values()]
    band = tab.view.figures["impact_band"]
    tab.on_tap(Tap(band, x=2.0 * tab.result.impact.steps_per_contact, y=0.5))
    tab.on_tap(Tap(band, x=None, y=0.5))
    assert host.settings == [{"steps": "1000"}]


def test_the_figures_and_the_table_are_those_of_the_result(shown):
    tab, host = shown()
    found = tab.result.found.restitution
    assert host.summary.startswith("Answer: You asked for 0.50")
    drawn = tab.view.sources["impact_over_instant"].data["restitution"]
    assert np.nanmin(drawn) == pytest.approx(found.least, rel=1e-3)
    assert np.nanmax(drawn) == pytest.approx(found.greatest, rel=1e-3)
    assert tab.view.sources["impact_here"].data["mean"][0] == pytest.approx(found.mean)
    np.testing.assert_allclose(tab.view.sources["impact_over_steps"].data["steps"], STEPS, rtol=1e-6)
    assert tab.view.ranges["restitution"].ends[1] <= 2.0  # also where most steps blow up
    rows = tab.offers.points["rows"]
    (mine,) = [row for row in rows if row["mark"]]
    assert [cell["text"] for cell in mine["cells"][:2]] == ["Newmark", "start of the step"]
    assert len(rows) == len(tab.result.schemes)
    assert [cell["text"] for cell in rows[-1]["cells"]] == ["Moreau and Jean, θ = 0.5", "impact law", "0.5", ""]
    for figure in tab.figures():
        for series in tab.table(figure.name):
            assert len({len(column) for column in series.columns.values()}) == 1


@pytest.mark.parametrize("setting", [SETTING, LAW])
def test_a_permitted_penetration_offers_the_k_for_it_which_is_set_here(setting):
    result = next(growing(setting, depth=0.01, speed=1.0))
    texts = offers_of(result, setting)["contact"]
    assert texts.keys() == ({"K", "D"} if setting is SETTING else {"K"})
    changed = setting._replace(**{name: float(text) for name, text in texts.items()})
    alone = question(changed, speed=1.0).at(1.0).without_step
    assert 0.998 * 0.01 < alone.penetration <= 0.01
    assert "contact" not in offers_of(next(growing(changed, depth=0.01, speed=1.0)), changed)  # it is set
    if setting is SETTING:
        assert alone.restitution == pytest.approx(0.5, abs=1e-3)
    tab = OneImpact(host := FakeHost())
    tab.build()
    tab.panel.chosen = tab.panel.chosen | {"depth": 0.01, "speed": 1.0}
    RESULTS.put(result.question, result)
    tab.show(Move(1, setting))
    send(tab.offers, {"open": "contact"})
    tab.close()
    assert (host.settings, host.visits) == ([texts], [])


@pytest.mark.parametrize("units", ["none", "si"])
def test_the_forces_of_the_best_and_the_worst_touch_and_without_a_step_are_drawn_and_named(shown, units):
    setting = SETTING._replace(units=units, omega1=100.0, m1=2.0, amplitude=1.0)
    tab, _ = shown(setting)
    e, plot = tab.result.found.restitution, tab.view.figures["impact_force"]
    said = {item.label.value for item in plot.legend[0].items}
    worst = max(e.least, e.greatest, key=lambda each: abs(each - 0.5))
    assert any(text.startswith("best touch: t/Δτ ") for text in said)
    assert any(text.startswith("worst touch: t/Δτ ") and text.endswith(f"e {worst:.2f}") for text in said)
    assert f"without a step: e {tab.result.impact.without_step.restitution:.2f}" in said
    force, time = (1.0, 1.0) if units == "none" else (2.0 * 100.0**2 * 1e-3, 0.01)
    drawn = tab.view.sources["impact_force_exact"].data
    assert drawn["force"].max() == pytest.approx(force * tab.result.impact.without_step.force, rel=1e-3)
    assert drawn["time"][-1] == pytest.approx(time * tab.result.impact.without_step.time, rel=1e-5)
    assert plot.yaxis[0].axis_label.endswith("/ N" if units == "si" else "/ (k₁A)")
    tables = table_in_units(tab.table("impact_force"), setting.scale)
    assert [series.label for series in tables] == ["best touch", "worst touch", "without a step"]
    assert [*tables[0].columns] == (["time [s]", "force [N]"] if units == "si" else ["tau", "force"])


def test_a_row_of_the_table_sets_its_integrator_and_contact_status(shown):
    tab, host = shown()
    rows = {row["cells"][0].get("open"): row["cells"] for row in tab.offers.points["rows"]}
    assert [cell["text"] for cell in rows["bathe located"][:2]] == ["Bathe", "step cut at contact"]
    for name in ("bathe end", "bathe located", "nothing"):
        send(tab.offers, {"open": name})
    assert host.settings == [
        {"integrator": "bathe", "status": "end", "located": "no"},
        {"integrator": "bathe", "status": "start", "located": "yes"},
    ]
    for texts, status in zip(host.settings, ("end", "located"), strict=True):
        method = question(SETTING._replace(**texts)).method
        assert (method.integrator.name, method.status) == ("bathe", status)


def test_a_k_and_d_that_give_something_else_whatever_the_step_are_named():
    setting = SETTING._replace(D=100.0)
    said = {head: str(text) for head, text in OneImpact(FakeHost()).describe(setting, next(growing(setting)))}
    assert "No step makes up for K and D, which give 0.00 without one: take another D over." in said["Answer"]


def test_fields_and_sentences_are_in_the_units_that_are_shown(shown):
    setting = SETTING._replace(units="si", omega1=100.0, m1=2.0, amplitude=1.0)
    tab, _ = shown(setting)
    assert tab.question(setting) == question(SETTING)
    said = dict(tab.panel.statements)
    assert f"{written(2.0 * SETTING.system.mass_share)} kg" in said["Contact"]
    assert "m/s" in said["Contact"]
    tab.panel.receive({"choose": {"mass": "1 kg", "speed": "1 m/s"}})
    assert tab.panel.chosen == {"mass": 0.5, "speed": pytest.approx(10.0), "depth": None}


def test_a_contact_that_is_none_says_why(shown):
    setting = SETTING._replace(steps=10**6, K=1e-3)
    tab = OneImpact(FakeHost())
    tab.build()
    assert "is too short to follow: take at least" in tab.obstacle(setting)


def test_the_files_give_the_same_numbers(shown, capsys, monkeypatch):
    tab, _ = shown()
    monkeypatch.setattr(impact_words, "INTEGRATORS", {"newmark": NewmarkBeta})  # the table is tested for itself
    assert main(shlex.split(tab.command(SETTING))[1:]) == 0
    printed = capsys.readouterr().out
    exec(tab.python(SETTING), {})
    assert f"least={tab.result.found.restitution.least!r}" in capsys.readouterr().out
    assert f"{tab.result.impact.steps_per_contact:.3g} in a contact" in printed
