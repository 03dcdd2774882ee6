"""One time grid for several solutions: the instants of Newmark's steps, period by period.

Newmark's solution exists at its steps only. A comparison therefore takes these instants, and the closed-form solvers
are evaluated there: nothing is interpolated. No run is repeated for that. The kept periods start again from their
checkpoint, with the same bits, and are sampled; of a motion that repeats itself one cycle is enough.

The settled periods of two solutions: everything that a comparison states is of them.

A transient can be long: a reference may move irregularly for ten thousand periods and then repeat itself for ever. So a
solution that does not repeat itself runs longer, up to LONGEST times as many periods, before it is compared. Of motions
that never repeat, SECTION periods are kept, which counts and distributions need; of others those asked for.

A motion that never repeats is settled if its section no longer changes: that of half as many periods differs from it by
no more than halves of either differ from each other.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.tolerances import BURSTS, DRAWS_NEARER, EVEN_SAMPLES, NARROW, NOTICED, SECTION_DRIFT
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.model import DISPLACEMENTS, System
from vibroscope.engine.motions.section import band_width, cycle_points, shifted_distance
from vibroscope.engine.result import Record, Response
from vibroscope.engine.simulate import simulate

PER_PERIOD = 100  # samples; more change the fourth digit of an rms of displacements (tests/engine/test_error.py)


def about_rest(displacement: np.ndarray, system: System) -> np.ndarray:
    """ξ₁ and ξ₂, (2, …), from the static equilibrium: relative differences are relative to what moves."""
    rest = np.array(system.rest[::2])
    return displacement - rest.reshape(2, *[1] * (displacement.ndim - 1))


def rms(values: np.ndarray) -> float:
    """Return the root mean square of all numbers."""
    return float(np.sqrt(np.mean(np.square(values))))


def relative_to(difference: float, size: float) -> float:
    """Return a difference relative to a size; inf if the size alone is zero."""
    return difference / size if size > 0 else np.inf if difference > 0 else 0.0


def run_again(response: Response, **changed: Any) -> Response:
    """Simulate a run again, with other arguments of :func:`engine.simulate` or with other ``keep`` and ``method``."""
    names = "system", "eta", "method", "periods", "keep"
    return simulate(**{name: getattr(response, name) for name in names} | changed)


def simulate_samples(response: Response, record: Record, cancelled: Poll | None = None) -> Response:
    """Simulate the first ``record.periods`` of the kept periods again, all of them sampled.

    Raises
    ------
    ValueError
        If the run ended early.
    """
    if not response.ok:
        raise ValueError(response.ending)
    kept = {"periods": record.periods, "keep": record.periods, "record": record}
    return run_again(response, initial=response.checkpoint, cancelled=cancelled, **kept)


def samples_on_grid(response: Response, record: Record, cancelled: Poll | None = None) -> np.ndarray:
    """Return ξ₁, ξ₂, ξ₁′, ξ₂′ of the first ``record.periods`` kept periods, (4, periods, m), at the record's phases."""
    return samples_by_period(simulate_samples(response, record, cancelled))


def samples_by_period(response: Response) -> np.ndarray:
    """Return ξ₁, ξ₂, ξ₁′, ξ₂′ of a response's samples, (4, periods, m), without the last instant.

    Raises
    ------
    ValueError
        If nothing was sampled.
    """
    sampled = response.trajectory
    if sampled is None:
        raise ValueError("the response holds no samples: give simulate a Record")
    periods = round((sampled.time[-1] - sampled.time[0]) / response.period)
    rows = np.concatenate([sampled.displacement, sampled.velocity])[:, :-1]
    return rows.reshape(4, periods, -1)


def grid_of(response: Response) -> Record:
    """Return the record that samples one period of another solution at the same phases as this response."""
    sampled = response.trajectory
    m = samples_by_period(response).shape[2]
    if response.method.has_step:
        return Record(1, m, response.method.steps)
    spacing = (sampled.time[1] - sampled.time[0]) / response.period
    if abs(spacing * m - 1) > EVEN_SAMPLES:
        raise ValueError("the samples are not spread evenly over a period: sample this solver without record.steps")
    return Record(1, m)


def repeat_cycle(cycle: np.ndarray, periods: int, shift: int = 0) -> np.ndarray:
    """Repeat a cycle (…, p, m) to (…, periods, m), starting with its period number ``shift``."""
    p = cycle.shape[-2]
    if shift % p == 0 and periods == p:
        return cycle
    return cycle[..., (np.arange(periods) + shift) % p, :]


def best_shift(cycle: np.ndarray, displacement: np.ndarray) -> int:
    """Return the ``shift`` with which a repeated cycle (2, p, m) is closest to displacements (2, periods, m).

    A motion of p periods can run in p ways that differ by whole excitation periods; all are solutions of equal right.
    """
    p, periods = cycle.shape[1], displacement.shape[1]
    if p == 1:
        return 0
    return min(range(p), key=lambda shift: rms(repeat_cycle(cycle, periods, shift) - displacement))


