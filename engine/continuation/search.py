"""All branches of a family over a range: from motions that coexist at some values, and from the points on branches.

At some values of the number runs from several starts show the motions that attract there. Each that lies on no branch
yet is followed both ways through the range. Branches of twice the period begin at period doublings, and others at
branch points; they are followed, too, up to the longest cycle that is asked for.

What a search has finished stands in a folder, so that the same search takes it up where it was stopped or killed. It
makes the same traces in the same order each time. So trace k is read instead of followed if it begins at the same
orbit. A trace is a file that is written whole or not at all; its numbers are written so that they are read to the last
bit, and what follows from them is computed again.
"""

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np
from vibroscope.engine.arguments import Poll, checked
from vibroscope.engine.continuation.branch import Branch, KnownBranches, branch_of_traces, point_on_branch
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.family import BranchQuestion
from vibroscope.engine.continuation.follow import BranchTracer
from vibroscope.engine.continuation.kinds import BRANCH_POINT, DOUBLING, across, ways_at_loss
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.seeds import OrbitFinder
from vibroscope.engine.continuation.sequences import on_its_sequence
from vibroscope.engine.continuation.tolerances import SAME_JOIN
from vibroscope.engine.continuation.tracer import Trace
from vibroscope.engine.drivers.code_cache import source_digest
from vibroscope.engine.drivers.event_driven import check_apart
from vibroscope.engine.facts import message_of, stated
from vibroscope.engine.motions.poincare_map import SYMMETRY_BREAKING, may_be_stable
from vibroscope.engine.result import Cancelled, check_cancelled
from vibroscope.engine.simulate import starting_checkpoint

QUESTION = "question.json"
ENGINE = Path(__file__).parents[1]
SEEDS = 40  # values of the number at which motions are looked for
STARTS_AT_EACH = 6  # at each, the first of them rest
FINE_SEEDS = 500  # values at which they are looked for then, from one start
MOST_IN_ALL = 100_000  # orbits on all branches together, after which the search ends: some minutes
STOPPED = "stopped"  # the end of a branch that was being followed when the search was cancelled
LONGEST_UNSTABLE = 8.0  # scaled length of the part of a branch, of more than one period, on which no motion is stable
AWAY = 10.0 ** np.arange(-4, -1.0, 0.5)  # scaled first steps on a branch that begins at a point
EVERY = 10  # orbits: how often a branch is compared with those found before


class Journal:
    """The finished traces of one search.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    question : mapping
        All that the search depends on, as JSON takes it.

    Raises
    ------
    ValueError
        If the folder holds the traces of another search, or of another version of the engine.
    """

    def __init__(self, folder: Path, question: Mapping[str, object]) -> None:
        self._folder = folder
        wanted = json.dumps({**question, "engine": source_digest(ENGINE)}, sort_keys=True).encode()
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / QUESTION
        if not file.exists():
            _write(file, wanted)
        elif file.read_bytes() != wanted:
            raise ValueError(f"{folder} holds another search, or one of another engine: give a new place")

    def read(self, k: int, start: CurvePoint, curve: Curve) -> Trace | None:
        """Trace k; None if it is not there, or begins elsewhere."""
        try:
            kept = json.loads(self._file(k).read_bytes())
        except (OSError, ValueError):
            return None
        if kept["start"] != _plain(start):
            return None
        points = [_read_point(each, curve) for each in kept["points"]]
        marked = ((kind, index, stop, _read_point(each, curve)) for kind, index, stop, each in kept["marks"])
        marks = [(point_on_branch(curve, kind, point, index, stop), point) for kind, index, stop, point in marked]
        return Trace(points, marks, kept["reason"], joined=kept["joined"])

    def write(self, k: int, trace: Trace) -> None:
        """Keep trace k, which is finished."""
        kept = {
            "start": _plain(trace.points[0]),
            "points": [_plain(point) for point in trace.points],
            "marks": [(point.kind, point.index, point.stop, _plain(where)) for point, where in trace.marks],
            "reason": trace.reason,
            "joined": trace.joined,
        }
        _write(self._file(k), json.dumps(kept).encode())

    def _file(self, k: int) -> Path:
        return self._folder / f"trace-{k}.json"


def _write(file: Path, content: bytes) -> None:
    unfinished = file.with_suffix(".partial")
    unfinished.write_bytes(content)
    os.replace(unfinished, file)


def _plain(point: CurvePoint) -> list:
    orbit = point.orbit
    numbers: Iterable[np.ndarray] = (point.unknowns, point.tangent)
    return [orbit.period, [int(kind) for kind in orbit.kinds], int(orbit.first), *(each.tolist() for each in numbers)]


def _read_point(kept: list, curve: Curve) -> CurvePoint:
    period, kinds, first, unknowns, tangent = kept
    orbit = Orbit(period, tuple(kinds), first, np.array(unknowns[:-1]))
    return CurvePoint(curve, orbit, unknowns[-1], np.array(tangent))


