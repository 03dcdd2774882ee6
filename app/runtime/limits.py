"""Limits on the cost of one request and on the rate of messages. No panel import."""

from __future__ import annotations

import time

from vibroscope.app.runtime.settings import current_settings


class CostLimitError(ValueError):
    """A request costs more than this server allows; the text is for the user."""


def check_cost(steps: int, periods: int) -> None:
    """Refuse a request that takes more time steps than the server allows (``VIBROSCOPE_STEPS``).

    Studies need no such check: their number of cells and their time limit are fixed.

    Parameters
    ----------
    steps, periods
        Time steps per period, and number of periods.

    Raises
    ------
    CostLimitError
        Its text names the cost, the limit, and what the user can do.
    """
    asked, granted = steps * periods, current_settings().steps
    if asked > granted:
        raise CostLimitError(
            f"That is {steps:,} steps × {periods:,} periods = {asked:,} steps, and this server does {granted:,} "
            "for one request: take fewer steps, or run Vibroscope on your own machine."
        )


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
