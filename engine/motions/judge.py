"""The judge of motions: which kind they are, of many cells together; a single motion is one cell.

A diagram, a plane, a study over the step, `motion` and what rests on it ask this judge alone, of the same periods: the
last `SETTLED_PERIODS` of a run from the start of a cell, and what follows them. A chaotic transient amplifies rounding,
so that two runs that go on from other periods may settle at other times; the kind of a motion must not depend on it.

- Closed form: a motion that does not repeat itself goes on as long as a single one is followed, and is then judged by
  its largest Lyapunov exponent.
- With a time step: by the motion without one that begins where the run ends, and by the width of the section's band
  with smaller steps (:mod:`.time_step_scatter`). A band beside a limit that repeats itself which narrows with the same
  step, too, is the rest of a transient: the cell is judged later.
- A chaotic transient ends by chance, after thousands of periods as after ten. A single motion that is found chaotic is
  followed several times as far; of the cells of a study that are called chaotic a few in a hundred may settle later.

What these runs do not decide is undecided.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from vibroscope.engine.cells import CellResults, Cells, run_cells
from vibroscope.engine.drivers.law_driven import remembers
from vibroscope.engine.drivers.section import periods_of
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import CellKind, Kind
from vibroscope.engine.motions.lyapunov import Lyapunov, follow_cells
from vibroscope.engine.motions.poincare_map import unresolved
from vibroscope.engine.motions.section import band_widths, cycle_spreads, rotation_number, settled_periods
from vibroscope.engine.motions.steady import schedule_of
from vibroscope.engine.motions.time_step_scatter import (
    FINER,
    FINER_LOCATED,
    SCATTER_KEEP,
    SCATTER_TRANSIENT,
    Limits,
    can_narrow,
    judge_bands,
)
from vibroscope.engine.motions.tolerances import FOLLOWED_GROWTH, REPEATED_BAND, SETTLES, SHRUNK
from vibroscope.engine.simulate import FARTHEST, LONG

SETTLED_PERIODS = SCATTER_KEEP  # last periods of a run that a motion is judged by
# Taken one by one, of a run that shows whether a single motion has come to the end of a long transient
STEPS_OF_A_TRANSIENT = 8_000_000
LONGEST_SEEN = 512  # periods of a cycle that a motion may have settled to while it was followed

# Of each cell: dtype and what stands where nothing is known.
KIND_VARIABLES = {
    "kind": (np.int8, CellKind.UNKNOWN),  # a `CellKind`
    "kind_period": (np.int32, 0),  # excitation periods until the motion repeats itself, without its scatter
    "lyapunov": (np.float64, np.nan),  # largest exponent per period of a motion that does not repeat itself
    "lyapunov_error": (np.float64, np.nan),
}


def unknown_kinds(n: int) -> dict[str, np.ndarray]:
    """`KIND_VARIABLES` of n cells of which nothing is known."""
    return {name: np.full(n, fill, dtype) for name, (dtype, fill) in KIND_VARIABLES.items()}


class Evidence:
    """What a single motion is described by, beside its kind; cell 0 of a call notes it.

    Attributes
    ----------
    starts : list of ((4,) ndarray, int)
        Where each later run began, in place of the run before, which was the rest of a transient; its transient.
    own_period : int
        After which the scattered section that was judged last happens to repeat itself; 0 if it does not.
    judged : Judgements
        Of that section.
    finer : list of (int, ndarray)
        Steps per period, and the section with them.
    limit : Evidence or None
        Of the motion without one that begins where the run ends.
    kind : dict of str to number
        Of a motion without a time step: `KIND_VARIABLES`.
    followed : Lyapunov or None
        What decided it.
    section : ndarray
        Its last points.
    is_late : bool
        Whether these are of later runs than the one that was judged.
    """

    def __init__(self):
        self.starts, self.finer, self.own_period, self.judged, self.limit = [], [], 0, None, None
        self.kind, self.followed, self.section, self.is_late = {}, None, None, False


def late_runs(cells: Cells, least: int = 0, **how) -> CellResults:
    """Let cells run, each from its start, to the periods that they are judged by, or to ``least`` if that is later."""
    long = LONG if cells.method.has_step else schedule_of(cells.method).long
    until = max(long, least)
    keep = {} if cells.method.has_step else {"recurrence": SETTLES}
    return run_cells(cells, transient=until - SETTLED_PERIODS, sample=SETTLED_PERIODS, **keep, **how)


def judge(
    cells: Cells, sections: np.ndarray, *, evidence: Evidence | None = None, threads=None, cancelled=None
) -> dict[str, np.ndarray]:
    """Judge motions by the last points of their runs, and by runs that begin there.

    Parameters
    ----------
    cells : Cells
    sections : (n, SETTLED_PERIODS, 4) ndarray
        Of runs of `LONG` periods (:func:`late_runs`).
    evidence : Evidence, optional
        To note what decided on cell 0.
    threads, cancelled
        As of :func:`engine.run_cells`.

    Returns
    -------
    dict of str to (n,) ndarray
        `KIND_VARIABLES`. No run can begin where a motion has grown beyond `FARTHEST`: it stays undecided.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    found, how = unknown_kinds(len(cells)), {"threads": threads, "cancelled": cancelled}
    found["kind"][:] = CellKind.UNDECIDED
    method = cells.method.limit if cells.method.has_step else cells.method
    if (alone := _systems(cells, lambda system: remembers(system, method))).any():  # the section alone says what it is
        found["kind_period"][alone] = periods_of(sections[alone])
        found["kind"][alone & (found["kind_period"] > 0)] = CellKind.PERIODIC
    near = np.flatnonzero((np.abs(sections[:, -1]) <= FARTHEST).all(axis=1) & ~alone)
    if not len(near):
        return found
    find = _judge_bands if cells.method.has_step else _judge_closed_forms
    judged = find(cells.at(near, initial=sections[near, -1]), sections[near], evidence, how)
    for name in found:
        found[name][near] = judged[name]
    return found


