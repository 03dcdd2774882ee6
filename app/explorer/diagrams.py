"""The bifurcation diagrams of the default system, loaded once per process. No panel import."""

from __future__ import annotations

import threading
from concurrent.futures import Future

from vibroscope.app.runtime.workers import workers
from vibroscope.engine import Diagram, Reference, System, diagram

_futures: dict[str, Future[Diagram]] = {}
_lock = threading.Lock()


def load_diagram(joint_damping: str) -> Future[Diagram]:
    """The diagram from the package or the cache; a worker computes it (some ten seconds) where neither has it."""
    with _lock:
        if joint_damping not in _futures:
            _futures[joint_damping] = workers().submit(diagram, System(), Reference(joint_damping))
        return _futures[joint_damping]
