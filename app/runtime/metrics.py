"""Counts and durations of this process, in Prometheus's text format; a handful, so no library for it.

A histogram has cumulative buckets, ``le`` the upper bound of each (Prometheus exposition format 0.0.4).
"""

from __future__ import annotations

import threading
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping

_BOUNDS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
_lock = threading.Lock()


class Count:
    """A number that only grows, told apart by one label."""

    def __init__(self, name: str, doc: str, label: str) -> None:
        self.name, self.doc, self.label = name, doc, label
        self._counts: Counter[str] = Counter()
        _ALL.append(self)

    def add(self, value: str) -> None:
        """One more of this kind; ``value`` is one of few words, never text from outside."""
        with _lock:
            self._counts[value] += 1

    def total(self) -> int:
        """Of all kinds."""
        return self._counts.total()

    def lines(self) -> list[str]:
        """As Prometheus reads it."""
        with _lock:
            counts = sorted(self._counts.items())
        return [*_head(self, "counter"), *(f'{self.name}{{{self.label}="{value}"}} {n}' for value, n in counts)]


class Durations:
    """Seconds that something took."""

    def __init__(self, name: str, doc: str) -> None:
        self.name, self.doc = name, doc
        self._counts = [0] * (len(_BOUNDS) + 1)
        self._sum = 0.0
        _ALL.append(self)

    def add(self, seconds: float) -> None:
        """One more."""
        with _lock:
            self._counts[bisect_left(_BOUNDS, seconds)] += 1
            self._sum += seconds

    def lines(self) -> list[str]:
        """As Prometheus reads it."""
        with _lock:
            counts, total = list(self._counts), self._sum
        lines, below = _head(self, "histogram"), 0
        for bound, count in zip((*_BOUNDS, "+Inf"), counts, strict=True):
            below += count
            lines.append(f'{self.name}_bucket{{le="{bound}"}} {below}')
        return [*lines, f"{self.name}_sum {total:.6f}", f"{self.name}_count {below}"]


class Gauge:
    """A number as it is when asked for; with a label, one for each of its values."""

    def __init__(self, name: str, doc: str, label: str = "") -> None:
        self.name, self.doc, self._label = name, doc, label
        self.read: Callable[[], Mapping[str, float] | float] = lambda: {} if label else 0
        _ALL.append(self)

    def lines(self) -> list[str]:
        """As Prometheus reads it."""
        found = self.read()
        numbers = {f'{{{self._label}="{value}"}}': n for value, n in found.items()} if self._label else {"": found}
        return [*_head(self, "gauge"), *(f"{self.name}{which} {n:g}" for which, n in numbers.items())]


_ALL: list[Count | Durations | Gauge] = []


def _head(metric: Count | Durations | Gauge, kind: str) -> list[str]:
    return [f"# HELP {metric.name} {metric.doc}", f"# TYPE {metric.name} {kind}"]


REQUESTS = Count("vibroscope_requests_total", "HTTP requests answered", "status")
REFUSED = Count("vibroscope_refused_total", "What was not taken: values, messages, sessions, connections", "what")
OPENED = Count("vibroscope_sessions_total", "Sessions opened and closed", "what")
SESSIONS = Gauge("vibroscope_sessions", "Sessions held now")
QUEUE = Gauge("vibroscope_queue", "Jobs that wait for a thread or run in one: figures, studies, searches", "pool")
WAITED = Durations("vibroscope_wait_seconds", "From asking for a job to its begin")
SOLVED = Durations("vibroscope_solve_seconds", "What both solvers took for one setting, kept results included")
EXPLAINED = Durations("vibroscope_explain_seconds", "What explaining one difference took, kept ones included")
BUILT = Durations("vibroscope_open_seconds", "What opening a session took")


def exposition() -> str:
    """Everything, as text."""
    return "\n".join(line for metric in _ALL for line in metric.lines()) + "\n"
