"""Whether a recommended setting shows the reference's kind of motion, and what is possible where none is found."""

import pytest
from vibroscope.engine import Newmark, Reference, System, steady
from vibroscope.engine.recommendation.search import of_same_kind
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial
from vibroscope.engine.wording import rounded_up

SYSTEM = System()


def test_a_setting_of_the_same_kind_is_preferred_and_another_kind_is_named():
    """The first two settings repeat after two periods, the reference after one."""
    found = steady(SYSTEM, 2.76, Reference())
    trials = [Trial(NewmarkSetting(12000.0, damping, 8000), 0.01, 0.02, 8000) for damping in (2.0, 2.1, 16.1)]
    best, kind = of_same_kind([found], trials, Newmark(1, 0, 1000), None)
    assert (best, kind) == (trials[2], "")
    best, kind = of_same_kind([found], trials[:2], Newmark(1, 0, 1000), None)
    assert best == trials[0]
    assert "the penalty solution repeats every 2 periods" in kind
    assert kind.endswith("the reference repeats every period")


def test_the_tolerance_that_is_possible_isrounded_up():
    for robust, possible in ((0.0702, 0.071), (0.05, 0.05), (0.0501, 0.051), (1.21, 1.3)):
        assert rounded_up(robust) == pytest.approx(possible)
