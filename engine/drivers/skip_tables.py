"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps."""

import math

import numpy as np

from ..kernels.accelerated.matrix_skip import FREE, LEVELS, MODES, PRESSED, PULLED, SkipTables
from ..kernels.accelerated.step_map import ENTRIES, REACHES
from ..kernels.compile.options import uncompiled
from ..kernels.equations.contact_law import CUT
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.parameters import Parameters
from ..kernels.time_stepping.linear_step import COLUMNS, FORCE, GAP, STATE_ROWS, LinearScheme

LONGEST = ENTRIES  # stride: every step is then one entry of each level away
SAME = 1e-12  # rows that differ by less, as a share of their size, are watched once

_UNIT = np.eye(COLUMNS)


def skip_tables(m: LinearScheme, p: Parameters) -> SkipTables:
    """The tables of all modes, with the steps of size Δτ of a scheme."""
    first = m.maps[0]
    watched = [_watched_rows(first, m, mode) for mode in range(MODES)]
    most = max(len(rows) for rows in watched)
    tables = SkipTables(
        rows=np.zeros((MODES, most, LEVELS, COLUMNS, ENTRIES)),
        firsts=np.zeros((MODES, most, LEVELS, COLUMNS)),
        bounds=np.zeros((MODES, most, COLUMNS)),
        sizes=np.zeros((MODES, most)),
        counts=np.array([len(rows) for rows in watched]),
        strides=np.zeros(MODES, dtype=np.int64),
        columns=np.zeros((MODES, LEVELS, ENTRIES, COLUMNS, COLUMNS)),
        impulses=np.zeros((LEVELS, ENTRIES, COLUMNS)),
        period=2 * math.pi / p.eta,
    )
    rates = uncompiled(free_rate)(p), uncompiled(pressed_rate)(p), uncompiled(free_rate)(p)
    reaches = REACHES[FREE], REACHES[PRESSED], REACHES[FREE]
    for mode in range(MODES):
        if watched[mode]:
            stride = min(int(reaches[mode] / (rates[mode] * m.system.h)), LONGEST)
            _fill_mode(tables, m, mode, np.array(watched[mode]), stride if stride > 1 else 0)
    return tables


def _stages(maps: np.ndarray, status: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The ends of each stage without and with contact, if all stages before have this status."""
    pairs = [(maps[0], maps[1])]
    if len(maps) > 2:
        pairs.append((maps[2 + 2 * status], maps[3 + 2 * status]))
    return pairs


def _watched_rows(maps: np.ndarray, m: LinearScheme, mode: int) -> list[np.ndarray]:
    """Rows, to be multiplied by x before the step, that are positive while the mode stays; none without such a mode."""
    status, cut = int(mode == PRESSED), m.system.law == CUT
    if mode == PULLED and not cut:
        return []
    pairs, side = _stages(maps, status), 1.0 if mode == FREE else -1.0
    end = pairs[-1][status]
    rows = [side * (end[1] - end[0] - m.system.touch * _UNIT[-1])]
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


def _step_matrix(m: LinearScheme, status: int) -> np.ndarray:
    """Φ of x."""
    matrix = np.eye(COLUMNS)
    matrix[:STATE_ROWS] = _stages(m.maps[0], status)[-1][status][:STATE_ROWS]
    matrix[FORCE] *= status
    c, s = math.cos(m.turn), math.sin(m.turn)
    matrix[-3:-1, -3:-1] = [[c, -s], [s, c]]
    return matrix


def _powers(matrix: np.ndarray) -> np.ndarray:
    """Its first ENTRIES powers, each a product of two earlier ones."""
    powers = matrix[None]
    while len(powers) < ENTRIES:
        powers = np.concatenate([powers, powers[-1] @ powers])
    return powers[:ENTRIES]


def _fill_mode(tables: SkipTables, m: LinearScheme, mode: int, watched: np.ndarray, stride: int) -> None:
    x_of_u, u_of_x = _relative_basis(m.system.touch)
    # a gap may be a small difference of rows; a force is as large as its displacements make it
    tables.sizes[mode, : len(watched)] = np.maximum(1.0, np.abs(watched[:, :2]).max(axis=1))
    step, rows = u_of_x @ _step_matrix(m, int(mode == PRESSED)) @ x_of_u, watched @ x_of_u
    with np.errstate(all="ignore"):  # of a method that is not stable: a number beyond bounds skips nothing
        single = _powers(step)
        levels = [single]
        if stride:
            levels.append(_powers(single[stride - 1]))
            change = step - np.eye(COLUMNS)
            curvatures = rows @ change @ change
            supremum = _supremum(curvatures, single[: stride - 1], levels[1])
            tables.bounds[mode, : len(rows)] = supremum * (stride**2 / 8)
        tables.strides[mode] = stride
        for level, powers in enumerate(levels):
            tables.columns[mode, level] = powers.transpose(0, 2, 1)
            first = rows if level == 0 else rows @ single[stride - 2]
            tables.firsts[mode, : len(rows), level] = first
            after = np.concatenate([first[None], first @ powers[:-1]])
            tables.rows[mode, : len(rows), level] = after.transpose(1, 2, 0)
        if mode == PRESSED:
            _fill_impulses(tables, m, levels, x_of_u, stride)


def _supremum(rows: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Largest |element| of the rows, of their products with the matrices of ``inner``, and of all with ``outer``."""
    begun = np.concatenate([rows[None], rows @ inner])  # (stride, R, COLUMNS)
    largest = np.abs(begun).max(axis=0)
    for matrix in outer[:-1]:
        np.maximum(largest, np.abs(begun @ matrix).max(axis=0), out=largest)
    return largest


def _fill_impulses(
    tables: SkipTables, m: LinearScheme, levels: list[np.ndarray], x_of_u: np.ndarray, stride: int
) -> None:
    stages = [pair[1] for pair in _stages(m.maps[0], 1)]
    row = m.system.h * sum(weight * end[FORCE] for weight, end in zip(m.weights, stages, strict=False)) @ x_of_u
    for level, powers in enumerate(levels):
        first = row if level == 0 else tables.impulses[0, stride - 1]
        tables.impulses[level] = np.cumsum(np.concatenate([first[None], first @ powers[:-1]]), axis=0)
