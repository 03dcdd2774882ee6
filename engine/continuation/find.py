"""The ways into the search for branches: one branch, all as they are found, or all at the end."""

from collections.abc import Callable, Iterator
from pathlib import Path

from ..arguments import checked
from ..result import Cancelled
from .branch import Branch
from .question import BranchQuestion
from .search import STOPPED, BranchSearch


def continue_branch(
    question: BranchQuestion, *, threads: int | None = None, cancelled: Callable[[], bool] | None = None
) -> Branch:
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
    orbit = search.finder.near(value, initial) if initial is not None else None
    if orbit is None:
        orbit = search.finder.settled(value, initial)
    branch = search.follow(orbit, value)
    if STOPPED in branch.ends:
        raise Cancelled
    return branch


def search_branches(
    question: BranchQuestion,
    *,
    threads: int | None = None,
    note: Callable[[str], None] | None = None,
    keep: str | Path | None = None,
    cancelled: Callable[[], bool] | None = None,
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
