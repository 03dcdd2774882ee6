"""The page of the explorer in the terms of its user, for tests in a browser."""

import math
import re
from urllib.parse import parse_qs

from vibroscope.app.explorer.link import print_address
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.page.address import read_opening
from vibroscope.app.page.tabs import TABS

from tests.waiting import PATIENCE, wait_until

_EXPECTED_MESSAGES = re.compile(
    r"\[bokeh [\d.]+\] (setting log level|Websocket connection \d+ is now open|document idle at)"
    r"|Bokeh items were rendered successfully"
)

PHONE = {"width": 390, "height": 844, "has_touch": True, "is_mobile": True}
PAPER = "?eta=1.08&K=2500&D=8&steps=2000"  # scene [A], where a test needs its numbers


def is_setting(query):
    """Whether a link sets numbers and choices of a setting alone, not a view or what is seen in it."""
    return parse_qs(query[1:]).keys() <= set(FIELDS)


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
        if not _EXPECTED_MESSAGES.search(message.text):
            self.complaints.append(f"{message.type}: {message.text}")

    def _asked(self, request):
        if not request.url.startswith((self.server, "data:", "blob:")):
            self.complaints.append(f"asked another host: {request.url}")

    def open(self, query=""):
        self.page.goto(f"{self.server}/{query}")
        self.until("!!window.Bokeh && Bokeh.documents.length && Bokeh.index.roots.length > 0")
        self.settle(update=1)
        return self

    def until(self, expression, seconds=PATIENCE):
        """Wait until an expression is true in the page; Playwright's own way needs an eval that the page forbids."""
        wait_until(lambda: self.page.evaluate(expression), seconds, expression)

    @property
    def form(self):
        return self.page.locator("form.panel")

    def update(self):
        """Number of the last update that was painted."""
        return int(self.form.get_attribute("data-update") or 0)

    def settle(self, update=0):
        """Wait until at least update number ``update`` is on the screen and nothing is under way."""
        self.form.wait_for(state="attached")  # some tabs hide it
        wait_until(lambda: self.update() >= update, what=f"update {update}")
        self.until("Bokeh.documents.every(d => d.is_idle)")
        painted = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 60)))"
        self.page.evaluate(f"document.fonts.ready.then(() => {painted})")

    def explained(self):
        """Wait until the difference is explained; that comes a moment after the last move."""
        self.page.locator(".lines[data-pending=false]").wait_for()
        return self

    def judged(self):
        """Wait until the kinds of both motions are known."""
        self.page.locator('.line.penalty[data-kind]:not([data-kind=""])').wait_for()
        return self

    def moved(self, act):
        """Do ``act`` and wait for its update."""
        before = self.update()
        act()
        self.settle(before + 1)

    def at(self, **texts):
        """Set numbers, whatever was set before."""
        set_them = "detail => document.dispatchEvent(new CustomEvent('vibroscope:set', { detail }))"
        self.page.evaluate(set_them, texts)
        self.wait_for_address(**texts)
        self.settle()
        return self

    def again(self, query):
        """Bring the page to Explore and the setting of a link, all folded; False if more than that stays."""
        if {"mute", "theme"} & self.address().keys():  # which stay
            return False
        setting = read_opening(query).setting
        before = self.update()
        self.page.evaluate(AGAIN, setting.texts())
        wait_until(lambda: self.update() > before, what="the opening scene")
        links = [f"?{print_address(setting, choice=held)}" for held in ("", "phase:0")]
        try:
            wait_until(lambda: self.query() in links, 20)
        except AssertionError:
            return False
        self.settle()
        return True

    def resized(self, width, height):
        """Give the window another size."""
        self.page.set_viewport_size({"width": width, "height": height})
        self.settle()
        return self

    def slider(self, name):
        return self.page.locator(f"#vibroscope-{name}-slider")

    def typed(self, name):
        return self.page.locator(f"#vibroscope-{name}-typed")

    def type(self, name, text):
        self.typed(name).fill(text)
        self.typed(name).press("Enter")

    def scene(self, key):
        """Choose a scene by its key in scenes.toml."""
        tile = self.page.locator(f"[data-scene='{key}']")
        if tile.is_hidden():
            self.unfold("More scenes")
        tile.click()

    def unfold(self, *titles):
        """Open folded parts of the page, by the beginning of their titles."""
        for title in titles:
            fold = self.page.locator("summary", has_text=re.compile(f"^{re.escape(title)}"))
            if not fold.evaluate("fold => fold.parentElement.open"):
                fold.click()

    def address(self):
        """Name and first text of each entry of the page's query string."""
        return {name: texts[0] for name, texts in parse_qs(self.query()[1:]).items()}

    def wait_for_address(self, **wanted):
        """Wait until these entries are in the query string."""
        wait_until(lambda: wanted.items() <= self.address().items(), what=f"{wanted} in the address")

    def query(self):
        """The page's query string, now (Playwright's own ``page.url`` lags behind ``replaceState``)."""
        return self.page.evaluate("location.search")

    def error(self):
        """The error messages on the page."""
        shown = self.page.locator(".error:not([hidden]) span, .refusal:not([hidden])")
        return " ".join(shown.all_text_contents())

    def open_tab(self, title, view=""):
        """Open a tab, and then one of its views."""
        for place, name in (("Parts of the page", title), (f"Views of {title}", view)):
            if name:  # a view may have the title of its tab
                places = self.page.get_by_role("tablist", name=place, exact=True)
                places.get_by_role("tab", name=name, exact=True).click()
                places.get_by_role("tab", name=name, exact=True, selected=True).wait_for()

    def open_view(self, key):
        """Open a view by its key, and wait until it is shown."""
        tab, view = next((tab, view) for tab in TABS for view in tab.views if view.key == key)
        self.open_tab(tab.title, view.title if len(tab.views) > 1 else "")
        wait_until(lambda: self.address().get("view", "explore") == key, what=f"the view {key} in the address")
        self.settle()
        return self

    def change_theme(self, name):
        """Press the button "Dark page" or "Light page" in the dialog of tour, keys and help, and close it."""
        self.page.get_by_role("button", name="Tour, keys and help").click()
        self.page.get_by_role("button", name=name).click()
        self.page.keyboard.press("Escape")

    def model(self, name, attribute):
        """One attribute of a Bokeh model, as the browser has it."""
        return self.page.evaluate("([n, a]) => Bokeh.documents[0].get_model_by_name(n)[a]", [name, attribute])

    def line(self, name):
        return self.page.locator(f".line.{name} > p").text_content()

    def source(self, name):
        """Columns of one data source as lists, once the page has it; not a number becomes None."""
        exists = "name => !!Bokeh.documents[0].get_model_by_name(name)"
        wait_until(lambda: self.page.evaluate(exists, name), what=f"the source {name}")
        return self.page.evaluate(SOURCE, name)

    def figure(self, name):
        """Ranges, labels and layout boxes of one figure, once it is drawn: those of a view come after it."""
        drawn = (
            "name => { const found = Bokeh.documents[0].get_model_by_name(name); "
            "return !!found && !!Bokeh.index.find_one_by_id(found.id)?.el; }"
        )
        wait_until(lambda: self.page.evaluate(drawn, name), what=f"the figure {name}")
        return self.page.evaluate(FIGURE, name)

    def count_messages(self):
        """Count what the server sends from now on; returns a function that gives the bytes so far."""
        self.page.evaluate("""() => {
          window.received = 0;
          for (const socket of window.sockets) socket.addEventListener("message",
            event => { window.received += event.data.size ?? event.data.byteLength ?? event.data.length; });
        }""")
        return lambda: self.page.evaluate("window.received")

    def keep_sent(self):
        """Keep what the page sends from now on, but that an update was painted; returns a function that gives it.

        What the server sends belongs to earlier moves, too, and comes later the slower the machine.
        """
        self.page.evaluate("window.sent.length = 0")
        return lambda: [text for text in self.page.evaluate(SENT) if '"painted"' not in text]

    def sources(self):
        return {name: self.source(name) for name in SOURCES}

    def zoom(self, name, x0, x1, y0, y1):
        """Drag a box in a figure, in shares of its frame from the top left, and wait until it is zoomed.

        It is dragged again if nothing comes of it: where the page is busy between two events of the mouse, Bokeh takes
        them for a long press.
        """
        before = self.ranges(name)

        def is_zoomed():
            box = self.figure(name)["frame"]
            self.page.mouse.move(box["x"] + x0 * box["width"], box["y"] + y0 * box["height"])
            self.page.mouse.down()
            self.page.mouse.move(box["x"] + x1 * box["width"], box["y"] + y1 * box["height"], steps=4)
            self.page.mouse.up()
            try:
                wait_until(lambda: self.ranges(name) != before, 5)
            except AssertionError:
                return False
            return True

        wait_until(is_zoomed, what=f"the zoom of {name}")

    def ranges(self, *figures):
        """Both ends of all axes of some figures; categories have none."""
        return [ends for ends in self.page.evaluate(RANGES, list(figures)) if None not in ends]

    def wait_for_zoom(self, figure):
        """Wait until the ends of all axes of a figure are in the address."""

        def is_in_address():
            zoom = self.address().get("zoom", "")
            known = [[float(end) for end in part.partition(":")[2].split(",")] for part in zoom.split(";") if part]
            return all(any(_almost_equal(ends, others) for others in known) for ends in self.ranges(figure))

        wait_until(is_in_address, what=f"the zoom of {figure} in the address")


