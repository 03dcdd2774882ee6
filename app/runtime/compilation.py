"""The kernels are compiled while the server already answers: in a process of its own, so that the page stays quick.

Numba holds the interpreter's lock while it compiles, for some minutes in all. What needs a kernel waits until all are
compiled (`Compilation.when_done`) and then loads the machine code from the cache; what needs only the first of them,
by which the explorer shows and then explains what it opens with, waits for these alone.
"""

import json
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from operator import itemgetter

from vibroscope.app.runtime.workers import lower_priority
from vibroscope.engine import Compiled, CompileProgress, compile_kernels, is_cache_private, is_compiled

Watcher = Callable[[CompileProgress | None], None]


class Compilation:
    """The compilation of the kernels for this process, if there is one.

    Parameters
    ----------
    command
        What compiles the kernels in another process, and prints each `CompileProgress` as a JSON array in a line.

    Attributes
    ----------
    progress : CompileProgress or None
        How far it is; None if nothing is being compiled.
    """

    def __init__(self, command: Sequence[str] = (sys.executable, "-m", __name__)) -> None:
        self.command = command
        self.progress: CompileProgress | None = None
        self._lock = threading.Lock()
        self._watchers: list[Watcher] = []
        self._waiting: list[tuple[Compiled, Callable[[], None]]] = []
        self._process: subprocess.Popen | None = None

    def start(self) -> None:
        """Compile all kernels in the background, unless they are compiled or being compiled."""
        with self._lock:
            if self.progress is not None or is_compiled():
                return
            self.progress = CompileProgress(0.0, "")
        self.thread = threading.Thread(target=self._run, name="compilation", daemon=True)
        self.thread.start()

    def when_done(self, act: Callable[[], None], needs: Compiled = Compiled.ALL) -> None:
        """Call ``act`` when so much is compiled: now if it is, else later in another thread."""
        with self._lock:
            if self.progress is not None and self.progress.compiled < needs:
                self._waiting.append((needs, act))
                return
        act()

    def watch(self, watcher: Watcher) -> None:
        """Call ``watcher`` in another thread with each progress, and last with None; not at all if all is compiled."""
        with self._lock:
            if self.progress is not None:
                self._watchers.append(watcher)

    def stop(self) -> None:
        """The server stops: compile no further, and call nobody any more."""
        with self._lock:
            self._watchers, self._waiting = [], []
            if self._process is not None:
                self._process.terminate()

    def _run(self) -> None:
        try:
            # Another process could write the machine code only to a copy of its own.
            self._compile_here() if is_cache_private() else self._compile_apart()
        except OSError:
            pass  # no process could be started: each kernel is compiled when it is first called
        finally:
            self.finish()

    def finish(self) -> None:
        """All is compiled that will be: call who waits and who watches."""
        with self._lock:
            self.progress = None
            waiting, self._waiting = self._waiting, []
            watchers, self._watchers = self._watchers, []
        for _, act in sorted(waiting, key=itemgetter(0)):
            act()
        for watcher in watchers:
            watcher(None)

    def _compile_here(self) -> None:
        lower_priority()
        compile_kernels(self._report)

    def _compile_apart(self) -> None:
        # In a session of its own: Ctrl+C in the terminal ends the server, and the server ends this.
        with subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
            self._process = process
            for line in process.stdout:
                self._report(CompileProgress(*json.loads(line)))

    def _report(self, progress: CompileProgress) -> None:
        with self._lock:
            self.progress = progress
            watchers = list(self._watchers)
            ready = [act for needs, act in self._waiting if needs <= progress.compiled]
            self._waiting = [(needs, act) for needs, act in self._waiting if needs > progress.compiled]
        for act in ready:
            act()
        for watcher in watchers:
            watcher(progress)


compilation = Compilation()


def _print(progress: CompileProgress) -> None:
    print(json.dumps(progress), flush=True)


if __name__ == "__main__":
    lower_priority()
    compile_kernels(_print, processes=None)
