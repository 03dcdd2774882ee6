"""Ctrl-C ends a long computation in an orderly way."""

import contextlib
import signal
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def watch_interrupt() -> Iterator[Callable[[], bool]]:
    """Gives whether Ctrl-C was pressed: the first one ends the computation, the second ends the process as usual."""
    pressed = []

    def note(*_) -> None:
        pressed.append(True)
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)
