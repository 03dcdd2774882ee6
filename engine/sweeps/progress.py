"""How far a study is."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Progress:
    """The argument of a study's ``progress`` callable.

    Attributes
    ----------
    done, total : int
        Cells; refinement raises the total.
    computed, reused, failed : int
        Of those done: computed by this run, found in the store, ended early (with their status in the result).
    seconds : float
        Since the study began.
    """

    done: int
    total: int
    computed: int
    reused: int
    failed: int
    seconds: float

    @property
    def rate(self) -> float:
        """Cells computed a second."""
        return self.computed / self.seconds if self.seconds > 0 else 0.0

    @property
    def seconds_left(self) -> float:
        """The seconds left at this rate; inf before the first cell."""
        return (self.total - self.done) / self.rate if self.rate else float("inf")


ProgressCallback = Callable[[Progress], None]


class ProgressCounter:
    """Counts the cells of a study and calls the callback, from before the first batch to the last cell."""

    def __init__(self, callback: ProgressCallback | None = None) -> None:
        self._callback = callback
        self._begun = time.perf_counter()
        self.total = self.computed = self.reused = self.failed = 0

    def now(self, in_hand: int = 0) -> Progress:
        """The progress, with so many cells done of the batch that is being computed."""
        computed, seconds = self.computed + in_hand, time.perf_counter() - self._begun
        return Progress(computed + self.reused, self.total, computed, self.reused, self.failed, seconds)

    def add(self, status: np.ndarray, *, reused: bool) -> None:
        """Count a batch whose cells have these statuses."""
        if reused:
            self.reused += status.size
        else:
            self.computed += status.size
        self.failed += int(np.count_nonzero(status))
        self.report()

    def report(self, in_hand: int = 0) -> None:
        """Call the callback."""
        if self._callback is not None:
            self._callback(self.now(in_hand))
