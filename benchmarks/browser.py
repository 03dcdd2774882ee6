"""Prints how fast the page follows its user, beside a bare Bokeh page that shows the same data, in one run.

A key press is timed from the keyboard event to the end of the frame in which the last of four figures painted the new
state. For each the explorer solves both models over 2,050 periods, while the bare page has its data ready. Both pages
take turns, ten keys each, so that other load affects both. The pendulums swing, and the pages draw without a GPU.

.venv/bin/python benchmarks/browser.py
"""

import json
import time
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

import numpy as np
from _pages import FIGURES, VIEWPORT, Visit, alive, explorer, free_port, launch, script, wait_until
from playwright.sync_api import sync_playwright

ROUNDS, KEYS, WARM_UP = 10, 10, 3
PAUSE = 0.35  # s between two keys, in which the last one is explained
DRAG_SECONDS, DRAG_RATE = 3.0, 30  # mouse moves a second
CURSOR_MOVES = 90
VISITS, REST = 5, 6.0  # s without visitors before a first visit
ETA = (0.5, 4.0)  # what both sliders cover
DRAG = (1.2, 2.4)
THUMB = 16  # pixels of a native slider's handle
EXPLORER, BARE = "#vibroscope-eta-slider", ".noUi-handle"
BOXES = """names => Object.fromEntries(names.map(name => {
  const box = Bokeh.index.find_one_by_id(probe.model(name).id).el.getBoundingClientRect();
  return [name, [Math.round(box.width), Math.round(box.height)]];
}))"""


@contextmanager
def turn(page, ours):
    """Stop the pendulums during the bare page's turn, which must not share the machine with them."""
    toggle = "document.dispatchEvent(new CustomEvent('vibroscope:play'))" if page is not ours else "0"
    ours.ask(toggle)
    yield
    ours.ask(toggle)


# ---- what a visitor does --------------------------------------------------------------------------------------------


class Key(NamedTuple):
    """Time (ms) and traffic (kB) of one key press."""

    latency: float  # from the key to the paint
    arrival: float  # its part until the last byte arrived
    cpu: float  # of the page's main thread
    update: float  # kB up to the paint
    whole: float  # kB up to the next key: the explanation is among them


def press(visit, count):
    """Press the key so often; returns a `Key` for each."""
    visit.watch("eta")
    visit.handle.focus()
    keys = []
    for n in range(1, count + 1):
        visit.ask("probe.messages = []; 0")
        cpu = visit.cpu()
        visit.page.keyboard.press("ArrowRight")
        visit.ask(f"probe.until({n})")
        pressed, shown = visit.ask("[probe.inputs.findLast(i => i.type === 'keydown').at, probe.painted.at(-1).at]")
        cpu = visit.cpu() - cpu
        time.sleep(PAUSE)
        messages = visit.ask("probe.messages")
        update = [message for message in messages if message["at"] <= shown]
        sizes = [sum(message["bytes"] for message in some) / 1000 for some in (update, messages)]
        # Bokeh acknowledges the move in a short message of its own, before or after the figures.
        came = max(message["at"] for message in update if message["bytes"] > 500)
        keys.append(Key(shown - pressed, came - pressed, cpu, *sizes))
    return keys


def drag(visit):
    """Painted states a second, stale states painted after the mouse stopped, and the lag of the last (ms)."""
    _back(visit)
    visit.watch("eta")
    grip = visit.handle.bounding_box()
    if grip["width"] > 2 * THUMB:  # a native slider is one box, its handle a part of it
        left, span, height = grip["x"] + THUMB / 2, grip["width"] - THUMB, grip["height"]
    else:
        track = visit.page.locator(".noUi-base").bounding_box()
        left, span, height = track["x"], track["width"], grip["height"]
    place = [left + span * (eta - ETA[0]) / (ETA[1] - ETA[0]) for eta in DRAG]
    y, mouse = grip["y"] + height / 2, visit.page.mouse
    mouse.move(place[0], y)
    mouse.down()
    visit.ask("probe.inputs = []; probe.painted = []; 0")
    moves, begin = int(DRAG_SECONDS * DRAG_RATE), time.perf_counter()
    for n in range(1, moves + 1):
        mouse.move(place[0] + (place[1] - place[0]) * n / moves, y)
        time.sleep(max(0.0, begin + n / DRAG_RATE - time.perf_counter()))
    time.sleep(2.5)
    mouse.up()
    first, last = visit.ask("probe.inputs.filter(i => i.type === 'pointermove').map(i => i.at)")[:: moves - 1]
    painted = [state["at"] for state in visit.ask("probe.painted")]
    during = sum(at <= last for at in painted)
    return 1000 * during / (last - first), max(0, len(painted) - during - 1), max(0.0, painted[-1] - last)


