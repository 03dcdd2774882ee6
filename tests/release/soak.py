"""Visitors of one server who use everything, and what it holds while nobody is there."""

import asyncio
import itertools
import os
import time
from collections import Counter

from tornado.httpclient import HTTPClientError
from vibroscope.app.page.tabs import TABS

from tests.browserless import Client, mapped, move, plain

AT_ONCE = 40  # visitors
QUARTERS = 4
PATIENCE = 120  # s for an answer where 40 visitors share two cores
FREED = 12.0  # s after the last session: memory is freed, and a session prewarmed
TAKEN = ("json", "report", "python", "command", "toml")


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
    idle : list of dict
        What the server holds while nobody is there: after one visit, then after each quarter.
    peaks : list of float
        Most memory (MB) in each quarter.
    visits, turned_away : int
    files : Counter
        Files exported, by their kind, and ``loaded``.
    """

    def __init__(self, server):
        self.server = server
        self.idle, self.peaks = [], []
        self.visits = self.turned_away = 0
        self.files = Counter()

    async def visit(self, number):
        """Open a session, move and export on every tab, load an exported file, and leave."""
        async with Client(self.server.url) as client:
            client.patience = PATIENCE
            await client.ready()
            await client.patch(client.message(mapped({"listens": True}), "ColumnSender"))
            for turn, key in enumerate(TABS, number * len(TABS)):
                await client.patch(client.message(move({"eta": f"{0.6 + turn % 3000 / 1000:.3f}"}, turn)))
                await client.patch(client.message(mapped({"tab": key, "move": turn}), "Header"))
                await asyncio.sleep(0.3)  # a study has begun; the next tab cancels it
                await client.patch(client.message(mapped({"take": TAKEN[turn % len(TAKEN)]}), "Header"))
                await asyncio.sleep(0.3)
            await client.set(turn + 1, eta="3.9")
            await self._load_exported(client, turn + 2)
        self.visits += 1

    async def _load_exported(self, client, number):
        given = [file for message in client.answers for file in _given(message)]
        self.files.update(file["give"] for file in given)
        client.answers.clear()
        if text := next((file["text"] for file in given if file["give"] == "toml"), ""):
            await client.patch(client.message(mapped({"load": mapped({"0": text}), "move": number}), "Header"))
            await client.shown(lambda shown: shown["texts"]["eta"] != "3.9")
            self.files["loaded"] += 1

    async def come_and_go(self, numbers, end):
        """Visit again and again until this time."""
        number = next(numbers)
        while time.monotonic() < end:
            try:
                await self.visit(number)
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
        end = time.monotonic() + seconds
        try:
            await asyncio.gather(*(self.come_and_go(numbers, end) for _ in range(AT_ONCE)))
        finally:
            watching.cancel()
        self.idle.append(await asyncio.to_thread(self.held_by_nobody))

    async def all_quarters(self, seconds):
        """One visit, and the quarters of so many seconds."""
        await self.visit(0)
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
        return (
            f"{self.visits} sessions on every tab ({self.turned_away} turned away at first), {AT_ONCE} at once, "
            f"{self.files.total()} files exported or loaded; while nobody is there, after one visit and after each "
            f"quarter: {idle['memory']} MB, {idle['threads']} threads, {idle['handles']} handles, {idle['tasks']} "
            f"tasks; at most {peaks} MB; memory in the last half {self.growth:+.1%}"
        )
