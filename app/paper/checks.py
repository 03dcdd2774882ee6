"""Checks of claims, as studies that sessions share: each is made once a process, and not at all if nobody waits."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vibroscope.app.paper import CLAIMS, Finding
from vibroscope.app.paper.claims import is_cancelled
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import lower_priority, pool
from vibroscope.app.studies.study_job import StudyJob
from vibroscope.engine.arguments import Poll

CHECKED = Cache(len(CLAIMS))  # all: no setting changes a finding


@dataclass(frozen=True)
class Checked:
    """A claim that is checked, as the only result of its study."""

    question: str
    finding: Finding
    share: float = 1.0


def begin_check(key: str, deliver: Callable[[StudyJob, Checked | Exception], None]) -> StudyJob:
    """Check a claim in a thread of lower priority than those of the sliders."""
    threads = pool("paper", 1, lower_priority, margin=math.inf)  # one after the other, since claims share runs
    return StudyJob(key, _check, deliver, CHECKED, threads)


def _check(key: str, _: None, cancelled: Poll) -> Iterator[Checked]:
    token = is_cancelled.set(cancelled)
    try:
        found = Checked(key, CLAIMS[key].find())
    finally:
        is_cancelled.reset(token)
    yield found
