"""Separate the scatter that Newmark's constant step causes from motion.

A constant step detects each contact change late by a part of a step, which differs from one change to the next. The
discrete map therefore consists of affine pieces, one for each sequence of steps with and without contact, with jumps of
the order of Δτ between them, and a section that should be a point is a band. The derivative of the discrete map does
not distinguish this scatter from motion: within a piece the instant of contact does not move at all, and the few steps
of a short contact rotate and stretch a disturbance at random. (For K = 12000, D = 18 and T/2000, the largest exponent
of the map is positive at η = 2.76, where the motion is periodic, and negative at η = 1.70, where it is chaotic.) The
limit Δτ → 0 decides instead:

- The exact penalty motion with the same K and D is that limit. It is started where the Newmark run ended.
- The band is measured again with 4, 16 and 64 times as many steps, from the same state, until it has clearly shrunk.

A band that shrinks towards the points of the limit is an artefact of the time step. A band that keeps its width beside
a chaotic limit is motion. A band that narrows with the same step too, as time goes on, is the rest of a transient, and
is judged later (:func:`later_run`). A band about other points than those of the limit is another motion, and smaller
steps say nothing of it (:func:`is_about_cycle`).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..drivers.section import TOLERANCE, period_of
from ..methods import STEPS_RANGE
from ..result import Response
from ..simulate import simulate
from ..wording import counted, every, rounded
from .description import Kind, Motion
from .section import band_width, cycle_spread, scatter
from .words import SYMBOLS

FINER = (4, 16, 64)  # times as many steps per period
FINER_LOCATED = (4,)  # located steps converge quadratically, and none of them is skipped
CLEAR = 1.0  # spread of a cycle, in widths of a band, from which on a band about its points must show them
SHOWN = 0.5  # of the distances between the points of a cycle; a band that does not show it has some of them by chance
SHRUNK = 0.5  # a width in proportion to Δτ would fall to a quarter each time; chance needs some room
TRANSIENT, KEEP = 768, 256  # periods of each run with finer steps


class Band(NamedTuple):
    """The band of a section with so many steps per period."""

    steps: int
    width: float  # :func:`.section.band_width`, by which it is judged
    scatter: float  # of the observed body alone (:func:`.section.scatter`), which is what sentences state


class SectionJudgement(NamedTuple):
    """Type of a Newmark motion, and how much its section scatters by the time step."""

    type: Kind
    period: int
    reason: str
    step_noise: float  # scatter of the observed body if the time step causes it, else 0
    bands: tuple[tuple[int, float], ...]  # steps per period, scatter of the observed body


def judge_newmark_section(
    run: Response, limit: Motion, cancelled: Callable[[], bool] | None = None
) -> SectionJudgement:
    """Decide what the section of a Newmark run shows.

    Parameters
    ----------
    run : Response
        Of Newmark, or of another method with a time step.
    limit : Motion
        The exact penalty motion that begins where the run ends, with its evidence.
    """
    own_period = period_of(run.section)
    period = _period_of_band(run, limit)
    own = _band(run, period)
    is_band = own.width > TOLERANCE * np.abs(run.section).max()
    if shown := period_shown(own_period, limit.period, is_band):
        reason = f"the section repeats itself after {counted(shown, 'period')}"
        return SectionJudgement(Kind.PERIODIC, shown, reason, 0.0, ())
    about_cycle = is_about_cycle(run.section, period, cycle_spread(limit.section, period))
    bands = (own, *(_finer_bands(run, period, own.width, cancelled) if about_cycle else ()))
    widths = ", ".join(f"±{rounded(each.scatter, 2)} at T/{each.steps}" for each in bands)
    listed = f"{widths} in {SYMBOLS[run.system.observed_body]}, over {len(run.section)} periods"
    shrinks = has_shrunk(bands[-1].width, own.width)
    decided, period, artefact = type_of_band(own_period, limit.type, limit.period, shrinks)
    if artefact:
        reason = (
            f"the section is a band, but an artefact of the time step: its width shrinks with it ({listed}), and "
            f"without a time step the motion repeats itself {every(limit.period)}"
        )
    elif own_period:
        after = counted(own_period, "period")
        reason = f"the section repeats itself after {after}; without a time step the motion is {limit.type}"
    elif not about_cycle:
        reason = (
            f"the section is a band ({listed}), but not about the points of the "
            f"motion without a time step, which repeats itself {every(limit.period)}: with this time step it is "
            "another motion"
        )
    elif decided is Kind.UNDECIDED:
        is_seen = limit.period <= _period_of_band(run, limit)
        what = "more steps per period would decide" if is_seen else "too long a cycle for these periods to show it"
        reason = (
            f"the section is a band ({listed}), and without a time step the motion "
            f"is {limit.type} ({limit.reason}): {what}"
        )
    else:
        reason = (
            f"without a time step the motion is {limit.type} ({limit.reason}), and the band does not shrink with the "
            f"step ({listed})"
        )
    shown = tuple((each.steps, each.scatter) for each in bands)
    return SectionJudgement(decided, period, reason, own.scatter if artefact else 0.0, shown)


def _band(run: Response, period: int) -> Band:
    section = run.section
    return Band(run.method.steps, band_width(section, period), scatter(section, period, run.system.observed_body))


def _period_of_band(run: Response, limit: Motion) -> int:
    """The period about whose points the section is a band; 1, its mean, where it has not two cycles of the limit."""
    return limit.period if 0 < 2 * limit.period <= min(len(run.section), KEEP) else 1


def later_run(run: Response, limit: Motion, cancelled: Callable[[], bool] | None = None) -> Response | None:
    """Go on with a Newmark run whose section is a band beside a limit that repeats itself, with the same step.

    Returns
    -------
    Response or None
        None if the band keeps its width: then it is no rest of a transient.
    """
    how = {"periods": TRANSIENT + 2 * run.keep, "keep": run.keep, "initial": run.checkpoint, "cancelled": cancelled}
    later = simulate(run.system, run.eta, run.method, **how)
    period = _period_of_band(run, limit)
    narrowed = later.ok and band_width(later.section, period) < SHRUNK * band_width(run.section, period)
    return later if narrowed else None


def period_shown(own_period: int, limit_period: int, is_band: bool) -> int:
    """The period that a section shows by itself, 0 if none.

    The limit decides between a cycle and a multiple of it, after which the rest of a transient returns more nearly.

    Parameters
    ----------
    own_period, limit_period : int
        Of the section and of the motion without a time step, 0 if it does not repeat itself.
    is_band : bool
        Whether the section deviates from the points of the limit's cycle by more than the tolerance.
    """
    if is_band:
        return own_period if own_period == limit_period else 0
    return min(filter(None, (own_period, limit_period)), default=0)


def is_about_cycle(section: np.ndarray, period: int, spread: float) -> bool:
    """Whether a band may lie about the points of a cycle: where it must show their distances, it has them.

    Parameters
    ----------
    section : (n, 4) ndarray
    period : int
        Of the cycle.
    spread : float
        :func:`.section.cycle_spread` of the cycle.
    """
    return spread <= CLEAR * band_width(section, period) or cycle_spread(section, period) > SHOWN * spread


def has_shrunk(finer, width):
    """Whether the last of the bands with smaller steps is clearly narrower than that with the step itself."""
    return finer < SHRUNK * width


def is_narrow(finer, width):
    """Whether a band with smaller steps is so narrow that no run with still smaller ones is needed."""
    return finer < SHRUNK**2 * width


def type_of_band(own_period: int, limit: Kind, limit_period: int, shrinks: bool) -> tuple[Kind, int, bool]:
    """Decide what a band in a Newmark section is.

    Parameters
    ----------
    own_period : int
        Periods after which the scattered section happens to repeat itself; 0 if it does not.
    limit, limit_period
        Type and period of the motion without a time step.
    shrinks : bool
        Whether the band shrinks with the step.

    Returns
    -------
    type : Kind
    period : int
        Of the motion without the scatter.
    artefact : bool
        Whether the time step causes the band.
    """
    if limit is Kind.PERIODIC and shrinks:
        return Kind.PERIODIC, limit_period, True
    if own_period:
        return Kind.PERIODIC, own_period, False
    if limit in (Kind.CHAOTIC, Kind.QUASI_PERIODIC) and not shrinks:
        return limit, 0, False
    return Kind.UNDECIDED, 0, False


def _finer_bands(run: Response, period: int, width: float, cancelled) -> list[Band]:
    """The band with more and more steps, until its width is clearly smaller than ``width``."""
    bands = []
    for factor in FINER_LOCATED if run.method.located else FINER:
        steps = factor * run.method.steps
        if steps > STEPS_RANGE[1]:
            break
        skipping = {"every_step": False} if run.method.has_step else {}
        method = replace(run.method, steps=steps, **skipping)
        options = {"periods": TRANSIENT + KEEP, "keep": KEEP, "initial": run.section[-1], "cancelled": cancelled}
        finer = simulate(run.system, run.eta, method, **options)
        if not finer.ok:
            break
        bands.append(_band(finer, period))
        if is_narrow(bands[-1].width, width):
            break
    return bands
