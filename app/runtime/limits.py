"""Limits on the rate of messages, and on work that holds the loop up. No panel import."""

import time
from asyncio import CancelledError, Future, get_running_loop, sleep
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


class TokenBucket:
    """A token bucket: it holds at most ``burst`` tokens and gains ``rate`` tokens per second."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._tokens, self._updated = burst, time.monotonic()

    def take(self, tokens: float = 1.0) -> bool:
        """Take ``tokens`` and return True; take none and return False if there are fewer."""
        now = time.monotonic()
        self._tokens = min(self._burst, self._tokens + (now - self._updated) * self._rate)
        self._updated = now
        if self._tokens < tokens:
            return False
        self._tokens -= tokens
        return True

    def owe(self, tokens: float) -> float:
        """Take ``tokens`` in any case; return the seconds until there are none owed."""
        self.take(0.0)
        self._tokens -= tokens
        return max(0.0, -self._tokens / self._rate)


class Turns:
    """Work that holds up the loop, one piece at a time, in turn by owner, with rests in which the loop serves others.

    The next piece is that of the owner who has used least of the loop's time lately, not the one that came first. The
    more an owner has used, the longer the rest after its piece, up to the length of the piece; at first there is none.
    """

    HALF_LIFE = 10.0  # s after which half of what an owner has had is forgotten
    FULL_REST = 2.0  # s: after so much time of one owner a rest is as long as the piece
    PENALTY = 5.0  # s for which an owner that asked for too much waits before it may ask again

    def __init__(self) -> None:
        self._waiting: list[tuple[str, Future[None]]] = []
        self._busy = False
        self._had: dict[str, float] = {}
        self._barred: dict[str, float] = {}  # until when
        self._counted = time.monotonic()

    def penalise(self, owner: str) -> None:
        """Let an owner wait before its next turn."""
        now = time.monotonic()
        self._barred = {name: until for name, until in self._barred.items() if until > now}
        self._barred[owner] = now + self.PENALTY

    @asynccontextmanager
    async def turn(self, owner: str) -> AsyncIterator[None]:
        """Wait for a turn, which the block then has."""
        while (wait := self._barred.get(owner, 0.0) - time.monotonic()) > 0:
            await sleep(wait)
        if self._busy:
            waits = get_running_loop().create_future()
            self._waiting.append((owner, waits))
            try:
                await waits
            except CancelledError:
                if waits.done() and not waits.cancelled():  # it was its turn
                    self._next()
                else:
                    self._waiting.remove((owner, waits))
                raise
        self._busy, begun = True, time.monotonic()
        try:
            yield
        finally:
            seconds = time.monotonic() - begun
            self._forget()
            before = self._had.get(owner, 0.0)
            self._had[owner] = before + seconds
            get_running_loop().call_later(seconds * min(1.0, before / self.FULL_REST), self._next)

    def _next(self) -> None:
        self._waiting = [entry for entry in self._waiting if not entry[1].done()]
        if not self._waiting:
            self._busy = False
            return
        self._forget()
        entry = min(self._waiting, key=lambda entry: self._had.get(entry[0], 0.0))
        self._waiting.remove(entry)
        entry[1].set_result(None)

    def _forget(self) -> None:
        now = time.monotonic()
        kept = 0.5 ** ((now - self._counted) / self.HALF_LIFE)
        self._counted = now
        self._had = {name: had * kept for name, had in self._had.items() if had * kept > 1e-3}