def _systems(cells: Cells, has: Callable[[System], object]) -> np.ndarray:
    """Of which cells the system has what is asked, (n,) of bool."""
    if isinstance(cells.system, System):
        return np.full(len(cells), bool(has(cells.system)))
    return np.array([bool(has(system)) for system in cells.system])


def classify(followed: Lyapunov) -> tuple[Kind, str]:
    """Return the type of a motion that is not known to be periodic, and the reason in words."""
    rate = f"largest Lyapunov exponent {followed.exponent:+.3g} ± {followed.error:.2g} per period"
    over = f"over {len(followed.section)} periods"
    if followed.is_quasi_periodic:
        return Kind.QUASI_PERIODIC, (
            f"{rate} {over}, zero within its uncertainty, and averages over the section converge as only those of "
            f"regular motion do (to {followed.irregularity:.1g}); the other frequency is "
            f"{rotation_number(followed.section):.6f} of the first"
        )
    if followed.is_chaotic:
        return Kind.CHAOTIC, f"{rate} {over}"
    if followed.sign == -1:
        return Kind.UNDECIDED, f"{rate}: it contracts, but has not come to a cycle {over}"
    return (
        Kind.UNDECIDED,
        f"{rate} {over}: not distinguishable from zero, or changing on the way; it may be a long transient",
    )


# -- methods with a time step ------------------------------------------------------------------------------------------


