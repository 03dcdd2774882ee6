"""Kinds of motion of the cells of a sweep: periodic, quasi-periodic, chaotic, or scattered by the step.

The sweep itself only shows which sections repeat themselves. The cells that do not are judged as a single motion is
(:mod:`engine.motions.judge`). No module of a study imports this one, so that it does not enter the digest of numerical
code.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.cells import Cells, run_cells
from vibroscope.engine.motions.description import CellKind, Kind
from vibroscope.engine.motions.judge import judge, late_runs, unknown_kinds
from vibroscope.engine.motions.section import scatter, settled_periods
from vibroscope.engine.motions.words import of_section, repetition_of
from vibroscope.engine.sweeps.batches import adaptive_batches
from vibroscope.engine.sweeps.codes import MISSING
from vibroscope.engine.sweeps.eta_study import EtaStudy
from vibroscope.engine.sweeps.plane_study import PlaneStudy


def known_kinds(status: np.ndarray, period: np.ndarray) -> dict[str, np.ndarray]:
    """The kinds of motion that the values of a study show without any further run, (n,) each.

    These are the cells that ended early, and those of period 1: a longer one may be scatter that happens to repeat
    itself, or a transient that alternates.
    """
    found = unknown_kinds(len(status))
    clear = (status == 0) & (period == 1)
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
        `CellKind.UNKNOWN`: the section alone speaks, and the words say that the kind is not judged.
    period : int
        ``kind_period``, or the section's where the kind is not known.
    near_period : int, optional
        Of the section. It counts where that is all that is known, or no kind was decided.
    section : (sample, 4) ndarray, optional
        It shows how much the displacement of ``body`` scatters.
    body : int
        See :attr:`engine.System.observed_body`.
    """
    if kind == CellKind.ENDED_EARLY:
        return "ended early"
    is_open = kind in (CellKind.UNKNOWN, CellKind.UNDECIDED)
    near = near_period if is_open and near_period is not None else period
    amount = scatter(section, near, body) if section is not None and near else np.nan
    words = repetition_of(Kind[CellKind(kind).name], period, near, amount, kind == CellKind.ARTEFACT, body)
    if kind == CellKind.UNKNOWN:
        return of_section(words, period, has_step=True)
    return words + ", kind not decided" if kind == CellKind.UNDECIDED else words


def judge_cells(
    study: EtaStudy | PlaneStudy,
    values: dict[str, np.ndarray],
    chosen: np.ndarray,
    *,
    threads: int | None = None,
    cancelled: Poll | None = None,
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
    cells = replace(cells, initial=study.starts_of(chosen, values["end"].reshape(-1, 4)))
    run, how = {"transient": study.transient, "sample": study.sample}, {"threads": threads, "cancelled": cancelled}
    return _judge_late(cells, run, how)


def grow_kinds(
    study: EtaStudy | PlaneStudy,
    values: dict[str, np.ndarray],
    places: np.ndarray,
    known: dict[str, np.ndarray] | None = None,
    number: Callable[[np.ndarray], np.ndarray] = np.asarray,
    **how,
) -> Iterator[dict[str, np.ndarray]]:
    """Judge the motions of some cells batch by batch; after each come the kinds of all cells, as far as they are known.

    Parameters
    ----------
    study, values, **how
        As of :func:`judge_cells`.
    places : (m,) ndarray of int
        The cells to judge, by their places in the kinds.
    known : dict, optional
        Kinds of an earlier call, from which to go on.
    number : callable
        ``number(places)`` gives the indices of these cells in the flattened grid, by default the same.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    kinds = known or unknown_kinds(study.cells)
    for some in adaptive_batches(places):
        kinds = {name: array.copy() for name, array in kinds.items()}
        for name, array in judge_cells(study, values, number(some), **how).items():
            kinds[name][some] = array
        yield kinds


def judge_runs(
    cells: Cells, *, transient: int, sample: int, threads: int | None = None, cancelled: Poll | None = None
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
    run, how = {"transient": transient, "sample": sample}, {"threads": threads, "cancelled": cancelled}
    found = run_cells(cells, **run, **how)
    periods = settled_periods(found.section)
    kinds = known_kinds(found.status, periods)
    chosen = np.flatnonzero(kinds["kind"] == CellKind.UNKNOWN)
    for name, array in _judge_late(cells.at(chosen), run, how).items():
        kinds[name][chosen] = array
    return kinds


def _judge_late(cells: Cells, run: dict[str, int], how: dict) -> dict[str, np.ndarray]:
    """Judge cells by runs from their starts, as late as a single motion is judged, or as their own runs end."""
    found, late = unknown_kinds(len(cells)), late_runs(cells, run["transient"] + run["sample"], **how)
    found["kind"][:] = CellKind.ENDED_EARLY
    chosen = np.flatnonzero(late.ok)
    for name, array in judge(cells.at(chosen), late.section[chosen], **how).items():
        found[name][chosen] = array
    return found
