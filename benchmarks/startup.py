"""Prints seconds from the command to the first figure in a browser, first without compiled kernels, then with them.

.venv/bin/python benchmarks/startup.py
"""

import tempfile
import time

from _pages import Visit, alive, explorer, free_port, launch, wait_until
from playwright.sync_api import sync_playwright


def start(browser, cache):
    """Seconds until the server answers, until the first figure is drawn, and until all are."""
    port, begin = free_port(), time.time()
    with explorer(port, environment={"VIBROSCOPE_CACHE_DIR": cache}):
        wait_until(lambda: alive(port), "the explorer answers")
        ready = time.time() - begin
        visit = Visit(browser, port, "form")
        drawn = visit.ask("(performance.timeOrigin + probe.first) / 1000") - begin
        complete = time.time() - begin
        visit.close()
    return ready, drawn, complete


def main():
    """Print both starts."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as cache:
        browser = launch(playwright)
        print(f"{'start':28}{'server answers':>16}{'first figure':>16}{'all figures':>16}")
        for name in ("first, kernels compiled", "second", "third", "fourth"):
            print(f"{name:28}" + "".join(f"{seconds:14.1f} s" for seconds in start(browser, cache)))
        browser.close()


if __name__ == "__main__":
    main()
