"""Separate the scatter that Newmark's constant step causes from motion.

A constant step detects each contact change late by a part of a step, which differs from one change to the next. The
discrete map therefore consists of affine pieces, one for each sequence of steps with and without contact, with jumps of
the order of Δτ between them, and a section that should be a point is a band. The derivative of the discrete map does
not distinguish this scatter from motion: within a piece the instant of contact does not move at all, and the few steps
of a short contact rotate and stretch a disturbance at random. (For K = 12000, D = 18 and T/2000, the largest exponent
of the map is positive at η = 2.76, where the motion is periodic, and negative at η = 1.70, where it is chaotic.) The
limit Δτ → 0 decides instead:

- The exact penalty motion with the same K and D is that limit. It is started where the Newmark run ended.
- The band is measured again with 4, 16 and 64 times as many steps, from the same state, until it has clearly shrunk:
  beside a limit that does not repeat itself with 4 times as many only, and not at all beside one that nothing decided.

A band that shrinks towards the points of the limit is an artefact of the time step. A band that keeps its width beside
a chaotic limit is motion. A band that narrows with the same step too, as time goes on, is the rest of a transient, and
is judged later (:mod:`.judge`). A band about other points than those of the limit is another motion, and smaller
steps say nothing of it (:func:`_is_about_cycle`).

:func:`judge_bands` judges the sections of many motions together; :func:`section_judgement` says in words what it found
of one of them.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.section import TOLERANCE, periods_of, sizes_of
from vibroscope.engine.facts import Amount, Statement, Symbol, joined, stated
from vibroscope.engine.methods import STEPS_RANGE
from vibroscope.engine.motions.description import CellKind, Kind, Motion
from vibroscope.engine.motions.section import band_widths, cycle_spreads, scatter
from vibroscope.engine.motions.tolerances import CLEAR_SPREAD, REPEATED_BAND, SHOWN_SPREAD, SHRUNK
from vibroscope.engine.motions.words import SYMBOLS
from vibroscope.engine.result import Response
from vibroscope.engine.wording import counted, every

FINER = (4, 16, 64)  # times as many steps per period
FINER_LOCATED = (4,)  # located steps converge quadratically, and all of them are taken
SCATTER_TRANSIENT, SCATTER_KEEP = 768, 256  # periods of each run with finer steps


class Limits(NamedTuple):
    """What motions with a time step are without one.

    Attributes
    ----------
    kinds : (n,) ndarray of int
        `CellKind`.
    periods : (n,) ndarray of int
        0 if a motion does not repeat itself.
    spreads : (n,) ndarray
        :func:`.section.cycle_spreads` of the cycles.
    """

    kinds: np.ndarray
    periods: np.ndarray
    spreads: np.ndarray


class Judgements(NamedTuple):
    """What the sections of motions with a time step show, each (n,).

    Attributes
    ----------
    kinds : ndarray of int
        `CellKind`; an artefact is a band about a cycle that the time step causes.
    periods : ndarray of int
        Of the motion without the scatter; 0 if it does not repeat itself.
    about : ndarray of int
        Points about which each section is taken for a band.
    widths : ndarray
        Of the bands.
    is_band, is_about_cycle, is_shown : ndarray of bool
        Whether a section deviates from the points of the limit's cycle by more than the tolerance; whether it may lie
        about these points; whether it shows its period by itself.
    """

    kinds: np.ndarray
    periods: np.ndarray
    about: np.ndarray
    widths: np.ndarray
    is_band: np.ndarray
    is_about_cycle: np.ndarray
    is_shown: np.ndarray


def judge_bands(
    sections: np.ndarray,
    own_periods: np.ndarray,
    limits: Limits,
    steps: np.ndarray,
    finer: Callable[[np.ndarray, int], tuple[np.ndarray, np.ndarray]],
    factors: tuple[int, ...],
) -> Judgements:
    """Judge motions with a time step by their limits, and by what smaller steps leave of the bands of their sections.

    Parameters
    ----------
    sections : (n, rows, 4) ndarray
    own_periods : (n,) ndarray of int
        After which the scattered sections happen to repeat themselves; 0 if they do not.
    limits : Limits
    steps : (n,) ndarray
        Steps per period.
    finer : callable
        ``finer(places, factor)`` runs the motions at these places with so many times as many steps: their sections,
        (m, rows, 4), and whether they reached their ends, (m,).
    factors : tuple of int
        How many times as many steps are tried, one after the other, until a band is narrow.
    """
    periodic = limits.kinds == CellKind.PERIODIC
    about = _points_of_bands(limits.periods, sections.shape[1])
    widths = band_widths(sections, about)
    is_band = widths > TOLERANCE * sizes_of(sections)
    shown = _periods_shown(own_periods, limits.periods, is_band)
    is_about_cycle = _is_about_cycle(sections, about, widths, limits.spreads)
    shrinks, left = np.zeros(len(sections), bool), (shown == 0) & is_about_cycle
    left = np.flatnonzero(left & (limits.kinds != CellKind.UNDECIDED))
    for factor in factors:
        left = left[factor * steps[left] <= STEPS_RANGE[1]]
        if not len(left):
            break
        found, ok = finer(left, factor)
        narrower = band_widths(found, about[left])
        shrinks[left] = np.where(ok, narrower < SHRUNK * widths[left], shrinks[left])
        left = left[ok & ~(narrower < SHRUNK**2 * widths[left]) & periodic[left]]
    moves = np.isin(limits.kinds, (CellKind.CHAOTIC, CellKind.QUASI_PERIODIC))
    alone = (shown > 0, periodic & shrinks, own_periods > 0, moves & ~shrinks)
    kinds = np.select(
        alone, (CellKind.PERIODIC, CellKind.ARTEFACT, CellKind.PERIODIC, limits.kinds), CellKind.UNDECIDED
    )
    periods = np.select(alone, (shown, limits.periods, own_periods, 0), 0)
    return Judgements(kinds, periods, about, widths, is_band, is_about_cycle, shown > 0)


def _points_of_bands(periods: np.ndarray, rows: int) -> np.ndarray:
    """The points about which sections are bands: those of the limits' cycles; 1, the mean, where two are too long."""
    return np.where((periods > 0) & (2 * periods <= min(rows, SCATTER_KEEP)), periods, 1)


