"""What one request, one connection and one address may cost. No panel import."""

from __future__ import annotations

import time

from app.settings import in_force


class TooMuch(ValueError):
    """More than this server does for one request; the text is for the user."""


def check_cost(steps: int, periods: int, cells: int = 1) -> None:
    """Refuse a request that asks for more time steps than the server grants (``VIBROSCOPE_STEPS``).

    Parameters
    ----------
    steps, periods, cells
        Time steps of a period, periods of a run, and runs.

    Raises
    ------
    TooMuch
        With what was asked for, what is granted, and what to do.
    """
    asked, granted = steps * periods * cells, in_force().steps
    if asked > granted:
        runs = f" × {cells:,} runs" if cells > 1 else ""
        raise TooMuch(
            f"That is {steps:,} steps × {periods:,} periods{runs} = {asked:,} steps, and this server does {granted:,} "
            "for one request: take fewer steps, or run Vibroscope on your own machine."
        )


class Bucket:
    """A token bucket: ``rate`` a second for ever, ``burst`` at once.

    Parameters
    ----------
    rate, burst
        Tokens a second, and at most.
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._tokens, self._seen = burst, time.monotonic()

    def take(self, tokens: float = 1.0) -> bool:
        """Take so many, or none if there are not enough."""
        now = time.monotonic()
        self._tokens = min(self._burst, self._tokens + (now - self._seen) * self._rate)
        self._seen = now
        if self._tokens < tokens:
            return False
        self._tokens -= tokens
        return True
