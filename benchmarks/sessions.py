"""Prints response times with 40 visitors who each move a slider every second, and memory after 1,000 visits.

The visitors use Bokeh's websocket protocol without a browser, so that the figures are the server's; they share the
machine with it. Each move is to a new setting: both models are solved and, a moment later, their difference is
explained. One visitor alone is measured before and after the forty.

The server is that of ``compose.yaml``, two replicas with half of the visitors each; for comparison all visit one
process, where a loop and solvers that share the interpreter's lock leave part of two cores idle.

.venv/bin/python benchmarks/sessions.py
"""

import asyncio
import functools
import itertools
import statistics
import time
import urllib.request
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from _pages import alive, explorer, free_port, wait_until

from tests.browserless import Client, mapped, move, plain

REPLICAS = 2
MANY, SECONDS = 40, 20
WARM, COMING, AT_ONCE = 200, 1000, 8
RATIO, GROWTH = 1.3, 10  # wanted: 95th percentile of the many against one's; kB a session


class Visitor:
    """A visitor who moves the slider of η by one step every second."""

    def __init__(self, url, number):
        self.client = Client(url)
        self.begin = 0.6 + (0.618 * number) % 1 * 3.0

    async def come(self):
        """Open the page."""
        await self.client.open()
        self.client.socket.protocol.set_nodelay(True)  # as browsers do
        await self.client.ready()
        await self.client.patch(self.client.message(mapped({"listens": True}), "ColumnSender"))
        controls = self.client.component("Controls")
        self.client.component = lambda _: controls  # else looked for in the whole document with each message
        return self

    async def move(self, number):
        """Seconds from a move to the message with its figures; then confirm that they are painted."""
        self.client.answers.clear()
        begun = time.perf_counter()
        setting = self.client.message(move({"eta": f"{self.begin + 0.0101 * number:.4f}"}, number))
        await self.client.send("PATCH-DOC", {"events": [setting]})
        while not brings_figures(await self.client.receive()):
            pass
        taken = time.perf_counter() - begun
        shown = await self.client.shown(lambda shown: shown.get("move") == number)
        painted = self.client.message(mapped({"painted": shown["update"]}))
        await self.client.send("PATCH-DOC", {"events": [painted]})
        return taken

    async def stay(self, phase):
        """Move once a second, at this phase of it."""
        begin = asyncio.get_running_loop().time() + phase
        taken = []
        for number in range(1, SECONDS + 1):
            await asyncio.sleep(begin + number - asyncio.get_running_loop().time())
            taken.append(await self.move(number))
        self.client.socket.close()
        return taken[2:]  # the first explains the page itself


def brings_figures(message):
    """Whether a message brings the columns that a move changes; curves over each number come later by themselves."""
    events = message["content"].get("events", [])
    sent = (plain(event["msg_data"]["values"])["data"] for event in events if event["kind"] == "MessageSent")
    return any(column == "v1" for data in sent for _, column, _ in data.get("names", ()))


async def together(servers, numbers):
    """Seconds of every move of so many visitors at once, and the servers' CPU time (s) of one."""
    ports = itertools.cycle(servers)
    visitors = [await Visitor(url_of(next(ports)), number).come() for number in numbers]
    begun = sum(map(cpu_seconds, servers.values()))
    stays = (visitor.stay(n / len(visitors)) for n, visitor in enumerate(visitors))
    taken = [seconds for stay in await asyncio.gather(*stays) for seconds in stay]
    return taken, (sum(map(cpu_seconds, servers.values())) - begun) / (len(visitors) * SECONDS)


async def come_and_go(url, count):
    """Make so many visits, a few at a time, each until its page is shown."""
    turn = asyncio.Semaphore(AT_ONCE)

    async def visit():
        async with turn, Client(url) as client:
            await client.ready()

    await asyncio.gather(*(visit() for _ in range(count)))


def url_of(port):
    """Where a server is."""
    return f"http://127.0.0.1:{port}"


def kilobytes(process):
    """The server's memory."""
    lines = Path(f"/proc/{process.pid}/status").read_text(encoding="ascii").splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmRSS")))


def cpu_seconds(process):
    """The server's CPU time in all its threads."""
    fields = Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100


def empty(port):
    """Whether all sessions have ended."""
    answer = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10).read().decode()
    return "vibroscope_sessions 0\n" in answer


def busy(servers):
    """Measure and print one visitor, many, and one again."""
    before, one = asyncio.run(together(servers, [MANY + 1]))
    many, each = asyncio.run(together(servers, range(MANY)))
    alone = before + asyncio.run(together(servers, [MANY + 2]))[0]
    where = f"{len(servers)} replicas" if len(servers) > 1 else "one process"
    print(f"\n{'a move every second each, ' + where:40}{'median':>10}{'p95':>10}{'worst':>10}   ms to figures")
    for name, taken in (("one visitor", alone), (f"{MANY} visitors", many)):
        figures = (statistics.median(taken), np.quantile(taken, 0.95), max(taken))
        print(f"{name:40}" + "".join(f"{1000 * figure:10.0f}" for figure in figures))
    ratio = np.quantile(many, 0.95) / np.quantile(alone, 0.95)
    wanted = f" (wanted ≤ {RATIO}×){'' if ratio <= RATIO else '  missed'}" if len(servers) == REPLICAS else ""
    print(f"95th percentile of {MANY} against one: {ratio:.2f}×{wanted}")
    print(f"the server's CPU time: {1000 * one:.0f} ms a move of one, {1000 * each:.0f} ms of {MANY}", flush=True)


def coming_and_going(port, process):
    """Measure and print memory before and after many visits."""
    kept = []
    for count in (WARM, COMING):
        begun = cpu_seconds(process)
        asyncio.run(come_and_go(url_of(port), count))
        cost = (cpu_seconds(process) - begun) / count
        wait_until(lambda: empty(port), "all sessions end", every=0.5)
        kept.append(kilobytes(process))
    growth = (kept[1] - kept[0]) / COMING
    print(f"\n{COMING} sessions opened and closed after {WARM} others: {kept[0] / 1000:.1f} → {kept[1] / 1000:.1f} MB")
    print(f"growth: {growth:.1f} kB a session (wanted ≤ {GROWTH}){'' if growth <= GROWTH else '  missed'}")
    print(f"the server's CPU time: {1000 * cost:.0f} ms a session")


@contextmanager
def serving(count):
    """Servers that have loaded their kernels: processes by port."""
    environment = {"VIBROSCOPE_SESSIONS": "10000", "VIBROSCOPE_THREADS": "2", "VIBROSCOPE_LOG_LEVEL": "error"}
    environment["VIBROSCOPE_PROXIED"] = "yes"  # so that some may come from another address
    with ExitStack() as stack:
        ports = [free_port() for _ in range(count)]
        servers = {port: stack.enter_context(explorer(port, environment=environment)) for port in ports}
        for port in servers:
            wait_until(functools.partial(alive, port), "the explorer answers")
            asyncio.run(come_and_go(url_of(port), 1))
        yield servers


def main():
    """Print both."""
    for count in (REPLICAS, 1):
        with serving(count) as servers:
            busy(servers)
            if count == 1:
                coming_and_going(*next(iter(servers.items())))


if __name__ == "__main__":
    main()
