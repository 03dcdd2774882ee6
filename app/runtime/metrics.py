"""Counters, gauges and durations of this process in Prometheus's text format.

A histogram has cumulative buckets, ``le`` is the upper bound of each (Prometheus exposition format 0.0.4). The few
metrics here need no client library.
"""

import threading
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping

_BOUNDS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
_lock = threading.Lock()


class Count:
    """A counter with one label."""

    def __init__(self, name: str, doc: str, label: str) -> None:
        self.name, self.doc, self.label = name, doc, label
        self._counts: Counter[str] = Counter()

    def add(self, value: str) -> None:
        """Add one to the counter of a label value, which is one of few words and never text from outside."""
        with _lock:
            self._counts[value] += 1

    def total(self) -> int:
        """Return the sum over all label values."""
        return self._counts.total()

    def lines(self) -> list[str]:
        """Return the lines that Prometheus reads."""
        with _lock:
            counts = sorted(self._counts.items())
        return [*_head(self, "counter"), *(f'{self.name}{{{self.label}="{value}"}} {n}' for value, n in counts)]


class Durations:
    """A histogram of durations in seconds."""

    def __init__(self, name: str, doc: str) -> None:
        self.name, self.doc = name, doc
        self._counts = [0] * (len(_BOUNDS) + 1)
        self._sum = 0.0

    def add(self, seconds: float) -> None:
        """Add one duration."""
        with _lock:
            self._counts[bisect_left(_BOUNDS, seconds)] += 1
            self._sum += seconds

    def lines(self) -> list[str]:
        """Return the lines that Prometheus reads."""
        with _lock:
            counts, total = list(self._counts), self._sum
        lines, below = _head(self, "histogram"), 0
        for bound, count in zip((*_BOUNDS, "+Inf"), counts, strict=True):
            below += count
            lines.append(f'{self.name}_bucket{{le="{bound}"}} {below}')
        return [*lines, f"{self.name}_sum {total:.6f}", f"{self.name}_count {below}"]


class Gauge:
    """A number that ``read`` returns at the time of the request; with a label, one number per label value."""

    def __init__(self, name: str, doc: str, label: str = "") -> None:
        self.name, self.doc, self._label = name, doc, label
        self.read: Callable[[], Mapping[str, float] | float] = lambda: {} if label else 0

    def lines(self) -> list[str]:
        """Return the lines that Prometheus reads."""
        found = self.read()
        numbers = {f'{{{self._label}="{value}"}}': n for value, n in found.items()} if self._label else {"": found}
        return [*_head(self, "gauge"), *(f"{self.name}{which} {n:g}" for which, n in numbers.items())]


def _head(metric: Count | Durations | Gauge, kind: str) -> list[str]:
    return [f"# HELP {metric.name} {metric.doc}", f"# TYPE {metric.name} {kind}"]


REQUESTS = Count("vibroscope_requests_total", "HTTP requests answered", "status")
REFUSED = Count("vibroscope_refused_total", "Refused values, messages, sessions and connections", "what")
OPENED = Count("vibroscope_sessions_total", "Sessions opened and closed", "what")
SESSIONS = Gauge("vibroscope_sessions", "Sessions that exist now")
TASKS = Gauge("vibroscope_tasks", "Tasks of the server's loop that have not ended")
QUEUE = Gauge("vibroscope_queue", "Jobs that wait or run: figures, studies, searches", "pool")
WAITED = Durations("vibroscope_wait_seconds", "Time from submitting a job to its start")
SOLVED = Durations("vibroscope_solve_seconds", "Time of both solvers for one setting, cached results included")
EXPLAINED = Durations("vibroscope_explain_seconds", "Time to explain one difference, cached explanations included")
JUDGED = Durations("vibroscope_judge_seconds", "Time to find the kinds of both motions of one setting")
BUILT = Durations("vibroscope_open_seconds", "Time to open a session")
_ALL = (REQUESTS, REFUSED, OPENED, SESSIONS, TASKS, QUEUE, WAITED, SOLVED, EXPLAINED, JUDGED, BUILT)


def exposition() -> str:
    """Return all metrics as text."""
    return "\n".join(line for metric in _ALL for line in metric.lines()) + "\n"
