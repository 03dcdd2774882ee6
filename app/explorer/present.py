"""From both runs to the columns of the figures. Pure arrays: no panel, no bokeh.

The size of an update decides how fast the page follows over a slow connection, so columns are float32 and hold no more
than a pixel can show. Two things are always kept: the minimum and the maximum of the force in every bin, and both
velocities of every impact in the phase plots.
"""

from collections.abc import Mapping

import numpy as np
from vibroscope.app.explorer.compute import RunPair, SolverRun
from vibroscope.app.explorer.state import Setting
from vibroscope.engine.motions.description import FEWEST_IN_CONTACT

Columns = dict[str, np.ndarray]

_TIME_POINTS = 200  # in a period of the displacements …
_MOST_TIME_POINTS = 2000  # … and in all
_FORCE_BINS = 200  # the same of the force
_MOST_FORCE_BINS = 2000
_POINTS_PER_PERIOD = 240
_MOST_POINTS = 720  # of an orbit
_POINTS_PER_CONTACT = 8
_MOST_CONTACT_POINTS = 480
_MOST_SECTION_POINTS = 50

_QUANTITIES = {"t": "time", "left": "time", "right": "time", "force": "force", "impulse": "impulse", "eta": None}

_EMPTY = np.empty(0, np.float32)


def present(runs: RunPair) -> dict[str, Columns]:
    """Columns of every source that a move changes, by the name of the source, in the units of the setting."""
    parts = {"phase": _orbit, "section": _section, "strip": contact_intervals, "force": _force, "impulse": _impulses}
    solvers = {"reference": runs.reference, "penalty": runs.penalty}
    columns = {"displacements": _displacements(runs)}
    columns |= {f"{name}_{solver}": part(run) for name, part in parts.items() for solver, run in solvers.items()}
    if runs.setting.bodies == "wall":
        columns = {name: _without_body_2(source) for name, source in columns.items()}
    return {name: convert_units(source, runs.setting) for name, source in columns.items()}


def orbit_columns(run: SolverRun, setting: Setting) -> Columns:
    """The columns of a phase plot alone, for an orbit that is drawn beside those of a setting."""
    columns = _orbit(run)
    return convert_units(_without_body_2(columns) if setting.bodies == "wall" else columns, setting)


def _without_body_2(columns: Columns) -> Columns:
    """The columns with nothing to draw of body 2: it is a wall."""
    return {name: np.full_like(column, np.nan) if name[-1] == "2" else column for name, column in columns.items()}


def convert_units(columns: Columns, setting: Setting) -> Columns:
    """Columns without dimension (times in periods) in the units of the setting: or the same."""
    if setting.scale is None:
        return columns
    return {name: (unit_factor(name, setting) * column).astype(np.float32) for name, column in columns.items()}


def unit_factor(column: str, setting: Setting) -> float:
    """The value of one unit of a column without dimension, in the units of the setting."""
    quantity = quantity_of(column)
    if setting.scale is None or quantity is None:
        return 1.0
    return setting.period if quantity == "time" else setting.scale.factor(quantity)


def quantity_of(column: str) -> str | None:
    """The physical quantity in a column of any source, as `engine.QUANTITIES` names it; None: it has no unit."""
    if column in _QUANTITIES:
        return _QUANTITIES[column]
    return "velocity" if column.startswith("v") or "_v" in column else "displacement"


def _displacements(runs: RunPair) -> Columns:
    grid = time_grid(runs.reference.window)
    # The window starts at τ ≡ 0 (mod T), so the base moves as a cos(2πτ/T + φ).
    drive = runs.setting.system.excitation
    moved = (
        drive.base_amplitude(runs.setting.eta) * np.cos(2 * np.pi * grid + drive.base_phase)
        if runs.setting.frame == "absolute"
        else 0.0
    )
    columns = {"t": grid}
    for name, run in (("reference", runs.reference), ("penalty", runs.penalty)):
        for row in (0, 1):
            columns[f"{name}{row + 1}"] = _resample(grid, run, "displacement", row) + moved
            # Not drawn over time: they place the marks of the present instant in the phase plots.
            columns[f"{name}_v{row + 1}"] = _resample(grid, run, "velocity", row)
    return as_float32(columns)


