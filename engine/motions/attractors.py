"""Coexisting motions: many starts, grouped by the motion that each of them ends in.

A penalty run that ends in another motion than the reference need not be wrong: at the same parameters several motions
may attract, each from its own basin of initial states. The share of the starts that end in a motion estimates the size
of its basin among the starts considered: displacements and velocities up to twice those of the motion from rest, with
the pendulums apart. A share p of n starts has the standard error √(p(1 − p)/n), and an attractor with a share below 1/n
may be missed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from vibroscope.engine.checks import whole
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Kind, Motion
from vibroscope.engine.motions.motion import Runs, motion
from vibroscope.engine.motions.sameness import least_size, same_cycle, same_motion
from vibroscope.engine.motions.starts import apart, random_states, reach_of
from vibroscope.engine.motions.steady import steady
from vibroscope.engine.result import Response
from vibroscope.engine.simulate import LONG, simulate

REACH_OF_STARTS = 2.0  # of the starts, in amplitudes of the motion from rest
STARTS = 64
DECIMALS = 4  # of a start, so that its numbers can be read, typed and sent in full


@dataclass(frozen=True)
class Attractor:
    """A motion in which starts end.

    Attributes
    ----------
    motion : Motion
        With its evidence.
    share : float
        Share of the starts that end in it.
    start : (4,) ndarray
        The first of these starts: ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    """

    motion: Motion
    share: float
    start: np.ndarray

    def __repr__(self) -> str:
        return f"Attractor({self.share:.3g} of the starts: {self.motion})"


def attractors(
    system: System,
    eta: float,
    method: Method,
    *,
    starts: int = STARTS,
    seed: int = 0,
    progress: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Attractor, ...]:
    """Search for the motions that attract at the same parameters.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference, ExactPenalty or TimeStepping
    starts : int
        Number of starts; the first is rest, the others are drawn at random.
    seed : int
        Of the random numbers: the same seed gives the same result.
    progress : callable, optional
        Called with the number of starts done so far.
    cancelled : callable, optional
        Polled many times a second; when it returns true the search is cancelled.

    Returns
    -------
    tuple of Attractor
        Largest share first. Starts from which a run diverges are one of them, of the type "diverged".

    Raises
    ------
    ValueError
        If a number is out of range.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, attractors
    >>> [found.motion.period for found in attractors(System(), 3.2, Reference(), starts=8)]
    [2, 6]
    """
    search = search_attractors(system, eta, method, starts=starts, seed=seed, cancelled=cancelled)
    for done, found in enumerate(search, start=1):  # noqa: B007 - the last one is returned
        if progress is not None:
            progress(done)
    return found


def search_attractors(
    system: System,
    eta: float,
    method: Method,
    *,
    starts: int = STARTS,
    seed: int = 0,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[tuple[Attractor, ...]]:
    """Yield the motions found so far after each start, with their shares of the starts so far.

    Parameters and exceptions are those of :func:`attractors`, which returns the last of them.
    """
    starts = whole("starts", starts, 1, 100_000, "give the number of starts")
    groups: list[_Group] = []
    states = _starts(system, eta, method, starts, seed, cancelled)
    least = least_size(system, states)
    for done, start in enumerate(states, start=1):
        run = _long_term_response(system, eta, method, start, cancelled)
        group = next((group for group in groups if group.includes(run, least)), None)
        if group is None:
            found = motion(system, eta, method, initial=start, cancelled=cancelled)
            limit = _limit_cycle(system, eta, method, run, found, cancelled)
            group = next((group for group in groups if group.tends_to(found, limit)), None)
            if group is None:
                group = _Group(found, run, start, limit)
                groups.append(group)
        group.count += 1
        groups.sort(key=lambda group: -group.count)
        yield tuple(Attractor(group.motion, group.count / done, group.start) for group in groups)


def _starts(system, eta, method, count, seed, cancelled) -> np.ndarray:
    """Return ``count`` initial states, (count, 4): rest, and random points of a box with the pendulums apart."""
    rows = simulate(system, eta, method, periods=LONG, cancelled=cancelled).section
    reach = REACH_OF_STARTS * reach_of(rows)
    seed = whole("seed", seed, 0, 2**63 - 1, "give any whole number")
    states = apart(system, np.round(random_states(np.random.default_rng(seed), count, reach), DECIMALS))
    states[0] = system.rest
    return states


def _long_term_response(system, eta, method, start, cancelled) -> Response:
    """Return one cycle of the steady motion of a closed-form solver, or else the last periods of a long run."""
    runs = Runs(system, eta, method, cancelled)
    if not method.has_step:
        found = runs.steady(start)
        if found.periodic or not found.response.ok:
            return found.response
        start = found.response.section[-1]
    return runs.run(LONG, start)


def _limit_cycle(system, eta, method, run: Response, found: Motion, cancelled) -> np.ndarray | None:
    """The cycle, (p, 4), that a periodic motion of a solver with a time step tends to without one; None without any."""
    if not method.has_step or found.type is not Kind.PERIODIC:
        return None
    limit = steady(system, eta, method.limit, initial=run.section[-1], max_period=found.period, cancelled=cancelled)
    return limit.response.section if limit.periodic and limit.period == found.period else None


@dataclass
class _Group:
    """The starts that end in one motion; ``limit``: its cycle without a time step, if it has one."""

    motion: Motion
    run: Response
    start: np.ndarray
    limit: np.ndarray | None
    count: int = 0

    def tends_to(self, found: Motion, limit: np.ndarray | None) -> bool:
        """Whether a motion, whose section differs, is the same but for what the time step makes of it.

        From one start it may scatter a cycle, and from another lock it to a near one that repeats itself exactly.
        """
        if limit is None or self.limit is None or found.period != self.motion.period:
            return False
        return same_cycle(self.limit, limit, found.period)

    def includes(self, run: Response, least: float) -> bool:
        """Whether a run ends in the same motion; ``least``: size below which a motion counts as rest."""
        if not (run.ok and self.run.ok):
            return run.status is self.run.status
        return same_motion(self.run.section, run.section, self.motion.period, self.motion.step_noise > 0, least)
