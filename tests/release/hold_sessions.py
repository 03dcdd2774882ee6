"""Open several sessions and move each: ``hold_sessions.py ADDRESS [SESSIONS]``; fails if one does not work."""

import asyncio
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.browserless import Client, token_of


async def main(url, sessions=3):
    tokens = await asyncio.gather(*(token_of(url) for _ in range(sessions)))
    clients = await asyncio.gather(*(Client(url, f"eta=1.{n + 10}").open(token) for n, token in enumerate(tokens)))
    for number, client in enumerate(clients):
        await client.ready()
        shown = await client.set(1, eta=f"2.{number + 10}")
        assert shown["texts"]["eta"] == f"{2.1 + number / 100:.2f}".rstrip("0")
    for client in clients:
        client.socket.close()


if __name__ == "__main__":
    asyncio.run(asyncio.wait_for(main(sys.argv[1], *map(int, sys.argv[2:])), 400))
