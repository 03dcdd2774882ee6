"""Thousands of fuzzed inputs: addresses, requests, messages, files."""

import asyncio
import re
import subprocess
from collections import Counter
from itertools import cycle
from urllib.parse import quote

import numpy as np
from tornado.websocket import WebSocketClosedError
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.page.address import Address
from vibroscope.app.page.tabs import VIEWS
from vibroscope.engine import read_measurement, read_system

from tests.browserless import Client, get
from tests.release.odd import ODD, forged, random_json, random_query, random_request, run
from tests.served import ROOT


def all_numbers_finite(setting):
    return all(isinstance(value, str) or np.isfinite(value) for value in setting)


def test_addresses(server, chance, inputs, report):
    """Each is read as a session reads it, with what it then shows; some are also requested as pages and opened."""
    refused = {}
    # Escape each byte that an address cannot contain; what looks like an escape already stays one.
    queries = [quote(random_query(chance), safe="=&%+;:,") for _ in range(inputs)]
    for query in queries:
        address = Address(host=None, on_view_change=None)
        asked, shown = address.open(query)  # never fails: what is refused opens as the opening scene, and says why
        assert address.frozen == bool(shown)
        if shown:
            refused[query] = shown
            assert re.fullmatch(
                r"\S.{10,300}[.!?] The link was not accepted, so this is the opening scene\.", shown, re.S
            ), shown
            assert asked.setting == opening_setting()
            continue
        assert all_numbers_finite((*asked.setting, *(value for pinned in asked.pinned for value in pinned)))
        assert np.isfinite([*asked.state.zoom.values()]).all()

    async def ask():
        statuses = [(await get(f"{server.url}/?{query}")).code for query in queries[: inputs // 10]]
        assert set(statuses) <= {200, 400}, set(statuses)
        opened = queries[: min(60, inputs // 20)]
        for query in opened:
            async with Client(server.url, query) as client:
                assert await client.ready()
                (header,) = client.models("Header1")
                shown = header["attributes"].get("error", "")
                assert shown == refused.get(query, ""), query
        return len(statuses), len(opened)

    asked, opened = run(ask())
    text = f"{len(refused)} refused with an explanation, {asked} requested as pages: no answer of 500; {opened} opened"
    report(f"{inputs} addresses: {text}", inputs=inputs, sessions=opened)


def test_requests(server, chance, inputs, report):
    """Request lines and headers as raw bytes: the server answers, but not with 500, or closes the connection."""
    statuses = Counter()

    async def ask(request):
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        try:
            writer.write(request)
            writer.write_eof()  # nothing more follows, whatever length was announced
            answer = await asyncio.wait_for(reader.read(), 20)
        except OSError:  # closed before all of it was read
            return "none"
        finally:
            writer.transport.abort()
        return answer.split(b" ", 2)[1].decode() if answer else "none"

    async def all_of_them():
        for _ in range(inputs):
            request = random_request(chance, f"127.0.0.1:{server.port}".encode())
            status = await ask(request)
            assert not status.startswith("5"), request[:300]
            statuses[status] += 1
        assert (await get(f"{server.url}/liveness")).code == 200

    run(all_of_them())
    text = ", ".join(f"{number} × {status}" for status, number in sorted(statuses.items()))
    report(f"{inputs} raw requests: {text}: no answer of 500", inputs=inputs)
    assert statuses["400"] > 0


def test_messages(server, chance, inputs, report):
    """Forged messages of every kind to every model of every tab; connections that the server closes are renewed."""
    ended, opened, tabs = 0, 0, cycle(VIEWS)
    each = min(500, inputs // 8 + 1)

    async def some(client):
        models = [m["id"] for kind in ("Range1d", "ColumnDataSource", "Figure", "1") for m in client.models(kind)]
        components = [m["id"] for m in client.models("ReactiveESM")]
        for _ in range(each):
            sent = forged(chance, chance.choice(models), chance.choice(components), random_json(chance))
            await client.patch(sent)
            client.answers.clear()  # an answer may hold a whole page
            await asyncio.sleep(0.015)  # within the rate limit

    async def all_of_them():
        nonlocal ended, opened
        tried = 0
        while tried < inputs:
            batch = [Client(server.url, f"view={next(tabs)}") for _ in range(8)]
            for client in batch:
                await client.open()
                await client.ready()
            done = await asyncio.gather(*map(some, batch), return_exceptions=True)
            assert all(result is None or isinstance(result, WebSocketClosedError) for result in done), done
            ended += sum(result is not None for result in done)
            opened += len(batch)
            tried += 8 * each
            for client in batch:
                client.socket.close()
        async with Client(server.url) as client:  # and another session still works
            await client.ready()
            assert (await client.set(1, eta="1.5"))["texts"]["eta"] == "1.5"
        return tried

    tried = run(all_of_them())
    refused = [server.metric(f'vibroscope_refused_total{{what="{what}"}}') for what in ("message", "value")]
    text = f"{refused[0]:.0f} dropped, {refused[1]:.0f} values refused with an explanation, {ended} connections ended"
    report(f"{tried} forged messages: {text}", inputs=tried, sessions=opened + 1)
    assert refused[0] > 0
    assert refused[1] > 0


def test_files(tmp_path, chance, inputs, report):
    """Files and uploads, damaged at random: refused with a ValueError or read as finite numbers."""
    refused = 0
    measured = (ROOT / "assets/example-measurement.csv").read_bytes()[:4000]
    system = subprocess.run([ROOT / ".venv/bin/vibroscope", "system"], capture_output=True, check=True).stdout
    upload = as_toml(Setting()).encode()
    readers = (
        (system, "x.toml", read_system),
        (measured, "x.csv", read_measurement),
        (upload, "x.toml", uploaded),
    )
    for number in range(inputs):
        content, name, read = readers[number % 3]
        changed = bytearray(content)
        for _ in range(chance.randint(1, 8)):
            place = chance.randrange(len(changed))
            changed[place : place + chance.randint(0, 20)] = chance.choice(ODD).encode()[:200] or b"\xff"
        path = tmp_path / name
        path.write_bytes(changed)
        try:
            found = read(path)
        except ValueError as error:
            refused += bool(str(error))
        else:
            assert all_finite(found), (name, found)
    report(f"{inputs} damaged files: {refused} refused with an explanation, none ended otherwise", inputs=inputs)


def uploaded(path):
    """Return the setting that the page makes of a file that its user loads."""
    return read_setting(loaded_from_toml(path.read_bytes().decode(errors="replace")).texts)


def all_finite(found):
    """Return whether every number in an object and its parts is finite."""
    if isinstance(found, tuple):
        return all(map(all_finite, found))
    if isinstance(found, int | float | np.ndarray):
        return bool(np.all(np.isfinite(found)))
    return all(all_finite(value) for value in getattr(found, "__dict__", {}).values())
