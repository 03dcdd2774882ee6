"""Sessions through a proxy: ``through_proxy.py ADDRESS [SESSIONS]``; ends with an error if one does not work."""

import asyncio
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.browserless import Client


async def session(url, number):
    async with Client(url, f"eta=1.{number + 10}") as client:
        await client.ready()
        told = await client.set(1, eta=f"2.{number + 10}")
        assert told["texts"]["eta"].startswith(f"2.{number + 10}".rstrip("0"))


async def main(url, sessions=3):
    for number in range(sessions):
        await asyncio.wait_for(session(url, number), 60)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], *map(int, sys.argv[2:])))