def _periods_shown(own_periods: np.ndarray, limit_periods: np.ndarray, is_band: np.ndarray) -> np.ndarray:
    """The periods that sections show by themselves, 0 where none.

    The limit decides between a cycle and a multiple of it, after which the rest of a transient returns more nearly.
    """
    shorter = np.minimum(own_periods, limit_periods)
    alone = np.where(shorter > 0, shorter, np.maximum(own_periods, limit_periods))
    return np.where(is_band, np.where(own_periods == limit_periods, own_periods, 0), alone)


def _is_about_cycle(sections: np.ndarray, periods: np.ndarray, widths: np.ndarray, spreads: np.ndarray) -> np.ndarray:
    """Whether bands may lie about the points of cycles: where they must show the distances of these, they have them."""
    about = spreads <= CLEAR_SPREAD * widths
    rest = np.flatnonzero(~about)
    about[rest] = cycle_spreads(sections[rest], periods[rest]) > SHOWN_SPREAD * spreads[rest]
    return about


class SectionJudgement(NamedTuple):
    """Type of a Newmark motion, and how much its section scatters by the time step."""

    type: Kind
    period: int
    reason: str
    step_noise: float  # scatter of the observed body if the time step causes it, else 0
    bands: tuple[tuple[int, float], ...]  # steps per period, first those of the run, and the scatter of the body


def widths_text(bands: Iterable[tuple[int, float]]) -> Statement:
    """The widths of bands, as in "±0.034 at T/8000, ±0.0068 at T/32000"."""
    return joined(", ", (stated("±{} at T/{}", Amount(width, "displacement", 2), str(steps)) for steps, width in bands))


def section_judgement(
    run: Response,
    limit: Motion,
    judged: Judgements,
    own_period: int,
    finer: Iterable[tuple[int, np.ndarray]],
    is_late: bool = False,
) -> SectionJudgement:
    """Say what the section of a run shows.

    Parameters
    ----------
    run : Response
        Of a method with a time step.
    limit : Motion
        The motion without one that begins where the run ends, with its evidence.
    judged : Judgements
        Of this section alone.
    own_period : int
        After which it happens to repeat itself; 0 if it does not.
    finer : iterable of (int, ndarray)
        Steps per period, and the section with them.
    is_late : bool
        Whether the motion without a time step shows what it is after a long transient only.
    """
    period, body = int(judged.about[0]), run.system.observed_body
    if judged.is_shown[0]:
        shown = int(judged.periods[0])
        reason = f"the section repeats itself after {counted(shown, 'period')}"
        return SectionJudgement(Kind.PERIODIC, shown, reason, 0.0, ())
    tried = [(run.method.steps, run.section), *finer]
    bands = tuple((steps, scatter(section, period, body)) for steps, section in tried)
    decided, artefact = Kind[CellKind(judged.kinds[0]).name], judged.kinds[0] == CellKind.ARTEFACT
    symbol, over = Symbol(SYMBOLS[run.system.observed_body]), f"over {len(run.section)} periods"
    listed = stated("{} in {}, {}", widths_text(bands), symbol, over)
    if artefact:
        reason = stated(
            "the section is a band, but an artefact of the time step: its width shrinks with it ({}), and without a "
            "time step the motion repeats itself {}",
            listed,
            every(int(judged.periods[0])),
        )
    elif own_period:
        after = counted(own_period, "period")
        reason = f"the section repeats itself after {after}; without a time step the motion is {limit.type}"
    elif not judged.is_about_cycle[0]:
        reason = stated(
            "the section is a band ({}), but not about the points of the motion without a time step, which repeats "
            "itself {}: with this time step it is another motion",
            listed,
            every(limit.period),
        )
    elif decided is Kind.UNDECIDED:
        is_seen = limit.period <= period
        what = "more steps per period would decide" if is_seen else "too long a cycle for these periods to show it"
        if is_late and is_seen:
            what = "this may be as long a transient: more periods would decide"
        reason = stated(
            "the section is a band ({}), and without a time step the motion is {} ({}): {}",
            listed,
            str(limit.type),
            limit.reason,
            what,
        )
    else:
        reason = stated(
            "without a time step the motion is {} ({}), and the band does not shrink with the step ({})",
            str(limit.type),
            limit.reason,
            listed,
        )
    noise, decided = (bands[0][1], Kind.PERIODIC) if artefact else (0.0, decided)
    return SectionJudgement(decided, int(judged.periods[0]), reason, noise, bands)


def can_narrow(sections: np.ndarray) -> np.ndarray:
    """Whether bands of sections, (n, rows, 4), may be the rest of a transient: not where the scatter repeats itself."""
    return periods_of(sections, REPEATED_BAND) == 0
