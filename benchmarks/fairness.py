"""Prints how long a visitor waits beside others who ask for much: moves beside busy sliders, a plane beside studies.

The busy ones move to a costly setting (32,000 located steps per period) three times a second, or keep a study under
way. Then one abuser keeps the server's loop busy: with large files, pings, or by opening sessions. He has a process of
his own, so that the visitor's clock does not measure what his messages cost to write. All use Bokeh's websocket
protocol without a browser and share the machine with the server.

.venv/bin/python benchmarks/fairness.py
"""

import asyncio
import contextlib
import itertools
import subprocess
import sys
import time

import numpy as np
from sessions import Visitor, serving, url_of
from tornado.iostream import StreamClosedError
from tornado.websocket import WebSocketClosedError

from tests.browserless import Client, mapped, move, plain

BUSY, MOVES, EVERY = 8, 20, 1 / 3
SLOWER, WORST, PICTURE = 10, 1.0, 5.0  # wanted: p95 against alone; s of a move at most; s to a first picture
ABUSED = 3  # wanted: p95 of moves beside one abuser of the loop against alone
OTHER = {"X-Forwarded-For": "192.0.2.1"}  # the abuser's address


async def keep_moving(url, number):
    """Move to another costly setting three times a second, until cancelled."""
    async with Client(url) as client:
        await client.ready()
        reading = asyncio.ensure_future(read(client))
        try:
            for count in itertools.count(1):
                texts = {"eta": f"{1.0 + 0.2 * number + 0.0007 * count:.4f}", "steps": "32000", "located": "yes"}
                await client.send("PATCH-DOC", {"events": [client.message(move(texts, count))]})
                await asyncio.sleep(EVERY)
        finally:
            reading.cancel()


async def read(client):
    """Take what the server sends."""
    while await client.receive() is not None:
        client.answers.clear()


async def moves(url, number):
    """Seconds of each of a visitor's moves, once a second."""
    visitor = await Visitor(url, number).come()
    taken = []
    for count in range(1, MOVES + 3):
        taken.append(await visitor.move(count))
        await asyncio.sleep(max(0.0, 1 - taken[-1]))
    visitor.client.socket.close()
    return taken[2:]  # the first explains the page itself


STUDIES = {
    "planes": "view=plane",
    "searches for branches": "view=bifurcation&choice=branches:on",
    "searches for curves": "view=plane&choice=curves:on",
    "basins": "view=basin",
    "codes": "view=code",
}


async def grow(url, number, query, pictures=None):
    """Open a study of its own and keep it under way; seconds to the first picture go to ``pictures``."""
    begun = time.perf_counter()
    async with Client(url, f"{query}&eta={1.5 + 0.01 * number:.4f}") as client:
        await client.ready()
        while (message := await client.receive()) is not None:
            client.answers.clear()
            changes = message["content"].get("events", []) if isinstance(message["content"], dict) else []
            shares = [plain(each["new"]).get("share", 0) for each in changes if each.get("attr") == "status"]
            if any(share > 0 for share in shares) and pictures is not None and not pictures.done():
                pictures.set_result(time.perf_counter() - begun)


async def again(abuse):
    """Abuse once more whenever the server has ended it."""
    while True:
        with contextlib.suppress(OSError, TypeError, StreamClosedError, WebSocketClosedError):
            await abuse()


async def upload(url):
    """Load a file of 64 kB sixty times a second."""
    parts = {str(number): "#" + "x" * 3999 for number in range(16)}
    async with Client(url, headers=OTHER) as client:
        file = client.message(mapped({"load": mapped(parts)}), "Header")
        reading = asyncio.ensure_future(read(client))
        try:
            while not reading.done():
                await client.send("PATCH-DOC", {"events": [file]})
                await asyncio.sleep(1 / 60)
        finally:
            reading.cancel()


async def ping(url):
    """Send pings without pause."""
    async with Client(url, headers=OTHER) as client:
        while True:
            for _ in range(100):
                client.socket.ping()
            await asyncio.sleep(0.001)


async def come(url, pause):
    """Open a session, and the next one after a pause, whether that one has opened or not."""
    tasks = set()
    try:
        while True:
            tasks.add(asyncio.ensure_future(visit(url)))
            while pause is None and len(tasks) == BUSY:
                _, tasks = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            await asyncio.sleep(pause or 0)
    finally:
        for task in tasks:
            task.cancel()


