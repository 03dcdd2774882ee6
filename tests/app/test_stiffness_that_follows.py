"""A contact stiffness that follows the time step, on the page: what is run, shown, linked, studied and taken away."""

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import explain
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.export.report import setting_rows
from vibroscope.app.export.scripts import as_command, as_python, speed_python
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.study.speed import Speed
from vibroscope.app.page.study.time_step import TimeStep, TimeStepView
from vibroscope.app.performance.bench import CHECKED
from vibroscope.app.studies import speed, time_step
from vibroscope.app.studies.speed import SolverKey, grow_speed
from vibroscope.app.studies.time_step import grow_step
from vibroscope.engine import Newmark, simulate, stiffness_of_step

COARSE = Setting(eta=2.76, K=12000.0, D=18.0, steps=200)
FOLLOWS = read_setting({"stiffness": "step"}, COARSE)


def followed(setting):
    exact = stiffness_of_step(setting.system, setting.eta, setting.steps, setting.step_scale)
    assert setting.stiffness_of_step == pytest.approx(exact, rel=1e-5)
    return setting.stiffness_of_step


def test_k_is_that_of_the_step_and_goes_with_it():
    assert followed(FOLLOWS) == FOLLOWS.K
    assert FOLLOWS.step_scale == 0.1
    finer = read_setting({"steps": "400"}, FOLLOWS)
    assert pytest.approx(4 * FOLLOWS.K, rel=1e-5) == finer.K
    for texts in ({"eta": "1.08"}, {"step_scale": "0.2"}, {"kappa3": "1.4"}, {"bodies": "wall"}):
        moved = read_setting(texts, FOLLOWS)
        assert moved.K == followed(moved) != FOLLOWS.K
    assert compute_runs(finer).penalty.response.method == Newmark(finer.K, 18.0, 400)


def test_a_stiffness_that_is_given_stays_and_scenes_have_their_own():
    typed = read_setting({"K": "900"}, FOLLOWS)
    assert (typed.K, typed.follows_step) == (900.0, False)
    assert read_setting({"K": "900", "stiffness": "step"}, COARSE) == FOLLOWS
    scene = next(iter(scenes().values()))
    assert read_setting(scene.texts(), FOLLOWS).K == scene.setting.K
    with pytest.raises(Refused, match="cannot be held"):
        make_question(FOLLOWS, {"tolerance": "5", "hold": "K"})


@pytest.mark.parametrize(
    ("texts", "name"), [({"steps": "65000", "step_scale": "1e6"}, "steps"), ({"step_scale": "0"}, "step_scale")]
)
def test_what_is_out_of_range_is_refused_in_one_line(texts, name):
    with pytest.raises(Refused, match=r"must be .*from") as refused:
        read_setting(texts, FOLLOWS)
    assert refused.value.name == name


def test_it_is_linked_kept_and_taken_away():
    assert read_setting(parse_address(print_address(FOLLOWS))) == FOLLOWS
    assert read_setting(loaded_from_toml(as_toml(FOLLOWS)).texts) == FOLLOWS
    assert read_setting(FOLLOWS.texts()) == FOLLOWS
    rows = dict(row[:2] for row in setting_rows(FOLLOWS))
    assert (rows["Stiffness"], rows["s"]) == ("follows the step", "0.1")
    assert repr(FOLLOWS.K) in as_python(FOLLOWS)
    assert f"--K {FOLLOWS.K!r}" in as_command(FOLLOWS)


def test_the_slider_is_locked_and_says_why():
    controls = Controls()
    controls.show_setting(FOLLOWS)
    assert controls.fields["K"]["locked"].startswith("follows from the time step")
    assert controls.shown["notes"]["K"] == "0.1 m/Δτ²: half the step gives four times K"
    assert float(controls.shown["texts"]["K"]) == FOLLOWS.K
    assert "step_scale" in controls.fields
    controls.show_setting(FOLLOWS._replace(units="si"))
    assert controls.shown["notes"]["K"].endswith("without dimension; 0.1 m/Δτ²: half the step gives four times K")
    controls.show_setting(COARSE)
    assert (controls.fields["K"]["locked"], "step_scale" in controls.fields) == ("", False)


def test_it_follows_where_other_units_carry_the_numbers_over():
    texts = entered({"mass1_kg": "2"}, FOLLOWS._replace(units="si"))
    moved = read_setting(texts, FOLLOWS._replace(units="si"))
    assert moved.follows_step
    assert followed(moved) == moved.K


def test_the_study_over_the_step_takes_the_stiffness_of_each():
    question, finer = (TimeStep.question(None, each) for each in (FOLLOWS, read_setting({"steps": "400"}, FOLLOWS)))
    assert question == finer
    study = question.study()
    expected = [stiffness_of_step(FOLLOWS.system, 2.76, n, 0.1) for n in study.steps]
    assert study.arrays["K"].values.tolist() == expected
    assert TimeStep.question(None, COARSE).stiffness_of_step is None


def test_the_figures_over_the_step_name_the_stiffness_of_the_steps_that_are_shown(monkeypatch):
    monkeypatch.setattr(time_step, "STEPS", (200, 400))
    result = list(grow_step(TimeStep.question(None, FOLLOWS), None, lambda: False))[-1]
    view = TimeStepView()
    for steps in ("200", "400"):
        shown = read_setting({"steps": steps}, FOLLOWS)
        view.update(shown, result)
        assert (
            f"T/{steps}, constant step, η = 2.76, K = {shown.K:g}, D = 18"
            in view.figures["step_phase_fixed"].title.text
        )
    np.testing.assert_allclose(result.data()["K"], [FOLLOWS.K, 4 * FOLLOWS.K], rtol=1e-5)


def test_another_step_is_proposed_for_the_stiffness_with_which_it_was_tried():
    texts = {"eta": "1.08", "D": "8", "steps": "16", "located": "yes", "stiffness": "step", "step_scale": "30"}
    setting = read_setting(texts)
    change = explain(compute_runs(setting)).change
    assert change.keys() == {"steps", "K"}
    moved = read_setting(change, setting)
    assert (moved.K, moved.follows_step) == (setting.K, False)


def test_speed_against_error_takes_the_stiffness_of_each_step(monkeypatch):
    """The error of each n is that against the exact penalty model of its own K: it fades as the step."""
    monkeypatch.setattr(speed, "ROUNDS", (1,))
    question = Speed.question(None, FOLLOWS)
    (result,) = grow_speed(question, None, lambda: False)
    expected = []
    for n in (100, 200, 800):
        stiffness = stiffness_of_step(FOLLOWS.system, 2.76, n, 0.1)
        located = Newmark(stiffness, 18.0, n, located=True)
        states = [
            simulate(FOLLOWS.system, 2.76, each, periods=CHECKED, keep=1).section[-1]
            for each in (located, located.limit)
        ]
        expected.append(np.abs(np.subtract(*states)).max())
    found = [result.errors[SolverKey("located", n)] for n in (100, 200, 800)]
    np.testing.assert_allclose(found, expected, rtol=1e-3)  # K of the present step is rounded
    columns = (result.data()[name] for name in ("solver", "solver_steps", "solver_K"))
    of_each = {(kind, n): stiffness for kind, n, stiffness in zip(*columns, strict=True)}
    assert of_each["fixed", 800] == pytest.approx(16 * FOLLOWS.K, rel=1e-5)
    assert "K of its own" in dict(Speed(None).describe(FOLLOWS, result))["Stiffness"]
    assert "stiffness_of_step=0.1" in speed_python(question)
    assert Speed.question(None, COARSE).stiffness_of_step is None
