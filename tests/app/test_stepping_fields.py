"""Integrator, contact status and law of the page: one source, links, scripts, and sentences where nothing is known."""

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import describe, explain
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.method_words import name_of_method, words_of_method
from vibroscope.app.explorer.motion_kind import judge_motions
from vibroscope.app.explorer.parameters import STEPPING_FIELDS
from vibroscope.app.explorer.presets import preset_of, scenes
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.study.plane import Plane
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    INTEGRATORS,
    Bathe,
    CentralDifference,
    Newmark,
    NewmarkBeta,
    TimeStepping,
    Verdict,
)

from tests.app.fakes import FakeHost

COARSE = {"eta": "2.76", "K": "12000", "D": "18", "steps": "200"}


@pytest.mark.parametrize(
    ("texts", "method"),
    [
        ({}, Newmark(2500.0, 8.0, 2000)),
        ({"located": "yes"}, Newmark(2500.0, 8.0, 2000, located=True)),
        ({"gamma": "0.6"}, TimeStepping(2500.0, 8.0, 2000, NewmarkBeta(0.25, 0.6))),
        ({"alpha": "-0.1", "rho": "0.1"}, Newmark(2500.0, 8.0, 2000)),  # numbers of other integrators
        ({"integrator": "hht", "status": "end"}, TimeStepping(2500.0, 8.0, 2000, HHT(-0.05), "end")),
        ({"integrator": "bathe", "rho": "0"}, TimeStepping(2500.0, 8.0, 2000, Bathe(0.0))),
        ({"law": "cut"}, TimeStepping(2500.0, 8.0, 2000, law="cut")),
        (
            {"status": "end", "without_solution": "halve", "initial_acceleration": "zero"},
            TimeStepping(2500.0, 8.0, 2000, NewmarkBeta(), "end", "halve", initial_acceleration="zero"),
        ),
    ],
)
def test_the_penalty_solution_is_what_is_set_and_a_link_holds_it(texts, method):
    setting = read_setting(texts)
    assert setting.penalty == method
    assert read_setting(parse_address(print_address(setting))) == setting


def test_the_default_has_the_link_of_before_and_scenes_return_to_it():
    address = print_address(Setting())
    assert not [name for name in STEPPING_FIELDS if name in address]
    changed = read_setting({"integrator": "hht", "status": "end", "law": "cut"})
    assert preset_of(changed) is None
    assert read_setting(scenes()["A"].texts(), changed) == read_setting(scenes()["A"].texts())


def test_the_status_that_was_chosen_last_counts_and_contradictions_are_refused():
    iterated = read_setting({"status": "end"})
    assert read_setting({"located": "yes"}, iterated).status == "start"
    assert read_setting({"status": "end"}, Setting(located="yes")).located == "no"
    assert read_setting({"integrator": "central-difference"}, iterated).penalty.integrator == CentralDifference()
    for texts in ({"integrator": "central-difference", "status": "end"}, {"located": "yes", "status": "end"}):
        with pytest.raises(Refused) as refused:
            read_setting(texts)
        assert refused.value.name == "status"


def test_the_panel_shows_the_numbers_of_the_integrator_alone():
    controls = Controls()
    choices = {each["name"]: each["choices"] for each in controls.spec["solver"] if "choices" in each}
    assert choices["integrator"].keys() == INTEGRATORS.keys()
    assert set(choices["law"]) == set(CONTACT_LAWS)
    for integrator, numbers in {"newmark": {"beta", "gamma"}, "hht": {"alpha"}, "bathe": {"rho"}}.items():
        controls.show_setting(read_setting({"integrator": integrator}))
        assert controls.fields.keys() & {"beta", "gamma", "alpha", "rho"} == numbers


def test_what_is_set_is_said_with_the_steps_that_have_no_solution():
    setting = read_setting({**COARSE, "status": "end", "without_solution": "keep"})
    runs = compute_runs(setting)
    found = runs.penalty.response
    assert found.steps_without_solution > 0
    text = describe(runs).penalty[1]
    assert "contact status iterated to the end of the step" in text
    assert f"{found.steps_without_solution:,} steps without a solution".replace(",", "") in text
    assert words_of_method(Newmark(1.0, 1.0, 8)) == ""
    assert name_of_method(TimeStepping(1.0, 1.0, 8, HHT(-0.1))) == "HHT-α, forces averaged (α = −0.1)"
    assert make_question(setting, {"tolerance": "5"}).search.scheme.status == "end"
    assert make_question(Setting(), {"tolerance": "5"}).search.scheme == Newmark(1.0, 0.0, 1000)


@pytest.mark.parametrize("texts", [{"integrator": "hht"}, {"law": "cut"}, {"status": "end"}])
def test_where_the_engine_knows_nothing_a_sentence_says_so(texts):
    setting = read_setting(COARSE | texts)
    explanation = explain(compute_runs(setting))
    assert explanation.headline.endswith(".")
    assert explanation.agree in ("yes", "partly", "no", "unknown")
    assert judge_motions(setting, lambda: False)["penalty"].name


def test_a_verdict_appears_once_the_engine_has_one(monkeypatch):
    said = Verdict("They agree.", "yes")
    monkeypatch.setattr("vibroscope.app.explorer.explanation.verdict", lambda *_, **__: said)
    assert explain(compute_runs(read_setting(COARSE | {"integrator": "hht"}))).headline.startswith("They agree.")


def test_scripts_and_commands_have_what_is_set():
    setting = read_setting(
        COARSE | {"integrator": "hht", "alpha": "-0.1", "status": "end", "without_solution": "halve"}
    )
    assert "--integrator hht --alpha -0.1 --status end --without-solution halve" in as_command(setting)
    script = as_python(setting)
    assert "integrator=HHT(alpha=-0.1)" in script
    compile(script, "script", "exec")
    names = script.partition("import ")[2].partition("\n")[0].split(", ")
    assert {"HHT", "TimeStepping", "Reference", "System", "compare"} <= set(names)


@pytest.mark.parametrize("law", ["kelvin-voigt", "cut"])
def test_the_script_runs(law, capsys):
    exec(as_python(read_setting(COARSE | {"integrator": "hht", "law": law})), {})
    assert "xi1, xi1', xi2, xi2' at the end" in capsys.readouterr().out


@pytest.mark.parametrize(("tab", "choice"), [(Plane, ""), (Bifurcation, "solver:newmark")])
def test_a_study_that_the_engine_does_not_have_is_a_sentence_until_it_has_one(tab, choice, monkeypatch):
    host = FakeHost()
    shown = tab(host)
    shown.build()
    shown.restore(tab.read_view("", choice, ""))
    setting = read_setting(COARSE | {"integrator": "hht"})
    question = shown.question(setting)
    method = question.other if tab is Plane else question.method
    assert method.integrator == HHT(-0.05)
    monkeypatch.setattr(type(question), "study", refuse)
    assert shown.obstacle(setting) == "A study is not there yet."
    assert shown.obstacle(read_setting(COARSE)) == ""
    monkeypatch.setattr(type(question), "study", lambda self: None)
    assert shown.obstacle(setting) == ""
    shown.close()


def refuse(question):
    raise ValueError("a study is not there yet")
