"""All branches of a family over a range: from motions that coexist at some values, and from the points on branches.

At some values of the number runs from several starts show the motions that attract there. Each that lies on no branch
yet is followed both ways through the range. Branches of twice the period begin at period doublings, and others at
branch points; they are followed, too, up to the longest cycle that is asked for.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np

from ..drivers.event_driven import displaced_state
from ..methods import ExactPenalty, Reference
from ..model import System, require, whole
from ..motions.steady import MAX_PERIOD_LIMIT
from ..result import Cancelled
from ..simulate import starting_checkpoint
from .branch import Branch, Point
from .curve import Curve, CurvePoint, null_vectors
from .family import Family
from .follow import MOST_ORBITS, Tracer
from .journal import Journal, Trace
from .margins import BRANCH_POINT, DOUBLING, least, margins
from .orbit import Orbit, check_cancelled
from .seeds import SAME, STABLE, OrbitFinder

SEEDS = 40  # values of the number at which motions are looked for
STARTS = 6  # at each, the first of them rest
FINE_SEEDS = 500  # values at which they are looked for then, from one start
MOST_IN_ALL = 100_000  # orbits on all branches together, after which the search ends: some minutes
STOPPED = "stopped"  # the end of a branch that was being followed when the search was cancelled
LONGEST_UNSTABLE = 300  # orbits, of a motion of more than one period
EVERY = 10  # orbits: how often a branch is compared with those found before
WALK = 8  # steps from an orbit to one between it and its neighbour on the branch
AWAY = 10.0 ** np.arange(-4, -1.0, 0.5)  # scaled first steps on a branch that begins at another one


def continue_branch(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    over: str = "eta",
    low: float,
    high: float,
    initial: Sequence[float] | None = None,
    max_period: int = 8,
    most_orbits: int = MOST_ORBITS,
    threads: int | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Branch:
    """Follow the periodic motion that a run settles to, both ways through a range of one number.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        With the law "kelvin-voigt".
    over : str
        The number that varies: "eta", "K", "D", "threshold", or a number of the system or its excitation. Where the
        motion starts it has the value that the other arguments give it.
    low, high : float
        The range of that number.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0: an orbit, stable or not, that nearly passes through it is followed, or else the one
        that a run from it settles to. By default rest.
    max_period : int
        Longest cycle to look for, in excitation periods.
    most_orbits : int
        After which a branch is given up, in each direction.
    threads : int, optional
        That run what the search begins with; as many as there are processors, if not given.
    cancelled : callable, optional
        Polled many times a second; when it returns true the work is cancelled.

    Returns
    -------
    Branch

    Raises
    ------
    ValueError
        If a number is out of range, or the run does not settle to a periodic motion.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, continue_branch
    >>> branch = continue_branch(System(), 2.76, Reference(), low=2.7, high=2.85, max_period=1)
    >>> [(point.kind, round(point.value, 8)) for point in branch.points]
    [('period doubling', 2.78895505)]
    """
    limits = {"max_period": max_period, "most_orbits": most_orbits, "threads": threads}
    search = BranchSearch(Family(over, system, eta, method), low, high, cancelled=cancelled, **limits)
    value = search.family.value
    if not low <= value <= high:
        raise ValueError(f"{over} = {value:g} lies outside {low:g} … {high:g}: begin within the range")
    orbit = search.finder.near(value, initial) if initial is not None else None
    if orbit is None:
        orbit = search.finder.settled(value, initial)
    branch = search.follow(orbit, value)
    if STOPPED in branch.ends:
        raise Cancelled
    return branch


def find_branches(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    over: str = "eta",
    low: float,
    high: float,
    max_period: int = 8,
    unstable: bool = False,
    most_orbits: int = MOST_ORBITS,
    initial: Sequence[float] | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    note: Callable[[str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Branch, ...]:
    """Follow every branch of periodic motions through a range of one number.

    Parameters
    ----------
    system, eta, method, over, low, high, threads, cancelled
        As for :func:`continue_branch`.
    max_period : int
        Longest cycle, in excitation periods; cascades of period doublings are followed up to it.
    unstable : bool
        Follow also what begins where an unstable motion bifurcates, and motions of several periods however long they
        stay unstable: there may be very many such branches.
    most_orbits : int
        After which each branch is given up, in each direction.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0: the motion there, or that a run from there settles to, is followed first.
    progress : callable, optional
        Called with the number of branches found so far.
    note : callable, optional
        Called with a sentence where no motion is found: from ``initial``, or at all.

    Returns
    -------
    tuple of Branch
        In the order in which they were found.

    Raises
    ------
    ValueError
        If a number is out of range.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, find_branches
    >>> found = find_branches(System(), 1.4, Reference(), low=1.35, high=1.48, max_period=2)
    >>> sorted(branch.period for branch in found)
    [1, 2]
    """
    found = []
    for branch in search_branches(
        system,
        eta,
        method,
        over=over,
        low=low,
        high=high,
        max_period=max_period,
        unstable=unstable,
        most_orbits=most_orbits,
        initial=initial,
        threads=threads,
        note=note,
        cancelled=cancelled,
    ):
        found.append(branch)
        if progress is not None:
            progress(len(found))
    return tuple(found)


def search_branches(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    over: str = "eta",
    low: float,
    high: float,
    max_period: int = 8,
    unstable: bool = False,
    most_orbits: int = MOST_ORBITS,
    initial: Sequence[float] | None = None,
    threads: int | None = None,
    note: Callable[[str], None] | None = None,
    keep: str | Path | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Iterator[Branch]:
    """Yield the branches of :func:`find_branches` as they are found; arguments and exceptions are the same.

    A branch that is being followed when the search is cancelled is yielded as far as it goes, before the exception.

    Parameters
    ----------
    keep : str or Path, optional
        A folder, in which each branch is kept once it is followed: the same search reads it there, however it ended.

    Raises
    ------
    ValueError
        Also if the folder holds another search, or one of another engine.
    """
    limits = {"max_period": max_period, "most_orbits": most_orbits, "unstable": unstable, "threads": threads}
    search = BranchSearch(Family(over, system, eta, method), low, high, cancelled=cancelled, **limits)
    if keep is not None:
        search.keep(Path(keep), initial)
    yield from search.all(initial, note or (lambda _: None))


class BranchSearch:
    """The branches of a family over a range."""

    def __init__(
        self,
        family: Family,
        low: float,
        high: float,
        *,
        max_period: int,
        most_orbits: int,
        unstable: bool = False,
        threads: int | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        low, high = (
            require(family.over, end, -1e12, 1e12, "give the ends of the range as numbers") for end in (low, high)
        )
        if not low < high:
            raise ValueError(f"{family.over} from {low:g} to {high:g} is an empty range: give the smaller number first")
        for end in (low, high):
            family.at(end)
        self.max_period = whole("max_period", max_period, 1, MAX_PERIOD_LIMIT, "give the longest cycle to follow")
        self.family, self.curve = family, Curve(family, low, high)
        self.most_orbits = whole("most_orbits", most_orbits, 2, 1_000_000, "give the orbits of a branch")
        self.cancelled, self.unstable = cancelled, unstable
        self.finder = OrbitFinder(self.curve, self.max_period, threads, cancelled)
        self._journal: Journal | None = None
        self._traces: list[tuple[list[CurvePoint], np.ndarray]] = []
        self._joined: list[float] = []  # where branches of twice the period end in others
        self._doublings: list[tuple[int, float]] = []
        self._pending: list[tuple[str, CurvePoint]] = []

    def keep(self, folder: Path, initial: Sequence[float] | None) -> None:
        """Keep what is followed in a folder, and read there what the same search has followed before."""
        family = self.family
        ends = {"low": self.curve.low, "high": self.curve.high, "eta": family.eta, "over": family.over}
        limits = {"max_period": self.max_period, "most_orbits": self.most_orbits, "unstable": self.unstable}
        problem = {"system": asdict(family.system), "method": {"name": family.method.name} | asdict(family.method)}
        start = None if initial is None else [float(number) for number in initial]
        self._journal = Journal(folder, ends | limits | problem | {"initial": start})

    def all(self, initial: Sequence[float] | None, note: Callable[[str], None]) -> Iterator[Branch]:
        """Yield all branches: first from what a few values of the number show, then from what lies on none of these."""
        for value, orbit in chain(self._given(initial, note), self._candidates()):
            check_cancelled(self.cancelled)
            if not self._is_known(orbit, value):
                yield from self._stoppable(self.follow(orbit, value))
                yield from self._offspring()
            if self._is_spent():
                note(f"the search ended after {MOST_IN_ALL:,} orbits and may have missed branches: narrow the range")
                return
        if not self._traces:
            note(self.finder.why_none())

    def _is_spent(self) -> bool:
        """Whether as many orbits were followed as one search may follow."""
        return sum(len(points) for points, _ in self._traces) >= MOST_IN_ALL

    def _given(self, initial: Sequence[float] | None, note: Callable[[str], None]) -> Iterator[tuple[float, Orbit]]:
        """The motion at a state, or that a run from there settles to."""
        value = self.family.value
        if initial is not None:
            starting_checkpoint(initial, *self.family.at(value))  # refuses what is no state
        if initial is not None and self.curve.low <= value <= self.curve.high:
            try:
                yield value, self.finder.near(value, initial) or self.finder.settled(value, initial)
            except ValueError as error:
                note(f"from the initial state {error}")

    def _stoppable(self, branch: Branch) -> Iterator[Branch]:
        """Yield a branch; raise Cancelled if the search was cancelled while it was followed."""
        if len(branch.values) > 1:
            yield branch
        if STOPPED in branch.ends:
            raise Cancelled

    def _candidates(self) -> Iterator[tuple[float, Orbit]]:
        """Orbits, with the number at which they are found: from runs, at a few values and then at many.

        Where nothing drives the system all its motions decay to one equilibrium, and no runs are needed to find others.
        """
        if not any(self.family.at(end)[0].excitation.drives for end in (self.curve.low, self.curve.high)):
            value = min(max(self.family.value, self.curve.low), self.curve.high)
            yield value, self.finder.settled(value, None)
            return
        yield from self.finder.orbits(SEEDS, STARTS, unstable=True)
        for source in (partial(self.finder.orbits, starts=1, unstable=False), self.finder.from_elsewhere):
            yield from source(FINE_SEEDS)

    def _offspring(self) -> Iterator[Branch]:
        """The branches that begin at points of others."""
        while self._pending and not self._is_spent():
            kind, point = self._pending.pop(0)
            start = self._other_branch(kind, point)
            if start is not None and not self._is_known(start.orbit, start.value):
                yield from self._stoppable(self._assembled(self._traced(start), None, kind))

    def follow(self, orbit: Orbit, value: float) -> Branch:
        """Follow an orbit both ways."""
        start = CurvePoint(self.curve, orbit, value)
        forwards = self._traced(start)
        closed = forwards.reason in ("the branch closes in itself", STOPPED)
        backwards = None if closed else self._traced(start.turned())
        return self._assembled(forwards, backwards, "")

    def _traced(self, start: CurvePoint) -> Tracer | Trace:
        """The branch ahead of an orbit: from the journal, or followed and kept there."""
        number = len(self._traces)
        trace = self._journal and self._journal.read(number, start, self.curve)
        if trace is None:
            trace = self._followed(start)
            if self._journal is not None and trace.reason != STOPPED:
                self._journal.write(number, start, trace)
        if trace.joined is not None:
            self._joined.append(trace.joined)
        self._traces.append((trace.points, np.array([point.value for point in trace.points])))
        self._doublings += [(point.period, point.value) for point, _ in trace.marks if point.kind == DOUBLING]
        for point, orbit in trace.marks:
            begins = point.kind == BRANCH_POINT or (point.kind == DOUBLING and 2 * point.period <= self.max_period)
            stable = np.abs(point.multipliers).max() < 1 + STABLE
            if begins and (stable or self.unstable):
                self._pending.append((point.kind, orbit))
        return trace

    def _followed(self, start: CurvePoint) -> Tracer:
        tracer = Tracer(self.curve, start, self._doublings, self.cancelled)
        since = 0  # the last orbit that was stable
        try:
            for count, _ in enumerate(tracer.run(self.most_orbits), start=1):
                here = tracer.points[-1]
                if count % EVERY == 0 and self._is_known(here.orbit, here.value):
                    tracer.reason = f"meets a branch found before at {self.family.over} = {here.value:.10g}"
                    break
                if self.unstable or here.orbit.period == 1:
                    continue
                stable = np.abs(here.evaluation.multipliers).max() < 1 + STABLE
                since = count if stable else since
                if count - since >= LONGEST_UNSTABLE:
                    tracer.reason = f"unstable over {LONGEST_UNSTABLE} orbits: ask for unstable motions to go on"
                    break
        except Cancelled:
            tracer.reason = STOPPED
        except ValueError as error:  # a number is out of its range
            tracer.reason = str(error)
        return tracer

    def _other_branch(self, kind: str, point: CurvePoint) -> CurvePoint | None:
        """The first orbit of the branch that begins at a point of another one."""
        if any(abs(point.value - value) < 1e-7 * self.curve.width for value in self._joined):
            return None
        times = 2 if kind == DOUBLING else 1
        orbit = point.orbit.repeated(times)
        here = CurvePoint(self.curve, orbit, point.value)
        scales = self.curve.scales(orbit)
        tangent = np.concatenate([point.tangent[:4], np.tile(point.tangent[4:-1], times), point.tangent[-1:]])
        if not np.isfinite(here.extended).all():
            return None
        first, second = null_vectors(here.extended * scales)
        tangent /= np.linalg.norm(tangent)
        away = (
            second - tangent * (tangent @ second)
            if abs(tangent @ second) < abs(tangent @ first)
            else first - tangent * (tangent @ first)
        )
        away /= np.linalg.norm(away)
        for step in AWAY:
            guess = here.unknowns + step * away * scales
            row = away / scales
            found = self.curve.constrained(replace(orbit, unknowns=guess[:-1]), float(guess[-1]), row, row @ guess)
            if found is None:
                continue
            start = CurvePoint(self.curve, *found, away)
            rows = start.evaluation.section
            half = orbit.period // 2
            if kind == DOUBLING and np.abs(rows[0] - rows[half]).max() < 0.1 * step * scales[0]:
                continue
            if least(margins(start.orbit, start.evaluation, self.family.at(start.value)[2])) > 0:
                return start
        return None

    def _is_known(self, orbit: Orbit, value: float) -> bool:
        """Whether an orbit lies on a branch that has been followed."""
        rows = self.curve.evaluate(orbit, value).section
        size = max(np.abs(rows).max(), 1e-9)
        for points, values in self._traces:
            for k in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0):
                a, b = points[k], points[k + 1]
                if a.orbit.period == orbit.period and self._is_between(a, b, rows, value, SAME * size):
                    return True
        return False

    def _is_between(self, a: CurvePoint, b: CurvePoint, rows: np.ndarray, value: float, same: float) -> bool:
        """Whether an orbit with this section is one of those between two neighbours on a branch, to a distance."""
        share = (value - a.value) / (b.value - a.value) if b.value != a.value else 0.5
        guesses = [(a.orbit, a.value, WALK), (b.orbit, b.value, WALK)]
        if a.orbit.kinds == b.orbit.kinds:
            chord = b.orbit.unknowns - a.orbit.unknowns
            between = replace(a.orbit, unknowns=a.orbit.unknowns + share * chord)
            off = np.linalg.norm(rows - between.unknowns[:4], axis=1).min()
            if off > np.linalg.norm(chord[:4]) + same:  # neighbours are close enough for the curve to turn little
                return False
            guesses.insert(0, (between, value, 1))
        for known, begin, steps in guesses:
            for there in np.linspace(begin, value, steps + 1)[1:]:
                known = known and self.curve.corrected(known, float(there))
            if known is not None and (np.abs(rows - known.unknowns[:4]).max(axis=1) < same).any():
                return True
        return False

    def _assembled(self, forwards: Tracer | Trace, backwards: Tracer | Trace | None, begins: str) -> Branch:
        """The branch of one or two traces."""
        points, marks = list(forwards.points), [mark for mark, _ in forwards.marks]
        if backwards is not None:
            shift = len(backwards.points) - 1
            marks = [replace(mark, index=mark.index + shift) for mark in marks]
            before = [replace(mark, index=shift - 1 - mark.index) for mark, _ in backwards.marks]
            marks = before[::-1] + marks
            points = backwards.points[:0:-1] + points
        values = np.array([point.value for point in points])
        sections = np.array(
            [displaced_state(self.family.at(point.value)[0], point.evaluation.section) for point in points]
        )
        names = [point.orbit.sequence for point in points]
        sequences = tuple((k, name) for k, name in enumerate(names) if k == 0 or names[k - 1] != name)
        first = backwards.reason if backwards is not None else (f"begins at a {begins}" if begins else forwards.reason)
        return Branch(
            over=self.family.over,
            period=points[0].orbit.period,
            values=values,
            sections=sections,
            multipliers=np.array([point.evaluation.multipliers for point in points]),
            sequences=sequences,
            points=tuple(marks),
            ends=(first, forwards.reason),
        )


__all__ = ["Branch", "Point", "continue_branch", "find_branches", "search_branches"]
