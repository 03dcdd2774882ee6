"""Recommended settings checked by independent runs."""

import math
import threading

import numpy as np
import pytest
from vibroscope.engine import (
    Cancelled,
    ExactPenalty,
    Newmark,
    Record,
    Reference,
    System,
    design_curve,
    recommend,
    simulate,
)
from vibroscope.engine.contact import damping_for, damping_ratio, stiffness_for
from vibroscope.engine.drivers.newmark import SkippedSamples
from vibroscope.engine.law_table import ratio_of_restitution
from vibroscope.engine.recommendation import reasons

from tests.recommended import question
from tests.share import every

SYSTEM = System()


def error_of(eta, stiffness, damping, steps, located=False):
    """Rms over 50 periods from the paper's reference, both from rest with every step computed; without Target."""
    record = Record(50, 500, steps)
    method = Newmark(stiffness, damping, steps, every_step=not located, located=located)
    run = simulate(SYSTEM, eta, method, record=record)
    reference = simulate(SYSTEM, eta, Reference(), record=record).trajectory.displacement
    return np.sqrt(np.mean((run.trajectory.displacement - reference) ** 2) / np.mean(reference**2))


@pytest.mark.parametrize(("eta", "paper"), every([(1.08, (2500, 8, 2000)), (2.76, (12000, 18, 8000))]))
def test_the_recommendation_needs_fewer_steps_than_the_paper_for_less_error(eta, paper):
    K, D, n = paper
    papers_error = max(error_of(eta, K, D, steps) for steps in (n, n + n // 80, n - n // 80))  # of neighbours, too
    found = recommend(question(SYSTEM, eta, tolerance=papers_error, steps_max=paper[2]))
    error = error_of(eta, *found.best.setting)
    assert found.met
    assert not found.reason
    assert found.best.setting.steps < paper[2]
    assert error < papers_error
    assert error <= found.best.robust  # not best.error: rounding changes the scatter of a constant step
    check_front(found)


def check_front(found):
    """Along the front cost and n rise, both errors fall, and the best setting is the first within the tolerance."""
    columns = [(trial.cost, trial.setting.steps, -trial.error, -trial.robust) for trial in found.front]
    assert len(columns) > 1
    assert (np.diff(columns, axis=0) > 0).all()
    assert found.best in found.front
    error = (lambda trial: trial.error) if found.met else (lambda trial: trial.robust)
    within = [trial for trial in found.front if error(trial) <= found.tolerance]
    assert (within[:1] == [found.best]) if found.met else not within
    assert all(trial.error <= trial.robust for trial in found.front)


def test_located_steps_need_fewer_than_a_hundred_solves():
    found = recommend(question(SYSTEM, 2.76, tolerance=0.03, located=True))
    assert found.met
    assert found.method.located
    assert error_of(2.76, *found.best.setting, located=True) <= 0.03
    run = simulate(SYSTEM, 2.76, found.method)
    assert found.best.cost == pytest.approx(run.cost.steps / 2050, rel=1e-12)
    assert found.best.setting.steps < found.best.cost < 100
    check_front(found)


@pytest.mark.parametrize("eta", every([2.76, 1.08]))
def test_the_error_that_located_steps_leave_does_not_grow_where_more_of_them_are_allowed(eta):
    left = []
    for steps_max in sorted((8, *every((32, 12, 16, 24, 64)))):
        found = recommend(question(SYSTEM, eta, located=True, steps_max=steps_max))
        assert found.best.setting.steps <= steps_max
        left.append(max(found.best.robust, found.tolerance))
    assert left == sorted(left, reverse=True)
    assert left[-1] < 0.08 < left[0]


def test_the_joint_damping_is_the_reason_if_it_alone_exceeds_the_tolerance():
    options = {"tolerance": 0.05, "steps_max": 64, "restitution_tolerance": None, "force_tolerance": None}
    found = recommend(question(SYSTEM, 1.08, **options))
    runs = [simulate(SYSTEM, 1.08, Reference(kind), record=Record(1)) for kind in ("derived", "table")]
    one, other = (run.trajectory.displacement for run in runs)
    assert found.joint_damping == pytest.approx(np.sqrt(np.mean((one - other) ** 2) / np.mean(other**2)), rel=0.01)
    assert not found.met
    assert "joint damping alone" in found.reason
    assert found.best.error > 0.05
    check_front(found)
    # against a reference without that part the same tolerance is met
    assert recommend(question(SYSTEM, 1.08, reference=Reference("derived"), **options)).met


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"tolerance": 0.02, "steps_max": 128}, "time step is to blame"),
        ({"tolerance": 0.02, "stiffness_max": 300.0, "steps_max": 256}, "K is to blame"),
    ],
)
def test_the_limit_that_is_to_blame_is_the_reason(options, word):
    found = recommend(question(SYSTEM, 2.76, **options))
    assert not found.met
    assert word in found.reason
    assert found.best.setting.steps <= options["steps_max"]
    assert max(t.setting.stiffness for t in found.front) <= options.get("stiffness_max", 1e6)


