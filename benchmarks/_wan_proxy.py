"""Emulates a line of the given delay and rate between a browser and a server on this machine.

Bytes of one direction leave one after another at the line's rate and arrive after the delay; all connections share the
line, as a visitor's do. What does not fit into a router's buffer waits at its sender.

.venv/bin/python benchmarks/_wan_proxy.py PORT TARGET_PORT [DELAY_MS] [MBIT_S]
"""

import asyncio
import sys
from contextlib import suppress

PIECE = 4 * 1460  # bytes that pass at once
BUFFER = 64  # pieces under way in one direction of one connection, some 370 kB


class Direction:
    """One direction of the line, shared by all connections."""

    def __init__(self, delay, rate):
        self.delay, self.rate = delay, rate
        self.free_at = 0.0

    def due(self, size):
        """The time at which so many bytes have arrived, if the first enters now."""
        now = asyncio.get_running_loop().time()
        self.free_at = max(now, self.free_at) + size / self.rate
        return self.free_at + self.delay

    async def carry(self, reader, writer):
        """Carry all bytes until the connection ends."""
        under_way = asyncio.Queue(BUFFER)
        arriving = asyncio.create_task(self.deliver(under_way, writer))
        with suppress(ConnectionError):
            while piece := await reader.read(PIECE):
                await under_way.put((self.due(len(piece)), piece))
        await under_way.put((self.due(0), b""))
        await arriving

    async def deliver(self, under_way, writer):
        """Write each piece when it is due; an empty one ends the connection."""
        with suppress(ConnectionError):
            while True:
                due, piece = await under_way.get()
                await asyncio.sleep(due - asyncio.get_running_loop().time())
                if not piece:
                    break
                writer.write(piece)
                await writer.drain()
        writer.close()


async def main(port, target, delay=25.0, megabits=20.0):
    """Carry until a signal ends it."""
    up, down = (Direction(delay / 1000, megabits * 1e6 / 8) for _ in range(2))

    async def connect(reader, writer):
        there, back = await asyncio.open_connection("127.0.0.1", target)
        await asyncio.gather(up.carry(reader, back), down.carry(there, writer))

    server = await asyncio.start_server(connect, "127.0.0.1", port)
    await server.serve_forever()


if __name__ == "__main__":
    numbers = [float(text) for text in sys.argv[3:]]
    asyncio.run(main(int(sys.argv[1]), int(sys.argv[2]), *numbers))
