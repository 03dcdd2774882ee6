"""Distribution of cells to threads, watched and cancelled from the calling thread.

Threads take the next few cells from one iterator as they become free, so that a hard cell delays no other.
"""

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np
from vibroscope.engine.arguments import Poll, whole
from vibroscope.engine.result import Cancelled

GRAIN = 4  # cells that a thread takes at a time, at least, unless they are few; chains stay together
MOST_THREADS = 1024
POLL = 0.02  # seconds between two looks at how far the threads are

Worker = Callable[[tuple[int, int], np.ndarray, int], None]


def thread_count(threads: int | None) -> int:
    """Number of threads to use, one for each core or fewer; raises ValueError if it is out of range."""
    cores = os.cpu_count() or 1
    return min(whole("threads", cores if threads is None else threads, 1, MOST_THREADS, "give one a core"), cores)


def share_out(
    ends: np.ndarray,
    worker: Callable[[], Worker],
    *,
    threads: int,
    progress: Callable[[int], None] | None = None,
    cancelled: Poll | None = None,
    grain: int = GRAIN,
) -> None:
    """Run the places 0 … ends[−1] of an order.

    Parameters
    ----------
    ends : (n,) ndarray of int
        After which places the order may be cut.
    worker : callable
        Called once in each thread, gives the function that runs some places. It is called with the first place and the
        one after the last; an array whose first entry, once it is set, cancels the work; and the index of the entry
        that it is to raise by 1 for each place that it has done.
    threads : int
        At most; no more are begun than there are parts of the order.
    progress, cancelled
        As in :func:`engine.run_cells`. While ``cancelled`` takes its time, the threads end what they have and take no
        more.
    grain : int, optional
        Places that a thread takes at a time, at least.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    if cancelled is not None and cancelled():
        raise Cancelled
    parts = list(_grains(ends, grain))
    threads = max(1, min(threads, len(parts)))
    signals = np.zeros(1 + threads, dtype=np.int64)
    grains, lock = iter(parts), threading.Lock()

    def work(slot: int) -> None:
        run = worker()
        while signals[0] == 0:
            with lock:
                places = next(grains, None)
            if places is None:
                return
            run(places, signals, slot)

    with ThreadPoolExecutor(threads) as pool:
        running = [pool.submit(work, 1 + k) for k in range(threads)]
        try:
            reported = 0
            while wait(running, POLL).not_done:
                with lock:
                    if cancelled is not None and cancelled():
                        raise Cancelled
                done = int(signals[1:].sum())
                if progress is not None and done > reported:
                    reported = done
                    progress(done)
        finally:
            signals[0] = 1
    for thread in running:
        thread.result()
    if progress is not None:
        progress(int(signals[1:].sum()))


def _grains(ends: np.ndarray, grain: int) -> Iterator[tuple[int, int]]:
    begin = 0
    for end in ends.tolist():
        if end - begin >= grain or end == ends[-1]:
            yield begin, end
            begin = end
