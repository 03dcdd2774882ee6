"""The bifurcation diagrams of the default system, loaded once per process. No panel import."""

from __future__ import annotations

import threading
from concurrent.futures import Future

from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.workers import workers
from vibroscope.engine import Diagram, Reference, System, diagram, shipped_diagram

FUTURES: dict[str, Future[Diagram]] = {}
_lock = threading.Lock()


def load_diagram(joint_damping: str) -> Future[Diagram]:
    """The diagram from the package or the cache; a worker computes it (some ten seconds) where neither has it."""
    with _lock:
        if joint_damping not in FUTURES:
            FUTURES[joint_damping] = future = Future()
            workers().submit(_load, Reference(joint_damping), future)
        return FUTURES[joint_damping]


def _load(method: Reference, future: Future[Diagram]) -> None:
    shipped = shipped_diagram(System(), method)
    if shipped is not None:
        future.set_result(shipped)
    else:
        compilation.when_done(lambda: workers().submit(_compute, method, future))


def _compute(method: Reference, future: Future[Diagram]) -> None:
    try:
        future.set_result(diagram(System(), method))
    except Exception as error:
        future.set_exception(error)
