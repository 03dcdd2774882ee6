"""Kinds of motion of the cells of a sweep: periodic, quasi-periodic, chaotic, or scattered by the step.

The sweep itself only shows which sections repeat themselves. The cells that do not are judged as
:func:`engine.motion` judges a single motion, with fewer and shorter runs: each cell goes on from where it ended.

- Reference and exact penalty: the largest Lyapunov exponent, over `FOLLOWED` periods.
- Newmark: the exact penalty motion with the same K and D, and the width of the section's band with smaller steps. A
  band that shrinks towards a periodic limit is an artefact of the time step; one that keeps its width beside a chaotic
  limit is motion. One that narrows with the same step too is the rest of a transient: the cell is judged later. One
  that is not about the points of a periodic limit is another motion. All this is asked of the same periods as those of
  a single motion (`_as_late`): the scatter may end late, and where several motions without a time step coexist, the one
  that counts begins where the run ends.

What these runs do not decide is undecided. No module of a study imports this one, so that it does not enter the digest
of numerical code.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..batch import follow_cells, run_cells
from ..cells import Cells
from ..drivers.threads import thread_count
from ..methods import Method
from ..motions.description import Kind
from ..motions.lyapunov import Lyapunov
from ..motions.motion import classify
from ..motions.section import band_widths, cycle_spreads, scatter, settled_period, settled_periods
from ..motions.steady import schedule_of
from ..motions.time_step_scatter import FINER, FINER_LOCATED, Limits, can_narrow, judge_bands
from ..motions.tolerances import SHRUNK
from ..motions.words import repetition_of
from ..simulate import FARTHEST, LONG
from .codes import MISSING, CellKind
from .eta_study import EtaStudy
from .plane_study import PlaneStudy
from .tolerances import SETTLES

FOLLOWED = (512, 4096)  # periods with a disturbance; the second number only if the first does not decide
SETTLED_PERIODS = 256  # last periods of these that may show a cycle which the motion has settled to
FINER_TRANSIENT = 256  # periods of a run with smaller steps before its section is taken


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


def known_kinds(study: EtaStudy, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The kinds of motion that the values of a study show without any further run.

    These are the cells that ended early, and those with a period: of Newmark's method only with the period 1, since a
    longer one may be scatter that happens to repeat itself.
    """
    return _known_kinds(study.method, values["status"], values["period"])


def _known_kinds(method: Method, status: np.ndarray, period: np.ndarray) -> dict[str, np.ndarray]:
    found = unknown_kinds(len(status))
    clear = (status == 0) & ((period == 1) if method.has_step else (period > 0))
    found["kind"][clear] = CellKind.PERIODIC
    found["kind_period"][clear] = period[clear]
    found["kind"][(status != 0) & (status != MISSING)] = CellKind.ENDED_EARLY
    return found


def kind_words(
    kind: CellKind, period: int, near_period: int | None = None, section: np.ndarray | None = None, body: int = 2
) -> str:
    """The motion of a cell, in the words of a single motion (:func:`engine.repetition`).

    Parameters
    ----------
    kind : CellKind
        `CellKind.UNKNOWN`: the section alone speaks.
    period : int
        ``kind_period``, or the section's where the kind is not known.
    near_period : int, optional
        Of the section. It counts where that is all that is known, or no kind was decided.
    section : (sample, 4) ndarray, optional
        It shows how much the displacement of ``body`` scatters.
    body : int
        See :attr:`System.observed_body`.
    """
    if kind == CellKind.ENDED_EARLY:
        return "ended early"
    is_open = kind in (CellKind.UNKNOWN, CellKind.UNDECIDED)
    near = near_period if is_open and near_period is not None else period
    amount = scatter(section, near, body) if section is not None and near else np.nan
    words = repetition_of(Kind[CellKind(kind).name], period, near, amount, kind == CellKind.ARTEFACT, body)
    return words + ", its kind not decided" if kind == CellKind.UNDECIDED else words


