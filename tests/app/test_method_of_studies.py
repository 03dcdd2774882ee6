"""The tabs of the time step, of speed and of the plane follow the integrator, contact status and law that are set."""

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.method_words import brief_name
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import speed_python
from vibroscope.app.page.study import time_step as step_tab
from vibroscope.app.page.study.plane import Plane
from vibroscope.app.page.study.speed import Speed, SpeedView
from vibroscope.app.page.study.speed import statements as speed_statements
from vibroscope.app.page.study.time_step import TimeStep, TimeStepView, statements
from vibroscope.app.studies import speed, time_step
from vibroscope.engine import CONTACT_LAWS, HHT, ExactPenalty, Newmark, System, TimeStepping, simulate
from vibroscope.engine.sweeps import StepStudy

from tests.app.fakes import FakeHost

COARSE = {"eta": "2.76", "K": "12000", "D": "18", "steps": "200"}
HHT_END = read_setting(COARSE | {"integrator": "hht", "status": "end", "without_solution": "keep"})
HERTZ = read_setting(COARSE | {"law": "hunt-crossley", "D": "30"})
KINDS = dict.fromkeys(("plain", "cut"), ("fixed", "plain", "located")) | {"hunt-crossley": ("fixed", "located")}


def never():
    return False


@pytest.fixture
def few(monkeypatch, tmp_path):
    """Few short runs, and nothing known from earlier ones."""
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    for module in (time_step, step_tab):
        monkeypatch.setattr(module, "STEPS", (100, 200))
        monkeypatch.setattr(module, "TRANSIENT", 60)
        monkeypatch.setattr(module, "SAMPLE", 20)
    monkeypatch.setattr(speed, "ROUNDS", (1,))


def step_result(setting):
    return list(time_step.grow_step(TimeStep.question(None, setting), None, never))[-1]


def test_the_time_step_study_is_of_what_is_set_and_its_command_makes_the_same_numbers(few, tmp_path):
    result = step_result(HHT_END)
    for scheme, status in (("fixed", "end"), ("located", "located")):
        method = TimeStepping(12000.0, 18.0, 200, HHT(-0.05), status, "keep")
        alone = simulate(System(), 2.76, method, periods=80, keep=20)
        np.testing.assert_array_equal(result.section(1, scheme)["xi2"], alone.section[:, 2])
    tab = TimeStep(FakeHost())
    command = tab.command(HHT_END).split()[1:]
    assert main([*command[:-1], str(tmp_path / "step.zarr")]) == 0
    stored = xarray.open_zarr(tmp_path / "step.zarr")
    np.testing.assert_array_equal(stored["xi2_section"][1, 0], result.section(1, "fixed")["xi2"])
    made = {}
    exec(tab.python(HHT_END), made)
    np.testing.assert_array_equal(made["study"]["error"], result.values["error"])
    assert result.data()["method"] == {"integrator": "hht", "status": "end", "law": "kelvin-voigt"}


def test_the_time_step_is_titled_and_described_by_what_is_set(few):
    result, view = step_result(HHT_END), TimeStepView()
    view.update(HHT_END, result)
    assert view.figures["step_phase_fixed"].title.text.startswith(
        "T/200, constant step, HHT-α, status at the end, η = 2.76"
    )
    lines = TimeStep(FakeHost()).describe(HHT_END, result)
    assert lines[0] == [
        "Penalty solution",
        "HHT-α, forces averaged (α = −0.05); contact status iterated to the end of the step; contact law Kelvin–Voigt.",
    ]
    usual = step_result(Setting()._replace(**{name: getattr(HHT_END, name) for name in ("eta", "K", "D", "steps")}))
    view.update(HHT_END, usual)
    assert view.figures["step_phase_fixed"].title.text.startswith("T/200, constant step, η = 2.76")


def test_a_study_of_another_law_has_fixed_and_located_steps(few):
    result = step_result(HERTZ)
    assert result.schemes == ("fixed", "located")
    assert result.share == 1
    view = TimeStepView()
    view.update(HERTZ, result)
    phases = [plot for name, plot in view.figures.items() if "phase" in name]
    assert all("Hunt–Crossley" in phase.title.text for phase in phases)
    assert len(view.sources["step_spread_located"].data["n"]) == 2
    assert "T/200, constant step" in str(statements(HERTZ, result))


def test_a_run_that_stops_for_want_of_a_solution_is_not_said_to_have_blown_up(few):
    stops = HHT_END._replace(without_solution="stop")
    assert "stopped: a step has no solution." in dict(statements(stops, step_result(stops)))["T/200, constant step"]


@pytest.mark.parametrize("kind", [TimeStep, Speed])
def test_the_question_changes_with_integrator_status_and_law_and_not_with_what_is_shown_anyway(kind):
    texts = ({}, {"integrator": "hht"}, {"integrator": "hht", "alpha": "-0.1"}, {"status": "end"})
    texts += tuple({"law": law} for law in CONTACT_LAWS[1:])
    questions = [kind.question(None, read_setting(COARSE | each)) for each in texts]
    assert len(set(questions)) == len(questions)
    located = [kind.question(None, read_setting(COARSE | each | {"located": "yes"})) for each in texts[:2]]
    assert located == questions[:2]


