"""The words must say what the numbers say."""

import pytest

from app.compute import RunCache, frame_of
from app.scenes import scenes
from app.state import Explorer
from app.words import tell

KEPT = RunCache()


def told(key=None, **numbers):
    if key:
        scene = scenes()[key]
        numbers = {"eta": scene.eta, "K": scene.K, "D": scene.D, "steps": scene.steps}
    return tell(frame_of(Explorer(**numbers).setting(), cache=KEPT))


def test_chatter_and_permanent_contact():
    words = told("A")
    assert words.reference == "One period, 10 impacts per period, in contact 24 % of the time."
    assert words.penalty.startswith("One period, 3 contacts per period, in contact ")


def test_one_impact():
    words = told("C")
    assert words.reference == "One period, 1 impact per period, in contact 0 % of the time."
    assert words.agree in ("yes", "partly")


def test_period_doubling():
    assert told("D").reference.startswith("Two periods, 0.5 impacts per period")


def test_scatter_is_told_about_the_points_and_not_between_them():
    """Two branches 0.8 apart in ξ₂, each scattered by some hundredths."""
    penalty = told(eta=3.25, K=12000.0, D=18.0, steps=2000).penalty
    scatter = float(penalty.split("σ = ")[1].split(")")[0])
    assert penalty.startswith("Nearly two periods")
    assert 0 < scatter < 0.1


def test_irregular_motion_is_not_compared_point_by_point():
    words = told("B")
    assert words.reference.startswith("No period")
    assert "point by point" in words.verdict or "differ" in words.verdict


def test_a_completely_different_motion_is_called_so():
    words = told("9B")
    assert words.agree == "no"
    assert words.verdict.startswith("They disagree")


def test_divergence_names_the_step_and_the_way_out():
    words = told(eta=2.76, K=1e5, D=100.0, steps=100)
    assert "step" in words.penalty
    assert "more steps" in words.verdict
    assert words.agree == "unknown"


@pytest.mark.parametrize("key", list(scenes()))
def test_no_scene_is_told_with_a_number_that_is_none(key):
    words = told(key)
    for line in (words.reference, words.penalty, words.verdict):
        assert line.endswith(".")
        assert "nan" not in line
        assert "None" not in line
