"""The ways into the search for branches: one branch, all as they are found, or all at the end."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ..arguments import checked
from ..methods import ExactPenalty, Reference
from ..model import System
from ..motions.poincare_map import unresolved
from ..result import Cancelled
from .branch import Branch
from .family import Family
from .follow import MOST_ORBITS
from .parameter_range import ParameterRange
from .search import STOPPED, BranchSearch
from .search_limits import SearchLimits


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
        The exact penalty with the law "kelvin-voigt".
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
    limits = SearchLimits(max_period, most_orbits)
    search = _search((system, eta, method), (over, low, high), limits, threads, cancelled)
    value = search.family.value
    search.span.check_start(value)
    orbit = search.finder.near(value, initial) if initial is not None else None
    if orbit is None:
        orbit = search.finder.settled(value, initial)
    branch = search.follow(orbit, value)
    if STOPPED in branch.ends:
        raise Cancelled
    return branch


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
    """Follow every branch of periodic motions through a range of one number, and yield each as it is found.

    A branch that is being followed when the search is cancelled is yielded as far as it goes, before the exception.

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
        If a number is out of range, or the folder holds another search, or one of another engine.
    Cancelled
        If ``cancelled`` returned true.
    """
    limits = SearchLimits(max_period, most_orbits, unstable)
    search = _search((system, eta, method), (over, low, high), limits, threads, cancelled)
    if keep is not None:
        search.keep(Path(keep), initial)
    yield from search.all(initial, note or (lambda _: None))


def find_branches(system: System, eta: float, method: Reference | ExactPenalty, **search: object) -> tuple[Branch, ...]:
    """Follow every branch of periodic motions through a range of one number.

    Parameters
    ----------
    system, eta, method, **search
        Arguments of :func:`search_branches`; exceptions are the same, too.

    Returns
    -------
    tuple of Branch
        In the order in which they were found.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, find_branches
    >>> found = find_branches(System(), 1.4, Reference(), low=1.35, high=1.48, max_period=2)
    >>> sorted(branch.period for branch in found)
    [1, 2]
    """
    return tuple(checked(search_branches)(system, eta, method, **search))


def _search(problem: tuple, span: tuple[str, float, float], limits: SearchLimits, threads, cancelled) -> BranchSearch:
    """The search, with its range checked."""
    over, low, high = span
    if reason := unresolved(problem[0]):
        raise ValueError(reason)
    family = Family(over, *problem)
    return BranchSearch(family, ParameterRange.of(family, low, high), limits, threads, cancelled)
