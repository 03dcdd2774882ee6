"""The words must say what the numbers say."""

import numpy as np
import pytest
from vibroscope.app.explorer.compute import frame_of
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.explorer.state import Explorer, read
from vibroscope.app.explorer.words import cause, explain, lines, tell
from vibroscope.app.runtime.cache import Cache

KEPT = Cache(48)


def frame(key=None, **numbers):
    explorer = Explorer(**numbers)
    if key:
        explorer.apply(scenes()[key].texts())
    return frame_of(explorer.setting(), cache=KEPT)


def test_chatter_and_permanent_contact():
    words = tell(frame("A"))
    assert words.reference == "One period, 10 impacts per period, in contact 24 % of the time."
    assert words.penalty.startswith("One period, 3 contacts per period, in contact ")


def test_one_impact():
    assert tell(frame("C")).reference == "One period, 1 impact per period, in contact 0 % of the time."


def test_period_doubling():
    assert tell(frame("D")).reference.startswith("Two periods, 0.5 impacts per period")


def test_scatter_is_told_about_the_points_and_not_between_them():
    """Two branches 0.8 apart in ξ₂, each scattered by some hundredths."""
    penalty = tell(frame(eta=3.25, K=12000.0, D=18.0, steps=2000)).penalty
    scatter = float(penalty.split("σ = ")[1].split(")")[0])
    assert penalty.startswith("Nearly two periods")
    assert 0 < scatter < 0.1


def test_the_cost_is_that_of_an_fe_code():
    cost = dict(row[:2] for row in tell(frame("C")).cost)
    assert cost["FE steps"] == "16.4 M"  # 2,050 periods of 8,000 steps
    assert {"penalty run", "reference run"} < cost.keys()


def test_the_numbers_say_that_what_a_change_leaves_is_left():
    told = next(line for line in explain(frame("9B")).details if line.startswith("If one number alone is changed: "))
    changes = told.partition(": ")[2].split("; ")
    assert all(" leaves " in change and change.rstrip(".").endswith("%") for change in changes)


def test_the_parts_of_the_difference_are_given_where_the_motions_keep_step():
    meaning = explain(frame("A"))
    assert set(meaning.parts) == {"total", "time_step", "regularisation", "joint_damping"}
    assert meaning.parts["joint_damping"] > 10 * meaning.parts["time_step"]
    assert "joint damping" in meaning.verdict


def test_the_curves_of_the_parts_add_up_to_that_of_the_difference():
    shown = frame("14A")
    series = explain(shown).series
    parts = series["time_step"] + series["regularisation"] + series["joint_damping"]
    np.testing.assert_allclose(parts, series["total"], atol=1e-5)
    columns = present(shown)["displacements"]
    for row, n in enumerate("12"):
        np.testing.assert_allclose(series["total"][row], columns[f"penalty{n}"] - columns[f"reference{n}"], atol=0.05)


def test_irregular_motion_is_not_compared_point_by_point():
    words = tell(frame("B"))
    assert words.reference.startswith("No period")
    assert explain(frame("B")).parts == {}


def test_a_completely_different_motion_is_called_so_and_what_to_change_is_valid():
    meaning = explain(frame("9B"))
    assert meaning.agree == "no"
    assert meaning.change
    changed = read(meaning.change)
    assert changed["K"] > 100


def test_divergence_names_the_step():
    blown = frame(eta=2.76, K=1e5, D=100.0, steps=100)
    assert "step" in tell(blown).penalty
    meaning = explain(blown)
    assert meaning.agree == "unknown"
    assert meaning.parts == {}


@pytest.mark.parametrize("key", list(scenes()))
def test_no_scene_is_told_with_a_number_that_is_none(key):
    for line in lines(tell(frame(key)), explain(frame(key))).values():
        assert line.endswith(".")
        assert "nan" not in line
        assert "None" not in line


def test_a_motion_that_is_drawn_a_period_apart_is_said_to_be():
    """Two periods, of which the penalty solution came to begin with the other."""
    shown = frame("D")
    columns = present(shown)["displacements"]
    reference, penalty = (columns[f"{name}2"][:-1] for name in ("reference", "penalty"))
    half = len(reference) // 2
    assert np.std(penalty - reference) > 5 * np.std(np.roll(penalty, half) - reference)
    assert "They are drawn one period apart" in explain(shown).verdict
    assert "apart" not in explain(frame("C")).verdict


def test_of_a_fault_only_the_engines_own_words_are_told():
    assert cause(ValueError("K must be at most 1e9")) == "K must be at most 1e9"
    assert "/" not in cause(OSError(13, "Permission denied", "/home/somebody/.cache"))