@pytest.mark.release  # half a minute: between two stops no step is skipped
def test_the_dampers_of_two_stops_are_the_reason_where_one_cannot_serve_both():
    stops = System(wall=True, d1=0.02, clearance=1.0, clearance2=1.0, restitution=0.5, restitution2=0.8)
    found = recommend(question(stops, 2.0, stiffness_max=3000.0, steps_max=200, tolerance=0.1))
    assert not found.met
    assert found.reason.startswith("the dampers of the stops are to blame: the stops ask for restitutions of 0.5 and")


def test_a_contact_that_is_held_is_blamed_where_it_is_too_soft_after_one_run_without_a_time_step(monkeypatch):
    runs = []
    monkeypatch.setattr(reasons, "simulate", lambda *problem, **how: runs.append(problem) or simulate(*problem, **how))
    found = recommend(question(SYSTEM, 2.76, tolerance=0.02, steps_max=256, stiffness=300.0, damping=4.0))
    assert (found.met, found.best.setting[:2]) == (False, (300.0, 4.0))
    assert "K = 300 and D = 4, which is held, is to blame" in found.reason
    assert [method for *_, method in runs] == [ExactPenalty(300.0, 4.0)]


def test_a_chaotic_reference_gives_no_recommendation():
    found = recommend(question(SYSTEM, 1.70))
    assert (found.met, found.best, found.front, found.method) == (False, None, (), None)
    assert "does not repeat itself" in found.reason
    assert "compare statistics" in found.reason


def test_a_search_is_repeatable_and_reports_progress():
    reported, fronts = [], []
    options = {"tolerance": 0.5, "steps_max": 128, "stiffness": 200.0, "located": True}
    heard = {"progress": reported.append, "partial": lambda front, _: fronts.append(front)}
    once = recommend(question(SYSTEM, 3.25, **options), **heard)
    assert once.met
    first = next(front for front in fronts if front)
    assert (len(first), len(fronts)) == (1, len(reported) - 1)
    within = [trial for front in fronts for trial in front if trial.meets(0.5)]
    assert min(trial.cost for trial in within) <= once.best.cost  # which is verified with half the step, too
    assert recommend(question(SYSTEM, 3.25, **options)) == once
    beside = recommend(question(SYSTEM, 3.25 * (1 + 1e-12), **options))
    assert (beside.best.setting, beside.ranges) == (once.best.setting, once.ranges)
    assert beside.eta == 3.25 * (1 + 1e-12)
    assert reported == sorted(reported)
    assert 0 < reported[0] < reported[-1] == 1


def test_a_search_that_is_cancelled_ends_no_run_that_begins_later(monkeypatch):
    """Those under way may come to their end, one in each thread."""
    run, stop, begun, ended = SkippedSamples.run, threading.Event(), [], []

    def counted(*question, **more):
        late = stop.is_set()
        begun.append(late)
        if len(begun) == 100:
            stop.set()
        found = run(*question, **more)
        ended.append((late, stop.is_set()))
        return found

    monkeypatch.setattr(SkippedSamples, "run", counted)
    with pytest.raises(Cancelled):
        recommend(question(SYSTEM, 2.76, tolerance=0.001), threads=2, cancelled=stop.is_set)
    assert ended.count((True, True)) == 0
    assert ended.count((False, True)) <= 2
    assert len(ended) >= 90


def test_a_design_curve_is_a_recommendation_for_each_eta():
    reported = []
    options = {"tolerance": 0.5, "steps_max": 16}
    curve = design_curve(question(SYSTEM, 3.2, **options), [3.2, 3.25], progress=reported.append)
    assert [one.eta for one in curve] == [3.2, 3.25]
    assert curve[1] == recommend(question(SYSTEM, 3.25, **options))
    assert reported == sorted(reported)
    assert reported[-1] == 1


def test_the_contact_formulas_hold_for_a_free_contact():
    """Restitution and duration of a stiff contact of the exact penalty solution."""
    stiffness = 1e6
    damping = damping_for(SYSTEM, stiffness, ratio_of_restitution(SYSTEM.restitution))
    assert damping_ratio(SYSTEM, stiffness, damping) == pytest.approx(ratio_of_restitution(0.5), rel=1e-12)
    run = simulate(SYSTEM, 2.76, ExactPenalty(stiffness, damping))
    impacts, contact = run.impacts, run.contacts[-1]
    restitution = impacts.velocity_after[-1] @ [-1, 1] / impacts.closing_speed[-1]
    assert restitution == pytest.approx(0.5, abs=0.05)  # springs and excitation act during the contact, too
    steps = 10_000
    contact_steps = (contact[1] - contact[0]) * 2.76 / (2 * math.pi) * steps
    assert stiffness_for(SYSTEM, 2.76, steps, contact_steps) == pytest.approx(stiffness, rel=0.1)
    assert (ratio_of_restitution(0.0), ratio_of_restitution(1.0)) == (1.0, 0.0)