class BranchSearch:
    """The branches of a family over a range.

    Parameters
    ----------
    question : BranchQuestion
    threads : int or None
        That run cells; None for as many as there are processors.
    cancelled : callable or None
    keep : str or Path, optional
        A folder in which to keep what is followed, and to read what the same search has followed before.
    """

    def __init__(
        self,
        question: BranchQuestion,
        threads: int | None = None,
        cancelled: Poll | None = None,
        keep: str | Path | None = None,
    ) -> None:
        self.question, self.family, self.span, self.cancelled = question, question.family, question.span, cancelled
        self.curve = Curve(self.family, self.span)
        self.finder = OrbitFinder(self.curve, question.max_period, threads, cancelled)
        self._journal = None if keep is None else Journal(Path(keep), question.as_dict())
        self._known = KnownBranches(self.curve)
        self._joined: list[float] = []  # where branches of twice the period end in others
        self._pending: list[tuple[str, CurvePoint]] = []

    def all(self, note: Callable[[str], None]) -> Iterator[Branch]:
        """Yield all branches: first from what a few values of the number show, then from what lies on none of these."""
        for value, orbit in chain(self._given(note), self._candidates()):
            check_cancelled(self.cancelled)
            if not self._known.have(CurvePoint(self.curve, orbit, value)):
                yield from self._stoppable(self.follow(orbit, value))
                yield from self._offspring()
            if self._is_spent():
                note(f"the search ended after {MOST_IN_ALL:,} orbits and may have missed branches: narrow the range")
                return
        if not self._known.orbits:
            note(self.finder.why_none())

    def _is_spent(self) -> bool:
        """Whether as many orbits were followed as one search may follow."""
        return self._known.orbits >= MOST_IN_ALL

    def _given(self, note: Callable[[str], None]) -> Iterator[tuple[float, Orbit]]:
        """The motion at a state, or that a run from there settles to."""
        value, initial = self.question.value, self.question.initial
        if initial is not None:
            start = starting_checkpoint(initial, *self.family.at(value))  # refuses what is no state
            if self.family.method.rigid:
                check_apart(start)
        if initial is not None and self.span.low <= value <= self.span.high:
            try:
                yield value, self.finder.begun(value, initial)
            except ValueError as error:
                note(stated("the motion from the initial state is not followed: {}", message_of(error)))

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
        if not any(self.family.at(end)[0].excitation.drives for end in (self.span.low, self.span.high)):
            value = min(max(self.family.value, self.span.low), self.span.high)
            yield value, self.finder.begun(value, None)
            return
        yield from self.finder.orbits(SEEDS, STARTS_AT_EACH, unstable=True)
        for source in (partial(self.finder.orbits, starts=1, unstable=False), self.finder.from_elsewhere):
            yield from source(FINE_SEEDS)

    def _offspring(self) -> Iterator[Branch]:
        """The branches that begin at points of others."""
        while self._pending and not self._is_spent():
            kind, point = self._pending.pop(0)
            if any(abs(point.value - value) < SAME_JOIN * self.span.width for value in self._joined):
                continue
            for start in other_branches(self.curve, kind, point):
                if not self._known.have(start):
                    yield from self._stoppable(branch_of_traces(self.family, self._traced(start), None, kind))

    def follow(self, orbit: Orbit, value: float) -> Branch:
        """Follow an orbit both ways."""
        start = CurvePoint(self.curve, orbit, value)
        start = on_its_sequence(self.curve, start) or start
        forwards = self._traced(start)
        closed = forwards.reason in ("the branch closes in itself", STOPPED)
        backwards = None if closed else self._traced(start.turned())
        return branch_of_traces(self.family, forwards, backwards, "")

    def _traced(self, start: CurvePoint) -> Trace:
        """The branch ahead of an orbit: from the journal, or followed and kept there."""
        number = self._known.traces
        trace = self._journal and self._journal.read(number, start, self.curve)
        if trace is None:
            trace = self._followed(start)
            if self._journal is not None and trace.reason != STOPPED:
                self._journal.write(number, trace)
        if trace.joined is not None:
            self._joined.append(trace.joined)
        self._known.add(trace)
        for point, orbit in trace.marks:
            doubles = point.kind == DOUBLING and 2 * point.period <= self.question.max_period
            followed = self.question.unstable or may_be_stable(point.multipliers)
            if (doubles or point.kind in (BRANCH_POINT, SYMMETRY_BREAKING)) and followed:
                self._pending.append((point.kind, orbit))
        return trace

    def _followed(self, start: CurvePoint) -> Trace:
        tracer = BranchTracer(self.curve, start, self.cancelled)
        since = 0.0  # the length up to the last orbit that was stable
        try:
            for count, _ in enumerate(tracer.run(self.question.most_orbits), start=1):
                here = tracer.points[-1]
                if count % EVERY == 0 and self._known.have(here):
                    tracer.reason = f"meets a branch found before at {self.curve.words(here)}"
                    break
                if self.question.unstable or here.orbit.period == 1:
                    continue
                since = tracer.length if may_be_stable(here.multipliers) else since
                if tracer.length - since >= LONGEST_UNSTABLE:
                    where = self.curve.words(here)
                    tracer.reason = f"given up at {where}, unstable for long: ask for unstable motions to go on"
                    break
        except Cancelled:
            tracer.reason = STOPPED
        except ValueError as error:  # a number is out of its range
            tracer.reason = str(error)
        return tracer


