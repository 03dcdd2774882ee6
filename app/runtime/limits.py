"""What one request, one connection and one address may cost. No panel import."""

from __future__ import annotations

import time

from vibroscope.app.runtime.settings import in_force


class TooMuch(ValueError):
    """More than this server does for one request; the text is for the user."""


def check_cost(steps: int, periods: int) -> None:
    """Refuse a request that asks for more time steps than the server grants (``VIBROSCOPE_STEPS``).

    The studies need none of this: how many cells they have is fixed, and so is the time that they may take.

    Parameters
    ----------
    steps, periods
        Time steps of a period, and periods.

    Raises
    ------
    TooMuch
        With what was asked for, what is granted, and what to do.
    """
    asked, granted = steps * periods, in_force().steps
    if asked > granted:
        raise TooMuch(
            f"That is {steps:,} steps × {periods:,} periods = {asked:,} steps, and this server does {granted:,} "
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