def test_every_method_has_a_kept_study_of_its_own_and_located_ones_are_half_of_any():
    methods = Newmark(1, 1, 100), TimeStepping(1, 1, 100, HHT(-0.1)), TimeStepping(1, 1, 100, law="hunt-crossley")
    study = StepStudy(System(), methods[0], 2.76, transient=10, sample=5, steps=[100])
    keys = {StepStudy(System(), each, 2.76, transient=10, sample=5, steps=[100]).key for each in methods}
    assert len(keys) == 3
    assert study.key in keys
    with pytest.raises(ValueError, match="give status = 'start' or 'end'"):
        StepStudy(System(), Newmark(1, 1, 100, located=True), 2.76, transient=10, sample=5, steps=[100])


@pytest.mark.parametrize("law", KINDS)
def test_speed_is_measured_of_what_is_set(few, law):
    setting = read_setting(COARSE | {"integrator": "hht"} | ({} if law == "plain" else {"law": law}))
    *_, result = speed.grow_speed(Speed.question(None, setting), None, never)
    assert {key.kind for key in result.turns} == {"reference", "exact", *KINDS[law]}
    limit = simulate(System(), 2.76, ExactPenalty(12000.0, 18.0, setting.law), periods=10, keep=1)
    own = simulate(System(), 2.76, setting.penalty, periods=10, keep=1)
    error = np.abs(own.section[-1] - limit.section[-1]).max()
    assert result.errors[speed.SolverKey("fixed", 200)] == pytest.approx(error, rel=1e-9)
    if "plain" in KINDS[law]:
        plain = speed.solvers(result.question)[speed.SolverKey("plain", 200)](10, never)
        assert plain.state == pytest.approx(own.section[-1], rel=1e-6)
    view = SpeedView()
    view.update(setting, result)
    legend = {item.label.value: item.visible for item in view.figure.legend[0].items}
    name = brief_name(setting.penalty)
    first = f"{name}, steps skipped" if "plain" in KINDS[law] else f"{name}, every step taken"
    assert legend[first]
    assert sum(legend.values()) == 2 + len(KINDS[law])
    assert view.present.data["text"] == ["set", "in an FE code"][: 1 + ("plain" in KINDS[law])]


def test_words_and_script_of_a_measurement_name_what_is_set(few, capsys):
    *_, result = speed.grow_speed(Speed.question(None, HERTZ), None, never)
    lines = dict(Speed(FakeHost()).describe(HERTZ, result))
    assert lines["Penalty solution"].endswith("contact law Hunt–Crossley.")
    assert "in which this law is solved for" in lines["What an FE code pays"]
    assert "Steps are cut" in lines["With the step cut where contact changes"]
    assert "closed form" not in f"{lines} {Speed.hint}".lower()
    exec(speed_python(Speed.question(None, HHT_END)), {})
    assert "located 200 " in capsys.readouterr().out
    located = HHT_END._replace(located="yes", status="start")
    *_, found = speed.grow_speed(Speed.question(None, located), None, never)
    assert "Present setting: T/200, step cut where contact changes" in dict(speed_statements(located, found))


def test_a_run_that_ends_early_costs_what_its_steps_cost():
    stops = HHT_END._replace(without_solution="stop", steps=800)
    solve = speed.solvers(Speed.question(None, stops))[speed.SolverKey("fixed", 200)]
    ended, whole = solve(200, never), solve(2, never)
    assert np.isnan(ended.state).all()
    assert ended.solves == 200 * 200
    assert whole.solves == 2 * 200


def test_a_method_of_two_stages_solves_twice_a_step():
    solvers = speed.solvers(Speed.question(None, read_setting(COARSE | {"integrator": "tr-bdf2"})))
    assert solvers[speed.SolverKey("fixed", 200)](3, never).solves == 2 * 3 * 200
    assert solvers[speed.SolverKey("plain", 200)](3, never).solves == 2 * 3 * 200
    assert solvers[speed.SolverKey("located", 200)](3, never).solves > 2 * 3 * 200
    assert solvers[speed.SolverKey("exact", 0)](3, never).solves == 0


def test_the_plane_is_named_after_what_is_set():
    tab = Plane(FakeHost())
    tab.build()
    question = tab.question(HERTZ)
    assert question.name == "Newmark, Hunt–Crossley"
    assert tab.question(HHT_END._replace(without_solution="stop")).name == "HHT-α, status at the end"
    assert "--law hunt-crossley" in tab.command(HERTZ).splitlines()[1]
    assert "law='hunt-crossley'" in tab.python(HERTZ)
    compile(tab.python(HERTZ), "script", "exec")
    assert "scheme" not in tab.python(read_setting(COARSE))
