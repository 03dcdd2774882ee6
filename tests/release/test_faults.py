"""What `make release` adds: thousands of fuzzed addresses, messages and files, faults, malicious clients, a soak.

Prints its figures: inputs tried, faults survived, sessions held. ``RELEASE_INPUTS`` sets how many of each kind are
tried; many visitors at once, and a thousand that come and go, are measured by ``benchmarks/sessions.py``.
"""

import asyncio
import json
import os
import random
import signal
import socket
import subprocess
import time
from contextlib import suppress

import numpy as np
import pytest
from tornado.websocket import WebSocketClosedError

from app.state import Explorer, Refused, Setting, parse_address
from engine import read_measurement, read_system
from tests.browserless import Client, changed, event, get, mapped, move
from tests.served import ROOT, served

pytestmark = pytest.mark.release
INPUTS = int(os.environ.get("RELEASE_INPUTS", "12000"))
SOAK_SECONDS = float(os.environ.get("RELEASE_SOAK", "180"))
ODD = (
    "nan",
    "inf",
    "-inf",
    "1e999",
    "²",
    "",
    "\0",
    "-0",
    "1e-400",
    "9" * 4000,
    "0x10",
    "1_0",
    "1,5",
    "é" * 50,
    "NaN%",
    "+",
)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with served(tmp_path_factory.mktemp("release") / "log.txt", VIBROSCOPE_LOG_FORMAT="json") as server:
        yield server
    lines = [json.loads(line) for line in server.log.read_text().splitlines() if line.startswith("{")]
    assert not [line for line in lines if "traceback" in line][:1]
    assert not [line for line in lines if line["event"] == "answered" and line.get("status", 0) >= 500]


def run(steps, seconds=900):
    return asyncio.run(asyncio.wait_for(steps, seconds))


def random_text(chance):
    number = f"{chance.uniform(-1, 1) * 10 ** chance.randint(-3, 6):.{chance.randint(0, 17)}g}"
    noise = "".join(chr(chance.choice((chance.randint(0, 127), chance.randint(0, 0x2FFF)))) for _ in range(5))
    return chance.choice((number, number, chance.choice(ODD), noise, "yes", "derived", "xi1"))


def random_json(chance, depth=3):
    kinds = [random_text, lambda c: c.uniform(-9, 9), lambda c: None, lambda c: c.choice((True, float("nan"), 10**400))]
    if depth:
        kinds += [
            lambda c: [random_json(c, depth - 1) for _ in range(c.randint(0, 4))],
            lambda c: mapped({c.choice((*Setting._fields, "set", "move", "x")): random_json(c, depth - 1)}),
            lambda c: {c.choice(("type", "id", "entries", "kind")): random_json(c, depth - 1)},
        ]
    return chance.choice(kinds)(chance)


def forged(chance, client, model, value):
    """One event that no page would send."""
    kind = chance.randrange(5)
    if kind == 0:
        return client.message(value)
    if kind == 1:
        return client.message(move({chance.choice(Setting._fields): random_text(chance)}, chance.randint(0, 9)))
    if kind == 2:
        return changed(model, chance.choice(("start", "end", "data", "shown", "inner_width")), value)
    if kind == 3:
        return event(chance.choice(("tap", "rangesupdate", "data_event")), mapped({"model": {"id": model}, "x": value}))
    return value


def holds_no_odd_number(setting):
    return all(isinstance(value, str) or np.isfinite(value) for value in setting)