def _almost_equal(ends, others):
    return all(math.isclose(one, other, rel_tol=2e-5, abs_tol=2e-4) for one, other in zip(ends, others, strict=True))


# What is open is closed, a motion that is held is held at its begin, and then the setting is that of the link.
AGAIN = """texts => {
  const walk = (root) => root.querySelectorAll("*").forEach((node) => {
    if (node.shadowRoot) walk(node.shadowRoot);
    if (node.open && node.matches("dialog")) node.close();
    if (node.open && node.matches("details")) node.open = false;
    if (node.matches(".player input") && Number(node.value)) {
      node.value = 0;
      node.dispatchEvent(new Event("input"));
    }
  });
  walk(document.body);
  scrollTo({ top: 0, behavior: "instant" });
  document.activeElement?.blur();
  const tell = (name, detail) => document.dispatchEvent(new CustomEvent(`vibroscope:${name}`, { detail }));
  tell("view", { value: "explore" });
  tell("reset", {});
  tell("set", texts);
}"""
# Contents of messages: a header and an object of metadata come before each, and parts of a picture may follow.
SENT = """() => window.sent.filter((part) => typeof part === "string" && part.includes('"events"'))"""
RANGES = """names => names.map(name => {
  const figure = Bokeh.documents[0].get_model_by_name(name);
  return [figure.x_range, figure.y_range, ...Object.values(figure.extra_y_ranges ?? {})].map(r => [r.start, r.end]);
}).flat()"""
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
    title: model.title.text.replaceAll("\\n", " "),
    labels: [...model.below, ...model.left, ...model.right].map(a => a.axis_label ?? ""),
    box: {x: box.x, y: box.y, width: box.width, height: box.height},
    frame: {x: canvas.x + frame.x0, y: canvas.y + frame.y0, width: frame.x1 - frame.x0, height: frame.y1 - frame.y0},
  };
}"""
