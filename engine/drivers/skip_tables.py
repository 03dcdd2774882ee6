"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps."""

import math

import numpy as np

from ..integrators import Integrator
from ..kernels.accelerated.located_skip import PIECES, WHOLE
from ..kernels.accelerated.matrix_skip import FREE, LEVELS, MODES, PRESSED, PULLED, SkipTables
from ..kernels.accelerated.step_map import ENTRIES, REACHES
from ..kernels.compile.options import uncompiled
from ..kernels.equations.contact_law import CUT
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.parameters import Parameters
from ..kernels.time_stepping.contact_location import LocatedScheme
from ..kernels.time_stepping.linear_step import COLUMNS, FORCE, GAP, STATE_ROWS, LinearScheme
from .step_maps import bodies_of, step_maps

MOST_PIECES = 256  # of a step, so that tables are made in no time
LONGEST = ENTRIES  # stride: every step is then one entry of each level away
SAME = 1e-12  # rows that differ by less, as a share of their size, are watched once


def skip_tables(m: LinearScheme, p: Parameters) -> SkipTables:
    """The tables of all modes, with the steps of size Δτ of a scheme."""
    maps, touch = _maps_of_statuses(m), m.system.touch
    watched = [_watched_rows(maps, m, mode) for mode in range(MODES)]
    tables = _empty_tables(watched, p)
    for mode in range(MODES):
        if watched[mode]:
            rows, status = np.array(watched[mode]), int(mode == PRESSED)
            # a gap may be a small difference of rows; a force is as large as its displacements make it
            tables.sizes[mode, : len(rows)] = np.maximum(1.0, np.abs(rows[:, :2]).max(axis=1))
            x_of_u, _ = _relative_basis(touch)
            levels = _fill_mode(tables, mode, status, _step_matrix(maps, status, m.turn, touch), rows @ x_of_u, p)
            if status:
                forces = [pair[1][FORCE] for pair in _stages(maps, 1)]
                row = m.system.h * sum(weight * force for weight, force in zip(m.weights, forces, strict=False))
                _fill_impulses(tables, mode, row @ x_of_u, levels)
    return tables


def located_tables(m: LocatedScheme, p: Parameters, integrator: Integrator, pieces: int) -> SkipTables:
    """The tables of located steps of size Δτ, and of the ``pieces`` of a step in which a contact begins."""
    bodies, unit = bodies_of(p), np.eye(COLUMNS)
    whole = step_maps(bodies, integrator, m.h)
    law = -m.stiffness * unit[1] - 2.0 * m.damper * unit[3]
    cuts = {FREE: 1, PIECES: pieces if 1 < pieces <= MOST_PIECES else 0, WHOLE: 1}
    tables = _empty_tables([[None] * (cuts[mode] > 0) for mode in range(MODES)], p)
    for mode, parts in cuts.items():
        if parts == 0:
            continue
        side, status, h = (1.0, 0, m.h) if mode == FREE else (-1.0, 1, m.h / parts)
        maps = whole if parts == 1 else step_maps(bodies, integrator, h)
        piece = _step_matrix(maps, status, p.eta * h, -p.free_gap)
        within = [unit]
        for _ in range(parts):
            within.append(within[-1] @ piece)
        within = np.array(within)
        tables.sizes[mode] = 1.0
        levels = _fill_mode(tables, mode, status, within[-1], side * unit[1:2] @ within[-1], p)
        accelerations = unit[5] @ within[:-1]  # g″ at the beginning of each piece of the first step
        with np.errstate(all="ignore"):
            supremum = _supremum(accelerations, levels[0][: max(tables.strides[mode] - 1, 0)], levels[-1])
        tables.dips[mode] = supremum.max(axis=0) * (m.h**2 / 2)
        _fill_impulses(tables, mode, 0.5 * h * law @ (within[:-1] + within[1:]).sum(axis=0), levels)
    return tables


def _empty_tables(watched: list[list], p: Parameters) -> SkipTables:
    most = max(len(rows) for rows in watched)
    return SkipTables(
        rows=np.zeros((MODES, most, LEVELS, COLUMNS, ENTRIES)),
        firsts=np.zeros((MODES, most, LEVELS, COLUMNS)),
        bounds=np.zeros((MODES, most, COLUMNS)),
        sizes=np.zeros((MODES, most)),
        counts=np.array([len(rows) for rows in watched]),
        strides=np.zeros(MODES, dtype=np.int64),
        columns=np.zeros((MODES, LEVELS, ENTRIES, COLUMNS, COLUMNS)),
        impulses=np.zeros((MODES, LEVELS, ENTRIES, COLUMNS)),
        dips=np.zeros((MODES, COLUMNS)),
        period=2 * math.pi / p.eta,
    )


def _maps_of_statuses(m: LinearScheme) -> np.ndarray:
    """The matrices of a step with each status (:func:`.step_maps.step_maps`); those of other laws without contact."""
    maps = m.maps[0]
    if m.system.law <= CUT:
        return maps
    flight = maps[:, : STATE_ROWS + 1, :COLUMNS]
    return flight[[0, 0, 1, 1, 1, 1] if len(flight) > 1 else [0, 0]]