def judge_cells(
    study: EtaStudy | PlaneStudy,
    values: dict[str, np.ndarray],
    chosen: np.ndarray,
    *,
    threads: int | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> dict[str, np.ndarray]:
    """Judge the motion of some cells that reached their end.

    Parameters
    ----------
    study : EtaStudy or PlaneStudy
    values : dict
        Its variables, ``end`` among them.
    chosen : (m,) ndarray of int
        The cells to judge, as indices of the flattened grid.
    threads : int, optional
        As many as there are processors, if not given.
    cancelled : callable, optional
        Polled many times a second; when it returns true the call is cancelled.

    Returns
    -------
    dict of str to (m,) ndarray
        `KIND_VARIABLES` of the chosen cells.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    cells = study.cells_at({name: each.ravel()[chosen] for name, each in study.points().items()})
    run = {"transient": study.transient, "sample": study.sample}
    period, end = values["period"].ravel()[chosen], values["end"].reshape(-1, 4)[chosen]
    return _judge(cells, period, end, run, _how(threads, cancelled))


def judge_runs(
    cells: Cells,
    *,
    transient: int,
    sample: int,
    threads: int | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> dict[str, np.ndarray]:
    """Run cells, and judge the motion of those that reached their end.

    Returns
    -------
    dict of str to (n,) ndarray
        `KIND_VARIABLES`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    run, how = {"transient": transient, "sample": sample}, _how(threads, cancelled)
    found = run_cells(cells, **run, **how)
    periods = settled_periods(found.section)
    kinds = _known_kinds(cells.method, found.status, periods)
    chosen = np.flatnonzero(kinds["kind"] == CellKind.UNKNOWN)
    if len(chosen):
        for name, array in _judge(cells.at(chosen), periods[chosen], found.end[chosen], run, how).items():
            kinds[name][chosen] = array
    return kinds


def _how(threads: int | None, cancelled) -> dict[str, object]:
    return {"threads": thread_count(threads), "cancelled": cancelled}


def _judge(cells: Cells, period, end, run: dict, how: dict) -> dict[str, np.ndarray]:
    """Judge cells by runs that begin where their own ended.

    No run can begin where a motion has grown beyond `FARTHEST`: it stays undecided.
    """
    found = unknown_kinds(len(cells))
    found["kind"][:] = CellKind.UNDECIDED
    near = np.flatnonzero((np.abs(end) <= FARTHEST).all(axis=1))
    some = cells.at(near, initial=end[near])
    if cells.method.has_step:
        chosen, *late = _as_late(some, run, how)
        near, judged = near[chosen], _judge_newmark(*late, run, how)
    else:
        judged, _ = _follow(some, period[near], end[near], how)
    for name, array in judged.items():
        found[name][near] = array
    return found


def _as_late(cells: Cells, run: dict, how: dict) -> tuple[np.ndarray, Cells, np.ndarray, np.ndarray]:
    """Let cells go on to what a single motion is judged by, the last `SETTLED_PERIODS` of `LONG`, or to later periods.

    Returns
    -------
    chosen : (m,) ndarray of int
        The cells that come so far.
    cells, periods, sections
        Theirs, as they are then.
    """
    missing = max(0, LONG - SETTLED_PERIODS - run["transient"] - run["sample"])
    later = run_cells(cells, transient=missing, sample=SETTLED_PERIODS, **how)
    chosen = np.flatnonzero(later.ok & (np.abs(later.end) <= FARTHEST).all(axis=1))
    going_on = cells.at(chosen, initial=later.end[chosen])
    return chosen, going_on, settled_periods(later.section[chosen]), later.section[chosen]


def _judge_newmark(cells: Cells, periods: np.ndarray, sections: np.ndarray, run, how) -> dict[str, np.ndarray]:
    """Judge cells by their limit without a time step, and by what smaller steps leave of the section's band."""
    limit, spreads = _limit(replace(cells, method=cells.method.limit, steps=None), run, how)
    skipping = {"every_step": False} if cells.method.has_step else {}
    method = replace(cells.method, **skipping)

    def finer(places: np.ndarray, factor: int) -> tuple[np.ndarray, np.ndarray]:
        some = cells.at(places, method=method, steps=factor * cells.steps_each()[places])
        runs = run_cells(some, transient=FINER_TRANSIENT, sample=SETTLED_PERIODS, **how)
        return runs.section, runs.ok

    limits = Limits(limit["kind"], limit["kind_period"], spreads)
    factors = FINER_LOCATED if cells.method.located else FINER
    judged = judge_bands(sections, periods, limits, cells.steps_each(), finer, factors)
    found = limit | {"kind": judged.kinds, "kind_period": judged.periods}
    repeats = np.isin(judged.kinds, (CellKind.PERIODIC, CellKind.ARTEFACT))
    found |= {name: np.where(repeats, np.nan, limit[name]) for name in ("lyapunov", "lyapunov_error")}
    settling = np.flatnonzero(judged.is_band & (limit["kind"] == CellKind.PERIODIC))
    settling = settling[can_narrow(sections[settling])]
    if len(settling):
        _judge_later(cells, settling, judged.widths[settling], judged.about[settling], found, run, how)
    return found


def _judge_later(cells: Cells, settling: np.ndarray, widths, periods, found: dict, run: dict, how: dict) -> None:
    """Let cells with a band beside a periodic limit go on with the same step; judge again what was a transient."""
    some = cells.at(settling)
    later = run_cells(some, transient=FINER_TRANSIENT, sample=SETTLED_PERIODS, **how)
    chosen = np.flatnonzero(later.ok & (band_widths(later.section, periods) < SHRUNK * widths))
    if len(chosen):
        going_on = some.at(chosen, initial=later.end[chosen])
        judged = _judge_newmark(going_on, settled_periods(later.section[chosen]), later.section[chosen], run, how)
        for name, array in judged.items():
            found[name][settling[chosen]] = array


def _limit(cells: Cells, run: dict, how: dict) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Kinds of the motions without a time step that begin where the cells of Newmark's method ended, and their spreads.

    Their samples are long enough to tell a slow transient that alternates from a cycle. A spread is that of the points
    of a cycle (:func:`..motions.section.cycle_spreads`); 0 for other motions.
    """
    runs = run_cells(cells, transient=run["transient"], sample=SETTLED_PERIODS, recurrence=SETTLES, **how)
    start = np.where(runs.ok[:, None], runs.end, np.nan)
    found, later = _follow(cells, settled_periods(runs.section), start, how)
    cycles = runs.section
    for i, section in later.items():
        cycles[i] = section
    return found, np.where(found["kind_period"] > 0, cycle_spreads(cycles, np.maximum(found["kind_period"], 1)), 0.0)


def _follow(
    cells: Cells, period: np.ndarray, start: np.ndarray, how: dict
) -> tuple[dict[str, np.ndarray], dict[int, np.ndarray]]:
    """Kinds of motions in closed form: of those without a period, by their largest Lyapunov exponent.

    Parameters
    ----------
    cells : Cells
    period : (m,) ndarray
        0 if the motion does not repeat itself, as far as is known.
    start : (m, 4) ndarray
        Where each of them goes on; nan where it cannot.

    Returns
    -------
    found : dict of str to (m,) ndarray
    sections : dict of int to (n, 4) ndarray
        The last points of those that were followed, by their place.
    """
    found = unknown_kinds(len(cells))
    found["kind"][:] = np.where(period > 0, CellKind.PERIODIC, CellKind.UNDECIDED)
    found["kind_period"][:] = period
    state, sections = _go_on(cells, period, start, found, how)
    places = _without_period(found["kind_period"], state)

    def judge(i: int, followed: Lyapunov) -> None:
        if len(followed.section) < periods:  # no derivative: an impact grazes
            state[i] = np.nan
            return
        found["lyapunov"][i], found["lyapunov_error"][i] = followed.exponent, followed.error
        sections[i], state[i] = followed.section[-SETTLED_PERIODS:], followed.section[-1]
        settled = settled_period(sections[i])
        kind = CellKind.PERIODIC if settled else CellKind[classify(followed)[0].name]
        found["kind"][i], found["kind_period"][i] = kind, settled

    for periods in FOLLOWED:
        follow_cells(cells, places, state[places], periods, judge, **how)
        places = places[(found["kind"][places] == CellKind.UNDECIDED) & np.isfinite(state[places]).all(axis=1)]
    return found, sections


def _go_on(cells: Cells, period: np.ndarray, start: np.ndarray, found: dict, how: dict) -> tuple[np.ndarray, dict]:
    """Let motions without a period go on as long as a single one is followed; write to ``found`` which have settled.

    A chaotic transient may last thousands of periods.

    Returns
    -------
    state : (m, 4) ndarray
        Where each cell goes on from.
    sections : dict of int to (SETTLED_PERIODS, 4) ndarray
        The last points of the cells that went on, by their place.
    """
    state, sections = start.copy(), {}
    places = _without_period(period, start)
    transient = schedule_of(cells.method).followed[0]
    later = run_cells(
        cells.at(places, initial=start[places]), transient=transient, sample=SETTLED_PERIODS, recurrence=SETTLES, **how
    )
    periods = settled_periods(later.section)
    for k in np.flatnonzero(later.ok).tolist():
        i = places[k]
        sections[i], state[i] = later.section[k], later.end[k]
        if periods[k]:
            found["kind"][i], found["kind_period"][i] = CellKind.PERIODIC, periods[k]
    return state, sections


def _without_period(period: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The places of cells without a period that can go on from their state."""
    return np.flatnonzero((period == 0) & (np.abs(state) <= FARTHEST).all(axis=1))