async def visit(url):
    """Open a session and leave."""
    with contextlib.suppress(OSError, TypeError, StreamClosedError, WebSocketClosedError):
        async with Client(url, headers=OTHER):
            pass


async def opened(url):
    """Seconds until a page is open."""
    begun = time.perf_counter()
    async with Client(url, "eta=1.9"):
        return time.perf_counter() - begun


ABUSES = {
    "64 kB files at 60/s": lambda url: again(lambda: upload(url)),
    "pings": lambda url: again(lambda: ping(url)),
    "2 openings a second": lambda url: come(url, 0.5),
    "openings without pause": lambda url: come(url, None),
}


async def abused(url, alone):
    """Print a visitor's moves, and how long a page takes to open, beside each abuser of the loop."""
    print(f"\n{'a move':40}{'median':>10}{'p95':>10}{'worst':>10}{'a page':>10}   ms")
    for number, name in enumerate(ABUSES, 92):
        async with apart(name, url):
            taken = await moves(url, number)
            page = await opened(url)
        figures = (np.median(taken), np.quantile(taken, 0.95), max(taken), page)
        missed = "" if figures[1] <= ABUSED * np.quantile(alone, 0.95) else f"  missed: p95 ≤ {ABUSED}× alone"
        print(f"beside {name:33}" + "".join(f"{1000 * figure:10.0f}" for figure in figures) + missed, flush=True)


@contextlib.asynccontextmanager
async def beside(jobs):
    """These jobs under way."""
    tasks = [asyncio.ensure_future(job) for job in jobs]
    await asyncio.sleep(5 if tasks else 0)
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


@contextlib.asynccontextmanager
async def apart(name, url):
    """An abuser in a process of his own."""
    abuser = subprocess.Popen([sys.executable, __file__, name, url])
    try:
        await asyncio.sleep(5)
        yield
    finally:
        abuser.terminate()
        abuser.wait()


async def first_picture(url, number):
    """Seconds until a visitor sees the first picture of a plane."""
    seen = asyncio.get_running_loop().create_future()
    growing = asyncio.ensure_future(grow(url, number, STUDIES["planes"], seen))
    try:
        return await asyncio.wait_for(seen, 500)
    finally:
        growing.cancel()
        await asyncio.gather(growing, return_exceptions=True)


async def measure(url):
    """Print both."""
    alone = await moves(url, 90)
    async with beside(keep_moving(url, number) for number in range(BUSY)):
        many = await moves(url, 91)
    print(f"\n{'a move':40}{'median':>10}{'p95':>10}{'worst':>10}   ms to figures")
    for name, taken in (("alone", alone), (f"beside {BUSY} busy sliders", many)):
        figures = (np.median(taken), np.quantile(taken, 0.95), max(taken))
        print(f"{name:40}" + "".join(f"{1000 * figure:10.0f}" for figure in figures))
    ratio = np.quantile(many, 0.95) / np.quantile(alone, 0.95)
    missed = "" if ratio <= SLOWER and max(many) <= WORST else "  missed"
    print(f"95th percentile against alone: {ratio:.2f}× (wanted ≤ {SLOWER}×, worst ≤ {WORST:g} s){missed}", flush=True)
    await abused(url, alone)
    await beside_studies(url)


async def beside_studies(url):
    """Print how long a plane takes to its first picture beside studies of each kind."""
    one = await first_picture(url, 0)
    print(f"\nfirst picture of a plane: alone {one:.1f} s (wanted ≤ {PICTURE:g} s, beside others too)", flush=True)
    for row, (name, query) in enumerate(STUDIES.items(), 1):
        numbers = range(row * (BUSY + 1), (row + 1) * (BUSY + 1))
        async with beside(grow(url, number, query) for number in numbers[1:]):
            crowd = await first_picture(url, numbers[0])
        print(f"beside {BUSY} {name}: {crowd:.1f} s{'' if crowd <= PICTURE else '  missed'}", flush=True)


async def abuse(name, url):
    """Be an abuser for as long as the longest measurement may take."""
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(ABUSES[name](url), 180)


def main():
    """Measure one server, or abuse it: ``fairness.py NAME ADDRESS`` is what the measurement calls itself with."""
    if len(sys.argv) == 3:
        asyncio.run(abuse(*sys.argv[1:]))
        return
    with serving(1) as servers:
        asyncio.run(measure(url_of(next(iter(servers)))))


if __name__ == "__main__":
    main()