def _judge_bands(cells: Cells, sections: np.ndarray, evidence: Evidence | None, how) -> dict[str, np.ndarray]:
    """Judge cells by their limits without a time step, and by what smaller steps leave of the sections' bands."""
    limit_evidence = Evidence() if evidence else None
    limit, spreads = _limits(replace(cells, method=cells.method.limit, steps=None), how, limit_evidence)
    method = replace(cells.method, every_step=False)
    periods, steps = settled_periods(sections), cells.steps_each()

    def finer(places: np.ndarray, factor: int) -> tuple[np.ndarray, np.ndarray]:
        found = _go_on(cells.at(places, method=method, steps=factor * steps[places]), how)
        if evidence and found.ok[0]:
            evidence.finer.append((int(factor * steps[0]), found.section[0]))
        return found.section, found.ok

    limits = Limits(limit["kind"], limit["kind_period"], spreads)
    judged = judge_bands(sections, periods, limits, steps, finer, FINER_LOCATED if cells.method.located else FINER)
    repeats = np.isin(judged.kinds, (CellKind.PERIODIC, CellKind.ARTEFACT))
    found = {"kind": judged.kinds, "kind_period": judged.periods}
    found |= {name: np.where(repeats, np.nan, limit[name]) for name in ("lyapunov", "lyapunov_error")}
    if evidence:
        evidence.own_period, evidence.judged, evidence.limit = int(periods[0]), judged, limit_evidence
    settling = np.flatnonzero(~judged.is_shown & (limit["kind_period"] > 0))
    settling = settling[can_narrow(sections[settling])]
    for transient in _transients(cells, limit_evidence):
        if not len(settling):
            break
        some = cells.at(settling)
        later = _go_on(some, how, transient)
        narrower = band_widths(later.section, judged.about[settling]) < SHRUNK * judged.widths[settling]
        chosen = np.flatnonzero(later.ok & narrower & (np.abs(later.end) <= FARTHEST).all(axis=1))
        if len(chosen):
            if evidence:
                evidence.starts.append((sections[0, -1], transient))
                evidence.finer.clear()
            going_on = some.at(chosen, initial=later.section[chosen, -1])
            again = _judge_bands(going_on, later.section[chosen], evidence, how)
            for name, array in again.items():
                found[name][settling[chosen]] = array
        settling = np.delete(settling, chosen)
    return found


def _transients(cells: Cells, limit: Evidence | None) -> tuple[int, ...]:
    """Periods after which bands are looked at again, whether they were the rest of a transient.

    Of a single motion once more where the transient was long without a time step, too, as far as its steps allow.
    """
    if limit is None or not limit.is_late:
        return (SCATTER_TRANSIENT,)
    longest, method = schedule_of(cells.method.limit).confirmed, cells.method
    most = longest if method.skips_steps else STEPS_OF_A_TRANSIENT // int(cells.steps_each()[0])
    return SCATTER_TRANSIENT, min(longest, most)


def _go_on(cells: Cells, how: dict, transient: int = SCATTER_TRANSIENT, **recurrence: float) -> CellResults:
    """Runs that go on from the ends of others until what these have left behind has died out."""
    return run_cells(cells, transient=transient, sample=SETTLED_PERIODS, **recurrence, **how)


