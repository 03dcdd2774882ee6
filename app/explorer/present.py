"""From a `Frame` to the columns the figures show. Pure arrays: no panel, no bokeh.

Everything is float32 and thinned to what a pixel can show, because over a slow
line the bytes of an update decide how fast the page follows. Nothing that
matters is thinned away: the force keeps the minimum and maximum of every bin,
the phase plots keep both velocities of every impact.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from vibroscope.app.explorer.compute import Frame, Run
from vibroscope.app.explorer.state import Setting

Columns = dict[str, np.ndarray]

WINDOW = 2  # periods in the time figures
TIME_POINTS = 401
_FORCE_BINS = 400
_POINTS_PER_PERIOD = 240
_MOST_POINTS = 720
_POINTS_IN_CONTACT = 8
_MOST_IN_CONTACTS = 480
_MOST_SECTION = 50

_NAMED = {"t": "time", "left": "time", "right": "time", "force": "force", "impulse": "impulse", "eta": None}

_EMPTY = np.empty(0, np.float32)


def present(frame: Frame) -> dict[str, Columns]:
    """Columns by source name, for every live source of the page, in the units of the frame's setting."""
    columns = {
        "displacements": _displacement(frame),
        "phase_reference": _phase(frame.reference, corners=True),
        "phase_penalty": _phase(frame.penalty, corners=False),
        "section_reference": _section(frame.reference),
        "section_penalty": _section(frame.penalty),
        "strip_reference": _strip(frame.reference),
        "strip_penalty": _strip(frame.penalty),
        "force_reference": _force(frame.reference),
        "force_penalty": _force(frame.penalty),
        "impulse_reference": _impulses(frame.reference),
        "impulse_penalty": _impulses(frame.penalty),
    }
    return {name: in_units(source, frame.setting) for name, source in columns.items()}


def in_units(columns: Columns, setting: Setting) -> Columns:
    """Non-dimensional columns (times in periods) as the setting shows them: the same, or in s, mm, mm/s, N, N·s."""
    if setting.scale is None:
        return columns
    return {name: (factor_of(name, setting) * column).astype(np.float32) for name, column in columns.items()}


def factor_of(column: str, setting: Setting) -> float:
    """What one unit of a column is, in the units that are shown."""
    quantity = quantity_of(column)
    if setting.scale is None or quantity is None:
        return 1.0
    return setting.period if quantity == "time" else setting.scale.factor(quantity)


def quantity_of(column: str) -> str | None:
    """The physical quantity in a column of any source, as `engine.QUANTITIES` names it; None: it has no unit."""
    if column in _NAMED:
        return _NAMED[column]
    return "velocity" if column.startswith("v") or "_v" in column else "displacement"


def size_of(columns: Mapping[str, Columns]) -> int:
    """Bytes of all columns: what one update sends, apart from its envelope."""
    return sum(column.nbytes for source in columns.values() for column in source.values())


def _displacement(frame: Frame) -> Columns:
    grid = np.linspace(0.0, WINDOW, TIME_POINTS)
    # τ ≡ 0 mod T at the start of the window, so the base is at cos 2πτ/T.
    base = np.cos(2 * np.pi * grid) if frame.setting.frame == "absolute" else 0.0
    columns = {"t": grid}
    for name, run in (("reference", frame.reference), ("penalty", frame.penalty)):
        for row in (0, 1):
            columns[f"{name}{row + 1}"] = _on(grid, run, "displacement", row) + base
            # Not drawn over time: they place the marks of the present phase in the phase plots.
            columns[f"{name}_v{row + 1}"] = _on(grid, run, "velocity", row)
    return _narrow(columns)


def _on(grid: np.ndarray, run: Run, what: str, row: int) -> np.ndarray:
    if run.trace is None:
        return np.full_like(grid, np.nan)
    return np.interp(grid, _window_time(run), getattr(run.trace, what)[row])


def _window_time(run: Run) -> np.ndarray:
    """Trace time in periods since the start of the last two."""
    return (run.trace.time - _window_start(run)) * run.response.eta / (2 * np.pi)


def _window_start(run: Run) -> float:
    """τ where the last two periods begin."""
    period = 2 * np.pi / run.response.eta
    return (run.response.checkpoint.periods + run.response.keep - WINDOW) * period


def _phase(run: Run, *, corners: bool) -> Columns:
    """Orbit of both pendulums, with both velocities of each of the reference's impacts."""
    if run.orbit is None:
        return dict.fromkeys(("x1", "v1", "x2", "v2"), _EMPTY)
    chosen = _orbit_indices(run)
    time = run.orbit.time[chosen]
    states = np.vstack([run.orbit.displacement[:, chosen], run.orbit.velocity[:, chosen]])
    if corners:
        time, states = _with_corners(run, time, states)
    x1, x2, v1, v2 = states
    return _narrow({"x1": x1, "v1": v1, "x2": x2, "v2": v2})


