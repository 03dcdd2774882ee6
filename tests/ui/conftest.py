"""A server in a process of its own, a browser, and pages that complain about anything unexpected."""

import json
import os
import re
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from tools.browser import find

ROOT = Path(__file__).parents[2]
ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--font-render-hinting=none",
    "--disable-font-subpixel-positioning",
    "--force-color-profile=srgb",
    "--force-device-scale-factor=1",
    # Redrawing a part of a tile leaves other edges than drawing it whole: pictures must not depend on history.
    "--hide-scrollbars",
    "--disable-partial-raster",
    "--disable-lcd-text",
]
KNOWN_MESSAGES = re.compile(
    r"\[bokeh [\d.]+\] (setting log level|Websocket connection \d+ is now open|document idle at)"
    r"|Bokeh items were rendered successfully"
)
SECONDS_TO_START = 120  # a cold start compiles the kernels


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.ui)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(holds, seconds=20.0, what=""):
    """Poll ``holds`` until it is true."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise AssertionError(f"not within {seconds} s: {what or holds}")
        time.sleep(0.02)


def _answers(url):
    try:
        return urllib.request.urlopen(url, timeout=2).status == 200
    except OSError:
        return False


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    """Address of a running explorer."""
    port = free_port()
    log = tmp_path_factory.mktemp("server") / "log.txt"
    program = (
        "from vibroscope.app.runtime.settings import Settings\n"
        "from vibroscope.app.server.server import serve\n"
        f"serve(Settings(port={port}))"
    )
    command = [sys.executable, "-c", program]
    with log.open("w") as output:
        process = subprocess.Popen(command, cwd=ROOT, stdout=output, stderr=subprocess.STDOUT, env=os.environ)
        try:
            url = f"http://127.0.0.1:{port}"
            wait_until(lambda: process.poll() is not None or _answers(f"{url}/liveness"), SECONDS_TO_START, "a server")
            assert process.poll() is None, log.read_text()
            yield url
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
    # What passes through no line of ours is the library's way of noticing that a page closed under it.
    ours = rf'File "{re.escape(str(ROOT))}/(app|engine)/|not computed'
    assert not re.search(ours, log.read_text()), log.read_text()


@pytest.fixture(scope="session")
def browser():
    """One Chromium for all tests."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=find(), args=ARGUMENTS)
        yield chromium
        chromium.close()


class Explorer:
    """A page of the explorer, in the terms of its user."""

    def __init__(self, page, server):
        self.page = page
        self.server = server
        self.complaints = []
        page.on("console", self._heard)
        page.on("pageerror", lambda error: self.complaints.append(f"page error: {error}"))
        page.on("request", self._asked)

    def _heard(self, message):
        if not KNOWN_MESSAGES.search(message.text):
            self.complaints.append(f"{message.type}: {message.text}")

    def _asked(self, request):
        if not request.url.startswith((self.server, "data:", "blob:")):
            self.complaints.append(f"asked another host: {request.url}")

    def open(self, query=""):
        self.page.goto(f"{self.server}/{query}")
        self.until("!!window.Bokeh && Bokeh.documents.length && Bokeh.index.roots.length > 0")
        self.settle(frame=1)
        return self

    def until(self, expression, seconds=20.0):
        """Wait until an expression is true in the page; Playwright's own way needs an eval that the page forbids."""
        wait_until(lambda: self.page.evaluate(expression), seconds, expression)

    @property
    def form(self):
        return self.page.locator("form.panel")

    def frame(self):
        """Number of the last update that was painted."""
        return int(self.form.get_attribute("data-frame") or 0)

    def settle(self, frame=0):
        """Wait until at least update number ``frame`` is on the screen and nothing is under way."""
        self.form.wait_for(state="attached")  # some tabs hide it
        wait_until(lambda: self.frame() >= frame, what=f"update {frame}")
        self.until("Bokeh.documents.every(d => d.is_idle)")
        painted = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 60)))"
        self.page.evaluate(f"document.fonts.ready.then(() => {painted})")

    def explained(self):
        """Wait until the difference is explained; that comes when the hand rests."""
        self.page.locator(".told[data-pending=false]").wait_for()
        return self

    def moved(self, act):
        """Do ``act`` and wait for its update."""
        before = self.frame()
        act()
        self.settle(before + 1)

    def slider(self, name):
        return self.page.locator(f"#vibroscope-{name}-slider")

    def typed(self, name):
        return self.page.locator(f"#vibroscope-{name}-typed")

    def type(self, name, text):
        self.typed(name).fill(text)
        self.typed(name).press("Enter")

    def scene(self, label, group="motion"):
        self.page.get_by_role("button", name=f"{group} {label}:", exact=False).click()

    def query(self):
        """The page's query string, now (Playwright's own ``page.url`` lags behind ``replaceState``)."""
        return self.page.evaluate("location.search")

    def error(self):
        """What the page refuses or could not do, wherever it says so."""
        told = self.page.locator(".error:not([hidden]) span, .refusal:not([hidden])")
        return " ".join(told.all_text_contents())

    def open_tab(self, title):
        self.page.get_by_role("tab", name=title, exact=True).click()
        self.page.locator(f"[role=tab][aria-selected=true]:text-is('{title}')").wait_for()

    def model(self, name, attribute):
        """One attribute of a Bokeh model, as the browser has it."""
        return self.page.evaluate("([n, a]) => Bokeh.documents[0].get_model_by_name(n)[a]", [name, attribute])

    def line(self, name):
        return self.page.locator(f".line.{name} p").text_content()

    def source(self, name):
        """Columns of one data source as lists; not a number becomes None."""
        return self.page.evaluate(SOURCE, name)

    def figure(self, name):
        """Ranges, labels and layout boxes of one figure."""
        return self.page.evaluate(FIGURE, name)

    def sources(self):
        return {name: self.source(name) for name in SOURCES}

    def zoom(self, name, x0, x1, y0, y1):
        """Drag a box in a figure, in shares of its frame from the top left."""
        box = self.figure(name)["frame"]
        self.page.mouse.move(box["x"] + x0 * box["width"], box["y"] + y0 * box["height"])
        self.page.mouse.down()
        self.page.mouse.move(box["x"] + x1 * box["width"], box["y"] + y1 * box["height"], steps=4)
        self.page.mouse.up()


