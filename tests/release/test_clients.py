"""Clients that vanish, are silent, or never read."""

import asyncio
import socket
import time

from tests.browserless import Client, mapped, move, token_of
from tests.release.odd import run


async def check_session(server):
    async with Client(server.url) as client:
        await client.ready()
        assert (await client.set(1, eta="1.7"))["texts"]["eta"] == "1.7"


def test_clients_that_vanish_during_an_update_and_silent_connections(server, chance, report):
    """Half a request, half a message, a client that vanishes during an update, and two hundred silent connections."""

    async def vanish(number):
        client = await Client(server.url).open()
        await client.ready()
        moved = client.message(move({"eta": f"{1 + number / 500:.4f}"}, 1))
        if chance.random() < 0.5:
            await client.send("PATCH-DOC", {"events": [moved]})
        else:
            await client.socket.write_message('{"msgid": "1", "msgtype": "PATCH-DOC"}')  # and not the rest of it
        client.socket.protocol.stream.close()  # without a closing handshake
        client.socket.close()  # sends nothing any more, and frees the client

    silent = []
    for _ in range(200):
        silent.append(socket.create_connection(("127.0.0.1", server.port)))
        silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ")

    async def all_of_them():
        for begin in range(0, 40, 8):
            await asyncio.gather(*(vanish(begin + n) for n in range(8)))
        await check_session(server)

    run(all_of_them())
    for connection in silent:
        connection.close()
    text = "40 browsers vanished during an update, 200 silent connections: another session still works, no traceback"
    report(text, faults=2, sessions=41)


def test_a_browser_that_never_reads_while_updates_come(server, report):
    """What it does not read is limited, then the server closes it; the other browser of the session is not affected."""
    refused = 'vibroscope_refused_total{what="message"}'

    async def moves():
        token = await token_of(server.url)
        client = await Client(server.url).open(token=token)
        silent = await Client(server.url).connect(token=token)  # reads nothing from here on
        await client.ready()
        before, closed, number, begun = server.memory(), server.metric(refused), 0, time.monotonic()
        while server.metric(refused) == closed:
            assert time.monotonic() < begun + 200, "never closed"
            number += 1
            shown = await client.set(number, eta=f"{1 + number % 1000 / 1000:.3f}")
            await client.patch(client.message(mapped({"painted": shown["update"]})))
            client.answers.clear()
            await asyncio.sleep(1 / 60)  # as often as a screen shows a frame
        seconds, more = time.monotonic() - begun, server.memory() - before
        silent.socket.protocol.stream.close()
        for connection in (client, silent):
            connection.socket.close()
        return number, seconds, more

    number, seconds, more = run(moves(), 300)
    text = f"closed after {seconds:.0f} s and {number} updates, all of which the other browser received"
    report(f"a browser that never reads: {text}; the server grew by {more:.0f} MB", faults=1, sessions=1)
    assert more < 300