def _back(visit):
    """Move the slider by keys to where the drag begins."""
    visit.watch("eta")
    visit.handle.focus()
    visit.page.keyboard.press("Home")
    time.sleep(1.5)
    for _ in range(round((DRAG[0] - ETA[0]) / 0.01)):
        visit.page.keyboard.press("ArrowRight")
    time.sleep(2.5)


def point(visit, count):
    """Latencies (ms) of the line at the pointer, in all figures, and the CPU time (ms) of a move."""
    visit.page.bring_to_front()
    visit.ask("probe.watchLine()")
    box = visit.ask("""(() => {
      const view = Bokeh.index.find_one_by_id(probe.model("displacement").id);
      const canvas = view.canvas_view.el.getBoundingClientRect(), { x0, x1, y0, y1 } = view.frame.bbox;
      return [canvas.x + x0, canvas.x + x1, canvas.y + (y0 + y1) / 2];
    })()""")
    visit.page.mouse.move(box[0] + 5, box[2])
    time.sleep(0.5)
    visit.ask("probe.painted = []; 0")
    latencies, cpu = [], visit.cpu()
    for n in range(1, count + 1):
        visit.page.mouse.move(box[0] + 5 + (box[1] - box[0] - 10) * n / count, box[2])
        visit.ask(f"probe.until({n})")
        moved, shown = visit.ask("[probe.inputs.findLast(i => i.type === 'pointermove').at, probe.painted.at(-1).at]")
        latencies.append(shown - moved)
        time.sleep(0.03)
    cpu = (visit.cpu() - cpu) / count
    visit.page.mouse.move(5, 5)
    return latencies, cpu


def arrive(browser, port, handle):
    """Seconds to the first figure, for a browser without and with the page in its cache."""
    visit = Visit(browser, port, handle)
    first = visit.ask("probe.first") / 1000
    visit.page.reload()
    visit.until("probe.first > 0")
    again = visit.ask("probe.first") / 1000
    visit.close()
    return first, again


# ---- the run --------------------------------------------------------------------------------------------------------


class Table:
    """The printed table: measured figures and their targets."""

    def __init__(self):
        self.missed = 0

    def head(self, text):
        """Print the head of a section."""
        print(f"\n{text}\n{'':44}{'explorer':>10}{'bare':>10}{'wanted':>16}", flush=True)

    def row(self, name, value, bare=None, most=None, least=None, ratio=None, digits=0):
        """Print one figure; ``most`` and ``least`` bound it, ``ratio`` bounds it relative to the bare page's."""
        met = (most is None or value <= most) and (least is None or value >= least)
        met = met and (ratio is None or value <= ratio * bare)
        self.missed += not met
        wanted = f"≤ {most:g}" if most is not None else f"≥ {least:g}" if least is not None else ""
        if ratio is not None:
            wanted = f"≤ {ratio:g}× is {value / bare:.2f}×"
        beside = "" if bare is None else f"{bare:.{digits}f}"
        print(f"{name:44}{value:10.{digits}f}{beside:>10}{wanted:>16}{'' if met else '  missed'}", flush=True)


def in_turns(ours, bare, rounds):
    """Press all keys in turns; returns a function from a quantity's name to its values, by page."""
    keys = {ours: [], bare: []}
    for number in range(rounds + 1):
        for page, found in keys.items():
            with turn(page, ours):
                found += press(page, KEYS if number else WARM_UP)
    return lambda name: [np.array([getattr(key, name) for key in found[WARM_UP:]]) for found in keys.values()]


def dragged(ours, bare):
    """The figures of `drag`, a pair for each quantity."""
    found = []
    for page in (ours, bare):
        with turn(page, ours):
            found.append(drag(page))
    return list(zip(*found, strict=True))


def arriving(table, browser, port, bare_port):
    """Print the time to the first figure; the first scene is solved, and the server has prepared a session."""
    table.head(f"First figure after the page is asked for, kernels warm, {VISITS} visits")
    visits = np.empty((VISITS, 2, 2))  # visit, page, again
    for visit in visits:
        time.sleep(REST)
        visit[:] = [arrive(browser, *place) for place in ((port, EXPLORER), (bare_port, BARE))]
    table.row("first visit, median, s", *np.median(visits[:, :, 0], axis=0), most=2, digits=2)
    table.row("first visit, worst, s", *np.max(visits[:, :, 0], axis=0), digits=2)
    table.row("loaded again at once, median, s", *np.median(visits[:, :, 1], axis=0), digits=2)


