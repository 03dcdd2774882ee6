"""Visitors of one server who use everything, and what it holds while nobody is there."""

import asyncio
import itertools
import json
import math
import os
import time
from collections import Counter
from pathlib import Path

from tornado.httpclient import HTTPClientError
from vibroscope.app.page.tabs import VIEWS

from tests.browserless import Client, mapped, move, plain

AT_ONCE = 40  # visitors
QUARTERS = 4
THINKING = 60.0  # s between the tabs of a visitor, so that all of them together keep half a core busy
GLANCE, STAY = 0.3, 3.0  # s on a tab: a study has begun, and the next tab cancels it; it has shown something
PATIENCE = 120  # s for an answer where 40 visitors share two cores
FREED = 12.0  # s after the last session: memory is freed, and a session prewarmed
TAKEN = ("json", "report", "python", "command", "toml")
# What a visitor asks for on the tab Explore: the component, the message that asks, and the one that ends it.
ASKED = {
    "suggestion": ("SuggestPanel", {"suggest": mapped({"tolerance": "20"})}, {"cancel": True}),
    "coexisting": ("CoexistingPanel", {"find": True}, {"close": True}),
    "fit": ("MeasurementPanel", {"fit": "restitution"}, {"remove": True}),
}
LONGEST = 4000  # characters of a text in a message
MEASURED = "2.76"  # η of the measurement
MEASUREMENT = Path(__file__).parents[2] / "assets" / "example-measurement.csv"


def _given(message):
    """Return the exported files in a message."""
    for change in message["content"].get("events", []) if message["msgtype"] == "PATCH-DOC" else []:
        if change.get("msg_type") == "bokeh_event" and change["msg_data"]["name"] == "esm_event":
            data = dict(change["msg_data"]["values"]["entries"])["data"]
            if "give" in plain(data):
                yield plain(data)


