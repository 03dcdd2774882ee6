"""What the time-step tab says and draws of blur and error: about the cycle, and why there is no number."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.study.time_step import TimeStep, TimeStepView, statements
from vibroscope.app.studies import time_step
from vibroscope.app.studies.time_step import PartialStep, grow_step
from vibroscope.engine.sweeps import CellKind

from tests.app.fakes import FakeHost

TWO = Setting(eta=3.2, K=12000.0, D=18.0)  # two periods with every n
APART = Setting(eta=1.08, K=22220.0, D=0.7267)  # exact penalty and every run differ


@cache
def result_of(setting: Setting) -> time_step.PartialStep:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time_step, "STEPS", (500, 1000, 2000, 4000))
        return list(grow_step(TimeStep(FakeHost()).question(setting), None, lambda: False))[-1]


@pytest.mark.parametrize("scheme", ["fixed", "located"])
def test_blur_is_about_the_points_of_the_cycle(scheme):
    """With 500 steps, not even nearly two periods, about the two points of exact penalty."""
    result = result_of(TWO)
    section = result.of_scheme("xi2_section", scheme)
    about_two = np.sqrt((section[:, ::2].var(axis=1) + section[:, 1::2].var(axis=1)) / 2)
    np.testing.assert_allclose(result.of_scheme("scatter", scheme), about_two, rtol=1e-6, atol=1e-14)
    assert (result.of_scheme("spread", scheme) > 0.2).all()
    assert result.of_scheme("near_period", "fixed")[0] == 0


def test_a_cycle_of_two_periods_that_repeats_exactly_has_no_blur():
    lines = dict(statements(TWO, result_of(TWO)))
    assert "repeats every 2 periods; no blur beyond rounding" in lines["T/2000, step cut at contact"]
    assert "step cut at contact: none beyond rounding" in lines["Blur, observed order"]
    assert "constant step: falls as n to the power of −" in lines["Blur, observed order"]


def test_where_motions_do_not_keep_step_words_and_figure_say_why_there_is_no_number():
    result, view = result_of(APART), TimeStepView()
    said = dict(statements(APART, result))
    why = "no number, since the motions do not keep step"
    assert said["Error by the time step, observed order"].count(why) == 2
    assert "constant step: does not fall with n" in said["Blur, observed order"]
    view.update(APART, result)
    assert view.figures["step_error_time_step"].title.text == f"Error by the time step alone: {why}"
    view.update(TWO, result_of(TWO))
    assert view.figures["step_error_time_step"].title.text.startswith("Error by the time step alone: constant step ")


def test_runs_that_blew_up_have_no_order_for_another_reason():
    setting = Setting(eta=2.76, K=12000.0, D=18.0, integrator="central-difference", steps=500)
    result = result_of(setting)
    for scheme in result.schemes:
        result.values["status"][:, time_step.SCHEMES[scheme]] = 1
        result.values["scatter"][:, time_step.SCHEMES[scheme]] = np.nan
    assert dict(statements(setting, result))["Blur, observed order"].count("no run came to its end") == 2


def test_a_slow_alternating_transient_is_no_cycle_of_two_periods():
    """A multiplier of exact penalty is −0.99684: after 2,000 periods its points still alternate by 9e-5."""
    setting = Setting(eta=2.76, K=115.0, D=4.762, steps=500)
    words = dict(statements(setting, result_of(setting)))
    assert words["T/500, constant step"].startswith("repeats every period, blurred by the time step: ξ₂ by ±")
    assert words["T/500, step cut at contact"].startswith("repeats every period;")


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ((2.0012, 0.0001), "falls as n to the power of −2.0012 ± 0.0001"),
        ((1.284, 0.31), "falls as n to the power of −1.3 ± 0.3"),
        ((1.284, 0.6), "falls unevenly, about as n to the power of −1.3 ± 0.6"),
        ((2.63, 5.2), "rises and falls with n, so that it has no order"),
        ((1.99993, 0.00003), "falls as n to the power of −1.9999;"),
        ((1.5, math.nan), "falls as n to the power of −1.50"),
    ],
)
def test_an_order_has_as_many_digits_as_its_error_and_none_below_it(monkeypatch, order, words):
    monkeypatch.setattr(PartialStep, "order", lambda *_: order)
    assert dict(statements(TWO, result_of(TWO)))["Blur, observed order"].startswith(f"constant step: {words}")


def test_a_motion_whose_kind_is_not_decided_still_nearly_repeats():
    result = result_of(TWO)
    index = int(np.flatnonzero(result.of_scheme("near_period", "fixed") == 2)[0])
    values = result.values | {"period": np.zeros_like(result.values["period"])}
    undecided = replace(result, values=values, judged={"fixed": {index: (CellKind.UNDECIDED, 0)}})
    assert undecided.words(index, "fixed") == "nearly repeats every 2 periods, kind not decided"
