"""The sentences must agree with the numbers."""

import numpy as np
import pytest
from vibroscope.app.explorer import explanation
from vibroscope.app.explorer.explanation import describe, explain, paragraphs
from vibroscope.app.explorer.field_units import words_of_change
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.reading import read_setting, read_values
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Verdict, percent

from tests.app import explanations
from tests.share import every


def setting_of(key=None, **numbers):
    """That of a scene, or of numbers."""
    return read_setting(scenes()[key].texts()) if key else Setting(**numbers)


def runs_of(key=None, **numbers):
    return explanations.runs_of(setting_of(key, **numbers))


def explanation_of(key=None, **numbers):
    return explanations.explained(setting_of(key, **numbers))


def test_chatter_and_permanent_contact():
    found = describe(runs_of("A"))
    lines = found.lines(None)
    assert lines["reference"] == "Repeats every period. 10 impacts per period, in contact 24 % of the time."
    assert lines["penalty"].startswith("Repeats every period. 3 contacts per period, in contact ")


def test_one_impact():
    found = describe(runs_of("C")).reference
    assert found == ("Repeats every period. 1 impact per period, in contact 0 % of the time.", "")


def test_period_doubling():
    assert describe(runs_of("D")).reference[0].startswith("Repeats every 2 periods. 0.5 impacts per period")


def test_scatter_is_that_of_each_branch_and_not_between_them():
    """Two branches 0.8 apart in ξ₂, each scattered by some hundredths."""
    penalty, _ = describe(runs_of(eta=3.25, K=12000.0, D=18.0, steps=2000)).penalty
    scatter = float(penalty.split("±")[1].split()[0])
    assert penalty.startswith("Nearly repeats every 2 periods (±")
    assert 0 < scatter < 0.1


def test_a_section_that_a_step_may_have_scattered_is_not_judged_by_one_run():
    runs = runs_of(eta=2.76, K=12000.0, D=18.0, steps=1000)
    assert describe(runs).penalty[0].startswith("Repeats every 2 periods, kind not judged. ")
    assert "Repeats every period, blurred by the time step" in explain(runs).kinds["penalty"]


def test_the_cost_is_that_of_an_fe_code():
    runs = runs_of("C")
    cost = dict(row[:2] for row in describe(runs).cost)
    assert cost["FE steps"] == "16.4 million"  # 2,050 periods of 8,000 steps
    for run in (runs.penalty, runs.reference):
        number, unit = cost[f"{'reference' if run.response.method.rigid else 'penalty'} took"].split()
        assert float(number) * {"ms": 1e-3, "s": 1.0}[unit] == pytest.approx(run.response.cost.seconds, rel=0.06)


def test_the_numbers_say_what_each_change_leaves():
    begin = "What is left at best if one number alone is changed: "
    found = explanation_of("9B")
    line = next(line for line in found.details if line.startswith(begin))
    for name, curve in found.alone["curves"].items():
        if curve["best"]["left"] > found.parts["total"] / 2:
            assert "no time step" not in line
            continue
        value = "no time step" if curve["best"]["value"] is None else f"{name} = {curve['best']['value']:g}"
        assert f"{value} {percent(curve['best']['left'])}" in line


DIGITS = [(1.08, 123.4, 50.0), (1.2, 1234.5, 100.3), (2.76, 150.3, 9.0)]


@pytest.mark.parametrize(("units", "eta", "K", "D"), every([(u, *n) for u in ("none", "si", "mm-t-s") for n in DIGITS]))
def test_the_change_that_is_offered_has_the_digits_of_its_sentence(units, eta, K, D):
    setting = Setting(eta=eta, K=K, D=D, units=units, omega1=94.25, m1=2.0, amplitude=0.5)
    found = explanations.explained(setting)
    assert {*found.change} & {"K", "D"}
    for each in words_of_change(found.change, setting).split(", "):
        assert each.partition(" = ")[2] in found.in_units(setting.scale).headline


def test_a_change_is_offered_only_if_the_page_takes_it(monkeypatch):
    setting = Setting(steps=8)
    offer = Verdict("Take more steps.", "no", "steps", {"steps": 10_000_000})
    monkeypatch.setattr(explanation, "verdict", lambda *_, **__: offer)
    found = explain(explanations.runs_of(setting))
    assert found.change == {}
    assert "Not on this page: That is 10,000,000 steps × 2,050 periods" in found.headline
    offer.change.update(steps=20_000, K=120_000.0, D=0.0)
    assert read_setting(explain(explanations.runs_of(setting)).change).K == 120_000


