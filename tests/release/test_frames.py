"""Websocket frames as raw bytes, and patches what JSON makes of them: dropped, refused, or allowed."""

import asyncio
import struct
from contextlib import suppress

from bokeh.document import Document
from bokeh.models import Range1d
from panel.io.state import set_curdoc
from tornado.iostream import StreamClosedError
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.server.validation import cost_of, is_worth_logging, valid_events

from tests.app.fakes import FakeHost
from tests.browserless import Client, event, mapped, token_of
from tests.release.odd import ODD, forged, random_json, run

PARTS = ('{"msgid": "1", "msgtype": "PATCH-DOC"}', '{"msgid": "1", "msgtype": "PULL-DOC-REQ"}', "{}", "[]", "null", "")
PARTS += (
    '{"msgid": 1}',
    '{"msgtype": "ACK"}',
    '{"msgid": "1", "msgtype": "PUSH-DOC"}',
    '{"events": []}',
    '{"events": 1}',
)
PARTS += (
    '{"msgid": "1", "msgtype": "PATCH-DOC", "num_buffers": 9}',
    "[" * 400,
    '{"events": [{"kind": "RootRemoved"}]}',
)
FINAL, MASKED = 0x80, 0x80


def random_frame(chance):
    """Return a frame: of any kind, whole or in part, with reserved bits, without a mask, or of another length."""
    content = chance.choice((*PARTS, *PARTS, chance.choice(ODD), "x" * chance.randrange(300))).encode()[:400]
    if chance.random() < 0.1:
        content = bytes(chance.randrange(256) for _ in range(chance.randrange(130)))
    first = chance.choice((FINAL, FINAL, FINAL, 0)) | chance.choice((1, 1, 1, 1, 0, 2, 8, 9, 10, 3, 15))
    if chance.random() < 0.03:
        first |= chance.choice((0x10, 0x20, 0x40))
    announced = chance.choice((len(content),) * 20 + (len(content) + 1, 0, 2**16 - 1, 2**31, 2**63))
    mask = 0 if chance.random() < 0.02 else MASKED
    if announced < 126:
        head = struct.pack("!BB", first, mask | announced)
    elif announced < 2**16:
        head = struct.pack("!BBH", first, mask | 126, announced)
    else:
        head = struct.pack("!BBQ", first, mask | 127, announced)
    return head + bytes(4 if mask else 0) + content


def test_frames(server, chance, inputs, report):
    """Frames as raw bytes; a connection that the server closes is renewed, with the same session or a new one."""
    closed = 0

    async def some(token, most):
        """Send up to so many over one connection; return how many."""
        client = Client(server.url)
        try:
            await client.connect(token)
        except ConnectionError:  # closed before a word: there are too many connections to this session
            client.socket.close()
            return 0
        stream, sent = client.socket.protocol.stream, 0
        reading = asyncio.ensure_future(read(client))
        with suppress(StreamClosedError):
            while sent < most and not reading.done():
                await stream.write(random_frame(chance))
                sent += 1
                await asyncio.sleep(0.001)  # in which the server may close it
        stream.close()
        client.socket.close()
        await asyncio.wait_for(reading, 60)
        return sent

    async def read(client):
        with suppress(ValueError):  # what answers a forged frame need not be a message
            while await client.socket.read_message() is not None:
                pass

    async def all_of_them():
        nonlocal closed
        tried, token = 0, await token_of(server.url)
        while tried < inputs:
            sent = await asyncio.wait_for(some(token, 8), 100)
            token = token if sent else await token_of(server.url)
            tried += sent
            closed += 1
        async with Client(server.url) as client:  # and another session still works
            await client.ready()
            assert (await client.set(1, eta="1.5"))["texts"]["eta"] == "1.5"
        return tried

    tried = run(all_of_them(), 3000)
    report(f"{tried} forged frames over {closed} connections: no traceback", inputs=tried, sessions=1)


def test_patches(chance, inputs, report):
    """What passes the validation is of the kinds that it names, whatever JSON holds; nothing makes it fail."""
    doc = Document()
    with set_curdoc(doc):
        doc.add_root(VIEWS["explore"](FakeHost()).build().get_root(doc))
    models = [model.id for model in doc.models]
    ranges = [model.id for model in doc.models if isinstance(model, Range1d)]
    passed = dropped = 0
    for _ in range(inputs):
        model = chance.choice((*ranges, chance.choice(models)))
        events = [forged(chance, model, chance.choice(models), random_json(chance)) for _ in range(chance.randrange(3))]
        events += [event(chance.choice(ODD), mapped({"model": {"id": model}}))] * (chance.random() < 0.1)
        content = chance.choice(({"events": events},) * 9 + (random_json(chance),))
        valid, out = valid_events(content, doc)
        assert cost_of(content) >= 2
        assert is_worth_logging(content) in (True, False)
        assert all(each["kind"] in ("ModelChanged", "MessageSent") for each in valid)
        passed, dropped = passed + len(valid), dropped + out
    report(f"{inputs} forged patches: {passed} events are allowed, {dropped} dropped", inputs=inputs)
    assert passed
    assert dropped
