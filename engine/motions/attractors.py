"""Coexisting motions: many starts, grouped by the motion that each of them ends in.

A penalty run that ends in another motion than the reference need not be wrong: at the same parameters several motions
may attract, each from its own basin of initial states. The share of the starts that end in a motion estimates the size
of its basin among the starts considered: displacements and velocities up to twice those of the motion from rest, with
the pendulums apart. A share p of n starts has the standard error √(p(1 − p)/n), and an attractor with a share below 1/n
may be missed.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.checks import whole
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Motion
from vibroscope.engine.motions.motion import motion
from vibroscope.engine.motions.sameness import least_size
from vibroscope.engine.motions.search import KnownMotion, MotionSearch, apart, random_states, reach_of
from vibroscope.engine.motions.steady import schedule_of
from vibroscope.engine.simulate import LONG, simulate

REACH_OF_STARTS = 2.0  # of the starts, in amplitudes of the motion from rest
STARTS = 64
SAMPLE = 256  # last periods of a run, by which its motion is recognised
STARTS_TOGETHER = 8  # runs in a batch, after which the motions so far are shown
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
    states = _starts(system, eta, method, starts, seed, cancelled)
    transient = (LONG if method.has_step else schedule_of(method).long) - SAMPLE
    search = MotionSearch(system, eta, method, transient, SAMPLE, least_size(system, states))
    known: list[KnownMotion] = []
    found: dict[int | None, Attractor] = {}  # by the index of the motion; None: the runs that end early
    counts: Counter[int | None] = Counter()
    for begin in range(0, starts, STARTS_TOGETHER):
        some = states[begin : begin + STARTS_TOGETHER]
        run = search.run(some, cancelled=cancelled)
        for k, start in enumerate(some):
            index = search.led_to(run, k, known, cancelled, start)
            if index not in found:
                described = None if index is None else known[index].described
                described = described or motion(system, eta, method, initial=start, cancelled=cancelled)
                found[index] = Attractor(described, 0.0, start)
            counts[index] += 1
            shares = ((each, count / counts.total()) for each, count in counts.most_common())
            yield tuple(replace(found[each], share=share) for each, share in shares)


def _starts(system, eta, method, count, seed, cancelled) -> np.ndarray:
    """Return ``count`` initial states, (count, 4): rest, and random points of a box with the pendulums apart."""
    rows = simulate(system, eta, method, periods=LONG, cancelled=cancelled).section
    reach = REACH_OF_STARTS * reach_of(rows)
    seed = whole("seed", seed, 0, 2**63 - 1, "give any whole number")
    states = apart(system, np.round(random_states(np.random.default_rng(seed), count, reach), DECIMALS))
    states[0] = system.rest
    return states