def closest_repetition(cycle: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Repeat a cycle (2, p, m) to be closest to displacements (2, periods, m)."""
    return repeat_cycle(cycle, displacement.shape[1], best_shift(cycle, displacement))


def samples_beside(
    response: Response, period: int, other: np.ndarray, grid: Record, cancelled: Poll | None = None
) -> tuple[np.ndarray, int]:
    """Sample a run on the grid of another solution, shifted by whole periods to be closest to it.

    Parameters
    ----------
    response : Response
    period : int
        Excitation periods after which it repeats itself; 0 if it does not: then nothing is shifted.
    other : (4, periods, m) ndarray
        The other solution.
    grid : Record
        Of one period of the other solution.

    Returns
    -------
    (4, periods, m) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′; nan if the run ended early.
    int
        Excitation periods by which it was shifted.
    """
    if not response.ok:
        return np.full_like(other, np.nan), 0
    periods = other.shape[1]
    cycle = samples_on_grid(response, replace(grid, periods=period or periods), cancelled)
    shift = best_shift(cycle[:2], other[:2]) if period else 0
    return repeat_cycle(cycle, periods, shift), shift


LONGER = (4, 16)  # times the periods asked for
AFFORDED = 100_000_000  # steps of the longest run of a penalty solution whose steps are not skipped
AFFORDED_PERIODS = {True: math.inf, False: 10_000}  # of the same, by whether its law is linear by pieces
SECTION = 1000  # periods: quick to compute, and their distribution is known to about 1/√SECTION
BLOCKS = 8  # of a section, whose distances show what chance does


def settled_length(run: Callable[[str, int, int], Response], periods: int, keep: int) -> tuple[int, int]:
    """How many periods to run, and how many of them to keep, until both solutions are settled, as far as is afforded.

    Parameters
    ----------
    run : callable
        ``run(name, periods, keep)``: the "reference", "penalty" or "exact" solution.
    periods, keep : int
        At least.
    """
    first = [run(name, periods, keep) for name in ("reference", "penalty")]
    if not all(each.ok for each in first):
        return periods, keep
    method, longer = first[1].method, max(periods, SECTION // 2)  # so that all of them have a section to keep
    most = (
        math.inf
        if first[1].method.skips_steps
        else min(AFFORDED / method.steps, AFFORDED_PERIODS[LAWS[method.law].closed_form])
    )
    lengths = [periods, *(factor * longer for factor in LONGER if factor * longer <= most)]
    settled, kept = lengths[0], keep
    for name, found in zip(("reference", "penalty"), first, strict=True):
        for length in lengths[lengths.index(settled) :]:
            if length > periods:
                found = run(name, length, SECTION)
            if not found.ok or repeats(found.section, keep):
                settled = length
                break
            if name == "penalty" and _is_blurred(found.section, run("exact", length, found.keep)):
                settled = length
                break
        else:
            settled = lengths[-1]
        if name == "reference" and found.ok and not repeats(found.section, keep):
            kept = SECTION
    return settled, kept


def repeats(section: np.ndarray, keep: int) -> bool:
    """Whether a section repeats itself within half of ``keep`` periods, and is not on its way to a shorter cycle."""
    period = period_of(section)
    return 0 < period <= keep // 2 and not _approaches_shorter_cycle(section, period)


def _approaches_shorter_cycle(section: np.ndarray, period: int) -> bool:
    """Whether the points of a cycle draw nearer to each other: a spiral comes back by chance after some turns."""
    for part in range(1, period // 2 + 1):
        if period % part == 0:
            apart = np.abs(section[part:] - section[:-part]).max(axis=1)
            if apart[period:].max(initial=0.0) < DRAWS_NEARER * apart[:-period].max(initial=0.0):
                return True
    return False


def _is_blurred(section: np.ndarray, limit: Response) -> bool:
    """Whether a section is a narrow band about the points of its limit without a time step, which repeats itself."""
    period = period_of(limit.section) if limit.ok else 0
    if not 0 < 2 * period <= len(section):
        return False
    points, others = (cycle_points(rows, period)[:, DISPLACEMENTS] for rows in (section, limit.section))
    width, size = band_width(section, period), float(np.abs(others).max())
    return width <= NARROW * size and shifted_distance(points, others) <= BURSTS * width


def change_between(before: np.ndarray, section: np.ndarray) -> float:
    """How far a section, (n, 2), has moved since an earlier one, relative to its size: 0 if chance may explain it.

    Chance is that of halves of either: a motion whose blocks are correlated over hundreds of periods has much of it.
    """
    size = rms(section)
    moved = wasserstein_distance(before, section)
    by_chance = max(wasserstein_distance(*np.array_split(rows, 2)) for rows in (before, section))
    return moved / size if size > 0 and moved > max(SECTION_DRIFT * by_chance, NOTICED * size) else 0.0


def chance_distance(section: np.ndarray) -> float:
    """Distance that chance alone causes between two sections of this length, (n, 2), by its blocks and halves.

    The distance of blocks falls as one over the root of their length, unless they are correlated, which halves show.
    """
    blocks = np.array_split(section[: len(section) // BLOCKS * BLOCKS], BLOCKS)
    of_blocks = np.mean([wasserstein_distance(one, other) for one, other in combinations(blocks, 2)])
    return max(float(of_blocks) / math.sqrt(BLOCKS), wasserstein_distance(*np.array_split(section, 2)) / math.sqrt(2))


def wasserstein_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean of the Wasserstein distances between the columns of two (n, k) arrays."""
    return float(np.mean(np.abs(np.sort(one, axis=0) - np.sort(other, axis=0))))
