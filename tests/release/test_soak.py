"""Memory is flat while sessions come, move and go for some minutes."""

import asyncio
import os
import time

from tests.browserless import Client, move
from tests.release.odd import run
from tests.served import served

SECONDS = float(os.environ.get("RELEASE_SOAK", "180"))


def test_soak(tmp_path, tell):
    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_LEVEL="warning") as server:
        measured = []

        async def visitor(number):
            async with Client(server.url) as client:
                await client.ready()
                for turn in range(6):
                    eta = f"{0.6 + (number * 6 + turn) % 3000 / 1000:.3f}"
                    await client.patch(client.message(move({"eta": eta}, turn)))
                    await asyncio.sleep(0.3)

        async def all_of_them():
            begun, number = time.monotonic(), 0
            while time.monotonic() < begun + SECONDS:
                await asyncio.gather(*(visitor(number + n) for n in range(4)))
                number += 4
                measured.append(server.memory())
            return number

        number = run(all_of_them(), SECONDS + 120)
    half = measured[len(measured) // 2 :]
    growth = half[-1] - half[0]
    told = f"{number} sessions in {SECONDS:.0f} s, {half[-1]:.0f} MB, {growth:+.1f} MB in the second half"
    tell(f"soak: {told}", sessions=number)
    assert growth < 40
