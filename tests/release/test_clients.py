"""Clients that vanish, say nothing, or never read."""

import asyncio
import random
import socket
import time

from tests.browserless import Client, mapped, move, token_of
from tests.release.odd import run


async def as_ever(server):
    async with Client(server.url) as client:
        await client.ready()
        assert (await client.set(1, eta="1.7"))["texts"]["eta"] == "1.7"


def test_gone_in_the_middle_of_an_update_and_silent(server, tell):
    """Half a request, half a message, gone in the middle of an update, two hundred connections that say nothing."""
    chance = random.Random(4)

    async def gone(number):
        client = await Client(server.url).open()
        await client.ready()
        moved = client.message(move({"eta": f"{1 + number / 500:.4f}"}, 1))
        if chance.random() < 0.5:
            await client.send("PATCH-DOC", {"events": [moved]})
        else:
            await client.socket.write_message('{"msgid": "1", "msgtype": "PATCH-DOC"}')  # and not the rest of it
        client.socket.protocol.stream.close()  # without a word
        client.socket.close()  # says nothing any more, and frees what is left here

    silent = []
    for _ in range(200):
        silent.append(socket.create_connection(("127.0.0.1", server.port)))
        silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ")

    async def all_of_them():
        for begin in range(0, 40, 8):
            await asyncio.gather(*(gone(begin + n) for n in range(8)))
        await as_ever(server)

    run(all_of_them())
    for connection in silent:
        connection.close()
    told = "40 browsers gone in the middle of an update, 200 silent connections: a session as ever, no traceback"
    tell(told, faults=2, sessions=41)


def test_a_browser_that_never_reads_while_updates_come(server, tell):
    """What waits for it piles up to a bound, then it is let go; the other one at the same session goes on."""
    refused = 'vibroscope_refused_total{what="message"}'

    async def moves():
        token = await token_of(server.url)
        client = await Client(server.url).open(token=token)
        silent = await Client(server.url).connect(token=token)  # reads nothing from here on
        await client.ready()
        before, let_go, number, begun = server.memory(), server.metric(refused), 0, time.monotonic()
        while server.metric(refused) == let_go:
            assert time.monotonic() < begun + 200, "never let go"
            number += 1
            told = await client.set(number, eta=f"{1 + number % 1000 / 1000:.3f}")
            await client.patch(client.message(mapped({"painted": told["update"]})))
            client.answers.clear()
            await asyncio.sleep(1 / 60)  # a screen shows no more
        seconds, more = time.monotonic() - begun, server.memory() - before
        silent.socket.protocol.stream.close()
        for connection in (client, silent):
            connection.socket.close()
        return number, seconds, more

    number, seconds, more = run(moves(), 300)
    told = f"let go after {seconds:.0f} s and {number} updates, every one of which the other browser got"
    tell(f"a browser that never reads: {told}; the server grew by {more:.0f} MB", faults=1, sessions=1)
    assert more < 300
