"""From the command to the first figure in a browser: first with no compiled kernels at hand, then with them.

.venv/bin/python benchmarks/startup.py
"""

import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tools.browser import find  # noqa: E402 - found through the line above

# The phase plot has its data and has been painted with them; and then the whole page.
FIRST_FIGURE = """() => {
  const page = window.Bokeh?.documents?.[0];
  const figure = page?.get_model_by_name("phase1");
  return page?.get_model_by_name("phase_reference")?.data.x1.length > 0
    && figure != null && Bokeh.index.find_one_by_id(figure.id)?.has_finished();
}"""
ALL_FIGURES = "() => Bokeh.documents[0].is_idle"
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]


def free_port():
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def start(browser, cache):
    """Seconds until the server answers, the first figure is drawn, and all are."""
    port = free_port()
    command = [Path(sys.executable).parent / "vibroscope", "serve", "--port", str(port)]
    environment = {**os.environ, "VIBROSCOPE_CACHE_DIR": cache}
    begin = time.perf_counter()
    server = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while time.perf_counter() < begin + 120:
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{port}/liveness", timeout=1).close()
                break
            except OSError:
                time.sleep(0.02)
        ready = time.perf_counter() - begin
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{port}/")
        page.wait_for_function(FIRST_FIGURE, timeout=120_000)
        drawn = time.perf_counter() - begin
        page.wait_for_function(ALL_FIGURES, timeout=120_000)
        complete = time.perf_counter() - begin
        page.close()
    finally:
        server.terminate()
        server.wait(30)
    return ready, drawn, complete


def main():
    """Print both starts."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as cache:
        browser = playwright.chromium.launch(executable_path=find(), args=ARGUMENTS)
        print(f"{'start':28}{'server answers':>16}{'first figure':>16}{'all figures':>16}")
        for name in ("first, kernels compiled", "second", "third", "fourth"):
            print(f"{name:28}" + "".join(f"{seconds:14.1f} s" for seconds in start(browser, cache)))
        browser.close()


if __name__ == "__main__":
    main()
