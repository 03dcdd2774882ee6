"""Speed against error of a setting: errors against 60-digit solutions, slopes, turns, results, figure, words."""

import json
import math

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.study.speed import Speed, SpeedView, statements
from vibroscope.app.page.study.time_step import TimeStep
from vibroscope.app.performance.bench import CHECKED, true_state
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.runtime.json_text import json_text
from vibroscope.app.studies import speed
from vibroscope.app.studies.speed import KINDS, PartialSpeed, SolverKey, SpeedQuestion, grow_speed, steps_around
from vibroscope.engine import Cancelled, ExactPenalty, Newmark, Reference, System
from vibroscope.engine.sweeps.digest import solver_digest

SHIPPED = ASSETS / "speed"
SETTING = Setting()._replace(eta=2.76, K=12000.0, D=18.0, steps=400)


def never():
    return False


def question_of(setting):
    return Speed.question(None, setting)


@pytest.fixture(scope="module")
def results():
    """A whole measurement in two parts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speed, "ROUNDS", (1, 3))
        yield list(grow_speed(question_of(SETTING), None, never))


def test_all_solvers_take_turns_from_a_quarter_to_four_times_n(results):
    assert [result.rounds for result in results] == [1, 3]
    keys = set(results[-1].turns)
    assert {key.steps for key in keys if key.kind == "located"} == {100, 200, 400, 800, 1600}
    assert {key.kind for key in keys} == set(speed.KINDS)
    assert len(keys) == 2 + 3 * 5
    assert all(0 < spent < 1e5 for spents in results[-1].turns.values() for spent in spents)
    assert steps_around(8) == [4, 8, 16, 32]  # never fewer than Newmark takes


def test_errors_are_those_of_the_truth_and_of_the_shipped_figure(results):
    right = true_state(2.76, ExactPenalty(12000, 18))
    run = speed.solvers(question_of(SETTING))[SolverKey("located", 400)](CHECKED, never)
    error = results[-1].errors[SolverKey("located", 400)]
    assert error == pytest.approx(np.abs(run.state - right).max(), rel=1e-5)  # exact penalty is as good as the truth
    finest, coarsest = (results[-1].errors[SolverKey("located", n)] for n in (1600, 400))
    assert math.log(coarsest / finest, 4) == pytest.approx(2, abs=0.15)  # the located step is of second order


def test_the_shipped_figure_is_of_these_solvers():
    found = json.loads((SHIPPED / "work-precision.json").read_text())
    advice = "assets/speed is of other solvers: run `python benchmarks/work_precision.py --write`"
    assert found.get("solvers") == solver_digest(), advice
    assert f"solvers {solver_digest()}" in (SHIPPED / "work-precision.svg").read_text(), advice


def test_the_plain_loop_has_the_error_of_the_skipped_steps_and_costs_each_step(results):
    result = results[-1]
    for n in (400, 800, 1600):
        fixed, plain = SolverKey("fixed", n), SolverKey("plain", n)
        assert result.errors[plain] == result.errors[fixed]
        states = [speed.solvers(result.question)[key](CHECKED, never).state for key in (plain, fixed)]
        assert states[0] == pytest.approx(states[1], rel=1e-6)
        assert result.solves[plain] == result.solves[fixed] == n
        assert result.solves[SolverKey("located", n)] > n
    assert result.times(SolverKey("plain", 1600), SolverKey("fixed", 1600)) > 3


def test_medians_of_a_stopped_measurement_go_on_from_its_turns(results, monkeypatch):
    monkeypatch.setattr(speed, "ROUNDS", (1, 3))
    shown, finished = grow_speed(results[0].question, results[0], never)
    assert shown is results[0]
    for key, turns in finished.turns.items():
        assert turns[:1] == results[0].turns[key]
        assert finished.cost(key) == np.median(turns)
    assert finished.share == 1
    assert list(grow_speed(finished.question, finished, never)) == [finished]


def test_a_cancelled_measurement_ends_in_the_middle_of_a_turn():
    calls = iter(range(1000))
    with pytest.raises(Cancelled):
        list(grow_speed(question_of(SETTING), None, lambda: next(calls) > 20))
    assert next(calls) < 60


def made(errors=None, **more):
    """A result by hand: costs 1, 2, … µs, the errors as given."""
    asked = SpeedQuestion(System(), 1.08, Newmark(2500.0, 8.0, 400), Reference())
    keys = list(speed.solvers(asked))
    errors = {key: 1.0 / key.steps for key in keys if key.steps} | (errors or {})
    return PartialSpeed(
        asked,
        errors,
        {key: 2.0 * key.steps if key.kind == "located" else float(key.steps) for key in keys},
        {key: (i + 1.0,) for i, key in enumerate(keys)},
    )


def test_the_setting_is_ringed_where_it_stands():
    view, result = SpeedView(), made()
    view.update(SETTING._replace(located="no"), result)
    ringed = view.present.data
    assert ringed["text"] == ["set", "in an FE code"]
    assert ringed["cost"] == [result.cost(SolverKey("fixed", 400)), result.cost(SolverKey("plain", 400))]
    assert ringed["error"] == pytest.approx([1 / 400] * 2)
    middle = math.sqrt(view.figure.x_range.start * view.figure.x_range.end)
    for cost, right, align in zip(ringed["cost"], ringed["right"], ringed["align"], strict=True):
        assert (right > 0, align) == ((True, "left") if cost < middle else (False, "right"))  # the text is inside
    view.update(SETTING._replace(located="yes"), result)
    assert view.present.data["text"] == ["set"]
    assert view.figure.y_range.start < 1 / 1600 < 1 / 100 < view.figure.y_range.end


def test_what_blew_up_is_said_and_neither_drawn_nor_ringed():
    gone = {SolverKey(kind, 400): math.nan for kind in ("fixed", "plain")}
    view, result = SpeedView(), made(gone)
    view.update(SETTING, result)
    assert view.present.data["text"] == []
    assert 400 not in view.sources["speed_fixed"].data["n"]
    assert "smaller step" in dict(statements(SETTING, result))["Present setting: T/400, constant step"]
    nothing = made(dict.fromkeys(result.errors, math.nan))
    SpeedView().update(SETTING, nothing)
    assert statements(SETTING, nothing)
    tab = Speed(None)
    tab.study.result = nothing
    assert set(json.loads(json_text(nothing.data()))["error"]) == {None}
    assert [series.label for series in tab.table("speed")] == list(KINDS)


def test_a_step_that_blows_up_costs_what_its_steps_would_have_cost_to_the_end():
    coarse = Setting(eta=2.76, K=12000.0, D=18.0, integrator="central-difference", steps=60)
    run = speed.solvers(question_of(coarse))[SolverKey("fixed", 60)](200, never)
    assert np.isnan(run.state).all()
    assert run.solves == 60 * 200


def test_words_count_what_the_located_step_would_save():
    good = made({SolverKey("located", 100): 1e-9})  # 200 solves instead of 400
    text = dict(statements(SETTING, good))["With the step cut where contact changes"]
    assert text.startswith("T/100: error 1e-9 A ")
    assert "200 solves per period beside 400, 2 times fewer" in text
    physical = SETTING._replace(units="mm-t-s", omega1=10.0, amplitude=2.0)
    text = dict(statements(physical, good))["With the step cut where contact changes"]
    assert text.startswith("T/100: error at most 2e-9 mm and 2e-8 mm/s after")
    bad = made({key: 1.0 for key in good.errors if key.kind == "located"})
    assert "None of those tried" in dict(statements(SETTING, bad))["With the step cut where contact changes"]


def test_the_question_holds_what_counts_and_equals_no_other_study_s():
    assert question_of(SETTING) == question_of(SETTING._replace(located="yes", units="si"))
    for change in ({"steps": 401}, {"K": 1.0}, {"kappa": 2.4}, {"joint_damping": "derived"}):
        assert question_of(SETTING) != question_of(SETTING._replace(**change))
    assert question_of(SETTING) != TimeStep.question(None, SETTING)
