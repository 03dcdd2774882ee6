"""Telling the noise of Newmark's constant step from motion.

A constant step finds each contact change late by a part of a step, another part each time. The discrete map is made of
affine pieces, one for each sequence of steps with and without contact, with a jump of the order of Δτ where two of them
meet; and a section that would be a point is a band. What the map's own derivative says is of no use: within a piece the
instant of contact does not move at all, and the few steps of a short contact turn and stretch a disturbance by chance.
At η = 2.76, K = 12000, D = 18 and T/2000 its largest exponent is positive about a motion that is periodic; at η = 1.70
it is negative in the midst of a motion that is chaotic. So another question decides:

    what is left as Δτ → 0?

The limit is the exact penalty motion with the same K and D, followed from where the Newmark run ended; and the band is
measured again with 4, 16 and 64 times as many steps, from there on as well, until it has clearly shrunk. A band that
shrinks about the limit's points is an artefact of the step; one that keeps its width beside a chaotic limit is motion.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..methods import STEPS_RANGE, Newmark
from ..result import Response
from ..simulate import simulate
from .description import Kind, Motion
from .section import TOLERANCE, band, repeats_after

FINER = (4, 16, 64)
FINER_LOCATED = (4,)  # its error falls as the square of the step, and all its steps are walked
SHRUNK = 0.5  # in proportion to the step it would be a quarter each time, were it not for chance
TRANSIENT, KEEP = 768, 256  # periods of each run with finer steps


class Verdict(NamedTuple):
    """What a Newmark run shows."""

    type: Kind
    period: int
    reason: str
    noise: float  # band that is due to the step
    bands: tuple[tuple[int, float], ...]  # steps per period, band


def told_apart(run: Response, limit: Motion, cancelled: Callable[[], bool] | None = None) -> Verdict:
    """Judge the section of a Newmark run by the exact penalty motion that begins where it ends.

    Parameters
    ----------
    run : Response
        Of Newmark, at its end.
    limit : Motion
        With its evidence.
    """
    own, period = repeats_after(run.section), limit.period or 1
    width = band(run.section, period)
    blurred = width > TOLERANCE * np.abs(run.section).max()
    whole = "every period" if limit.period == 1 else f"every {limit.period} periods"
    if own and (not blurred or own == limit.period):
        return Verdict(Kind.PERIODIC, own, f"the section repeats itself after {_counted(own)}", 0.0, ())
    bands = ((run.method.steps, width), *_finer_bands(run, period, width, cancelled))
    listed = ", ".join(f"{sigma:.2g} at {steps}" for steps, sigma in bands)
    if limit.type is Kind.PERIODIC and bands[-1][1] < SHRUNK * width:
        reason = (
            f"the section is a band, but an artefact of the time step: its width shrinks with it (standard deviation "
            f"{listed} steps per period), and without a time step the motion repeats itself {whole}"
        )
        return Verdict(Kind.PERIODIC, limit.period, reason, width, bands)
    if own:
        reason = f"the section repeats itself after {_counted(own)}; without a time step the motion is {limit.type}"
        return Verdict(Kind.PERIODIC, own, reason, 0.0, bands)
    if limit.type in (Kind.CHAOTIC, Kind.QUASI_PERIODIC) and bands[-1][1] > SHRUNK * width:
        reason = (
            f"without a time step the motion is {limit.type} ({limit.reason}), and the band does not shrink with the "
            f"step (standard deviation {listed} steps per period)"
        )
        return Verdict(limit.type, 0, reason, 0.0, bands)
    reason = (
        f"the section is a band (standard deviation {listed} steps per period), and without a time step the motion is "
        f"{limit.type}: more steps per period would tell"
    )
    return Verdict(Kind.UNDECIDED, 0, reason, 0.0, bands)


def _finer_bands(run: Response, period: int, width: float, cancelled) -> list[tuple[int, float]]:
    bands = []
    for factor in FINER_LOCATED if run.method.located else FINER:
        steps = factor * run.method.steps
        if steps > STEPS_RANGE[1]:
            break
        method: Newmark = replace(run.method, steps=steps, every_step=False)
        options = {"periods": TRANSIENT + KEEP, "keep": KEEP, "initial": run.section[-1], "cancelled": cancelled}
        finer = simulate(run.system, run.eta, method, **options)
        if not finer.ok:
            break
        bands.append((steps, band(finer.section, period)))
        if bands[-1][1] < SHRUNK**2 * width:
            break
    return bands


def _counted(periods: int) -> str:
    return "1 period" if periods == 1 else f"{periods} periods"