def _stages(maps: np.ndarray, status: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The ends of each stage without and with contact, if all stages before have this status."""
    pairs = [(maps[0], maps[1])]
    if len(maps) > 2:
        pairs.append((maps[2 + 2 * status], maps[3 + 2 * status]))
    return pairs


def _watched_rows(maps: np.ndarray, m: LinearScheme, mode: int) -> list[np.ndarray]:
    """Rows, to be multiplied by x before the step, that are positive while the mode stays; none without such a mode."""
    status, cut = int(mode == PRESSED), m.system.law == CUT
    if (mode == PULLED and not cut) or (mode == PRESSED and m.system.law > CUT):
        return []
    pairs, side = _stages(maps, status), 1.0 if mode == FREE else -1.0
    end = pairs[-1][status]
    rows = [side * (end[1] - end[0] - m.system.touch * np.eye(COLUMNS)[-1])]
    for i, pair in enumerate(pairs):
        if m.at_end:  # either status wants that of the mode
            if mode != PULLED:
                rows += [side * end[GAP] for end in pair]
            if mode != FREE and cut:
                rows += [-side * end[FORCE] if mode == PRESSED else side * end[FORCE] for end in pair]
            continue
        if i + 1 < len(pairs):  # the status from the start of the next stage
            rows.append(side * pair[status][GAP])
        if mode != FREE and cut:
            rows.append(pair[1][FORCE] if mode == PRESSED else -pair[1][FORCE])
    return _distinct(rows)


def _distinct(rows: list[np.ndarray]) -> list[np.ndarray]:
    found = []
    for row in rows:
        if not any(np.abs(row - other).max() <= SAME * np.abs(row).max() for other in found):
            found.append(row)
    return found


def _relative_basis(touch: float) -> tuple[np.ndarray, np.ndarray]:
    """The matrices that make x of u, and u of x."""
    x_of_u = np.eye(COLUMNS)
    x_of_u[[1, 3, 5], [0, 2, 4]] = 1.0
    x_of_u[1, -1] = touch
    u_of_x = np.eye(COLUMNS)
    u_of_x[[1, 3, 5], [0, 2, 4]] = -1.0
    u_of_x[1, -1] = -touch
    return x_of_u, u_of_x


def _step_matrix(maps: np.ndarray, status: int, turn: float, touch: float) -> np.ndarray:
    """Φ of a step over which the phase of the excitation grows by ``turn``."""
    matrix, (x_of_u, u_of_x) = np.eye(COLUMNS), _relative_basis(touch)
    matrix[:STATE_ROWS] = _stages(maps, status)[-1][status][:STATE_ROWS]
    matrix[FORCE] *= status
    c, s = math.cos(turn), math.sin(turn)
    matrix[-3:-1, -3:-1] = [[c, -s], [s, c]]
    return u_of_x @ matrix @ x_of_u


def _powers(matrix: np.ndarray) -> np.ndarray:
    """Its first ENTRIES powers, each a product of two earlier ones."""
    powers = matrix[None]
    while len(powers) < ENTRIES:
        powers = np.concatenate([powers, powers[-1] @ powers])
    return powers[:ENTRIES]


def _fill_mode(
    tables: SkipTables, mode: int, status: int, step: np.ndarray, rows: np.ndarray, p: Parameters
) -> list[np.ndarray]:
    """Write the watched rows of a mode and the powers of its step, of each level, and return the powers."""
    rate, reach = (pressed_rate, REACHES[PRESSED]) if status else (free_rate, REACHES[FREE])
    stride = min(int(reach / (uncompiled(rate)(p) * 2 * math.pi / p.eta / p.steps)), LONGEST)
    with np.errstate(all="ignore"):  # of a method that is not stable: a number beyond bounds skips nothing
        levels = [_powers(step)]
        if stride > 1:
            tables.strides[mode] = stride
            levels.append(_powers(levels[0][stride - 1]))
            change = step - np.eye(COLUMNS)
            supremum = _supremum(rows @ change @ change, levels[0][: stride - 1], levels[1][:-1])
            tables.bounds[mode, : len(rows)] = supremum * (stride**2 / 8)
        for level, powers in enumerate(levels):
            tables.columns[mode, level] = powers.transpose(0, 2, 1)
            first = rows if level == 0 else rows @ levels[0][stride - 2]
            tables.firsts[mode, : len(rows), level] = first
            after = np.concatenate([first[None], first @ powers[:-1]])
            tables.rows[mode, : len(rows), level] = after.transpose(1, 2, 0)
    return levels


def _supremum(rows: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Largest |element| of the rows and of their products with matrices of ``inner``, of ``outer`` and of both."""
    begun = np.concatenate([rows[None], rows @ inner])
    largest = np.abs(begun).max(axis=0)
    side_by_side = outer.transpose(1, 0, 2).reshape(COLUMNS, -1)  # one product of matrices instead of many
    for r in range(largest.shape[0]):
        for i in range(0, len(begun), ENTRIES):
            images = np.abs(begun[i : i + ENTRIES, r] @ side_by_side).max(axis=0).reshape(-1, COLUMNS)
            np.maximum(largest[r], images.max(axis=0), out=largest[r])
    return largest


def _fill_impulses(tables: SkipTables, mode: int, row: np.ndarray, levels: list[np.ndarray]) -> None:
    """Write the impulses of a mode; ``row``: that of its first step."""
    with np.errstate(all="ignore"):
        for level, powers in enumerate(levels):
            first = row if level == 0 else tables.impulses[mode, 0, tables.strides[mode] - 1]
            tables.impulses[mode, level] = np.cumsum(np.concatenate([first[None], first @ powers[:-1]]), axis=0)
