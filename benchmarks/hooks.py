"""What each hook into Panel, Bokeh and their scripts saves: the explorer beside itself without that hook.

Two servers run at the same time and take turns, so that what else the machine does meets both. For a hook of the server
(`app.compat` and what uses it) visitors move a slider every second, and the measure is the time of the event loop's
thread per move; ``defaults`` concerns what ended sessions leave, and there it is per visit, collections included. For a
hook of the page (``compat.js``) the measure is the time of the page's main thread per key press, per move of the
pointer or per opening, and the time from the key to the paint. Each line gives with, without, and their ratio.

.venv/bin/python benchmarks/hooks.py [NAME …]
"""

import asyncio
import functools
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from _pages import Visit, alive, free_port, launch, running, wait_until
from browser import EXPLORER, point, press
from playwright.sync_api import sync_playwright
from sessions import Visitor, come_and_go, empty, url_of

ROUNDS = 2
VISITORS, MOVES = 10, 12  # of each server, one move a second
VISITS, AT_ONCE, COLLECTED = 64, 8, 5.0  # of each server; s after the last session until garbage has been collected
KEYS, POINTS, OPENINGS = 10, 60, 5
# How a server leaves one hook out, by Python that runs before anything is served.
COMPONENT = "from vibroscope.app.compat import FastUpdates; del FastUpdates."
SERVER_HOOKS = {
    "events": f"{COMPONENT}_process_bokeh_event",
    "updates": f"{COMPONENT}_update_model",
    "claimed": "from vibroscope.app.server import building; building.claim_document = id",
    "design": "from vibroscope.app.page.shared import component; del component._CachedDesign.params",
    "sent": "from vibroscope.app.server.protocol import PatchMessage; del PatchMessage.create",
    "received": "from vibroscope.app.server.protocol import PatchMessage; del PatchMessage.apply_to_document",
    "columns": "from vibroscope.app.page.explore import column_sender as sender; "
    "sender.ColumnSender.put = lambda _, *columns: sender.write(*columns)",
}
VISIT_HOOKS = {"defaults": "from vibroscope.app.server import building; building.forget_empty_defaults = id"}
PAGE_HOOKS = ("colours", "sheets", "positions", "glyphs", "legends", "tooltips")
OPENING_HOOKS = ("figures", "resizes")
PAGE_HOOK = """
from vibroscope.app.server.static_files import Module
whole = Module.whole
Module.whole = lambda path: whole(path).replace(b'hook("{name}",', b'((...unused) => 0)("{name}",')
"""
SERVE = """
from vibroscope.app.runtime.settings import Settings
from vibroscope.app.server.server import serve
serve(Settings(port={port}, sessions=1000, threads=2, log_level="error"))
"""


@contextmanager
def servers(without):
    """Two explorers, the second without a hook: processes by port."""
    with ExitStack() as stack:
        found = {}
        for change in ("", without):
            port = free_port()
            code = change + SERVE.format(port=port)
            found[port] = stack.enter_context(running(port, sys.executable, "-c", code))
        for port in found:
            wait_until(functools.partial(alive, port), "the explorer answers")
        yield found


def report(name, what, with_hook, without):
    """Print one line."""
    print(f"{name:12}{what:34}{with_hook:8.1f}{without:8.1f}{without / with_hook:8.2f}×", flush=True)


# ---- hooks of the server --------------------------------------------------------------------------------------------


def loop_milliseconds(process):
    """Time of the event loop's thread so far, which is the process's first."""
    return int(Path(f"/proc/{process.pid}/task/{process.pid}/schedstat").read_text().split()[0]) / 1e6


