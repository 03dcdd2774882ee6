"""A client for Bokeh's websocket protocol, to send what no browser would send: page, token, document, patches."""

import asyncio
import itertools
import json
import re
import time

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import websocket_connect

from tests.waiting import PATIENCE

_IDS = itertools.count(1)
BUSY = (429, 503, 599)  # 599: Tornado's client waited in vain


async def get(url, **options):
    """An answer of any status."""
    return await AsyncHTTPClient().fetch(HTTPRequest(url, request_timeout=PATIENCE, **options), raise_error=False)


async def token_of(url):
    page = await get(url)
    if page.code in BUSY:
        raise ConnectionError(f"the server answers {page.code}")
    assert page.code == 200, page.code
    return re.search(r'"token":"([^"]+)"', page.body.decode())[1]


def move(texts, number=1):
    """The data of a message that sets numbers."""
    return mapped({"set": mapped(texts), "move": number})


def mapped(values):
    return {"type": "map", "entries": [[name, value] for name, value in values.items()]}


class Client:
    """One session, as a browser would hold it; after `open` it has the document of the page."""

    def __init__(self, url, query="", headers=None, compression=None):
        self.url, self.query, self.headers = url, query, headers or {}
        self.compression = compression  # options of Tornado's client; {} as a browser, None: none
        self.patience = PATIENCE  # s that the controls may take to show something
        self.closed = False  # by the server
        self.answers = []  # in the order in which they came

    async def connect(self, token=None, origin=None):
        """Connect, so that the session is built; nothing is requested yet."""
        token = token or await token_of(f"{self.url}/?{self.query}")
        address = f"{self.url.replace('http', 'ws', 1)}/ws?{self.query}"
        # A browser, too, waits while sessions are built for others.
        request = HTTPRequest(address, headers={"Origin": origin or self.url} | self.headers, request_timeout=PATIENCE)
        self.socket = await websocket_connect(
            request, subprotocols=["bokeh", token], compression_options=self.compression
        )
        self.socket.protocol.stream.set_nodelay(True)  # else a message of three frames waits 40 ms for an answer
        if (message := await self.receive()) is None:
            self.socket.close()
            raise ConnectionError("the server ended the connection before it was open")
        assert message["msgtype"] == "ACK"
        return self

    async def open(self, token=None, origin=None):
        await self.connect(token, origin)
        await self.send("PULL-DOC-REQ", {})
        self.document = (await self.answer("PULL-DOC-REPLY"))["content"]["doc"]
        return self

    async def knock(self, token=None, origin=None):
        """Status of the answer to an attempt to connect."""
        headers = {
            "Upgrade": "websocket",
            "Connection": "Upgrade",
            "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
            "Sec-WebSocket-Version": "13",
            "Sec-WebSocket-Protocol": f"bokeh, {token or await token_of(self.url)}",
            "Origin": origin or self.url,
        }
        return (await get(f"{self.url}/ws", headers=headers)).code

    async def __aenter__(self):
        return await self.open()

    async def __aexit__(self, *_):
        self.socket.close()

    # -- frames ----------------------------------------------------------------

    async def receive(self):
        """The next message, its header and content in one; None once the server has closed."""
        parts = []
        for _ in range(3):
            part = None if self.closed else await self.socket.read_message()
            if part is None:
                self.closed = True  # another call of Tornado's would wait for ever
                return None
            parts.append(part)
        header, _, content = map(json.loads, parts)
        for _ in range(2 * header.get("num_buffers", 0)):
            await self.socket.read_message()
        message = {**header, "content": content}
        self.answers.append(message)
        return message

    async def answer(self, kind):
        while (message := await self.receive()) is not None:
            if message["msgtype"] == kind:
                return message
        raise ConnectionError(f"closed before {kind}")

    async def send(self, kind, content):
        header = {"msgid": str(next(_IDS)), "msgtype": kind}
        parts = [part if isinstance(part, str) else json.dumps(part) for part in (header, {}, content)]
        # At once: with a pause between them, two that send would mix their parts. Tornado logs a traceback for a write
        # that is cancelled.
        await asyncio.shield(asyncio.gather(*map(self.socket.write_message, parts)))
        return header["msgid"]

    async def patch(self, *events):
        """Send a patch and wait for the answer; None if the server closed the connection instead."""
        number = await self.send("PATCH-DOC", {"events": list(events)})
        while (message := await self.receive()) is not None:
            if message.get("reqid") == number:
                return message
        return None

    # -- the page ---------------------------------------------------------------

    def models(self, kind):
        """Every object of a kind in the document, as it was received."""
        return list(objects(self.document, kind))

    def component(self, name):
        """Identifier of one of the page's own components."""
        return next(m["id"] for m in self.models("ReactiveESM") if m["attributes"].get("class_name") == name)

    def message(self, data, name="Controls"):
        values = {"type": "map", "entries": [["model", {"id": self.component(name)}], ["data", data]]}
        return event("data_event", values)

    async def ready(self):
        return await self.patch(event("document_ready", {"type": "map"}))

    async def set(self, number=1, **texts):
        """Set some parameters; returns what the controls then show (`app.page.controls.controls`)."""
        await self.patch(self.message(move(texts, number)))
        return await self.shown(lambda shown: shown.get("move") == number)

    async def shown(self, holds):
        """What the controls show, once ``holds`` is true of it."""
        end = time.monotonic() + self.patience
        while time.monotonic() < end:
            for message in reversed(self.answers):
                for shown in _shown(message):
                    if holds(shown):
                        return shown
            if await self.receive() is None:
                break
        raise AssertionError(f"never shown: {[shown for m in self.answers for shown in _shown(m)][-2:]}")


def event(name, values):
    data = {"type": "event", "name": name, "values": values}
    return {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": data}


def changed(model, attribute, value):
    return {"kind": "ModelChanged", "model": {"id": model}, "attr": attribute, "new": value}


def objects(part, kind):
    """Every object of a kind in a part of a document."""
    if isinstance(part, dict):
        if part.get("type") == "object" and part.get("name", "").endswith(kind):
            yield part
        part = list(part.values())
    if isinstance(part, list):
        for item in part:
            yield from objects(item, kind)


def _shown(message):
    """Every value of ``shown`` in a patch or in the document."""
    if message["msgtype"] == "PULL-DOC-REPLY":
        yield from (plain(m["attributes"]["shown"]) for m in objects(message["content"]["doc"], "Controls1"))
        return
    for change in message["content"].get("events", []) if isinstance(message["content"], dict) else []:
        if change.get("attr") == "shown":
            yield plain(change["new"])


def plain(value):
    """A serialised value as a Python object."""
    if isinstance(value, dict) and value.get("type") == "map":
        return {name: plain(item) for name, item in value.get("entries", [])}
    return [plain(item) for item in value] if isinstance(value, list) else value