SOURCES = (
    "displacements",
    "phase_reference",
    "phase_penalty",
    "section_reference",
    "section_penalty",
    "strip_reference",
    "strip_penalty",
    "force_reference",
    "force_penalty",
    "impulse_reference",
    "impulse_penalty",
)
SOURCE = """name => {
  const source = Bokeh.documents[0].get_model_by_name(name);
  return Object.fromEntries(Object.entries(source.data instanceof Map ? Object.fromEntries(source.data) : source.data)
    .map(([column, values]) => [column, Array.from(values, v => Number.isFinite(v) ? v : null)]));
}"""
FIGURE = """name => {
  const model = Bokeh.documents[0].get_model_by_name(name);
  const view = Bokeh.index.find_one_by_id(model.id);
  const box = view.el.getBoundingClientRect();
  const frame = view.frame.bbox;
  const canvas = view.canvas_view.el.getBoundingClientRect();
  return {
    x: [model.x_range.start, model.x_range.end], y: [model.y_range.start, model.y_range.end],
    title: model.title.text, labels: [...model.below, ...model.left, ...model.right].map(a => a.axis_label ?? ""),
    box: {x: box.x, y: box.y, width: box.width, height: box.height},
    frame: {x: canvas.x + frame.x0, y: canvas.y + frame.y0, width: frame.x1 - frame.x0, height: frame.y1 - frame.y0},
  };
}"""


@pytest.fixture(scope="session")
def windows(browser):
    """Contexts by their options, kept: the pages then find their scripts in the browser's cache."""
    kept = {}

    def window(**options):
        key = json.dumps(options, sort_keys=True)
        if key not in kept:
            kept[key] = browser.new_context(
                reduced_motion="reduce", locale="en-GB", timezone_id="UTC", device_scale_factor=1, **options
            )
            kept[key].set_default_timeout(20_000)
        return kept[key]

    yield window
    for context in kept.values():
        context.close()


@pytest.fixture
def visit(windows, server):
    """Open the explorer in a session of its own; at the end, nothing unexpected may have been said."""
    opened = []

    def open_page(query="", width=1440, height=900, **options):
        context = windows(viewport={"width": width, "height": height}, **options)
        explorer = Explorer(context.new_page(), server)
        opened.append(explorer)
        return explorer.open(query)

    yield open_page
    complaints = [complaint for explorer in opened for complaint in explorer.complaints]
    for explorer in opened:
        explorer.page.close()
    assert complaints == []
