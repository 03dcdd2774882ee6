"""An own start travels with the setting: computed, explained, judged, linked, shown in units, taken away."""

from dataclasses import replace
from queue import Queue

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import describe, explain
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.motion_kind import judge_motions
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.presets import preset_of, scenes
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.scripts import as_command, speed_python
from vibroscope.app.page.explore import explainer, measurement
from vibroscope.app.page.study import time_step as step_tab
from vibroscope.app.page.study.speed import Speed
from vibroscope.app.page.study.time_step import TimeStep
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies import speed, time_step
from vibroscope.engine import Newmark, Record, compare_measured, simulate, synthetic_measurement
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.sweeps import StepStudy

from tests.app.fakes import Document, FakeHost, send
from tests.waiting import PATIENCE

START = (1.2232, 4.5444, 3.5934, 2.5268)  # leads the reference to a motion of six periods; rest, to one of two
REST = Setting(eta=3.2, K=12000.0, D=18.0, steps=2000)
OWN = REST._replace(**dict(zip(START_FIELDS, START, strict=True)))


@pytest.fixture(scope="module")
def runs():
    cache = Cache(8)
    return compute_runs(OWN, cache=cache), compute_runs(REST, cache=cache)


def test_both_runs_begin_there_and_are_kept_apart_from_those_from_rest(runs):
    own, rest = runs
    for name in ("reference", "penalty"):
        response = getattr(own, name).response
        alone = simulate(OWN.system, OWN.eta, response.method, initial=START)
        np.testing.assert_array_equal(response.section, alone.section)
    assert (own.reference.motion.period, rest.reference.motion.period) == (6, 2)


def test_explanation_and_kinds_speak_of_the_motions_that_are_shown(runs):
    own, _ = runs
    explained = explain(own)
    assert "every 6 periods" in explained.kinds["reference"]
    assert "every 6 periods" in describe(own).reference[0]
    assert "From the same start" in explained.headline
    kinds = judge_motions(OWN, lambda: False)
    assert (kinds["reference"].name, judge_motions(REST, lambda: False)["reference"].name) == ("period 6", "period 2")


def test_an_explanation_is_that_of_its_start(monkeypatch):
    monkeypatch.setattr(explainer, "EXPLANATIONS", Cache(2))
    monkeypatch.setattr(explainer, "compute_runs", lambda setting, _: setting)
    monkeypatch.setattr(explainer, "explain", lambda runs, *_: runs.initial)
    explained = Queue()
    explainer.begin_explanation(OWN, lambda _, found: explained.put(found))
    assert explained.get(timeout=PATIENCE) == START
    assert (explainer.known_explanation(OWN), explainer.known_explanation(REST)) == (START, None)


def test_a_link_comes_back_to_the_start_and_holds_none_from_rest():
    address = print_address(OWN)
    assert read_setting(parse_address(address)) == OWN
    assert "start_" not in print_address(REST)
    pinned = print_address(REST, pins=[OWN])
    assert "start_xi1" in pinned


def test_pendulums_that_overlap_at_the_start_are_refused_with_what_to_do():
    with pytest.raises(Refused, match=r"ξ₁\(0\) must be at most ξ₂\(0\), not 2 with 0: .*Set ξ₂\(0\) first") as refusal:
        read_setting({"start_xi1": "2"}, REST)
    assert refusal.value.name == "start_xi1"
    with pytest.raises(Refused, match=r"Set ξ₁\(0\) first") as refusal:
        read_setting({"start_xi2": "-1"}, REST)
    assert refusal.value.name == "start_xi2"
    assert read_setting({"start_xi1": "-2", "start_xi2": "-1"}, REST).initial == (-2, 0, -1, 0)
    with pytest.raises(Refused, match="start_v1 must be a number from -1e6 to 1e6, not “2e6”"):
        read_setting({"start_v1": "2e6"}, REST)


def test_a_start_is_typed_and_shown_in_units():
    setting = REST._replace(units="mm-t-s", omega1=20.0, amplitude=2.5)
    texts = plain_texts({"start_xi2": {"typed": "5 mm"}, "start_v2": {"typed": "-0,1 m/s"}}, setting)
    found = read_setting(texts, setting)
    assert found.initial == pytest.approx((0, 0, 2, -2))  # by hand: 5/2.5 and -100/(2.5·20)
    field = shown_field("start_v2", found)
    assert (field.label, field.number(found.start_v2), field.unit) == ("x₂′(0)", "-100", "mm/s")
    with pytest.raises(Refused, match=r"x₁\(0\) must be at most x₂\(0\), not 7.5 mm with 5 mm"):
        read_setting({"start_xi1": "3"}, found)