def _orbit_indices(run: Run) -> np.ndarray:
    """Evenly spread samples, more of them inside contacts, where the penalty force turns the orbit."""
    time = run.orbit.time
    periods = (time[-1] - time[0]) * run.response.eta / (2 * np.pi)
    count = min(_MOST_POINTS, max(2, round(periods * _POINTS_PER_PERIOD)))
    even = np.linspace(0, len(time) - 1, min(count, len(time)))
    begin, end = np.searchsorted(time, run.response.contacts.T.reshape(2, -1))
    inside = (end > 0) & (begin < len(time) - 1) & (end - begin < len(time) / count * _POINTS_IN_CONTACT)
    extra = np.linspace(begin[inside] - 1, end[inside], _POINTS_IN_CONTACT)
    # Irregular motion over many periods has too many contacts to refine them all.
    extra = extra.ravel() if extra.size <= _MOST_IN_CONTACTS else _EMPTY
    return _each_once(np.clip(np.concatenate([even, extra]), 0, len(time) - 1).astype(np.intp), len(time))


def _with_corners(run: Run, time: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    impacts = run.response.impacts
    within = (impacts.time > time[0]) & (impacts.time < time[-1])
    where = np.repeat(np.searchsorted(time, impacts.time[within]), 2)
    position = np.repeat(impacts.position[within], 2)
    velocity = np.stack([impacts.velocity_before[within], impacts.velocity_after[within]], 1).reshape(-1, 2)
    added = np.vstack([position, position, velocity.T])
    return (
        np.insert(time, where, np.repeat(impacts.time[within], 2)),
        np.insert(states, where, added, axis=1),
    )


def _section(run: Run) -> Columns:
    """Poincaré section of the kept periods, with η for the bifurcation diagram."""
    rows = run.response.section[-_MOST_SECTION:]
    x1, v1, x2, v2 = rows.T.reshape(4, -1)
    eta = np.full(len(rows), run.response.eta)
    return _narrow({"eta": eta, "x1": x1, "v1": v1, "x2": x2, "v2": v2})


def _strip(run: Run) -> Columns:
    """Intervals in contact within the window, in periods; the reference's impacts have no length."""
    if not run.response.ok:
        return {"left": _EMPTY, "right": _EMPTY}
    scale = run.response.eta / (2 * np.pi)
    spans = (run.response.contacts.reshape(-1, 2) - _window_start(run)) * scale
    if run.response.method.name == "reference":
        hits = (run.response.impacts.time - _window_start(run)) * scale
        spans = np.vstack([spans, np.column_stack([hits, hits])])
    spans = spans[(spans[:, 1] >= 0) & (spans[:, 0] <= WINDOW)].clip(0, WINDOW)
    return _narrow({"left": spans[:, 0], "right": spans[:, 1]})


def _force(run: Run) -> Columns:
    if run.trace is None:
        return {"t": _EMPTY, "force": _EMPTY}
    time, force = envelope(_window_time(run), run.trace.force, _FORCE_BINS * WINDOW // 2)
    return _narrow({"t": time, "force": force})


def envelope(x: np.ndarray, y: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """The minimum and the maximum of each bin, in their order, and nothing of what lies flat between.

    First, last, smallest and largest samples are always among the points kept.
    """
    if len(x) <= 2 * bins:
        return x, y
    starts = np.linspace(0, len(x), bins, endpoint=False).astype(np.intp)
    low, high = (_arg_in_bins(sign * y, starts) for sign in (1, -1))
    # Where the force sets in or ends, so that its flanks stand upright.
    flank = np.flatnonzero((y[1:] != 0) != (y[:-1] != 0))
    index = _each_once(np.concatenate([[0, len(x) - 1], low, high, flank, flank + 1]), len(x))
    kept = y[index]
    bend = np.ones(len(index), bool)
    bend[1:-1] = (kept[1:-1] != kept[:-2]) | (kept[1:-1] != kept[2:])
    return x[index[bend]], kept[bend]


def _each_once(index: np.ndarray, size: int) -> np.ndarray:
    """In ascending order; far below the cost of sorting."""
    chosen = np.zeros(size, bool)
    chosen[index] = True
    return np.flatnonzero(chosen)


def _arg_in_bins(y: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Index of the first smallest value of each bin."""
    smallest = np.minimum.reduceat(y, starts)
    sizes = np.diff(np.append(starts, len(y)))
    hits = np.flatnonzero(y == np.repeat(smallest, sizes))
    return hits[np.searchsorted(hits, starts)]


def _impulses(run: Run) -> Columns:
    """Impulse of each impact in the window (penalty: of each contact)."""
    if not run.response.ok:
        return {"t": _EMPTY, "impulse": _EMPTY}
    impacts = run.response.impacts
    time = (impacts.time - _window_start(run)) * run.response.eta / (2 * np.pi)
    within = (time >= 0) & (time <= WINDOW)
    return _narrow({"t": time[within], "impulse": impacts.impulse[within]})


def _narrow(columns: Mapping[str, np.ndarray]) -> Columns:
    return {name: np.asarray(column, np.float32) for name, column in columns.items()}