async def moves(ports):
    """Seconds of every move, by port; the visitors of both servers move in turns."""
    visitors = [await Visitor(url_of(port), n).come() for n in range(VISITORS) for port in ports]
    begin = asyncio.get_running_loop().time()

    async def stay(number, visitor):
        taken = []
        for move in range(1, MOVES + 1):
            phase = move + number / len(visitors)
            await asyncio.sleep(begin + phase - asyncio.get_running_loop().time())
            taken.append(await visitor.move(move))
        visitor.client.socket.close()
        return taken[2:]  # the first explains the page itself

    taken = await asyncio.gather(*(stay(number, visitor) for number, visitor in enumerate(visitors)))
    return [[seconds for stay in taken[which::2] for seconds in stay] for which in (0, 1)]


def loop(name):
    """Compare the time of the event loop."""
    used, taken = np.zeros(2), [[], []]
    for _ in range(ROUNDS):
        with servers(SERVER_HOOKS[name]) as found:
            before = np.array([loop_milliseconds(process) for process in found.values()])
            for which, seconds in enumerate(asyncio.run(moves(list(found)))):
                taken[which] += seconds
            used += np.array([loop_milliseconds(process) for process in found.values()]) - before
    report(name, "event loop, ms a move", *(used / (ROUNDS * VISITORS * MOVES)))
    report(name, "move to figures, median, ms", *(1000 * np.median(seconds) for seconds in taken))


def visits(name):
    """Compare the time of the event loop for visits that end at once, until what they left has been collected."""
    with servers(VISIT_HOOKS[name]) as found:
        before = [loop_milliseconds(process) for process in found.values()]
        for _ in range(VISITS // AT_ONCE):
            for port in found:
                asyncio.run(come_and_go(url_of(port), AT_ONCE))
        for port in found:
            wait_until(functools.partial(empty, port), "all sessions end", every=0.5)
        time.sleep(COLLECTED)
        used = np.array([loop_milliseconds(process) for process in found.values()]) - before
    report(name, "event loop, ms a visit", *(used / VISITS))


# ---- hooks of the page ----------------------------------------------------------------------------------------------


def paint(name, browser):
    """Compare the time of the page's main thread."""
    with servers(PAGE_HOOK.format(name=name)) as found:
        visits = [Visit(browser, port, EXPLORER) for port in found]
        for visit in visits:
            visit.ask("document.dispatchEvent(new CustomEvent('vibroscope:play')), 0")  # the pendulums stand still
        if name == "tooltips":
            cpu = [[point(visit, POINTS)[1] for visit in visits] for _ in range(ROUNDS)]
            report(name, "main thread, ms a pointer move", *np.mean(cpu, axis=0))
        else:
            keys = [[], []]
            for number in range(2 * ROUNDS + 1):
                for visit, its_keys in zip(visits, keys, strict=True):
                    pressed = press(visit, KEYS)
                    its_keys.extend(pressed if number else [])
            report(name, "main thread, median, ms a key", *(np.median([key.cpu for key in some]) for some in keys))
            report(name, "key to paint, median, ms", *(np.median([key.latency for key in some]) for some in keys))
        for visit in visits:
            visit.close()


def opening(name, browser):
    """Compare the time of the page's main thread until the page is open."""
    with servers(PAGE_HOOK.format(name=name)) as found:
        cpu = [[], []]
        for _ in range(OPENINGS):
            for port, its_cpu in zip(found, cpu, strict=True):
                visit = Visit(browser, port, EXPLORER)
                its_cpu.append(visit.cpu())
                visit.close()
    report(name, "main thread, median, ms an opening", *map(np.median, cpu))


def main(names):
    """Measure the named hooks, or all."""
    print(f"{'hook':12}{'':34}{'with':>8}{'without':>8}{'ratio':>9}")
    for name in SERVER_HOOKS:
        if not names or name in names:
            loop(name)
    for name in VISIT_HOOKS:
        if not names or name in names:
            visits(name)
    if names and not {*names} & {*PAGE_HOOKS, *OPENING_HOOKS}:
        return
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for name in PAGE_HOOKS:
            if not names or name in names:
                paint(name, browser)
        for name in OPENING_HOOKS:
            if not names or name in names:
                opening(name, browser)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
