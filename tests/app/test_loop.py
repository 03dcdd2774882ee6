"""No message of a visitor keeps the event loop, which serves everybody, for longer than a few moves of a slider."""

import asyncio
import json
import time
from pathlib import Path
from statistics import median

import pytest
from vibroscope.app.page.tabs import VIEWS

from tests.browserless import Client, changed, mapped, move, objects
from tests.served import ROOT, served
from tests.share import every

WATCHDOG = Path(__file__).parent / "watchdog"
MOVES, PINS = 6, 4
AT_MOST = 4  # turns of a move, by the functions called in it: some 50,000, or 15 to 25 ms of a quiet machine


class Visitor:
    """Sends one message after the other, as a browser that paints what it gets, and notes when each was dealt with."""

    def __init__(self, client):
        self.client, self.number, self.heard, self.spans = client, 0, time.monotonic(), []

    async def listen(self):
        painted = set()
        while (message := await self.client.receive()) is not None:
            self.heard = time.monotonic()
            for update in _updates(message) - painted:
                painted.add(update)
                await self.send(self.client.message(mapped({"painted": update})))

    async def send(self, event):
        await self.client.send("PATCH-DOC", {"events": [event]})

    async def do(self, name, event, quiet=0.3, most=4.0):
        """Send and wait until the server has been quiet for so long; a later turn counts for the next message."""
        begun = self.heard = time.monotonic()
        await self.send(event)
        while time.monotonic() < begun + most and time.monotonic() - self.heard < quiet:
            await asyncio.sleep(0.02)
        self.spans.append((name, begun, time.monotonic()))

    async def ask(self, name, component="Controls", **data):
        """A message to a component, the last of its kind that the page has."""
        self.number += 1
        found = [
            each["id"]
            for message in ({"content": self.client.document}, *self.client.answers)
            for each in objects(message["content"], "ReactiveESM")
            if each["attributes"].get("class_name") == component
        ]
        data = {name: mapped(each) if isinstance(each, dict) else each for name, each in data.items()}
        event = self.client.message(mapped(data | {"move": self.number}))
        event["msg_data"]["values"]["entries"][0] = ["model", {"id": found[-1]}]
        await self.do(name, event)

    async def move(self, **texts):
        self.number += 1
        await self.do("move", self.client.message(move(texts, self.number)))


def _updates(message):
    content = message["content"] if isinstance(message["content"], dict) else {}
    shown = [event["new"] for event in content.get("events", []) if event.get("attr") == "shown"]
    return {value for each in shown for name, value in each["entries"] if name == "update" and value}


async def visit(url):
    """All tabs, pins, a measurement, what is drawn in other ways, muted curves."""
    async with Client(url) as client:
        await client.ready()
        visitor = Visitor(client)
        listening = asyncio.ensure_future(visitor.listen())
        for number in range(MOVES):
            await visitor.move(eta=str(1.2 + number / 100))
        for number in range(PINS):
            await visitor.move(eta=str(1.31 + number / 10))
            await visitor.ask(f"pin {number + 1}", pin=True)
        for frame in ("difference", "absolute", "relative"):
            await visitor.ask(f"frame {frame}", set={"frame": frame})
        for what in ("png:displacement?width=85", "pdf:force", "report"):
            await visitor.ask(f"take {what}", "Header", take=what)
        await visitor.ask("wall", set={"bodies": "wall"})
        await visitor.ask("reset", reset=True)
        figure = next(each for each in client.models("Figure") if each["attributes"]["name"] == "displacement")
        for visible in (False, True):
            curve = figure["attributes"]["renderers"][0]["id"]
            await visitor.do(f"curve visible: {visible}", changed(curve, "visible", visible))
        text = (ROOT / "assets" / "example-measurement.csv").read_text()
        parts = [text[begin : begin + 4000] for begin in range(0, len(text), 4000)]
        await visitor.ask("file", "MeasurementButton", file={"name": "run.csv", "size": len(text)})
        for part in parts:
            await visitor.ask("part", "MeasurementButton", part={"0": part})
        await visitor.ask("measurement", "MeasurementButton", end=True)
        for key in (*VIEWS, *every([*VIEWS])):  # built, and open again
            await visitor.ask(f"view {key}", view=key)
        listening.cancel()
        return visitor.spans


@pytest.fixture(scope="module")
def longest(tmp_path_factory):
    """For each message its name, the calls of the longest turn by it, and the walks over all models."""
    folder = tmp_path_factory.mktemp("loop")
    turns = folder / "turns.txt"
    with served(folder / "log.txt", PYTHONPATH=str(WATCHDOG), VIBROSCOPE_TURNS=str(turns)) as server:
        spans = asyncio.run(asyncio.wait_for(visit(server.url), 300))
        assert "rror" not in server.log.read_text()
    rows = [json.loads(line) for line in turns.read_text().splitlines()]
    found = []
    for name, begun, ended in spans:
        within = [(used, walks) for start, _, used, walks in rows if begun <= start < ended]
        found.append((name, max((used for used, _ in within), default=0), sum(walks for _, walks in within)))
    return found


def test_no_message_makes_bokeh_walk_over_all_models_on_the_loop(longest):
    assert {name for name, _, walks in longest if walks} == set()


def test_no_message_takes_longer_than_a_few_moves(longest):
    yardstick = median(used for name, used, _ in longest[:MOVES])
    slow = {name: round(used / yardstick, 1) for name, used, _ in longest if used > AT_MOST * yardstick}
    assert slow == {}
