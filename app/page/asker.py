"""What a part of the page has asked for: at most one question at a time, after a rest, and what is known of it."""

from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer.errors import error_text
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.job import Job
from vibroscope.app.studies.study_job import RESULTS, Grow, PartialResult, StudyJob


class Asker:
    """Asks the last question alone: another one, or `drop`, cancels the one before, whether it waits or is under way.

    A `StudyJob` answers in finer and finer parts that all sessions share, an `Answer` by one call. Both rest while
    figures are on their way, and take turns with the jobs of other sessions. With `on_loop` nothing that was cancelled
    is delivered. A view drops its questions when it is hidden, and so when the session ends. Only the figures of a
    move are not asked so, but by `JobQueue`: one that is overtaken may still come.

    Attributes
    ----------
    job : Job or None
        That of the last question, under way or done, unless it was dropped.

    Parameters
    ----------
    host : TabHost
    rest : int
        ms from `ask` until the question is asked, so that none is while a slider moves.
    """

    def __init__(self, host: TabHost, rest: int = 0) -> None:
        self.job: Job | None = None
        self._host, self._rest = host, rest
        self._asked = 0

    def ask(self, begin: Callable[[], Job | None]) -> None:
        """Call ``begin`` after the rest: it begins a job, or none if the question has no answer any more."""
        self.drop()
        if self._rest:
            self._host.doc.add_timeout_callback(partial(self._begin, self._asked, begin), self._rest)
        else:
            self.job = begin()

    def drop(self) -> None:
        """Cancel the question, and forget its job."""
        self._asked += 1
        if self.job is not None:
            self.job.cancel()
            self.job = None

    def _begin(self, number: int, begin: Callable[[], Job | None]) -> None:
        if number == self._asked:
            self.job = begin()


class StudyAsker(Asker):
    """Asks studies, and keeps what is known of the last one: a part, all of it, or that it has stopped or failed.

    Attributes
    ----------
    question : object
        None: none.
    result : PartialResult or None
        Of the question or, until there is any, of the one before.
    stopped : bool
        By the user, or since its time is over.
    failed : str
        Why the study has ended early; else empty.

    Parameters
    ----------
    host : TabHost
    grow : Grow
    on_change : callable
        Called when a worker has changed one of the attributes.
    """

    def __init__(self, host: TabHost, grow: Grow, on_change: Callable[[], None]) -> None:
        super().__init__(host)
        self._grow, self._on_change = grow, on_change
        self.result: PartialResult | None = None
        self.forget()

    def forget(self) -> None:
        """Cancel the question, so that it is asked anew though it had stopped or failed; a result stays."""
        self.drop()
        self.question, self.stopped, self.failed = None, False, ""

    def follow(self, question: object) -> None:
        """Begin this study, or go on with it, unless all of it is known, or it has stopped or failed."""
        if question != self.question:
            self.forget()
            self.question = question
        if question is None:
            return
        self.result = RESULTS.get(question) or self.result
        if self.job is None and not (self.share == 1 or self.stopped or self.failed):
            self.ask(lambda: StudyJob(question, self._grow, on_loop(self._host, self._take)))

    def stop(self, on: bool) -> None:
        """Stop the study; with False go on with it, also after it failed."""
        if on:
            self.drop()
            self.stopped = True
        else:
            question = self.question
            self.forget()
            self.follow(question)

    @property
    def share(self) -> float:
        """The share of the question that is known."""
        return self.result.share if self.result is not None and self.result.question == self.question else 0.0

    def _take(self, job: StudyJob, result: PartialResult | Exception) -> None:
        if isinstance(result, Exception):
            self.failed = error_text(result)
        else:
            self.result, self.stopped = result, job.out_of_time
        if self.failed or self.stopped or self.share == 1:
            self.drop()
        self._on_change()