def on_the_spot(table, ours, bare):
    """Print the figures without a line between server and browser."""
    table.head(f"Key press to paint, {ROUNDS * KEYS} keys each")
    keys = in_turns(ours, bare, ROUNDS)
    table.row("median, ms", *(np.median(page) for page in keys("latency")), ratio=1.3)
    table.row("95th percentile, ms", *(np.quantile(page, 0.95) for page in keys("latency")), ratio=1.6)
    table.row("of the median until the last byte came, ms", *(np.median(page) for page in keys("arrival")))
    table.row("CPU of the page's main thread, mean, ms", *(np.mean(page) for page in keys("cpu")))
    table.row("kB an update, mean", *(np.mean(page) for page in keys("update")), most=50, digits=1)
    table.row("kB an update, largest", *(np.max(page) for page in keys("update")), digits=1)
    table.row("kB with the explanation that follows, mean", *(np.mean(page) for page in keys("whole")), digits=1)
    table.head(f"Drag of {DRAG_SECONDS:g} s, {DRAG_RATE} moves a second")
    drags = dragged(ours, bare)
    table.row("painted states a second", *drags[0], least=15, digits=1)
    table.row("stale states after the mouse stopped", *drags[1], most=1)
    table.row("lag after the mouse stopped, ms", *drags[2])
    table.head("Line at the pointer, in five figures")
    cursor, cpu = point(ours, CURSOR_MOVES)
    table.row("median, ms", np.median(cursor))
    table.row("95th percentile, ms", np.quantile(cursor, 0.95), most=20)
    table.row("CPU of the page's main thread, mean, ms", cpu)


def far_away(table, ours, bare):
    """Print the figures over the emulated line."""
    table.head("25 ms each way, 20 Mbit/s")
    keys = in_turns(ours, bare, 3)
    table.row("key press to paint, median, ms", *(np.median(page) for page in keys("latency")), most=160)
    table.row("95th percentile, ms", *(np.quantile(page, 0.95) for page in keys("latency")))
    drags = dragged(ours, bare)
    table.row("painted states a second", *drags[0], digits=1)
    table.row("lag after a drag of 3 s, ms", *drags[2], most=200)


def slowly(table, browser, port):
    """Print when a first visit over a slow line can be read, and when it has its first figure."""
    table.head("First visit at 75 ms each way, 1.6 Mbit/s")
    visit = Visit(browser, port, EXPLORER)
    readable = "performance.getEntriesByName('first-contentful-paint')[0].startTime / 1000"
    table.row("something to read, s", visit.ask(readable), most=1, digits=2)
    table.row("first figure, s", visit.ask("probe.first / 1000"), most=8, digits=2)
    visit.close()


def main():
    """Print every figure beside its target."""
    table = Table()
    with ExitStack() as stack:
        playwright = stack.enter_context(sync_playwright())
        browser = launch(playwright)
        stack.callback(browser.close)
        port, far, slow, bare_port, bare_far = (free_port() for _ in range(5))
        stack.enter_context(explorer(port, far, slow))
        wait_until(lambda: alive(port), "the explorer answers")
        ours = Visit(browser, port, EXPLORER)
        sizes = ours.page.evaluate(BOXES, [*FIGURES, "strip", "diagram"])
        slider = ours.handle.bounding_box()
        sizes["slider"] = [round(slider["width"]), round(slider["height"])]
        origins = ",".join(f"127.0.0.1:{p}" for p in (bare_port, bare_far))
        stack.enter_context(script("_bare_page.py", bare_port, origins, json.dumps(sizes)))
        ours.close()
        arriving(table, browser, port, bare_port)
        ours = Visit(browser, port, EXPLORER)
        on_the_spot(table, ours, Visit(browser, bare_port, BARE))
        ours.close()
        for here, there in ((far, port), (bare_far, bare_port)):
            stack.enter_context(script("_wan_proxy.py", here, there))
        far_away(table, Visit(browser, far, EXPLORER), Visit(browser, bare_far, BARE))
        stack.enter_context(script("_wan_proxy.py", slow, port, 75, 1.6))
        slowly(table, browser, slow)
    print(f"\n{table.missed or 'no'} target{'s' * (table.missed != 1)} missed; window {VIEWPORT}")


if __name__ == "__main__":
    main()