@pytest.mark.parametrize(
    ("change", "words", "fields"),
    [
        ({"status": "located"}, "cutting the step where contact changes", {"located": "yes", "status": "start"}),
        ({"located": True}, "cutting the step where contact changes", {"located": "yes", "status": "start"}),
        ({"status": "start"}, "contact status: start of the step", {"status": "start"}),
        ({"law": "limited"}, "contact law: limited damper", {"law": "limited"}),
        ({"without_solution": "keep"}, "step without a solution: keep status", {"without_solution": "keep"}),
        ({"without_solution": "halve"}, "step without a solution: halve step", {"without_solution": "halve"}),
        (
            {"integrator": "newmark", "beta": 0.25, "gamma": 0.5},
            "integrator: Newmark, β = 0.25, γ = 0.5",
            {"integrator": "newmark", "beta": 0.25, "gamma": 0.5},
        ),
        ({"K": 1.0, "D": 0.5}, "K = 1, D = 0.5", {"K": 1.0, "D": 0.5}),
    ],
)
def test_the_page_takes_every_change_that_the_verdict_can_propose(monkeypatch, change, words, fields):
    setting = Setting(steps=8, integrator="hht", beta=0.4, gamma=0.7, status="end")
    monkeypatch.setattr(explanation, "verdict", lambda *_, **__: Verdict("Change it.", "no", change=change))
    found = explain(explanations.runs_of(setting))
    assert found.headline == "Change it."
    assert words_of_change(found.change, setting) == words
    assert read_setting(found.change, setting) == setting._replace(**fields)


def test_what_finishes_a_run_without_a_solution_is_offered():
    setting = Setting(eta=2.76, K=12000.0, D=18.0, steps=500, status="end")
    found = explanations.explained(setting)
    assert "stopped at step" in found.headline
    assert "Not on this page" not in found.headline
    assert explanations.runs_of(read_setting(found.change, setting)).penalty.response.ok


def test_the_parts_of_the_difference_are_given_where_the_motions_keep_step():
    found = explanation_of("A")
    assert set(found.parts) == {"total", "time_step", "regularisation", "joint_damping"}
    assert found.parts["joint_damping"] > 10 * found.parts["time_step"]
    assert "joint damping" in found.headline


def test_the_curves_of_the_parts_add_up_to_that_of_the_difference():
    shown, series = runs_of("14A"), explanation_of("14A").series
    parts = series["time_step"] + series["regularisation"] + series["joint_damping"]
    np.testing.assert_allclose(parts, series["total"], atol=1e-5)
    columns = present(shown)["displacements"]
    for row, n in enumerate("12"):
        np.testing.assert_allclose(series["total"][row], columns[f"penalty{n}"] - columns[f"reference{n}"], atol=0.05)


def test_an_irregular_motion_is_not_compared_point_by_point():
    assert describe(runs_of(eta=1.7)).reference[0].startswith("Does not repeat")
    explanation = explanation_of(eta=1.7)
    assert "sections" in explanation.measure
    assert explanation.series == {}


def test_a_completely_different_motion_is_called_so_and_what_to_change_is_valid():
    explanation = explanation_of("9B")
    assert explanation.agree == "no"
    assert explanation.change
    assert read_values(explanation.change)["D"] < 50


def test_divergence_names_the_step():
    blown = runs_of(eta=2.76, K=1e5, D=100.0, steps=100)
    assert "step" in describe(blown).penalty[1]
    explanation = explanation_of(eta=2.76, K=1e5, D=100.0, steps=100)
    assert explanation.agree == "unknown"
    assert explanation.parts == {}


@pytest.mark.parametrize("key", every(scenes()))
def test_no_text_of_a_scene_holds_a_number_that_is_none(key):
    lines = paragraphs(describe(runs_of(key)), explanation_of(key)).values()
    assert len(lines) >= 3
    for line in lines:
        assert line.endswith(".")
        assert "nan" not in line
        assert "None" not in line


def test_motions_that_are_drawn_a_period_apart_are_announced():
    """Motions of two periods; the penalty solution begins with the second one."""
    shown = runs_of("D")
    columns = present(shown)["displacements"]
    reference, penalty = (columns[f"{name}2"][:-1] for name in ("reference", "penalty"))
    half = len(reference) // 2
    assert np.std(penalty - reference) > 5 * np.std(np.roll(penalty, half) - reference)
    assert "They are drawn 1 period apart" in explanation_of("D").headline
    assert "drawn" not in explanation_of("C").headline
