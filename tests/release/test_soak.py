"""Memory stays flat while sessions open, move, visit every tab, export files, load one and close, for an hour.

Afterwards no thread, file handle or task of theirs is left. ``RELEASE_SOAK`` sets the seconds.
"""

import asyncio
import os
import time
from collections import Counter

from tornado.httpclient import HTTPClientError
from vibroscope.app.page.tabs import TABS

from tests.browserless import Client, mapped, move, plain
from tests.release.odd import run
from tests.served import served

AT_ONCE = 40  # visitors
SECONDS = float(os.environ.get("RELEASE_SOAK", "3600"))
PATIENCE = 120  # s for an answer where 40 visitors share two cores
LAST_VISITS = 1200  # s that the visits may take that are under way at the end
# Growth in the last half of an hour. In some minutes caches still fill: then MB in the last quarter, where +5 and +7
# were measured on two busy cores.
FLAT, HOUR = 0.02, 3600
MOST = 15.0
# Pools start their threads when they are needed, up to a fixed number; a prewarmed session may have come or gone.
SPARE = {"threads": 24, "handles": 8, "tasks": 4}
TAKEN = ("json", "report", "python", "command", "toml")


def _given(message):
    """Return the exported files in a message."""
    for change in message["content"].get("events", []) if message["msgtype"] == "PATCH-DOC" else []:
        if change.get("msg_type") == "bokeh_event" and change["msg_data"]["name"] == "esm_event":
            data = dict(change["msg_data"]["values"]["entries"])["data"]
            if "give" in plain(data):
                yield plain(data)


def held(server):
    """How many threads, file handles and tasks the server has."""
    threads, handles = (len(os.listdir(f"/proc/{server.process.pid}/{what}")) for what in ("task", "fd"))
    return {"threads": threads, "handles": handles, "tasks": int(server.metric("vibroscope_tasks "))}


def idle(server):
    """Wait until all sessions have ended."""
    server.wait_for(lambda: not server.metric("vibroscope_sessions "), 120)


def test_soak(tmp_path, report):
    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_LEVEL="warning") as server:
        measured, files, idle_before, turned_away = [], Counter(), [], Counter()

        async def visitor(number):
            async with Client(server.url) as client:
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
                given = [file for message in client.answers for file in _given(message)]
                files.update(file["give"] for file in given)
                client.answers.clear()
                if text := next((file["text"] for file in given if file["give"] == "toml"), ""):
                    parts = mapped({"0": text})
                    await client.patch(client.message(mapped({"load": parts, "move": turn + 2}), "Header"))
                    await client.shown(lambda shown: shown["texts"]["eta"] != "3.9")
                    files["loaded"] += 1

        async def come_and_go(number, end):
            visits = 0
            while time.monotonic() < end:
                try:
                    await visitor(number)
                except (ConnectionError, HTTPClientError):  # turned away, as a browser is that then asks again
                    turned_away[number] += 1
                    await asyncio.sleep(1)
                else:
                    number, visits = number + AT_ONCE, visits + 1
            return visits

        async def watch():
            while True:
                measured.append((time.monotonic(), server.memory()))
                await asyncio.sleep(1)

        async def all_of_them():
            await visitor(0)  # on every tab: the pools of threads are there
            idle_before.append(await asyncio.to_thread(settled))
            watching = asyncio.create_task(watch())
            end = time.monotonic() + SECONDS
            visits = await asyncio.gather(*(come_and_go(number, end) for number in range(AT_ONCE)))
            watching.cancel()
            return sum(visits)

        def settled():
            idle(server)
            return held(server)

        sessions = run(all_of_them(), SECONDS + LAST_VISITS)
        before, after = idle_before[0], settled()
        seconds = measured[-1][0] - measured[0][0]
    quarters = [measured[len(measured) * n // 4 - (n == 4)][1] for n in range(5)]
    growth = quarters[4] - quarters[3]
    text = f"{sessions} sessions on every tab ({turned_away.total()} turned away at first), "
    text += f"{files.total()} files exported or loaded, in {seconds:.0f} s"
    text += f", {' → '.join(f'{each:.0f}' for each in quarters)} MB by quarters, {growth:+.1f} MB in the last"
    kept = ", ".join(f"{before[what]} → {number} {what}" for what, number in after.items())
    rate = f"at that rate {growth * 14400 / seconds:+.0f} MB an hour"
    report(f"soak: {text}, {rate}; {kept} while nobody is there", sessions=sessions)
    assert {*TAKEN, "loaded"} <= files.keys()
    if SECONDS >= HOUR:
        assert quarters[4] - quarters[2] < FLAT * quarters[2]
    assert growth < MOST
    for what, number in after.items():
        assert number <= before[what] + SPARE[what], what
