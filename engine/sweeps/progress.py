"""How far a study is."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Progress:
    """Told to the ``progress`` callable of a study.

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
        """At this rate; inf before the first cell."""
        return (self.total - self.done) / self.rate if self.rate else float("inf")


Hook = Callable[[Progress], None]


class Tally:
    """Counts cells as they come, and tells."""

    def __init__(self, hook: Hook | None = None):
        self._hook = hook
        self._begun = time.perf_counter()
        self.total = self.computed = self.reused = self.failed = 0

    @property
    def seconds(self) -> float:
        """Since the study began."""
        return time.perf_counter() - self._begun

    def add(self, status: np.ndarray, *, reused: bool) -> None:
        """A chunk with cells of such status is done."""
        if reused:
            self.reused += status.size
        else:
            self.computed += status.size
        self.failed += int(np.count_nonzero(status))
        self.tell()

    def tell(self, in_hand: int = 0) -> None:
        """Tell, with so many cells of the chunk in hand."""
        if self._hook is not None:
            computed = self.computed + in_hand
            self._hook(Progress(computed + self.reused, self.total, computed, self.reused, self.failed, self.seconds))
