"""The search for the motions that starts lead to: runs in a batch, and those that end in the same motion put together.

Starts are drawn from a box of states, with the bodies apart, or are those of a plane. Each run is compared with the
motions that are known (:mod:`.section`). What is none of them is a new motion: the cycle that Newton's method finds
from there (:mod:`.steady`), or else what the kind of its motion says (:mod:`.motion`).

A penalty run that ends in another motion than the reference need not be wrong: at the same parameters several motions
may attract, each from its own basin of initial states. The share of the starts that end in a motion estimates the size
of its basin among the starts considered: displacements and velocities up to twice those of the motion from rest, with
the pendulums apart. A share p of n starts has the standard error √(p(1 − p)/n), and an attractor with a share below 1/n
may be missed.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from vibroscope.engine.arguments import Poll, whole
from vibroscope.engine.cells import CellResults, Cells, run_cells
from vibroscope.engine.drivers.law_driven import remembers
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Kind, Motion
from vibroscope.engine.motions.motion import Runs, motion
from vibroscope.engine.motions.section import least_size, same_cycle, same_motion
from vibroscope.engine.motions.steady import Steady, schedule_of, steady
from vibroscope.engine.motions.trapping import Region
from vibroscope.engine.simulate import LONG, simulate

REACH_OF_STARTS = 2.0  # of the starts, in amplitudes of the motion from rest
STARTS = 64
SAMPLE = 256  # last periods of a run, by which its motion is recognised
STARTS_TOGETHER = 8  # runs in a batch, after which the motions so far are shown
DECIMALS = 4  # of a start, so that its numbers can be read, typed and sent in full


@dataclass(frozen=True)
class KnownMotion:
    """A motion that starts lead to.

    Attributes
    ----------
    kind : Kind
    period : int
        Excitation periods after which it repeats itself; 0: never.
    section : (n, 4) ndarray
        One cycle of a closed-form solver, or else the sample of a run.
    blurred : bool
        Whether a time step scatters it.
    cycle : Steady or None
        What Newton's method found.
    limit : (period, 4) ndarray or None
        The cycle that one with a time step tends to without it, if it does.
    described : Motion or None
        From the first start, where that is how it was found out.
    others : list of (n, 4) ndarray
        Sections that differ, of the same motion but for what the time step makes of it.
    regions : list of Region
        From which runs lead to it, where they are asked for.
    """

    kind: Kind
    period: int
    section: np.ndarray
    blurred: bool = False
    cycle: Steady | None = None
    limit: np.ndarray | None = None
    described: Motion | None = None
    others: list[np.ndarray] = field(default_factory=list)
    regions: list[Region] = field(default_factory=list)

    def includes(self, section: np.ndarray, least: float) -> bool:
        """Whether a section of the same solver is that of this motion; ``least``: size below which one is rest."""
        known = (self.section, *self.others)
        return any(same_motion(each, section, self.period, self.blurred, least) for each in known)

    def tends_to(self, other: "KnownMotion") -> bool:
        """Whether a motion, whose section differs, is the same but for what the time step makes of it.

        From one start it may scatter a cycle, and from another lock it to a near one that repeats itself exactly.
        """
        if self.limit is None or other.limit is None or other.period != self.period:
            return False
        return same_cycle(self.limit, other.limit, self.period)


class MotionSearch:
    """The motions of one solver that starts lead to.

    Parameters
    ----------
    system, eta, method
        As in :func:`engine.simulate`.
    transient, sample : int
        Periods of a run, and of these the last ones, by which its motion is recognised.
    least : float
        Size below which a motion counts as rest (:func:`.section.least_size`).
    """

    def __init__(self, system: System, eta: float, method: Method, transient: int, sample: int, least: float = 0.0):
        self.system, self.eta, self.method = system, eta, method
        self.transient, self.sample, self.least = transient, sample, least
        self.closed_form = not method.has_step and not remembers(system, method)

    def run(self, states: np.ndarray, transient: int | None = None, **how) -> CellResults:
        """Runs from states, (n, 4); ``how``: threads, progress and cancelled as of :func:`engine.run_cells`."""
        cells = Cells(self.system, np.full(len(states), self.eta), self.method, initial=states)
        transient = self.transient if transient is None else transient
        return run_cells(cells, transient=transient, sample=self.sample, **how)

    def led_to(
        self,
        run: CellResults,
        k: int,
        motions: list[KnownMotion],
        cancelled: Poll | None = None,
        start: np.ndarray | None = None,
    ) -> int | None:
        """Index of the motion that the k-th run leads to, which is added where it is new; None if it ended early.

        ``start``: from which a new motion is found out, by default the end of the run.
        """
        if not run.ok[k]:
            return None
        index = self.index_of(run.section[k], motions)
        if index is not None:
            return index
        start = self.clean(run.end[k : k + 1])[0] if start is None else start
        return self.add(motions, start, cancelled, run.section[k])

    def index_of(self, section: np.ndarray, motions: list[KnownMotion]) -> int | None:
        """Index of the motion whose section it is; None if it is none of them."""
        return next((k for k, each in enumerate(motions) if each.includes(section, self.least)), None)

    def add(
        self,
        motions: list[KnownMotion],
        start: np.ndarray,
        cancelled: Poll | None,
        section: np.ndarray | None = None,
    ) -> int | None:
        """Index of the motion that a start leads to, which is added where it is new; None if its run ends early.

        Parameters
        ----------
        section : (n, 4) ndarray, optional
            The sample of a run from there, for solvers that find no cycle by Newton's method.
        """
        found = self._motion_from(start, cancelled, section)
        if found is None:
            return None
        index = self.index_of(found.section, motions)
        if index is not None:
            return index
        for index, each in enumerate(motions):
            if each.tends_to(found):
                each.others.append(found.section)
                return index
        motions.append(self.prepared(found, cancelled))
        return len(motions) - 1

    def prepared(self, found: KnownMotion, cancelled: Poll | None) -> KnownMotion:
        """A new motion with what later runs are compared with."""
        return found

    def clean(self, states: np.ndarray) -> np.ndarray:
        """States from which a run can go on: those of a reference do not penetrate, not even by rounding."""
        if not self.method.rigid:
            return states
        return np.array([self.system.without_penetration(state) for state in states]).reshape(-1, 4)

    def cycle_from(self, start: np.ndarray, cancelled: Poll | None) -> KnownMotion | None:
        """The cycle that Newton's method finds from a start; None if there is no cycle, or no Newton's method."""
        if not self.closed_form:
            return None
        found = Runs(self.system, self.eta, self.method, cancelled).steady(start)
        if not found.periodic:
            return None
        return KnownMotion(Kind.PERIODIC, found.period, found.response.section, cycle=found)

    def _motion_from(self, start: np.ndarray, cancelled, section: np.ndarray | None) -> KnownMotion | None:
        """The motion that a start leads to; None if its run ends early."""
        cycle = self.cycle_from(start, cancelled)
        if cycle is not None:
            return cycle
        described = motion(self.system, self.eta, self.method, initial=start, cancelled=cancelled)
        if described.type is Kind.DIVERGED:
            return None
        if described.type is Kind.PERIODIC and self.closed_form:  # which it came to while it was followed
            cycle = self.cycle_from(self.clean(described.section[-1:])[0], cancelled)
            return cycle or KnownMotion(Kind.PERIODIC, described.period, described.section)
        if section is None:
            section = self.run(start[None], threads=1, cancelled=cancelled).section[0]
        period = described.period if described.type is Kind.PERIODIC else 0
        section = section if len(section) >= 2 * period else described.section
        limit = self._limit_of(described, section[-1], cancelled)
        blurred = described.step_noise > 0
        return KnownMotion(described.type, period, section, blurred, limit=limit, described=described)

    def _limit_of(self, found: Motion, state: np.ndarray, cancelled) -> np.ndarray | None:
        """The cycle, (p, 4), that a cycle with a time step tends to without one; None without any."""
        if not self.method.has_step or found.type is not Kind.PERIODIC:
            return None
        how = {"max_period": found.period, "cancelled": cancelled}
        limit = steady(self.system, self.eta, self.method.limit, initial=state, **how)
        return limit.response.section if limit.periodic and limit.period == found.period else None


# --- starts -----------------------------------------------------------------------------------------------------------


def reach_of(rows: np.ndarray) -> np.ndarray:
    """The largest displacement and the largest velocity of either body in states, (n, 4); at least 1 each."""
    return np.abs(rows).max(axis=0, initial=1.0).reshape(2, 2).max(axis=0)


def random_states(random: np.random.Generator, count: int, reach: np.ndarray) -> np.ndarray:
    """States ξ₁, ξ₁′, ξ₂, ξ₂′, (count, 4), up to a displacement and a velocity."""
    return random.uniform(-1, 1, (count, 4)) * reach[[0, 1, 0, 1]]


def apart(system: System, states: np.ndarray) -> np.ndarray:
    """States, (…, 4), with bodies that overlap in exchanged places; at a wall, reflected from it.

    Between two stops the gap is reflected from both until it lies within the play.
    """
    x1, v1, x2, v2 = np.moveaxis(states, -1, 0)
    if system.two_stops:
        x2 = np.zeros_like(x2) if system.wall else x2
        gap = system.play - np.abs(np.mod(system.gap(x1, x2), 2 * system.play) - system.play)
        return np.stack([system.clearance + x2 - gap, v1, x2, np.zeros_like(v2) if system.wall else v2], axis=-1)
    if system.wall:
        none = np.zeros_like(x1)
        return np.stack([np.minimum(x1, 2 * system.clearance - x1), v1, none, none], axis=-1)
    return np.stack([np.minimum(x1, x2 + system.clearance), v1, np.maximum(x2, x1 - system.clearance), v2], axis=-1)


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
    cancelled: Poll | None = None,
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
    cancelled: Poll | None = None,
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