def _limits(cells: Cells, how: dict, evidence: Evidence | None) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Kinds of the motions without a time step that begin where cells ended, and the spreads of their cycles.

    A spread is that of the points of a cycle (:func:`.section.cycle_spreads`); 0 for other motions.
    """
    runs = _go_on(cells, how, recurrence=SETTLES)
    cycles = np.where(runs.ok[:, None, None], runs.section, np.nan)
    found, later = _follow(cells, cycles, how, evidence)
    for i, section in later.items():
        cycles[i] = section[-SETTLED_PERIODS:]
    shown = (found["kind_period"] > 0) & (2 * found["kind_period"] <= SETTLED_PERIODS)
    return found, np.where(shown, cycle_spreads(cycles, np.where(shown, found["kind_period"], 1)), 0.0)


# -- closed form -------------------------------------------------------------------------------------------------------


def _judge_closed_forms(cells: Cells, sections: np.ndarray, evidence: Evidence | None, how) -> dict[str, np.ndarray]:
    """Judge cells by their sections, and those that do not repeat themselves by what they come to."""
    return _follow(cells, sections, how, evidence)[0]


def _follow(
    cells: Cells, sections: np.ndarray, how: dict, evidence: Evidence | None = None
) -> tuple[dict[str, np.ndarray], dict[int, np.ndarray]]:
    """Kinds of motions in closed form: of those without a period, by their largest Lyapunov exponent.

    Parameters
    ----------
    cells : Cells
    sections : (m, SETTLED_PERIODS, 4) ndarray
        At the end of which each of them goes on; nan where it cannot.

    Returns
    -------
    found : dict of str to (m,) ndarray
    later : dict of int to (n, 4) ndarray
        The last points of those that went on, by their place.
    """
    found, state, later = unknown_kinds(len(cells)), sections[:, -1].copy(), {}
    decided_by_rounding = np.zeros(len(cells), bool)
    state[_systems(cells, unresolved)] = np.nan
    found["kind_period"][:] = np.where(np.isfinite(state).all(axis=1), settled_periods(sections), 0)
    found["kind"][:] = np.where(found["kind_period"] > 0, CellKind.PERIODIC, CellKind.UNDECIDED)

    def note(i: int, section: np.ndarray) -> None:
        later[i], state[i] = section, section[-1]
        if settled := int(settled_periods(section[None])[0]):
            found["kind"][i], found["kind_period"][i] = CellKind.PERIODIC, settled
            found["lyapunov"][i] = found["lyapunov_error"][i] = np.nan

    def judge_exponent(i: int, followed: Lyapunov) -> None:
        if evidence and i == 0:
            evidence.followed = followed
        if np.isnan(followed.exponent):  # no derivative: an impact grazes
            state[i] = np.nan
            return
        found["lyapunov"][i], found["lyapunov_error"][i] = followed.exponent, followed.error
        if followed.exponent == -np.inf:
            decided_by_rounding[i] = followed.growth > FOLLOWED_GROWTH
            return
        found["kind"][i] = CellKind[classify(followed)[0].name]
        note(i, followed.section[-2 * LONGEST_SEEN :])

    def open_places() -> np.ndarray:
        is_open = (found["kind"] == CellKind.UNDECIDED) & (found["lyapunov"] != -np.inf)
        return np.flatnonzero(is_open & (np.abs(state) <= FARTHEST).all(axis=1))

    def go_on(places: np.ndarray, transient: int, sample: int) -> None:
        some = cells.at(places, initial=state[places])
        runs = run_cells(some, transient=transient, sample=sample, recurrence=SETTLES, **how)
        for k in np.flatnonzero(runs.ok).tolist():
            note(int(places[k]), runs.section[k])

    # a transient that alternates fades slowly beside a period doubling: twice the period shows first
    several = np.flatnonzero(found["kind_period"] > 1)
    fading = several[periods_of(sections[several], REPEATED_BAND) == 0]
    schedule, places = schedule_of(cells.method), np.union1d(open_places(), fading)
    go_on(places, schedule.followed, SETTLED_PERIODS)
    may_stick = _systems(cells, lambda system: cells.method.rigid and system.wall)
    for periods in schedule.judged:
        places = open_places()
        if periods < schedule.followed:  # a contact that sticks leaves nothing of a disturbance, and may be rare
            places = places[~may_stick[places]]
        follow_cells(cells, places, state[places], periods, judge_exponent, **how)
    # contacts that stick leave nothing of a disturbance: a long cycle shows in the section alone, if it is one
    sticking = (found["lyapunov"] == -np.inf) & ~decided_by_rounding
    go_on(np.flatnonzero(sticking), LONG - 2 * LONGEST_SEEN, 2 * LONGEST_SEEN)
    if evidence:
        go_on(np.flatnonzero(found["kind"] == CellKind.CHAOTIC), schedule.confirmed, SETTLED_PERIODS)
        evidence.kind, evidence.section = {name: array[0] for name, array in found.items()}, later.get(0, sections[0])
        evidence.is_late = 0 in later
    return found, later
