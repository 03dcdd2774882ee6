"""Motions that exist side by side: many starts, grouped by what they end in.

A penalty run that comes to another motion than the reference need not be wrong: at the same parameters several motions
may attract, each from its own part of all starts. The share of the starts estimates the size of that part, of the
starts considered here: displacements and velocities up to twice those of the motion that a run from rest comes to, and
the pendulums apart. A share p of n starts is uncertain by √(p(1 − p)/n), and an attractor that draws less than 1/n may
be missed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..methods import Method, Newmark
from ..model import System, whole
from ..result import Response
from ..simulate import simulate
from .description import Kind, Motion
from .motion import LONGEST, REST, RUN, motion
from .section import TOLERANCE, band, repeats_after
from .steady import steady

REACH = 2.0  # of the starts, in amplitudes of the motion from rest
KEEP = 256  # rows of a section that motions without a period are compared by
BATCHES = 16
SIGMAS = 6.0  # standard errors that the averages of one motion may differ by
SAME = 1e-6  # of the size: cycles in closed form that differ by less are one
NOISY = 3.0  # cycles may differ by so many widths of their bands, and these by such a factor


@dataclass(frozen=True)
class Attractor:
    """One of the motions that starts end in.

    Attributes
    ----------
    motion : Motion
        With its evidence.
    share : float
        Share of the starts that end in it.
    start : (4,) ndarray
        The first of them: ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    """

    motion: Motion
    share: float
    start: np.ndarray


def attractors(
    system: System,
    eta: float,
    method: Method,
    *,
    starts: int = 64,
    seed: int = 0,
    progress: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Attractor, ...]:
    """Look for all motions that attract at the same parameters.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference, ExactPenalty or Newmark
    starts : int
        How many; the first is rest, the others are drawn at random.
    seed : int
        Of the random numbers: the same seed gives the same result.
    progress : callable, optional
        Called with the number of starts done so far.
    cancelled : callable, optional
        Polled many times a second; when it returns true the search is withdrawn.

    Returns
    -------
    tuple of Attractor
        Largest share first. Starts from which a run blows up are one of them, with the type "diverged".

    Raises
    ------
    ValueError
        If a number is out of range.
    Cancelled
        If ``cancelled`` returned true.
    """
    starts = whole("starts", starts, 1, 100_000, "give the number of starts")
    groups: list[_Group] = []
    for done, start in enumerate(_starts(system, eta, method, starts, seed, cancelled), start=1):
        run = _settled(system, eta, method, start, cancelled)
        group = next((group for group in groups if group.holds(run)), None)
        if group is None:
            group = _Group(motion(system, eta, method, initial=start, cancelled=cancelled), run, start)
            groups.append(group)
        group.count += 1
        if progress is not None:
            progress(done)
    groups.sort(key=lambda group: -group.count)
    return tuple(Attractor(group.motion, group.count / starts, group.start) for group in groups)


def _starts(system, eta, method, count, seed, cancelled) -> np.ndarray:
    """(count, 4): rest, and points of a box with the pendulums apart."""
    rows = simulate(system, eta, method, periods=RUN, cancelled=cancelled).section
    span = np.abs(rows).max(axis=0, initial=0.0) if len(rows) else np.zeros(4)
    across = REACH * np.maximum([span[[0, 2]].max(), span[[1, 3]].max()], 1.0)
    states = np.random.default_rng(seed).uniform(-1, 1, (count, 4)) * across[[0, 1, 0, 1]]
    states[:, [0, 2]] = np.sort(states[:, [0, 2]], axis=1)
    states[0] = REST
    return states


def _settled(system, eta, method, start, cancelled) -> Response:
    """One cycle of the steady motion in closed form, else the last periods of a long run."""
    if not isinstance(method, Newmark):
        found = steady(system, eta, method, initial=start, max_period=LONGEST, cancelled=cancelled)
        if found.periodic or not found.response.ok:
            return found.response
        start = found.response.section[-1]
    return simulate(system, eta, method, periods=RUN, keep=KEEP, initial=start, cancelled=cancelled)


@dataclass
class _Group:
    """Starts that end in one motion."""

    motion: Motion
    run: Response
    start: np.ndarray
    count: int = 0

    def holds(self, run: Response) -> bool:
        """Whether a run has come to the same motion."""
        if not (run.ok and self.run.ok):
            return run.status is self.run.status
        if self.motion.type is Kind.PERIODIC:
            return _same_cycle(self.run.section, run.section, self.motion.period)
        return not repeats_after(run.section) and _same_statistics(self.run.section, run.section)


def _same_cycle(known: np.ndarray, section: np.ndarray, period: int) -> bool:
    """Whether both sections are the same points, one after the other, but for the noise of a time step."""
    if len(section) < period or (len(section) < KEEP and len(section) != period):
        return False
    mine, theirs = _points(known, period), _points(section, period)
    widths = band(known, period), band(section, period)
    size = np.abs(known).max()
    least = TOLERANCE * size
    if max(widths) > NOISY * min(widths) + least:
        return False
    allowed = SAME * size + NOISY * max(widths)
    return any(np.abs(mine - np.roll(theirs, shift, axis=0)).max() <= allowed for shift in range(period))


def _points(section: np.ndarray, period: int) -> np.ndarray:
    cycles = len(section) // period
    return section[len(section) - cycles * period :].reshape(cycles, period, 4).mean(axis=0)


def _same_statistics(known: np.ndarray, section: np.ndarray) -> bool:
    """Whether averages of coordinates and squares agree within their standard errors (batch means)."""
    if len(known) != len(section):
        return False
    batches = [
        np.array([batch.mean(axis=0) for batch in np.array_split(np.hstack([rows, rows**2]), BATCHES)])
        for rows in (known, section)
    ]
    mine, theirs = (each.mean(axis=0) for each in batches)
    errors = np.sqrt(sum(each.var(axis=0, ddof=1) for each in batches) / BATCHES)
    return bool((np.abs(mine - theirs) <= SIGMAS * errors + TOLERANCE * np.abs(mine).max()).all())
