"""What the browser receives of a move: first the figures, then the words and the answer."""

import asyncio

from tests.browserless import Client
from tests.served import served


def changes(message):
    """The attributes that a message changes."""
    events = message["content"].get("events", []) if message["msgtype"] == "PATCH-DOC" else []
    return {event["attr"] for event in events if "attr" in event}


def test_figures_are_sent_before_the_words_are_put_together(tmp_path):
    async def steps(server):
        async with Client(server.url) as client:
            await client.ready()
            client.answers.clear()
            await client.set(eta="1.37")
            return [changes(message) for message in client.answers]

    with served(tmp_path / "log.txt") as server:
        *before, answer = asyncio.run(asyncio.wait_for(steps(server), 120))
    figures = [some for some in before if "data" in some]  # without the browser's parts columns come in Bokeh's own way
    assert figures
    assert not {"shown", "content"} & set().union(*figures)
    assert {"shown", "content"} <= answer
    assert not {"data", "start"} & answer
