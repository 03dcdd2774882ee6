import asyncio
from asyncio import Future

import pytest
from tornado.iostream import StreamClosedError
from vibroscope.app.server.batched_writes import UNREAD, Gathered

TEXT, CLOSE = b"\x81\x01a", b"\x88\x00"


class Stream:
    def __init__(self, closed=False):
        self.written, self.closed = [], closed
        self._write_buffer = bytearray()  # as Tornado keeps what the system has not taken

    def write(self, data):
        if self.closed:
            raise StreamClosedError
        self.written.append(data)
        self._write_buffer += data
        return Future()  # never done: nobody reads


def nobody():
    raise AssertionError("it reads")


def test_frames_of_one_turn_leave_together():
    async def steps():
        stream = Stream()
        write = Gathered(stream, nobody)
        sent = [write(TEXT), write(TEXT)]
        assert stream.written == []
        await asyncio.gather(*sent)
        await write(TEXT)
        return stream.written

    assert asyncio.run(steps()) == [TEXT + TEXT, TEXT]


def test_a_control_frame_waits_for_nothing():
    async def steps():
        stream = Stream()
        write = Gathered(stream, nobody)
        write(TEXT)
        write(CLOSE)
        return stream.written  # and nothing later

    assert asyncio.run(steps()) == [TEXT + CLOSE]


def test_whoever_waits_hears_that_the_connection_is_gone():
    async def steps():
        with pytest.raises(StreamClosedError):
            await Gathered(Stream(closed=True), nobody)(TEXT)

    asyncio.run(steps())


def test_one_that_never_reads_holds_up_nobody_and_is_let_go_once():
    async def steps():
        stream, let_go = Stream(), []

        def farewell():
            let_go.append(len(stream._write_buffer))
            write(CLOSE)

        write = Gathered(stream, farewell)
        for _ in range(20):
            await asyncio.wait_for(write(bytes(1_000_000)), 1)
        return let_go

    assert asyncio.run(steps()) == [UNREAD + 1_000_000]
