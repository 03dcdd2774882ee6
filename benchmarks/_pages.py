"""Servers and pages for the measurements in a browser."""

import os
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tools.browser import find  # noqa: E402 - found through the line above

ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
PROBE = (ROOT / "benchmarks" / "_probe.js").read_text(encoding="utf-8")
FIGURES = ("phase1", "phase2", "displacement", "force")  # the four that a move changes
VIEWPORT = {"width": 1440, "height": 900}


def free_port():
    """A free port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def listens(port):
    """Whether a server listens on this port."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextmanager
def running(port, *command, environment=None):
    """Run a process that listens on ``port`` until the end of the block."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([str(part) for part in command], env={**os.environ, **(environment or {})}, **quiet)
    try:
        wait_until(lambda: process.poll() is not None or listens(port), f"{command} listens")
        if process.poll() is not None:
            raise RuntimeError(f"{command} ended with {process.returncode}")
        yield process
    finally:
        process.terminate()
        process.wait(30)


def explorer(port, *origins, environment=None):
    """Run ``vibroscope serve``."""
    command = [Path(sys.executable).parent / "vibroscope", "serve", "--port", port]
    for origin in (port, *origins):
        command += ["--origin", f"127.0.0.1:{origin}"]
    return running(port, *command, environment=environment)


def script(name, port, *arguments):
    """Run one of the scripts beside this one."""
    return running(port, sys.executable, Path(__file__).with_name(name), port, *arguments)


def wait_until(holds, what, seconds=120.0, every=0.02):
    """Poll until it holds."""
    end = time.perf_counter() + seconds
    while not holds():
        if time.perf_counter() > end:
            raise TimeoutError(f"not within {seconds:g} s: {what}")
        time.sleep(every)


def launch(playwright):
    """Start the browser."""
    return playwright.chromium.launch(executable_path=find(), args=ARGUMENTS)


def alive(port):
    """Whether the explorer answers."""
    try:
        return urllib.request.urlopen(f"http://127.0.0.1:{port}/liveness", timeout=1).status == 200
    except OSError:
        return False


class Visit:
    """A page with the probe."""

    def __init__(self, browser, port, handle):
        """``handle`` selects the slider, which takes the keys."""
        self.context = browser.new_context(viewport=VIEWPORT)
        self.page = self.context.new_page()
        self.page.add_init_script(PROBE)
        self.page.goto(f"http://127.0.0.1:{port}/")
        self.until("probe.first > 0 && Bokeh.documents[0].is_idle")
        self.handle = self.page.locator(handle)
        self._tools = self.context.new_cdp_session(self.page)
        self._tools.send("Performance.enable")

    def until(self, expression, seconds=120.0):
        """Wait for an expression to be true; Playwright's own way needs an eval that the explorer forbids."""
        wait_until(lambda: self.page.evaluate(expression), expression, seconds)

    def ask(self, expression):
        """The value of an expression in the page."""
        return self.page.evaluate(expression)

    def watch(self, what, figures=FIGURES):
        """Begin to note when all ``figures`` show a new state."""
        self.page.bring_to_front()
        self.page.evaluate("([figures, what]) => probe.watch(figures, what)", [list(figures), what])

    def cpu(self):
        """CPU time (ms) of the page's main thread so far."""
        metrics = self._tools.send("Performance.getMetrics")["metrics"]
        return next(1000 * metric["value"] for metric in metrics if metric["name"] == "ThreadTime")

    def close(self):
        """Close the page."""
        self.context.close()