def other_branches(curve: Curve, kind: str, point: CurvePoint) -> Iterator[CurvePoint]:
    """The first orbits of the branches that begin at a point of this kind, as far as they are found.

    Where symmetry is lost they are the mirror images of each other, and the symmetric ones on either side.
    """
    times = 2 if kind == DOUBLING else 1
    orbit = point.orbit.repeated(times)
    here = CurvePoint(curve, orbit, point.value)
    scales = curve.scales(orbit)
    tangent = np.concatenate([point.tangent[:4], np.tile(point.tangent[4:-1], times), point.tangent[-1:]])
    if not np.isfinite(here.extended).all():
        return
    if kind == SYMMETRY_BREAKING:
        lost, kept = ways_at_loss(here)
        ways = lost, -lost, kept, -kept
    else:
        ways = (across(tangent / np.linalg.norm(tangent), *np.linalg.svd(here.extended * scales)[2][-2:]),)
    starts = (_first_along(curve, here, kind, away) for away in ways)
    yield from (start for start in starts if start is not None)


def _first_along(curve: Curve, here: CurvePoint, kind: str, away: np.ndarray) -> CurvePoint | None:
    """The first orbit that is found in a direction from a point where branches meet; None if there is none."""
    orbit, scales = here.orbit, here.scales
    for step in AWAY:
        guess = here.unknowns + step * away * scales
        row = away / scales
        start = curve.constrained(orbit.at(guess[:-1]), float(guess[-1]), (row, row @ guess), away)
        if start is None:
            continue
        rows = start.evaluation.section
        half = orbit.period // 2
        if kind == DOUBLING and np.abs(rows[0] - rows[half]).max() < 0.1 * step * scales[0]:
            continue  # back on the branch of half the period
        if start.least_margin > 0:
            return start
    return None


def continue_branch(question: BranchQuestion, *, threads: int | None = None, cancelled: Poll | None = None) -> Branch:
    """Follow the periodic motion that a run settles to, both ways through a range of one number.

    Parameters
    ----------
    question : BranchQuestion
        With ``initial`` the orbit there is followed.
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
        If the motion begins outside the range, or the run does not settle to a periodic motion.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import BranchQuestion, Reference, System, continue_branch
    >>> branch = continue_branch(BranchQuestion(System(), 2.76, Reference(), low=2.7, high=2.85, max_period=1))
    >>> [(point.kind, round(point.value, 8)) for point in branch.points]
    [('period doubling', 2.78895505)]
    """
    search = BranchSearch(question, threads, cancelled)
    value, initial = question.value, question.initial
    question.span.check_start(value)
    branch = search.follow(search.finder.begun(value, initial), value)
    if STOPPED in branch.ends:
        raise Cancelled
    return branch


def search_branches(
    question: BranchQuestion,
    *,
    threads: int | None = None,
    note: Callable[[str], None] | None = None,
    keep: str | Path | None = None,
    cancelled: Poll | None = None,
) -> Iterator[Branch]:
    """Follow every branch of periodic motions through a range of one number, and yield each as it is found.

    A branch that is being followed when the search is cancelled is yielded as far as it goes, before the exception.

    Parameters
    ----------
    question : BranchQuestion
    threads, cancelled
        As for :func:`continue_branch`.
    note : callable, optional
        Called with a sentence where no motion is found: from ``initial``, or at all.
    keep : str or Path, optional
        A folder, in which each branch is kept once it is followed: the same search reads it there, however it ended.

    Yields
    ------
    Branch

    Raises
    ------
    ValueError
        If ``initial`` is no state, or the folder holds another search, or one of another engine.
    Cancelled
        If ``cancelled`` returned true.
    """
    yield from BranchSearch(question, threads, cancelled, keep).all(note or (lambda _: None))


def find_branches(question: BranchQuestion, **search: object) -> tuple[Branch, ...]:
    """Follow every branch of periodic motions through a range of one number.

    Parameters
    ----------
    question : BranchQuestion
    **search
        Arguments of :func:`search_branches`; exceptions are the same, too.

    Returns
    -------
    tuple of Branch
        In the order in which they were found.

    Examples
    --------
    >>> from vibroscope.engine import BranchQuestion, Reference, System, find_branches
    >>> found = find_branches(BranchQuestion(System(), 1.4, Reference(), low=1.35, high=1.48, max_period=2))
    >>> sorted(branch.period for branch in found)
    [1, 2]
    """
    return tuple(checked(search_branches)(question, **search))