def test_addresses(server, capsys):
    """Every one through the parser that sessions use; a share of them as requests for the page and as sessions."""
    chance, refused = random.Random(1), 0
    names = (*Setting._fields, "tab", "pin", "theme", "bokeh-token", "x")
    queries = []
    for _ in range(INPUTS):
        pairs = [(chance.choice(names), random_text(chance)) for _ in range(chance.randint(0, 5))]
        queries.append("&".join(f"{name}={text}" for name, text in pairs))
        state = Explorer()
        before = state.setting()
        try:
            state.apply(parse_address(queries[-1]))
        except Refused as error:
            refused += bool(str(error))
            assert state.setting() == before  # whole or not at all
        assert holds_no_odd_number(state.setting())

    async def ask():
        statuses = []
        for query in queries[: INPUTS // 10]:
            address = "".join(
                c if c.isascii() and c.isprintable() and c not in ' "<>' else f"%{ord(c) % 256:02x}" for c in query
            )
            statuses.append((await get(f"{server.url}/?{address[:6000]}")).code)
        assert set(statuses) <= {200, 400}, set(statuses)
        for query in queries[: min(60, INPUTS // 100)]:
            safe = "".join(c if (c.isalnum() and c.isascii()) or c in "=&.-" else "%41" for c in query)[:3000]
            async with Client(server.url, safe) as client:
                assert await client.ready()
        return len(statuses)

    asked = run(ask())
    with capsys.disabled():
        print(f"\n{INPUTS} addresses, {refused} refused in words, {asked} of them asked for as pages: no answer of 500")


def test_messages(server, capsys):
    """Forged messages of every kind, in few connections that are renewed when the server ends them."""
    chance, ended = random.Random(2), 0

    async def some(client, number):
        models = [m["id"] for kind in ("Range1d", "ColumnDataSource", "Figure", "1") for m in client.models(kind)]
        for _ in range(number):
            said = forged(chance, client, chance.choice(models), random_json(chance))
            await client.patch(said)
            await asyncio.sleep(0.015)  # within the rate that is granted

    async def all_of_them():
        nonlocal ended
        tried = 0
        while tried < INPUTS:
            batch = [Client(server.url) for _ in range(8)]
            for client in batch:
                await client.open()
                await client.ready()
            done = await asyncio.gather(*(some(c, min(500, INPUTS // 8 + 1)) for c in batch), return_exceptions=True)
            ended += sum(isinstance(result, WebSocketClosedError) for result in done)
            assert all(result is None or isinstance(result, WebSocketClosedError) for result in done), done
            tried += 8 * min(500, INPUTS // 8 + 1)
            for client in batch:
                client.socket.close()
        async with Client(server.url) as client:  # and a session as ever
            await client.ready()
            assert (await client.set(1, eta="1.5"))["texts"]["eta"] == "1.5"
        return tried

    tried = run(all_of_them())
    refused = [server.metric(f'vibroscope_refused_total{{what="{what}"}}') for what in ("message", "value")]
    told = f"{refused[0]:.0f} taken apart, {refused[1]:.0f} values refused in words, {ended} connections ended"
    with capsys.disabled():
        print(f"\n{tried} forged messages: {told}")
    assert refused[0] > 0
    assert refused[1] > 0


def test_files(tmp_path, capsys):
    """System files and measurements, damaged at random: refused with a ValueError, or read as finite numbers."""
    chance, refused = random.Random(3), 0
    measured = (ROOT / "assets/example-measurement.csv").read_bytes()[:4000]
    system = subprocess.run([ROOT / ".venv/bin/vibroscope", "system"], capture_output=True, check=True).stdout
    readers = (
        (system, "x.toml", lambda path: read_system(path)),
        (measured, "x.csv", lambda path: read_measurement(path)),
    )
    for number in range(INPUTS):
        content, name, read = readers[number % 2]
        damaged = bytearray(content)
        for _ in range(chance.randint(1, 8)):
            place = chance.randrange(len(damaged))
            damaged[place : place + chance.randint(0, 20)] = chance.choice(ODD).encode()[:200] or b"\xff"
        path = tmp_path / name
        path.write_bytes(damaged)
        try:
            read(path)
        except ValueError as error:
            refused += bool(str(error))
    with capsys.disabled():
        print(f"\n{INPUTS} damaged files: {refused} refused in words, none ended otherwise")


def test_clients_that_mean_no_good(server, capsys):
    """Half a request, half a message, gone in the middle of an update, two hundred connections that say nothing."""

    async def gone(number):
        client = await Client(server.url).open()
        await client.ready()
        await client.send("PATCH-DOC", {"events": [client.message(move({"eta": f"{1 + number / 500:.4f}"}, 1))]})
        client.socket.protocol.stream.close()  # without a word
        client.socket.close()  # says nothing any more, and frees what is left here

    silent = []
    for _ in range(200):
        silent.append(socket.create_connection(("127.0.0.1", server.port)))
        silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ")

    async def all_of_them():
        for begin in range(0, 40, 8):
            await asyncio.gather(*(gone(begin + n) for n in range(8)))
        async with Client(server.url) as client:
            await client.ready()
            assert (await client.set(1, eta="1.7"))["texts"]["eta"] == "1.7"

    run(all_of_them())
    for connection in silent:
        connection.close()
    with capsys.disabled():
        print("\n40 browsers gone in the middle of an update, 200 silent connections: a session as ever, no traceback")


@pytest.mark.parametrize("fault", ["full", "read-only", "corrupt"])
def test_cache_folder(fault, tmp_path, capsys):
    """The explorer serves whatever the cache folder is like."""
    cache = tmp_path / "cache"
    cache.mkdir()
    mounted = fault != "corrupt"
    if mounted:
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", cache]).returncode:
            pytest.skip("mounting needs root")
        if fault == "full":
            with suppress(OSError):
                (cache / "filler").write_bytes(b"x" * 300_000)
        else:
            subprocess.run(["mount", "-o", "remount,ro", cache], check=True)
    try:
        if fault == "corrupt":
            with served(tmp_path / "first.txt", VIBROSCOPE_CACHE_DIR=str(cache)):
                pass
            for path in cache.rglob("*.nb[ic]"):
                path.write_bytes(b"\0" * 100)
        with served(tmp_path / "log.txt", VIBROSCOPE_CACHE_DIR=str(cache)) as server:

            async def steps():
                async with Client(server.url) as client:
                    await client.ready()
                    await client.shown(lambda told: told.get("frame"), seconds=300)  # nothing kept: kernels compile
                    return await client.set(1, eta="1.5")

            assert run(steps(), 400)["texts"]["eta"] == "1.5"
        with capsys.disabled():
            print(f"\ncache folder {fault}: served")
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", cache], check=True)


def test_a_killed_server_is_replaced_and_a_stop_under_load_answers_all(tmp_path, capsys):
    key = {"BOKEH_SECRET_KEY": "k" * 48}
    with served(tmp_path / "first.txt", **key) as server:
        server.process.kill()
        server.process.wait()
    with served(tmp_path / "second.txt", **key) as server:

        async def load():
            clients = [await Client(server.url).open() for _ in range(8)]
            for client in clients:
                await client.ready()
                shown = await client.shown(lambda told: told.get("frame"))
                await client.patch(client.message(mapped({"painted": shown["frame"]})))
            for number, client in enumerate(clients):
                await client.patch(client.message(move({"eta": f"1.{30 + number}", "steps": "32000"}, 5)))
            server.process.send_signal(signal.SIGTERM)
            answers = [await client.shown(lambda told: told.get("move") == 5) for client in clients]
            for client in clients:
                client.socket.close()
            return answers

        answers = run(load(), 120)
        assert server.stop() == 0
    assert "Traceback" not in (tmp_path / "second.txt").read_text()
    with capsys.disabled():
        print(f"\nSIGTERM with {len(answers)} moves under way: {len(answers)} answered, exit status 0")


def test_soak(tmp_path, capsys):
    """Memory is flat while sessions come, move and go for some minutes."""
    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_LEVEL="warning") as server:
        measured = []

        async def visitor(number):
            async with Client(server.url) as client:
                await client.ready()
                for turn in range(6):
                    await client.patch(
                        client.message(move({"eta": f"{0.6 + (number * 6 + turn) % 3000 / 1000:.3f}"}, turn))
                    )
                    await asyncio.sleep(0.3)

        async def all_of_them():
            begun, number = time.monotonic(), 0
            while time.monotonic() < begun + SOAK_SECONDS:
                await asyncio.gather(*(visitor(number + n) for n in range(4)))
                number += 4
                measured.append((number, server.memory()))
            return number

        number = run(all_of_them(), SOAK_SECONDS + 120)
    half = [megabytes for _, megabytes in measured[len(measured) // 2 :]]
    growth = half[-1] - half[0]
    with capsys.disabled():
        print(
            f"\nsoak: {number} sessions in {SOAK_SECONDS:.0f} s, {half[-1]:.0f} MB, {growth:+.1f} MB in the second half"
        )
    assert growth < 40
