"""The threads that share cells out wait while their caller is asked whether it was cancelled."""

import threading

import numpy as np
from vibroscope.engine.drivers.threads import GRAIN, share_out

from tests.waiting import PATIENCE

THREADS = 2


def test_threads_take_no_more_cells_while_the_caller_lets_others_run():
    begun, go, third = threading.Barrier(THREADS + 1), threading.Event(), threading.Event()
    ran, looks, taken_meanwhile = [], [], []

    def run(places, signals, slot):
        ran.append(places)
        if len(ran) > THREADS:
            third.set()
        elif not go.is_set():
            begun.wait(PATIENCE)
            go.wait(PATIENCE)
        signals[slot] += places[1] - places[0]

    def cancelled():
        looks.append(None)
        if len(looks) == 2:  # the first is before the threads
            begun.wait(PATIENCE)
            go.set()
            taken_meanwhile.append(third.wait(0.2))
        return False

    ends = np.arange(GRAIN, 20 * GRAIN + 1, GRAIN)
    share_out(ends, lambda: run, threads=THREADS, cancelled=cancelled)
    assert taken_meanwhile == [False]
    assert sorted(ran) == [(end - GRAIN, end) for end in ends.tolist()]
