"""The way of results to the browser: from worker threads to the loop of the session, then one update at a time.

What adds models to the page, a view that is opened or the curves of a pin, takes hundreds of milliseconds: Bokeh walks
over all models of the document and serialises the new ones. That is done in a thread (`SessionLoop.add_models`), or the
loop would answer nobody meanwhile. The document is locked, so that nothing else of its session is called.

Answers may come late and in any order. Who numbers a request, and who drops an answer that is too late:

1. The browser numbers each move (`controls.js`); until the last one is answered it keeps what its user has set, shows
   "computing", and after half a second hides the verdict (`findings.js`).
2. A job queue has one request that waits, the newest, and one that runs; one that is overtaken ends early, or its
   answer comes before the newer one's (`JobQueue`). So figures come in the order of the moves.
3. Every answer goes to the loop of the session (`SessionLoop`), where alone anything is shown: a result is compared
   there with what is shown at that moment, and nothing can come between.
4. An update that the browser has no time for is replaced by a newer one (`UpdateChannel`); each answers a move, once
   its figures are sent. One that had to wait may come after the answer to a newer move, which failed or was refused;
   that one stays answered.
5. What belongs to figures, their verdict and the kinds of their motions, is asked for when these are written, and again
   if a move has stopped it whose figures then failed. It is shown only if the figures are still those of its setting
   (`Explainer`, `MotionJudge`); until then, that of the setting before is marked as pending (`Findings`).
6. What answers another question (a study, a search, an explanation, a pin, a claim) is a `Job`: one that was cancelled
   delivers nothing, and another question cancels it (`on_loop`, `Asker`).

`tests/app/test_late_answers.py` tries the orders.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import panel as pn
from bokeh.document import Document
from panel.io.state import set_curdoc
from vibroscope.app.compat import Unsent, claim_document, collected, send, send_rest
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import ahead_of_jobs

# If the browser has not answered for so long (seconds), the next update is sent all the same.
_PATIENCE = 1.0


class SessionLoop:
    """Calls functions on the loop of a session's document, from the time when the page is open.

    Panel drops changes that are made before the browser has received the page, so calls wait for that.
    """

    def __init__(self, doc: Document) -> None:
        self._doc = doc
        self._session = logs.session.get()
        self._waiting: list[Callable[[], None]] = []
        self._open = False
        self._closed = False

    def start(self) -> None:
        """The page is open: make the calls that waited for it."""
        self._open = True
        for callback in self._waiting:
            callback()
        self._waiting.clear()

    def close(self) -> None:
        """The session has ended: make no more calls."""
        self._closed = True

    def call_later(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` on the loop, from any thread, if the session still exists."""
        if self._doc.session_context is None or self._closed:
            return
        try:
            self._doc.add_next_tick_callback(partial(self._call_when_open, callback))
        except AttributeError:  # Bokeh takes the document's callbacks away while it ends a session, in another thread
            if self._doc.session_context is not None:
                raise

    def add_models(self, add: Callable[[], None], then: Callable[[], None], fail: Callable[[], None]) -> None:
        """Call ``add``, which adds models to the page, in a thread, then ``then`` on the loop; see `TabHost`.

        Nothing else of the session is called meanwhile. If ``add`` fails, that is logged, and ``fail`` is called.
        """
        if self._open:
            self._doc.add_next_tick_callback(partial(self._add_in_thread, add, then, fail))
        else:  # in the thread that builds the page
            add()
            then()

    async def _add_in_thread(self, add: Callable[[], None], then: Callable[[], None], fail: Callable[[], None]) -> None:
        """Bokeh awaits this with the document locked."""
        with logs.in_session(self._session), ahead_of_jobs(), set_curdoc(self._doc):
            unsent, error = await asyncio.to_thread(self._add, add)
            claim_document(self._doc)
            send(self._doc, unsent)
            if error is not None:
                logs.event("models not added", logging.ERROR, error=error)
                then = fail
            then()

    def _add(self, add: Callable[[], None]) -> tuple[Unsent, Exception | None]:
        """Change the page and make the messages of that, in a thread; with the error of ``add``, if there was one."""
        claim_document(self._doc)
        failed = None
        with collected(self._doc) as unsent, self._doc.models.freeze():  # one walk over all models, not one for each
            try:
                add()
            except Exception as error:  # it must not leave the models frozen
                failed = error
        return unsent, failed

    def _call_when_open(self, callback: Callable[[], None]) -> None:
        if self._open:
            with logs.in_session(self._session), ahead_of_jobs():
                callback()
        else:
            self._waiting.append(callback)


class _Update(NamedTuple):
    move: int  # that the update answers
    write: Callable[[], None]
    follow: Callable[[], None]


class UpdateChannel:
    """Sends one update at a time: the next, the newest, when the browser has painted the last.

    Otherwise updates would queue up on a slow connection, and the page would lag behind the slider.
    """

    def __init__(self, doc: Document, answer: Callable[[int, int], None]) -> None:
        """``answer(move, update)`` sends the browser the newest move that was answered and the number of the update."""
        self._doc = doc
        self._answer = answer
        self._next: _Update | None = None
        self._unpainted = 0
        self._sent_at = 0.0
        self.count = 0  # updates so far; the number of the last one
        self._answered = 0  # the newest move that was answered

    def answer(self, move: int = 0) -> None:
        """Answer ``move`` without an update, or say again which move was answered."""
        self._answered = max(self._answered, move)
        self._answer(self._answered, self.count)

    def push(self, move: int, write: Callable[[], None], follow: Callable[[], None] = lambda: None) -> None:
        """Call both now if the browser is free, else as soon as it is, unless a newer update replaces this one.

        ``write`` changes what the browser paints, ``follow`` the words beside it. They are sent one after the other, so
        that the browser reads and paints the figures while the words are put together.
        """
        self._next = _Update(move, write, follow)
        self._send_when_free()

    def painted(self, update: object) -> None:
        """The browser has painted the update of this number."""
        if update == self._unpainted:
            self._unpainted = 0
            self._send_when_free()

    def _send_when_free(self) -> None:
        send_rest(self._doc)
        if self._unpainted and time.monotonic() - self._sent_at < _PATIENCE:
            return
        if self._next is None:
            return
        update, self._next = self._next, None
        self.count += 1
        self._unpainted, self._sent_at = self.count, time.monotonic()
        with pn.io.hold(self._doc):
            update.write()
        with pn.io.hold(self._doc):
            update.follow()
            self.answer(update.move)
        self._doc.add_timeout_callback(self._send_when_free, int(1000 * _PATIENCE) + 50)
