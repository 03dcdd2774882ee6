"""One setting for a range of η, checked at each η by a comparison of its own."""

import math

import pytest
from vibroscope.engine import (
    ExactPenalty,
    Record,
    Reference,
    System,
    percent,
    recommend,
    simulate,
    steps_at,
)
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.parts import PART_NAMES
from vibroscope.engine.recommendation.trials import NewmarkSetting, RangeTrials, Trial

from tests.answers import compared
from tests.recommended import question

SYSTEM = System()
QUICK = {"tolerance": 0.5, "steps_max": 1024, "restitution_tolerance": None, "force_tolerance": None}


FRONTS = []  # so far, with the η at which their steps count


@pytest.fixture(scope="module")
def found():
    FRONTS.clear()
    return recommend(question(SYSTEM, [2.7, 2.76], **QUICK), partial=lambda *so_far: FRONTS.append(so_far))


def test_a_comparison_finds_the_tolerance_met_at_every_eta_of_the_range(found):
    assert found.met
    assert not found.reason
    assert [served.eta for served in found.served] == pytest.approx([2.7, 2.73, 2.76])  # and between those asked for
    for served in found.served:
        difference = compared(SYSTEM, served.eta, found.method_at(served.eta)).difference
        assert difference.total <= found.tolerance
        assert difference.total == pytest.approx(served.error, rel=0.25)  # rounding changes the scatter of a step
        assert served.error <= served.robust <= found.best.robust


def test_the_time_step_is_one_and_the_same(found):
    for served in found.served:
        step = 2 * math.pi / (served.eta * served.steps)
        assert step <= found.time_step * (1 + 1e-12)
        assert step > found.time_step * (1 - 1 / served.steps)
    assert found.best.cost == found.best.setting.steps


def test_the_limit_names_the_worst_eta_and_its_largest_part(found):
    worst = max(found.served, key=lambda served: served.robust)
    difference = compared(SYSTEM, worst.eta, found.method_at(worst.eta), reference=Reference()).difference
    assert found.limit.startswith(
        f"the range is limited at eta = {worst.eta:g}: an error of {percent(worst.error, 0.2)}"
    )
    if difference.parts:
        part = f"by {PART_NAMES[difference.largest]} ({percent(difference.parts[difference.largest])})"
        assert part in found.limit
    else:  # the steps scatter the motion
        exact = simulate(SYSTEM, worst.eta, ExactPenalty(*found.best.setting[:2]), record=Record(50, 500))
        left = Target.find(SYSTEM, worst.eta).error(exact)
        name = "time step" if left < worst.error / 2 else "K and D"
        assert f"most of it by {name}: {percent(left)} are left" in found.limit


def test_an_error_has_no_parts_where_the_motion_without_a_time_step_is_another_one():
    """An analyst's bodies of 2 kg and 1.2 kg, 15 and 32 Hz, at 26.25 and 30 Hz."""
    system = System.from_mass_ratio(0.6, kappa=32 / 15, d1=0.01, d2=0.01, restitution=0.7)
    held = {"stiffness": 2260.0, "damping": 3.29}
    found = recommend(question(system, [1.75, 2.0], tolerance=0.08, reference=Reference("derived"), **held))
    worst = max(found.served, key=lambda served: served.robust)
    assert "the largest part" not in found.limit
    assert "most of it" not in found.limit
    error, robust = (percent(value, 0.08) for value in (worst.error, worst.robust))
    assert f"an error of {error} there, {robust} with half the step or numbers nearby" in found.limit
    exact = simulate(system, worst.eta, ExactPenalty(*held.values()), record=Record(50, 500))
    left = Target.find(system, worst.eta, Reference("derived")).error(exact)
    assert left > 5 * worst.error
    assert found.limit.endswith(f"without a time step the motion is another one, {percent(left)} off")


def test_a_range_needs_at_least_as_many_steps_as_its_worst_eta(found):
    worst = max(found.served, key=lambda served: served.robust).eta
    alone = recommend(question(SYSTEM, worst, **QUICK)).best.setting.steps * worst / found.eta
    assert found.best.setting.steps > 0.8 * alone  # the search finds n to some per cent


def test_what_is_found_so_far_is_given_from_the_first_number_of_steps_on(found):
    fronts, etas = zip(*FRONTS, strict=True)
    assert set(etas) == {found.eta}
    assert len(fronts[0]) == 1
    assert len(fronts) >= 8
    assert found.best.setting.steps >= min(one.setting.steps for one in fronts[-1] if one.robust <= found.tolerance)


def test_what_is_held_is_kept():
    found = recommend(question(SYSTEM, [2.7, 2.76], **QUICK, stiffness=333.3, damping=None))
    assert found.best.setting.stiffness == 333.3
    assert {trial.setting.stiffness for trial in found.front} == {333.3}


def test_a_range_that_is_not_met_says_where_it_is_and_why_not():
    found = recommend(question(SYSTEM, [1.08, 2.76], tolerance=0.05, located=True, steps_max=32))
    assert not found.met
    assert "at eta = 1.08 the joint damping alone makes an error of 7.7 %" in found.reason
    worst = found.served[0]
    error, robust = (percent(value, 0.05) for value in (worst.error, worst.robust))  # the former by errors that cancel
    assert f"limited at eta = 1.08: an error of {error} there, {robust} with half the step" in found.limit
    assert [served.eta for served in found.served] == [1.08, 2.76]
    assert 0.05 < found.possible <= 0.077  # 12 steps at eta = 2.76 leave hardly more than the joint damping does


def test_eta_without_a_periodic_reference_are_left_out():
    found = recommend(question(SYSTEM, [1.70, 1.705], **QUICK))
    assert (found.met, found.best, found.served, found.left_out) == (False, None, (), (1.70, 1.705))
    assert math.isnan(found.time_step)
    assert "repeats itself nowhere from eta = 1.7 to eta = 1.705" in found.reason


@pytest.mark.parametrize(
    ("etas", "words"),
    [([], "0 different eta"), ([2.7, -1], "eta = -1"), ([1 + i / 99 for i in range(51)], "51 different")],
)
def test_a_range_has_valid_eta(etas, words):
    with pytest.raises(ValueError, match=words):
        recommend(question(SYSTEM, etas))


class Part:
    """Trials at one η that find an error of 1/n, times a factor."""

    located = False

    def __init__(self, eta, factor):
        self.eta, self.factor, self.tried = eta, factor, []

    def screen(self, setting, neighbours, bound):
        self.tried.append(setting.steps)
        error = self.factor / setting.steps
        return Trial(setting, error, error, setting.steps)


def test_the_worst_eta_counts_and_is_tried_first_once_it_has_failed():
    easy, hard = Part(2.0, 1.0), Part(4.0, 3.0)
    pool = type("Pool", (), {"map": staticmethod(map)})
    trials = RangeTrials([easy, hard, Part(3.0, 0.5)], pool)
    setting = NewmarkSetting(1e3, 5.0, 100)
    assert trials.screen([setting]) == [Trial(setting, 0.03, 0.03, 100.0)]
    assert (easy.tried, hard.tried) == ([200], [100])
    assert trials.screen([setting], 1, 0.02)[0].robust == math.inf
    easy.tried.clear()
    assert trials.screen([setting], 1, 0.02)[0].robust == math.inf
    assert easy.tried == []


def test_steps_of_a_time_step_at_another_eta_are_rounded_up():
    assert [steps_at(eta, 3.0, 100) for eta in (3.0, 2.0, 1.0, 0.7)] == [100, 150, 300, 429]
