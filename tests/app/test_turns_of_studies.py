"""Every study gives way: the first result of another session comes while its first slice is being computed."""

import threading
from types import SimpleNamespace

import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime import logs, workers
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import Workers
from vibroscope.app.studies import study_job
from vibroscope.app.studies.basin import BasinQuestion, grow_basin
from vibroscope.app.studies.bifurcation import DiagramQuestion, grow_diagram
from vibroscope.app.studies.branches import BranchesQuestion, grow_branches
from vibroscope.app.studies.coexisting import CoexistingQuestion, search_coexisting
from vibroscope.app.studies.plane import PlaneQuestion, grow_plane
from vibroscope.app.studies.plane_curves import CurvesQuestion, grow_curves
from vibroscope.app.studies.speed import SpeedQuestion, grow_speed
from vibroscope.app.studies.time_step import StepQuestion, grow_step
from vibroscope.app.studies.your_code import CodeQuestion, grow_code
from vibroscope.engine import Newmark, Reference, System

from tests.waiting import PATIENCE

SYSTEM, ETA, PENALTY = System(), 2.7613, Newmark(12_345.0, 18.0, 2000)  # of which no other test has runs in a cache
STUDIES = {
    "basin": (
        grow_basin,
        BasinQuestion(SYSTEM, ETA, Reference(), PENALTY, ("xi2", "v2"), (-4.0, 4.0), (-9.0, 9.0), (0.0,) * 4),
    ),
    "branches": (grow_branches, BranchesQuestion(SYSTEM, Reference(), (1.3, 1.5))),
    "code": (grow_code, CodeQuestion(Setting(eta=ETA, K=12_345.0, D=18.0))),
    "coexisting": (search_coexisting, CoexistingQuestion(SYSTEM, ETA, Reference(), PENALTY)),
    "curves": (grow_curves, CurvesQuestion(SYSTEM, 2.78, (6000.0, 30_000.0), (15.0, 22.0))),
    "diagram": (grow_diagram, DiagramQuestion(SYSTEM, Reference(), "rest", (2.7, 2.9))),
    "plane": (grow_plane, PlaneQuestion(SYSTEM, ETA, 2000, False, False, (10.0, 1e5), (0.1, 100.0))),
    "speed": (grow_speed, SpeedQuestion(SYSTEM, ETA, PENALTY, Reference())),
    "step": (grow_step, StepQuestion(SYSTEM, ETA, PENALTY)),
}


@pytest.fixture
def two(monkeypatch):
    """One thread for two sessions, and a clock that shows a quarter of a second more at each look."""
    clock = iter(range(10**9))
    monkeypatch.setattr(workers.time, "monotonic", lambda: 0.25 * next(clock))
    with Workers("test", 1) as pool:
        monkeypatch.setattr(study_job, "study_threads", lambda: pool)
        yield SimpleNamespace(order=[], done=threading.Event(), pool=pool)


def ask_beside(two, job):
    """Let another session ask while ``job()`` is computed; its first result is delivered, and the job cancelled."""

    def at_once(question, last, cancelled):
        yield SimpleNamespace(share=1.0)

    def deliver(*_):
        two.order.append("short")
        job().cancel()
        two.done.set()

    with logs.in_session("visitor"):
        study_job.StudyJob("short", at_once, deliver, Cache(4))


@pytest.mark.parametrize("name", STUDIES)
def test_the_first_result_of_another_session_comes_while_a_study_is_computed(name, two):
    grow, question = STUDIES[name]
    jobs, asked = [], []

    def watched(question, last, cancelled):
        def poll():
            if not asked:
                asked.append(True)
                ask_beside(two, lambda: jobs[0])
            return cancelled()

        yield from grow(question, last, poll)

    begin = threading.Event()
    two.pool.submit(begin.wait, PATIENCE)
    with logs.in_session("long"):
        jobs.append(study_job.StudyJob(question, watched, lambda *_: two.order.append("long"), Cache(4)))
    begin.set()
    assert two.done.wait(PATIENCE)
    two.pool.shutdown()
    assert two.order == ["short"]