def test_a_scene_starts_from_rest():
    scene = scenes()["A"]
    there = read_setting(scene.texts(), OWN)
    assert there.initial == Setting().initial
    assert preset_of(there).key == "A"
    assert preset_of(there._replace(start_v2=1.0)) is None


def test_the_commands_take_a_start_that_begins_with_a_minus_sign(capsys):
    setting = REST._replace(start_xi1=-1.5, steps=200)
    first, *_, last = as_command(setting).splitlines()
    assert "--initial=-1.5,0,0,0" in first
    assert "--initial=-1.5,0,0,0" in last
    assert main(first.split()[1:]) == 0
    assert "xi1, xi1', xi2, xi2'" in capsys.readouterr().out


def test_a_measurement_is_compared_with_the_motions_that_are_shown(monkeypatch):
    measured = synthetic_measurement(OWN.system, 3.2, periods=30)
    found = compare_measured(OWN.system, 3.2, measured, OWN.penalty, initial=START)
    assert found.reference.period == 6
    jobs = []

    class Job:
        cancelled = False

        def __init__(self, question, deliver):
            self.question, self.deliver = question, deliver
            jobs.append(self)

    monkeypatch.setattr(measurement, "judge_file", Job)
    overlay = measurement.Overlay(FakeHost(doc=Document()), lambda: None)
    overlay.follow(OWN)
    for message in ({"file": {"name": "own.csv"}}, {"end": True}):
        send(overlay.button, message)
    jobs[0].deliver(jobs[0], found)
    pending = []
    for setting in (OWN, REST, OWN):
        overlay.follow(setting)
        pending.append(overlay.panel.content["pending"])
    assert pending == [False, True, False]


def test_a_study_of_the_time_step_runs_from_there(monkeypatch, tmp_path):
    """Its script and command too; from rest the start has no part in the key of the study."""
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    for module in (time_step, step_tab):
        monkeypatch.setattr(module, "STEPS", (500,))
    asked, rest = (TimeStep.question(None, setting) for setting in (OWN, REST))
    *_, found = time_step.grow_step(asked, None, lambda: False)
    alone = simulate(OWN.system, OWN.eta, Newmark(OWN.K, OWN.D, 500), periods=2050, keep=50, initial=START)
    np.testing.assert_array_equal(found.section(0, "fixed")["xi2"], alone.section[:, 2])
    assert (rest.initial, rest.study().options, asked.study().options) == (None, {}, {"initial": [*START]})
    assert asked.study().key != rest.study().key
    tab = TimeStep(FakeHost())
    assert f"initial={START}" in tab.python(OWN)
    assert "initial" not in tab.python(REST)
    command = tab.command(OWN).split()[1:]
    assert main([*command[:-1], str(tmp_path / "step.zarr")]) == 0
    stored = xarray.open_zarr(tmp_path / "step.zarr")
    np.testing.assert_array_equal(stored["xi2_section"][0, 0], found.section(0, "fixed")["xi2"])


def test_the_errors_of_a_study_are_those_from_the_motion_that_the_reference_has_from_there():
    study = StepStudy(
        OWN.system, Newmark(OWN.K, OWN.D, 2000), OWN.eta, transient=300, sample=24, steps=[2000], initial=START
    )
    at_rest = replace(study, initial=None).compute()
    run = simulate(OWN.system, OWN.eta, OWN.penalty, periods=312, keep=12, initial=START, record=Record(12, 200, 2000))
    error = Target.find(OWN.system, OWN.eta, initial=START).error(run)
    assert study.compute()["error"][0, 0] == pytest.approx(error, rel=0.1)
    assert at_rest["error"][0, 0] != pytest.approx(error, rel=0.1)
    with pytest.raises(ValueError, match="initial has 2 numbers: give the four of the state"):
        replace(study, initial=(1.0, 2.0))


def test_speed_and_error_are_measured_from_there():
    asked = Speed.question(None, OWN)
    found = speed.solvers(asked)[speed.SolverKey("fixed", 2000)](10, lambda: False)
    run = simulate(OWN.system, OWN.eta, OWN.penalty, periods=10, keep=1, initial=START)
    np.testing.assert_array_equal(found.state, run.section[-1])
    assert f"{START})" in speed_python(asked)
    assert Speed.question(None, REST).initial is None
    assert f"{Speed.question(None, REST).reference!r})\n" in speed_python(Speed.question(None, REST))
