"""A few long cells are shared out one by one, the longest first, so that no thread is idle beside a queue."""

import threading

import numpy as np
import pytest
from vibroscope.engine import Cells, Newmark, System, cells, run_cells, simulate

from tests.waiting import PATIENCE

STEPS = (60, 100, 80)


@pytest.fixture
def run_few(monkeypatch):
    """Runs cells with located steps, each through the function that takes its method's steps."""

    def run_few(watched, threads):
        def watch(system, eta, method, **options):
            watched(method.steps)
            return simulate(system, eta, method, **options)

        monkeypatch.setattr(cells, "simulate", watch)
        few = Cells(System(), np.full(3, 2.76), Newmark(12000, 18, 60, located=True), steps=STEPS)
        return run_cells(few, transient=3, sample=2, threads=threads)

    return run_few


def test_each_thread_takes_one_at_a_time(run_few):
    both = threading.Barrier(2)
    met = []

    def watched(steps):
        if steps != min(STEPS):  # the third has no partner
            both.wait(PATIENCE)  # raises if no other thread comes
            met.append(steps)

    assert run_few(watched, 2).ok.all()
    assert sorted(met) == [80, 100]


def test_the_longest_comes_first_and_results_keep_their_places(run_few):
    order = []
    found = run_few(order.append, 1)
    assert order == [100, 80, 60]
    for steps, end in zip(STEPS, found.end, strict=True):
        alone = simulate(System(), 2.76, Newmark(12000, 18, steps, located=True), periods=5, keep=2)
        assert end.tolist() == alone.section[-1].tolist()
