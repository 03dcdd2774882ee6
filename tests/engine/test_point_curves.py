"""Curves of points in two parameters: where they meet, where they end, and that each is followed once."""

import numpy as np
import pytest
from vibroscope.engine import (
    BranchQuestion,
    ExactPenalty,
    Point,
    PointCurves,
    Reference,
    System,
    continue_branch,
    continue_point,
    find_branches,
    simulate,
)
from vibroscope.engine.continuation.points import PointProblem
from vibroscope.engine.continuation.tolerances import POINT_DIFFERENCE
from vibroscope.engine.kernels.event_driven.orbit import CLOSING

PAPER, EXACT = System(), ExactPenalty(12_000.0, 18.0)
CLOSE = 1e-8
WIDE = {"low": 1.2, "high": 2.2}
ALONG = {"along": "K", "along_low": 500.0, "along_high": 20_000.0}


def points(eta, method, low, high, kind):
    """The points of a kind of the branch of period one."""
    branch = continue_branch(BranchQuestion(PAPER, eta, method, low=low, high=high, max_period=1))
    return [point for point in branch.points if point.kind == kind]


def met(curve, kind):
    """Where a curve meets points of a kind, (n, 2)."""
    return np.array([place for other, *place in curve.meetings if other == kind])


def test_doublings_and_grazings_meet_in_the_same_points_from_either_curve():
    (first,) = points(1.7, EXACT, 1.66, 1.71, "period doubling")
    (grazing,) = points(1.6, EXACT, 1.565, 1.61, "grazing")
    last = points(1.9, EXACT, 1.79, 1.91, "period doubling")[0]
    on_grazing = met(continue_point(BranchQuestion(PAPER, 1.6, EXACT, **WIDE), grazing, **ALONG), "period doubling")
    for point in (first, last):
        (meeting,) = met(continue_point(BranchQuestion(PAPER, 1.7, EXACT, **WIDE), point, **ALONG), "grazing")
        assert (np.abs(on_grazing / meeting - 1).max(axis=1)).min() < CLOSE


def test_two_folds_meet_in_a_cusp_and_lie_on_one_curve():
    softer = ExactPenalty(5200.0, 18.0)  # close to the cusp, so that the curve is short
    branch = continue_branch(BranchQuestion(PAPER, 1.3, softer, low=1.29, high=1.31, max_period=1))
    folds = [point for point in branch.points if point.kind == "fold"]
    assert len(folds) == 2
    question, reach = BranchQuestion(PAPER, 1.3, softer, **WIDE), ALONG | {"along_low": 4700.0, "along_high": 5300.0}
    together = PointCurves(question, **reach)
    (cusp,) = met(together.follow(folds[0]), "cusp")
    (again,) = met(continue_point(question, folds[1], **reach), "cusp")
    assert np.abs(again / cusp - 1).max() < CLOSE
    assert together.follow(folds[1]) is None


@pytest.mark.parametrize("damping", [8.0, 8.4])
def test_a_fold_of_twice_the_period_ends_at_a_doubling(damping):
    """Where the doubling changes its side: equations of a fold are singular there, and doublings solve them."""
    method, span = ExactPenalty(300.0, damping), {"over": "K", "low": 200.0, "high": 400.0}
    question = BranchQuestion(PAPER, 2.0, method, **span, max_period=2)
    branches = find_branches(question)
    fold = next(point for branch in branches for point in branch.points if point.kind == "fold")
    curve = continue_point(question, fold, along="D", along_low=2.0, along_high=8.5)
    assert curve.ends[0].startswith("period doubling at K = 246.81825")
    ((K, D),) = met(curve, "period doubling")
    single = continue_branch(
        BranchQuestion(PAPER, 2.0, ExactPenalty(K, D), over="K", low=240.0, high=250.0, max_period=1)
    )
    assert min(abs(point.value / K - 1) for point in single.points if point.kind == "period doubling") < CLOSE
    np.testing.assert_allclose(D, 7.66419232, rtol=CLOSE)  # extrapolated from four curves that begin elsewhere


