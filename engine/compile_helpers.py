"""Processes that help to compile the kernels: each makes the calls that no other process has begun.

All of them write machine code into one cache folder. A process that helps reads nothing from its input, and ends where
that ends: with the process that it helps, however that ends.
"""

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

COMMAND = sys.executable, "-m", f"{__package__}.compilation"


class Claims:
    """Which calls have been begun by any process: each has a file in a folder that they share."""

    def __init__(self, folder: str | Path):
        self._folder = Path(folder)

    def take(self, call: int) -> bool:
        """Whether this process makes a call: it is the first to ask."""
        try:
            (self._folder / str(call)).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True


class Helpers:
    """Processes that help this one, for the time of a block.

    Parameters
    ----------
    count : int
        How many.
    compiled : callable
        Called, in other threads, with the name of each function that one of them has compiled.
    command : sequence of str
        What starts one; the folder of the claims is added to it.

    Attributes
    ----------
    claims : Claims
        Those of all.
    """

    def __init__(self, count: int, compiled: Callable[[str], None], command: Sequence[str] = COMMAND):
        self._count, self._compiled, self._command = count, compiled, command
        self._changed = threading.Condition()
        self._done: set[int] = set()
        self._running = 0

    def __enter__(self) -> "Helpers":
        self._folder = tempfile.TemporaryDirectory(prefix="vibroscope-compile-")
        self.claims = Claims(self._folder.name)
        self._processes, self._listeners = [], []
        for _ in range(self._count):
            try:
                self._start()
            except OSError:  # there can be no more processes: this one compiles alone
                break
        return self

    def __exit__(self, *error: object) -> None:
        for process in self._processes:
            process.stdin.close()  # which ends it
        for process, listener in zip(self._processes, self._listeners, strict=True):
            process.wait()
            listener.join()
            process.stdout.close()
        self._folder.cleanup()

    def wait(self, calls: Iterable[int]) -> None:
        """Wait until the calls are made by those who have begun them, unless one of the processes has failed."""
        calls = set(calls)
        with self._changed:
            self._changed.wait_for(lambda: self._done >= calls or self._running < self._count)

    def made(self, call: int) -> None:
        """Note that a call is made, by this process."""
        with self._changed:
            self._done.add(call)

    def _start(self) -> None:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        process = subprocess.Popen([*self._command, self._folder.name], **pipes)
        self._processes.append(process)
        self._running += 1
        listener = threading.Thread(target=self._listen, args=(process,), name="compiles", daemon=True)
        self._listeners.append(listener)
        listener.start()

    def _listen(self, process: subprocess.Popen) -> None:
        try:
            for line in process.stdout:
                what = json.loads(line)
                if isinstance(what, int):
                    with self._changed:
                        self._done.add(what)
                        self._changed.notify_all()
                else:
                    self._compiled(what)
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()


def report(what: str | int) -> None:
    """Report to the process that is helped which function is compiled, or which call is made."""
    print(json.dumps(what), flush=True)


def end_with_input() -> None:
    """Let this process end as soon as its input does."""

    def watch() -> None:
        sys.stdin.read()
        os._exit(0)

    threading.Thread(target=watch, name="input", daemon=True).start()