class Soak:
    """Visitors of one server, quarter by quarter.

    Attributes
    ----------
    thinking : float
        Seconds that a visitor looks at the tab Explore before the next tab.
    idle : list of dict
        What the server holds while nobody is there: after one visit, then after each quarter.
    peaks : list of float
        Most memory (MB) in each quarter.
    busy : list of float
        Cores that the server kept busy in each quarter.
    visits, turned_away : int
    files : Counter
        Files exported, by their kind; ``loaded``, ``measurement``, and what was ASKED for and begun.
    """

    def __init__(self, server, thinking=0.0):
        self.server, self.thinking = server, thinking
        self.idle, self.peaks, self.busy = [], [], []
        self.visits = self.turned_away = 0
        self.files = Counter()

    async def visit(self, number, end=math.inf, stay=GLANCE):
        """Open a session, move and export on every tab, ask for what there is, load an exported file, and leave.

        Visits begin on different tabs, and end early at the time ``end``.
        """
        keys, turns = [*VIEWS], itertools.count(number * len(VIEWS))
        async with Client(self.server.url) as client:
            client.patience = PATIENCE
            await client.ready()
            await client.patch(client.message(mapped({"listens": True}), "ColumnSender"))
            for turn, place in zip(turns, range(number, number + len(keys)), strict=False):
                if time.monotonic() > end:
                    break
                await client.patch(client.message(move({"eta": f"{0.6 + turn % 3000 / 1000:.3f}"}, turn)))
                await self._look(client, keys[place % len(keys)], turn, stay)
                await self._think(client, turn)
            await client.set(next(turns), eta=MEASURED)
            await client.patch(client.message(mapped({"view": "explore", "move": next(turns)}), "Header"))
            await self._ask(client, stay)
            await self._load_exported(client, next(turns))
        self.visits += 1

    async def _look(self, client, key, turn, stay):
        """Open a tab and export what it shows."""
        await client.patch(client.message(mapped({"view": key, "move": turn}), "Header"))
        await asyncio.sleep(stay)
        await client.patch(client.message(mapped({"take": TAKEN[turn % len(TAKEN)]}), "Header"))
        await asyncio.sleep(GLANCE)

    async def _think(self, client, turn):
        if self.thinking:
            await client.patch(client.message(mapped({"view": "explore", "move": turn}), "Header"))
            await asyncio.sleep(self.thinking)

    async def _ask(self, client, stay):
        """Upload a measurement, and begin and end each search of the tab Explore."""
        text = MEASUREMENT.read_text()
        name = mapped({"name": MEASUREMENT.name, "size": len(text)})
        parts = mapped({str(begin): text[begin : begin + LONGEST] for begin in range(0, len(text), LONGEST)})
        for part in ({"file": name}, {"part": parts}, {"end": True}):
            await client.patch(client.message(mapped(part), "MeasurementButton"))
        await asyncio.sleep(stay)
        for what, (component, begin, stop) in ASKED.items():
            await client.patch(client.message(mapped(begin), component))
            await asyncio.sleep(stay)
            await client.patch(client.message(mapped(stop), component))
            self.files[what] += _has_said(client, component, "running")
        self.files["measurement"] += _has_said(client, "MeasurementPanel", MEASUREMENT.name)

    async def _load_exported(self, client, number):
        given = [file for message in client.answers for file in _given(message)]
        self.files.update(file["give"] for file in given)
        client.answers.clear()
        if text := next((file["text"] for file in given if file["give"] == "toml"), ""):
            file = mapped({"name": "a.toml", "size": len(text)})
            for message in ({"file": file}, {"part": mapped({"0": text})}, {"end": True, "move": number}):
                await client.patch(client.message(mapped(message), "Header"))
            await client.shown(lambda shown: shown["texts"]["eta"] != MEASURED)
            self.files["loaded"] += 1

    async def come_and_go(self, numbers, end, late):
        """Visit again and again until this time, the first time ``late`` s after the others."""
        await asyncio.sleep(late)
        number = next(numbers)
        while time.monotonic() < end:
            try:
                await self.visit(number, end)
            except (ConnectionError, HTTPClientError):  # turned away, as a browser is that then asks again
                self.turned_away += 1
                await asyncio.sleep(1)
            else:
                number = next(numbers)

    async def watch(self):
        """Keep the most memory of this quarter."""
        self.peaks.append(0.0)
        while True:
            self.peaks[-1] = max(self.peaks[-1], self.server.memory())
            await asyncio.sleep(1)

    async def quarter(self, numbers, seconds):
        """Visitors come and go; then all leave, and what the server still holds is noted."""
        watching = asyncio.create_task(self.watch())
        begin, used = time.monotonic(), self.server.cpu()
        late = [min(self.thinking, seconds / 4) * i / AT_ONCE for i in range(AT_ONCE)]
        try:
            await asyncio.gather(*(self.come_and_go(numbers, begin + seconds, each) for each in late))
        finally:
            watching.cancel()
        self.busy.append((self.server.cpu() - used) / (time.monotonic() - begin))
        self.idle.append(await asyncio.to_thread(self.held_by_nobody))

    async def all_quarters(self, seconds):
        """One visit that stays long enough for every kernel to be loaded, and the quarters of so many seconds."""
        thinking, self.thinking = self.thinking, 0.0
        await self.visit(0, stay=STAY)
        self.thinking = thinking
        self.idle.append(await asyncio.to_thread(self.held_by_nobody))
        numbers = itertools.count(1)
        for _ in range(QUARTERS):
            await self.quarter(numbers, seconds / QUARTERS)

    def held_by_nobody(self):
        """Memory (MB), threads, file handles and tasks of the server once all sessions have ended."""
        self.server.wait_for(lambda: not self.server.metric("vibroscope_sessions "), PATIENCE)
        time.sleep(FREED)
        threads, handles = (len(os.listdir(f"/proc/{self.server.process.pid}/{what}")) for what in ("task", "fd"))
        tasks = int(self.server.metric("vibroscope_tasks "))
        return {"memory": self.server.memory(), "threads": threads, "handles": handles, "tasks": tasks}

    @property
    def growth(self):
        """Of the memory while nobody is there, in the last half, as a share."""
        return self.idle[-1]["memory"] / self.idle[QUARTERS // 2]["memory"] - 1

    @property
    def sentence(self):
        """Its figures."""
        idle = {what: " → ".join(f"{each[what]:.0f}" for each in self.idle) for what in self.idle[0]}
        peaks = " → ".join(f"{peak:.0f}" for peak in self.peaks)
        busy = " → ".join(f"{cores:.2f}" for cores in self.busy)
        return (
            f"{self.visits} sessions on every tab ({self.turned_away} turned away at first), {AT_ONCE} at once, "
            f"{busy} cores busy, {self.files.total()} files exported or loaded and searches; while nobody is there, "
            f"after one visit and after each quarter: {idle['memory']} MB, {idle['threads']} threads, "
            f"{idle['handles']} handles, {idle['tasks']} tasks; at most {peaks} MB; memory in the last half "
            f"{self.growth:+.1%}"
        )


def _has_said(client, component, word):
    """Whether a component has sent a word in what it shows since the session was opened."""
    (shows,) = (model["id"] for model in client.models(f"{component}1"))
    patches = (message["content"] for message in client.answers if message["msgtype"] == "PATCH-DOC")
    changes = (change for patch in patches for change in patch.get("events", []))
    said = (json.dumps(plain(change.get("new"))) for change in changes if change.get("model") == {"id": shows})
    return any(word in text for text in said)
