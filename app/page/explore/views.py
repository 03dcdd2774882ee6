"""The figures of Explore, made one by one, so that the loop serves other sessions between them.

Making them takes most of the time that opening a page takes. `make_between` makes them beforehand; otherwise
`make_views` makes all at once. Both give the same.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Generator
from contextvars import ContextVar
from typing import NamedTuple

from vibroscope.app.explorer.present import WINDOW
from vibroscope.app.page.explore.displacement import DisplacementView
from vibroscope.app.page.explore.eta_map import EtaMapView
from vibroscope.app.page.explore.force import ForceView
from vibroscope.app.page.explore.phase import PhaseView
from vibroscope.app.page.shared.ranges import OwnedRange


class Views(NamedTuple):
    """The figures, and the axis of time that two of them share."""

    time: OwnedRange
    phase: PhaseView
    displacement: DisplacementView
    force: ForceView
    eta_map: EtaMapView


_made: ContextVar[Views | None] = ContextVar("made", default=None)  # beforehand, for the page that is built next


def _pieces() -> Generator[None, None, Views]:
    """Yield after each figure; returns them."""
    axis, phase = OwnedRange(0, WINDOW), PhaseView()
    yield
    displacement = DisplacementView(axis.range)
    yield
    force = ForceView(axis.range)
    yield
    return Views(axis, phase, displacement, force, EtaMapView(phase.sections))


def make_views() -> Views:
    """The figures: those made beforehand, once, or new ones."""
    made = _made.get()
    _made.set(None)
    pieces = _pieces()
    while made is None:
        try:
            next(pieces)
        except StopIteration as end:
            made = end.value
    return made


async def make_between(rests: Callable[[], bool]) -> None:
    """Make the figures for the page that this task builds next.

    Parameters
    ----------
    rests : callable
        Whether others are to be served between two figures, for as long as each takes.
    """
    pieces = _pieces()
    while True:
        begun = time.monotonic()
        try:
            next(pieces)
        except StopIteration as end:
            _made.set(end.value)
            return
        await asyncio.sleep(time.monotonic() - begun if rests() else 0)
