"""What the browser receives of a move: first the figures, then the words and the answer."""

import asyncio

from tornado.locks import Lock
from vibroscope.app.server.protocol import PageProtocol
from vibroscope.app.server.websocket import SessionSocket

from tests.browserless import Client, mapped
from tests.waiting import PATIENCE


class Connection:
    """Takes frames, as Tornado does."""

    def __init__(self):
        self.frames = []

    def is_closing(self):
        return False

    def write_message(self, message, binary=False):
        self.frames.append(message)
        return asyncio.ensure_future(asyncio.sleep(0))


def changes(message):
    """The attributes that a message changes."""
    events = message["content"].get("events", []) if message["msgtype"] == "PATCH-DOC" else []
    return {event["attr"] for event in events if "attr" in event}


def test_figures_are_sent_before_the_words_are_put_together(server):
    async def steps():
        async with Client(server.url) as client:
            await client.ready()
            client.answers.clear()
            await client.set(eta="1.37")
            return [changes(message) for message in client.answers]

    *before, answer = asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    figures = [some for some in before if "data" in some]  # without the browser's parts columns come in Bokeh's own way
    assert figures
    assert not {"shown", "content"} & set().union(*figures)
    assert {"shown", "content"} <= answer  # maybe with columns of the first picture, of what takes longer


def test_of_two_views_that_are_asked_for_at_once_the_last_is_shown(server):
    """The first has never been open, so that it is built in a thread; the other one is there."""

    async def steps():
        async with Client(server.url) as client:
            await client.ready()
            views = [client.message(mapped({"view": view, "move": n})) for n, view in enumerate(("help", "explore"), 1)]
            await client.patch(*views)
            return (await client.set(3, eta="1.37"))["address"]

    address = asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert "eta=1.37" in address
    assert "view=" not in address


def test_figures_that_are_ready_while_an_answer_is_written_are_sent_at_once():
    """Panel looks at the lock of a message that is being written, and tries again 10 ms later."""

    async def message_and_lock():
        socket = SessionSocket.__new__(SessionSocket)
        socket.write_lock, socket.ws_connection = Lock(), Connection()
        sending = asyncio.ensure_future(PageProtocol(lambda _: None).create("OK", "1").send(socket))
        await asyncio.sleep(0)  # one turn of the loop, in which figures may come
        return len(socket.ws_connection.frames), socket.write_lock.acquire().done(), await sending

    frames, free, _ = asyncio.run(message_and_lock())
    assert (frames, free) == (3, True)
