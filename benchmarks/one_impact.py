"""Prints how fast the tab One impact answers: from a key on a slider to the text of the sentence that has changed.

Each key makes another contact: another K, or another η, with another step and other closing speeds of the reference.
Beside the time stands the CPU time that server and page take until then: on a machine with other work the answer waits
for its turn, since studies have a low priority.

.venv/bin/python benchmarks/one_impact.py
"""

import time
from pathlib import Path
from statistics import median

from _pages import Visit, alive, explorer, free_port, launch, wait_until
from playwright.sync_api import sync_playwright

KEYS, WARM_UP = 20, 3
PAUSE = 1.5  # s between two keys, in which the band and the table of the last one are under way
WANTED = 200.0  # ms
WATCH = """box => {
  probe.keys = [];
  probe.answers = [];
  let text = box.textContent;
  document.addEventListener("keydown", event => probe.keys.push(event.timeStamp), { capture: true });
  new MutationObserver(() => {
    const answer = box.querySelector("p")?.textContent;
    if (answer !== text) probe.answers.push([performance.now(), answer]);
    text = answer;
  }).observe(box, { childList: true, subtree: true });
}"""


def cpu_of(process):
    """CPU time (ms) of all threads of a process so far."""
    return sum(int(each.read_text().split()[0]) for each in Path(f"/proc/{process.pid}/task").glob("*/schedstat")) / 1e6


def answers(visit, slider, server):
    """Times (ms) from each key on a slider to the first sentence that is another one: passed, of server, of page."""
    handle, taken = visit.page.locator(slider), []
    for n in range(WARM_UP + KEYS):
        handle.focus()
        visit.ask("probe.keys.length = probe.answers.length = 0")
        used = cpu_of(server), visit.cpu()
        visit.page.keyboard.press("ArrowRight")
        visit.until("probe.answers.length > 0", seconds=20)
        pressed, (answered, _) = visit.ask("[probe.keys[0], probe.answers[0]]")
        if n >= WARM_UP:
            taken.append((answered - pressed, cpu_of(server) - used[0], visit.cpu() - used[1]))
        time.sleep(PAUSE)
    return taken


def main():
    """Print the median of all keys, and the slowest."""
    with sync_playwright() as playwright:
        port, browser = free_port(), launch(playwright)
        with explorer(port) as server:
            wait_until(lambda: alive(port), "the explorer answers")
            visit = Visit(browser, port, "#vibroscope-eta-slider")
            visit.page.get_by_role("tab", name="One impact").click()
            box = visit.page.locator("section.study .statements").locator("visible=true")
            box.get_by_text("You asked for").wait_for(timeout=240_000)
            box.evaluate(WATCH)
            for name in ("K", "eta"):
                passed, served, shown = zip(*answers(visit, f"#vibroscope-{name}-slider", server), strict=True)
                print(
                    f"{name}: a key is answered in {median(passed):.0f} ms, at most {max(passed):.0f} ms, of {KEYS} "
                    f"(wanted: {WANTED:.0f} ms); CPU {median(served):.0f} ms of the server, {median(shown):.0f} ms of "
                    "the page"
                )
        browser.close()


if __name__ == "__main__":
    main()