def test_a_curve_reaches_the_border_of_the_range():
    (point,) = points(2.76, Reference(), 2.7, 2.8, "period doubling")
    question = BranchQuestion(PAPER, 2.76, Reference(), low=2.5, high=3.0)
    reach = {"along": "restitution", "along_low": 0.6, "along_high": 1.0}
    with pytest.raises(ValueError, match="begin within the range"):
        PointCurves(question, **reach)
    curve = continue_point(question, point, **reach | {"along_low": 0.6 * PAPER.restitution})
    for end, reason in zip((curve.values[0], curve.values[-1]), curve.ends, strict=True):
        number = {"eta": 0, "restitution": 1}[reason.split()[0]]
        assert reason.endswith("leaves the range")
        limits = [(2.5, 3.0), (0.6 * PAPER.restitution, 1.0)][number]
        assert min(abs(end[number] - limit) for limit in limits) < 1e-12


@pytest.mark.parametrize("ends", [(0.1, 0.9), (0.3, 0.9), (0.1, 0.7), (0.3 - 1.5 * POINT_DIFFERENCE, 0.9)])
def test_a_derivative_at_the_end_of_a_range_is_as_exact_as_within_it(ends):
    class InTwoNumbers(PointProblem):
        scales, condition = np.empty(0), None

        def __init__(self):
            """The two numbers alone, without an orbit."""

        def moved(self, place, step):
            if not (ends[0] <= place + step).all() or not (place + step <= ends[1]).all():
                raise ValueError("out of range")
            return place + step

    problem, place = InTwoNumbers(), np.array([0.3, 0.7])
    found = problem.gradient(lambda there: np.exp(3.0 * there[0]) * np.sin(there[1]), place)
    expected = np.exp(0.9) * np.array([3.0 * np.sin(0.7), np.cos(0.7)])
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    with pytest.raises(ValueError, match="out of its range"):
        problem.gradient(np.sum, np.array([2.0, 2.0]))


def test_a_new_kind_of_point_is_its_condition_alone(monkeypatch):
    """Where the impact has the speed that it has at one orbit of a branch."""
    monkeypatch.setattr(PointProblem, "by_kind", dict(PointProblem.by_kind))
    question = BranchQuestion(PAPER, 2.76, Reference(), low=2.7, high=2.78, max_period=1)
    branch = continue_branch(question)
    eta, (state,) = branch.values[3], branch.sections[3]

    def impact(system, eta, state):
        run = simulate(system, eta, Reference(), periods=1, keep=1, initial=state)
        (time,), (speed,) = run.impacts.time / run.period, run.impacts.closing_speed
        return time, speed

    time, speed = impact(PAPER, eta, state)

    class SameSpeed(PointProblem):
        kinds = ("same speed",)

        def condition(self, place):
            return float(place.evaluation.facts[0, CLOSING] - speed)

    point = Point("same speed", eta, 1, branch.multipliers[3], state, ("impact",), np.array([time]), 3)
    curve = continue_point(question, point, along="restitution", along_low=0.48, along_high=0.52)
    assert len(curve.values) > 5
    for value, restitution in curve.values[:: len(curve.values) // 3]:
        system = PAPER.changed({"restitution": restitution})
        there = continue_branch(BranchQuestion(system, value, Reference(), low=value - 0.001, high=value + 0.001))
        states = dict(zip(there.values, there.sections[:, 0], strict=True))
        assert impact(system, value, states[value])[1] == pytest.approx(speed, rel=1e-9)


def test_grazing_of_the_linear_response_over_two_numbers_is_that_of_closed_form():
    system = System(wall=True, d1=0.05, clearance=1.0, restitution=0.8)
    system = system.changed({"base": 0.0, "force1": 0.5})
    branch = continue_branch(BranchQuestion(system, 1.0, Reference(), over="force1", low=0.01, high=1.0, max_period=1))
    point = next(p for p in branch.points if p.kind == "grazing")
    question = BranchQuestion(system, 1.0, Reference(), over="force1", low=0.001, high=1.0)
    curve = continue_point(question, point, along="eta", along_low=0.1, along_high=1.4)
    force, eta = curve.values.T
    assert np.abs(force - np.hypot(1 - eta**2, 0.1 * eta)).max() < 1e-11
