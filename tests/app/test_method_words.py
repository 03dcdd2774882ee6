"""The head of a report says in words what was run, every number of it."""

import pytest
from vibroscope.app.explorer.method_words import full_words
from vibroscope.engine import HHT, ExactPenalty, Newmark, Reference, TimeStepping

HEADS = {
    Reference("derived", 0.01): "reference; joint damping that of both dampers; threshold 0.01",
    ExactPenalty(
        700, None, "flores"
    ): "exact penalty; contact law flores (exponent 1.5); K = 700, D from the restitution",
    Newmark(12000, 18, 2000, located=True): (
        "newmark (beta 0.25, gamma 0.5); steps cut where contact changes; contact law kelvin-voigt; K = 12000, D = 18, "
        "2000 steps a period"
    ),
    TimeStepping(700, 3, 90, HHT(-0.1), "end", law="impact", penetration=0.02, every_step=True): (
        "hht (alpha -0.1); contact status iterated to the end of the step; contact law impact (exponent 1.5, "
        "penetration 0.02); K = 700, D = 3, 90 steps a period; every step taken"
    ),
}


@pytest.mark.parametrize(("method", "words"), HEADS.items())
def test_a_method_is_said_with_its_numbers(method, words):
    assert full_words(method) == words


def test_a_wall_has_no_joint_damping():
    assert full_words(Reference(), wall=True) == "reference; threshold 0.002"
