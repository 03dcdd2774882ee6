"""From a worker thread to a session's own loop: all that needs no document is prepared on the way."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from vibroscope.app.explorer.compute import Frame
from vibroscope.app.page.tab import Desk
from vibroscope.app.runtime import logs

Prepared = TypeVar("Prepared")


def prepared(
    desk: Desk,
    prepare: Callable[[Frame], Prepared],
    arrived: Callable[[int, Prepared], None],
    failed: Callable[[int, Exception], None],
) -> Callable[[int, Frame | Exception], None]:
    """A way to deliver for `Latest`: ``prepare`` is called in its thread, one of the others on the loop."""

    def deliver(move: int, result: Frame | Exception) -> None:
        if isinstance(result, Frame):
            try:
                desk.later(partial(arrived, move, prepare(result)))
                return
            except Exception as error:  # told on the page as any other
                logs.event("not presented", logging.ERROR, error=error)
                result = error
        desk.later(partial(failed, move, result))

    return deliver