def time_grid(window: int) -> np.ndarray:
    """The instants of the displacements, in periods since the start of the window of so many periods."""
    return np.linspace(0.0, window, min(_TIME_POINTS * window, _MOST_TIME_POINTS) + 1)


def _resample(grid: np.ndarray, run: SolverRun, what: str, row: int) -> np.ndarray:
    if run.trace is None:
        return np.full_like(grid, np.nan)
    return np.interp(grid, _window_time(run), getattr(run.trace, what)[row])


def _window_time(run: SolverRun) -> np.ndarray:
    """Time of the trace in periods since the start of the window."""
    return (run.trace.time - _window_start(run)) * run.response.eta / (2 * np.pi)


def _window_start(run: SolverRun) -> float:
    """τ at the start of the periods that are shown."""
    period = 2 * np.pi / run.response.eta
    return (run.response.checkpoint.periods + run.response.keep - run.window) * period


def _orbit(run: SolverRun) -> Columns:
    """Orbit of both bodies; of the reference also the states before and after each impact."""
    if run.orbit is None:
        return dict.fromkeys(("x1", "v1", "x2", "v2"), _EMPTY)
    chosen = _orbit_indices(run)
    time = run.orbit.time[chosen]
    states = np.vstack([run.orbit.displacement[:, chosen], run.orbit.velocity[:, chosen]])
    if run.response.method.rigid:
        time, states = _with_corners(run, time, states)
    x1, x2, v1, v2 = states
    return as_float32({"x1": x1, "v1": v1, "x2": x2, "v2": v2})


def _orbit_indices(run: SolverRun) -> np.ndarray:
    """Indices of evenly spaced samples, and of more samples in contacts, where the penalty force bends the orbit."""
    time = run.orbit.time
    periods = (time[-1] - time[0]) * run.response.eta / (2 * np.pi)
    count = min(_MOST_POINTS, max(2, round(periods * _POINTS_PER_PERIOD)))
    even = np.linspace(0, len(time) - 1, min(count, len(time)))
    begin, end = np.searchsorted(time, run.response.contacts.T.reshape(2, -1))
    inside = (end > 0) & (begin < len(time) - 1) & (end - begin < len(time) / count * _POINTS_PER_CONTACT)
    extra = np.linspace(begin[inside] - 1, end[inside], _POINTS_PER_CONTACT)
    # An irregular motion over many periods has too many contacts to refine them all.
    extra = extra.ravel() if extra.size <= _MOST_CONTACT_POINTS else _EMPTY
    return _sorted_unique(np.clip(np.concatenate([even, extra]), 0, len(time) - 1).astype(np.intp), len(time))


