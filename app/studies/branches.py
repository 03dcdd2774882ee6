"""The branches of periodic motions over a number, while they are searched for. No panel import.

The search cannot be taken up where it was cancelled: it begins anew, and what it had found stays until as much is found
again.

A limit of the seconds that a search computes, and of what it finds.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from vibroscope.app.runtime.settings import current_settings
from vibroscope.app.runtime.workers import own_time
from vibroscope.engine import (
    CONTACT_LAWS,
    COORDINATES,
    METHOD_NUMBERS,
    PARAMETERS,
    POINT_KINDS,
    Branch,
    BranchQuestion,
    Cancelled,
    ExactPenalty,
    Point,
    Reference,
    System,
    search_branches,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import Statement, joined, sentence

Part = TypeVar("Part")


def limited(
    search: Callable[[Poll], Iterator[Part]], seconds: float, most: int, what: str, cancelled: Poll
) -> Iterator[tuple[tuple[Part, ...], str | None]]:
    """All that a search has found, after each find; and last, with why it ended early, or an empty text.

    Parameters
    ----------
    search : callable
        Gets a function that says whether to end, on which it raises `Cancelled`.
    seconds : float
        Of its own; what other studies have while a partial result is taken does not count.
    most : int
        Finds after which it ends.
    what : str
        The finds in a word.
    cancelled : callable
        Whether the study was cancelled; `Cancelled` is then raised on.
    """
    found, cut, left, begin = (), "", seconds, own_time()

    def ends() -> bool:
        return cancelled() or own_time() - begin > left

    try:
        for each in search(ends):
            found = (*found, each)
            if len(found) == most:
                cut = f"The search ended at {most} {what}: a narrower range shows the others."
                break
            left -= own_time() - begin
            yield found, None
            begin = own_time()
    except Cancelled:
        if cancelled():
            raise
        cut = f"The search ended after {seconds:g} s and may have missed {what}: a narrower range is quicker."
    yield found, cut


MAX_PERIOD = 4  # longest cycle that is looked for, in excitation periods
MOST_BRANCHES = 60
LIMIT = {"most_orbits": 400}  # of a branch in each direction: where impacts pile up it has thousands
SECONDS = 60.0  # of one search, without what others had meanwhile
# kinds of points where motions begin, end or change their stability; the others are changes of the sequence of events
BIFURCATIONS = tuple(name for name, kind in POINT_KINDS.items() if kind.test)


class BranchesQuestion(NamedTuple):
    """Branches to search for: ``over`` goes from end to end of ``span``; ``eta`` holds where it does not vary.

    The motion at ``followed`` is followed first: a value of the number, and the state (ξ₁, ξ₁′, ξ₂, ξ₂′) there.
    """

    system: System
    method: Reference | ExactPenalty
    span: tuple[float, float]
    over: str = "eta"
    eta: float = 1.0
    followed: tuple[float, tuple[float, ...]] | None = None

    @property
    def search(self) -> BranchQuestion:
        """What the engine is asked."""
        numbers = {"over": self.over, "low": self.span[0], "high": self.span[1], "max_period": MAX_PERIOD} | LIMIT
        question = BranchQuestion(self.system, self.eta, self.method, **numbers)
        if self.followed is None:
            return question
        value, initial = self.followed
        return BranchQuestion(*question.at(value), **numbers, initial=initial)


@dataclass(frozen=True, eq=False)
class PartialBranches:
    """The branches that were found so far.

    Attributes
    ----------
    question : BranchesQuestion
    branches : tuple of Branch
    share : float
        1 when the search is over.
    cut : str or Statement
        Why the search ended before all was found, in a sentence; empty if it did not.
    """

    question: BranchesQuestion
    branches: tuple[Branch, ...]
    share: float = 0.0
    cut: str | Statement = ""

    @property
    def points(self) -> list[tuple[int, int, Point]]:
        """Every point with the number of its branch and its number there, in the order of its value."""
        found = [(n, k, point) for n, branch in enumerate(self.branches) for k, point in enumerate(branch.points)]
        return sorted(found, key=lambda each: each[2].value)

    def near(self, value: float) -> list[tuple[int, int]]:
        """Number of the branch and of the orbit that is nearest wherever a branch passes the value."""
        found = []
        for number, branch in enumerate(self.branches):
            aside = branch.values - value
            passes = np.flatnonzero((aside[:-1] <= 0) != (aside[1:] <= 0)).tolist()
            found += [(number, k if abs(aside[k]) < abs(aside[k + 1]) else k + 1) for k in passes]
        return found

    def words(self) -> str:
        """How many branches and bifurcations there are."""
        kinds = [point.kind for branch in self.branches for point in branch.points]
        numbers = {kind: kinds.count(kind) for kind in BIFURCATIONS if kind in kinds}
        counts = [f"{number} {POINT_KINDS[kind].words(number)}" for kind, number in numbers.items()]
        count = len(self.branches)
        head = f"{count} branch{'' if count == 1 else 'es'} of up to {MAX_PERIOD} periods"
        return f"{head} with {', '.join(counts)}" if counts else head

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        return {"branches": self.orbit_table(), "points": self.point_table(), "cut": self.cut}

    def orbit_table(self) -> dict[str, np.ndarray]:
        """Every section point of every orbit: the columns of a table."""
        over, parts = self.question.over, []
        for number, branch in enumerate(self.branches):
            periods = branch.sections.shape[1]
            largest, stable = branch.multipliers[:, 0], branch.stable
            orbit = {"branch": number + 1, over: branch.values, "period": branch.period, "stable": stable.astype(int)}
            orbit |= {"multiplier_re": largest.real, "multiplier_im": largest.imag}
            rows = {name: np.repeat(np.broadcast_to(column, len(stable)), periods) for name, column in orbit.items()}
            rows["section"] = np.tile(np.arange(periods), len(stable))
            parts.append(rows | dict(zip(COORDINATES, branch.sections.reshape(-1, 4).T, strict=True)))
        return {name: np.concatenate([part[name] for part in parts]) for name in (parts[0] if parts else {})}

    def point_table(self) -> dict[str, np.ndarray]:
        """Every point: the columns of a table."""
        points = self.points
        critical = np.array([point.critical_multiplier for *_, point in points])
        return {
            "branch": np.array([number + 1 for number, *_ in points]),
            "kind": np.array([point.kind for *_, point in points]),
            self.question.over: np.array([point.value for *_, point in points]),
            "period": np.array([point.period for *_, point in points]),
            "multiplier_re": critical.real,
            "multiplier_im": critical.imag,
            **dict(zip(COORDINATES, np.array([point.state for *_, point in points]).reshape(-1, 4).T, strict=True)),
        }


def grow_branches(
    question: BranchesQuestion, last: PartialBranches | None, cancelled: Poll
) -> Iterator[PartialBranches]:
    """The branches so far, after each. Raises `Cancelled`."""
    kept, notes = last.branches if last else (), []
    how = {"threads": current_settings().threads, "note": notes.append}
    search = partial(search_branches, question.search, **how)
    found = limited(lambda ends: search(cancelled=ends), SECONDS, MOST_BRANCHES, "branches", cancelled)
    for branches, cut in found:
        if cut is None:
            yield PartialBranches(question, max(branches, kept, key=len))
    why = joined(" ", filter(None, (cut, *map(sentence, notes))))
    yield PartialBranches(question, branches, 1.0, why)


def why_none(over: str, method: Reference | ExactPenalty) -> str:
    """Why there are no branches of a solver over a number, in a sentence; empty where there are."""
    if over not in PARAMETERS:
        return "Branches are of motions without a time step: sweep another number than the steps per period."
    if not method.rigid if over == "restitution" else over in METHOD_NUMBERS and over not in method.numbers:
        return f"The {'reference' if method.rigid else 'penalty model'} has no {over}."
    if not method.rigid and not method.linear:
        return f"There are no branches with the contact law {method.law}: choose {CONTACT_LAWS[0]}."
    return ""


def matched(first: list[Point], second: list[Point]) -> list[tuple[Point | None, Point | None]]:
    """The points of two lists in pairs of the same kind and period, each the nearest of the other; in order of value.

    A point that is not the nearest of its own nearest one stays alone.
    """
    pairs, alone = [], [(None, point) for point in second]
    for point in first:
        other = _nearest(point, second)
        mutual = other is not None and _nearest(other, first) is point
        pairs.append((point, other if mutual else None))
        if mutual:
            alone = [each for each in alone if each[1] is not other]
    return sorted([*pairs, *alone], key=lambda pair: (pair[0] or pair[1]).value)


def _nearest(point: Point, others: list[Point]) -> Point | None:
    same = [each for each in others if (each.kind, each.period) == (point.kind, point.period)]
    return min(same, key=lambda each: abs(each.value - point.value), default=None)
