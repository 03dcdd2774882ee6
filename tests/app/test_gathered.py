import asyncio
from asyncio import Future

import pytest
from tornado.iostream import StreamClosedError

from app.gathered import Gathered

TEXT, CLOSE = b"\x81\x01a", b"\x88\x00"


class Stream:
    def __init__(self, fault=None):
        self.written, self.fault = [], fault

    def write(self, data):
        if self.fault == "at once":
            raise StreamClosedError
        self.written.append(data)
        sent = Future()
        if self.fault:
            sent.set_exception(StreamClosedError())
        else:
            sent.set_result(None)
        return sent


def test_frames_of_one_turn_leave_together():
    async def steps():
        stream = Stream()
        write = Gathered(stream)
        sent = [write(TEXT), write(TEXT)]
        assert stream.written == []
        await asyncio.gather(*sent)
        await write(TEXT)
        return stream.written

    assert asyncio.run(steps()) == [TEXT + TEXT, TEXT]


def test_a_control_frame_waits_for_nothing():
    async def steps():
        stream = Stream()
        write = Gathered(stream)
        write(TEXT)
        write(CLOSE)
        return stream.written  # and nothing later

    assert asyncio.run(steps()) == [TEXT + CLOSE]


@pytest.mark.parametrize("fault", ["at once", "later"])
def test_whoever_waits_hears_that_the_connection_is_gone(fault):
    async def steps():
        with pytest.raises(StreamClosedError):
            await Gathered(Stream(fault))(TEXT)

    asyncio.run(steps())