def _with_corners(run: SolverRun, time: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    impacts = run.response.impacts
    within = (impacts.time > time[0]) & (impacts.time < time[-1])
    where = np.repeat(np.searchsorted(time, impacts.time[within]), 2)
    places = [np.repeat(place[within], 2) for place in (impacts.position, impacts.position2(run.response.system))]
    velocity = np.stack([impacts.velocity_before[within], impacts.velocity_after[within]], 1).reshape(-1, 2)
    added = np.vstack([*places, velocity.T])
    return (
        np.insert(time, where, np.repeat(impacts.time[within], 2)),
        np.insert(states, where, added, axis=1),
    )


def _section(run: SolverRun) -> Columns:
    """Poincaré section of the kept periods, with η, which places it in the map over η."""
    rows = run.response.section[-_MOST_SECTION_POINTS:]
    x1, v1, x2, v2 = rows.T.reshape(4, -1)
    eta = np.full(len(rows), run.response.eta)
    return as_float32({"eta": eta, "x1": x1, "v1": v1, "x2": x2, "v2": v2})


def contact_intervals(run: SolverRun) -> Columns:
    """Intervals in contact within the window, in periods; an impact of the reference has length zero."""
    if not run.response.ok:
        return {"left": _EMPTY, "right": _EMPTY}
    scale = run.response.eta / (2 * np.pi)
    spans = (run.response.contacts.reshape(-1, 2) - _window_start(run)) * scale
    if run.response.method.name == "reference":
        hits = (run.response.impacts.time - _window_start(run)) * scale
        spans = np.vstack([spans, np.column_stack([hits, hits])])
    spans = spans[(spans[:, 1] >= 0) & (spans[:, 0] <= run.window)].clip(0, run.window)
    return as_float32({"left": spans[:, 0], "right": spans[:, 1]})


def _force(run: SolverRun) -> Columns:
    if run.trace is None:
        return {"t": _EMPTY, "force": _EMPTY}
    time, force = envelope(_window_time(run), run.trace.force, min(_FORCE_BINS * run.window, _MOST_FORCE_BINS))
    if run.response.method.located:
        time, force = _with_short_contacts(run, time, force)
    return as_float32({"t": time, "force": force})


def _with_short_contacts(run: SolverRun, time: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The force; of each contact with too few samples, a rectangle instead: its duration, and the mean of its force."""
    impacts, contacts = run.response.impacts, run.response.contacts.reshape(-1, 2)
    at = np.searchsorted(impacts.time, contacts[:, 0])
    for (begin, end), index in zip(contacts, at, strict=True):
        started = index < len(impacts.time) and np.isclose(impacts.time[index], begin, rtol=1e-9)
        inside = (run.trace.time > begin) & (run.trace.time < end)
        if not started or inside.sum() >= FEWEST_IN_CONTACT or begin < _window_start(run):
            continue
        edges = (np.array([begin, begin, end, end]) - _window_start(run)) * run.response.eta / (2 * np.pi)
        kept = (time < edges[0]) | (time > edges[-1])
        time, force = time[kept], force[kept]
        place = np.searchsorted(time, edges)
        mean = impacts.impulse[index] / (end - begin)
        time, force = np.insert(time, place, edges), np.insert(force, place, [0.0, mean, mean, 0.0])
    return time, force


def envelope(x: np.ndarray, y: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """The minimum and the maximum of each bin, in their order; of a constant stretch, its ends only.

    The first and the last sample are always kept.
    """
    if len(x) <= 2 * bins:
        return x, y
    starts = np.linspace(0, len(x), bins, endpoint=False).astype(np.intp)
    low, high = (_arg_in_bins(sign * y, starts) for sign in (1, -1))
    # The samples around the beginning and the end of a force, so that its flanks are drawn upright.
    flank = np.flatnonzero((y[1:] != 0) != (y[:-1] != 0))
    index = _sorted_unique(np.concatenate([[0, len(x) - 1], low, high, flank, flank + 1]), len(x))
    kept = y[index]
    changes = np.ones(len(index), bool)
    changes[1:-1] = (kept[1:-1] != kept[:-2]) | (kept[1:-1] != kept[2:])
    return x[index[changes]], kept[changes]


def _sorted_unique(index: np.ndarray, size: int) -> np.ndarray:
    """Return `numpy.unique` of indices below ``size``, without the cost of sorting."""
    chosen = np.zeros(size, bool)
    chosen[index] = True
    return np.flatnonzero(chosen)


def _arg_in_bins(y: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Index of the first smallest value of each bin."""
    smallest = np.minimum.reduceat(y, starts)
    sizes = np.diff(np.append(starts, len(y)))
    hits = np.flatnonzero(y == np.repeat(smallest, sizes))
    return hits[np.searchsorted(hits, starts)]


def _impulses(run: SolverRun) -> Columns:
    """Impulse of each impact in the window; of the penalty solution, of each contact that has ended by then."""
    if not run.response.ok:
        return {"t": _EMPTY, "impulse": _EMPTY}
    impacts = run.response.impacts
    time = (impacts.time - _window_start(run)) * run.response.eta / (2 * np.pi)
    within = (time >= 0) & (time <= run.window)
    if run.response.method.name != "reference":
        spans = run.response.contacts
        within &= ~np.isin(impacts.time, spans[spans[:, 1] >= run.response.window[1], 0])
    return as_float32({"t": time[within], "impulse": impacts.impulse[within]})


def as_float32(columns: Mapping[str, np.ndarray]) -> Columns:
    """The columns in single precision, as figures draw them."""
    return {name: np.asarray(column, np.float32) for name, column in columns.items()}
