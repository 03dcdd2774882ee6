"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps."""

import math

import numpy as np

from ..integrators import Integrator
from ..kernels.accelerated.located_skip import ASKED, CONTACT, MISSING, TABULATED, write_piece_matrix
from ..kernels.accelerated.matrix_skip import FREE, LEVELS, MODES, PRESSED, PULLED, SkipTables
from ..kernels.accelerated.step_map import ENTRIES, REACHES
from ..kernels.compile.options import uncompiled
from ..kernels.equations.contact_law import CUT
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.parameters import Parameters
from ..kernels.time_stepping.contact_location import LocatedScheme
from ..kernels.time_stepping.linear_step import COLUMNS, FORCE, GAP, STATE_ROWS, LinearScheme
from ..kernels.time_stepping.located import halvings_at
from .step_maps import bodies_of, step_maps

LONGEST = ENTRIES  # stride: every step is then one entry of each level away
BLOCK = 16  # rows of a product: so small that BLAS does not wake other threads for it, which would take longer
SAME = 1e-12  # rows that differ from a multiple of another by less, as a share of their size, are not watched


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
            step, stride = _step_matrix(maps, status, m.turn, touch), _stride(p, status == 1, m.system.h)
            levels = _fill_mode(tables, mode, step, rows @ x_of_u, stride)
            if status:
                forces = [pair[1][FORCE] for pair in _stages(maps, 1)]
                row = m.system.h * sum(weight * force for weight, force in zip(m.weights, forces, strict=False))
                _fill_impulses(tables, mode, row @ x_of_u, levels)
    return tables


class LocatedTables:
    """The tables of located steps of size Δτ and of their pieces, made as a run asks for them.

    ``contacts``: whether contacts are skipped, too, as those of spring and damper.

    Attributes
    ----------
    arrays : SkipTables
    """

    def __init__(self, m: LocatedScheme, p: Parameters, integrator: Integrator, contacts: bool = True):
        self._scheme, self._parameters, self._integrator = m, p, integrator
        halvings, _ = uncompiled(halvings_at)(m, True, 0.0)
        modes = CONTACT + 1 + min(halvings, TABULATED) if contacts else FREE + 1
        self.arrays = _empty_tables([[None]] * modes, p)
        self.arrays.counts[:] = MISSING

    def make_asked(self) -> None:
        """Make the tables that the kernel has asked for."""
        for mode in np.flatnonzero(self.arrays.counts == ASKED):
            self._make(int(mode))

    def _make(self, mode: int) -> None:
        """Make the tables of a mode."""
        m, p, tables, unit = self._scheme, self._parameters, self.arrays, np.eye(COLUMNS)
        pressed, halvings = mode != FREE, max(mode - CONTACT, 0)
        h = m.h / 2**halvings
        piece, entries = self._piece_matrix(pressed, h), ENTRIES
        stride = _stride(p, pressed, h)
        if halvings > 0 and stride > 1:  # no more pieces follow each other, Eq. (13)
            entries = min(ENTRIES, int(2.0 / m.step_per_age / stride) + 1)
        tables.sizes[mode], tables.counts[mode] = 1.0, 1
        signed_gap = -unit[1:2] if pressed else unit[1:2]
        levels = _fill_mode(tables, mode, piece, signed_gap @ piece, stride, entries)
        with np.errstate(all="ignore"):
            supremum = _supremum(unit[5:6], levels[0][: max(stride - 1, 0)], levels[-1])  # of |g″| at ends of pieces
        tables.dips[mode] = supremum[0] * (h**2 / 2)
        if pressed:
            law = -m.stiffness * unit[1] - 2.0 * m.damper * unit[3]
            _fill_impulses(tables, mode, 0.5 * h * law @ (unit + piece), levels)

    def _piece_matrix(self, pressed: bool, h: float) -> np.ndarray:
        """Φ of a piece of length h."""
        m, p = self._scheme, self._parameters
        if m.stages.count > 0:
            return _step_matrix(step_maps(bodies_of(p), self._integrator, h), int(pressed), p.eta * h, -p.free_gap)
        matrix = np.empty((COLUMNS, COLUMNS))
        write_piece_matrix(m, pressed, h, p.free_position, matrix)
        return matrix


def _empty_tables(watched: list[list], p: Parameters) -> SkipTables:
    modes, most = len(watched), max(len(rows) for rows in watched)
    return SkipTables(
        rows=np.zeros((modes, most, LEVELS, COLUMNS, ENTRIES)),
        firsts=np.zeros((modes, most, LEVELS, COLUMNS)),
        bounds=np.zeros((modes, most, COLUMNS)),
        sizes=np.zeros((modes, most)),
        counts=np.array([len(rows) for rows in watched]),
        strides=np.zeros(modes, dtype=np.int64),
        columns=np.zeros((modes, LEVELS, ENTRIES, COLUMNS, COLUMNS)),
        impulses=np.zeros((modes, LEVELS, ENTRIES, COLUMNS)),
        dips=np.zeros((modes, COLUMNS)),
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
    """The rows but for multiples: those of an earlier one have its sign, as the forces without and with contact."""
    found = []
    for row in rows:
        own = row / np.abs(row).max()
        if not any(np.abs(own - other / np.abs(other).max()).max() <= SAME for other in found):
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


def _powers(matrix: np.ndarray, entries: int = ENTRIES) -> np.ndarray:
    """The first powers of a matrix, each a product of two earlier ones."""
    powers = matrix[None]
    while len(powers) < entries:
        powers = np.concatenate([powers, powers[-1] @ powers])
    return powers[:entries]


def _stride(p: Parameters, pressed: bool, h: float) -> int:
    """Steps of length h from entry to entry of the coarser level."""
    rate, reach = (pressed_rate, REACHES[PRESSED]) if pressed else (free_rate, REACHES[FREE])
    return min(int(reach / (uncompiled(rate)(p) * h)), LONGEST)


def _fill_mode(
    tables: SkipTables, mode: int, step: np.ndarray, rows: np.ndarray, stride: int, entries: int = ENTRIES
) -> list[np.ndarray]:
    """Write the watched rows of a mode and the powers of its step, of each level, and return the powers.

    ``entries``: of the coarser level, which is made if the stride is more than a step.
    """
    with np.errstate(all="ignore"):  # of a method that is not stable: a number beyond bounds skips nothing
        levels = [_powers(step)]
        if stride > 1:
            tables.strides[mode] = stride
            levels.append(_powers(levels[0][stride - 1], entries))
            change = step - np.eye(COLUMNS)
            supremum = _supremum(rows @ change @ change, levels[0][: stride - 1], levels[1][:-1])
            tables.bounds[mode, : len(rows)] = supremum * (stride**2 / 8)
        for level, powers in enumerate(levels):
            tables.columns[mode, level, : len(powers)] = powers.transpose(0, 2, 1)
            first = rows if level == 0 else rows @ levels[0][stride - 2]
            tables.firsts[mode, : len(rows), level] = first
            after = np.concatenate([first[None], first @ powers[:-1]])
            tables.rows[mode, : len(rows), level, :, : len(powers)] = after.transpose(1, 2, 0)
    return levels


def _supremum(rows: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Largest |element| of the rows and of their products with matrices of ``inner``, of ``outer`` and of both."""
    begun = np.concatenate([rows[None], rows @ inner])
    largest = np.abs(begun).max(axis=0)
    side_by_side = outer.transpose(1, 0, 2).reshape(COLUMNS, -1)  # one product of matrices instead of many
    for r in range(largest.shape[0]):
        for i in range(0, len(begun), BLOCK):
            images = np.abs(begun[i : i + BLOCK, r] @ side_by_side).max(axis=0).reshape(-1, COLUMNS)
            np.maximum(largest[r], images.max(axis=0), out=largest[r])
    return largest


def _fill_impulses(tables: SkipTables, mode: int, row: np.ndarray, levels: list[np.ndarray]) -> None:
    """Write the impulses of a mode; ``row``: that of its first step."""
    with np.errstate(all="ignore"):
        for level, powers in enumerate(levels):
            first = row if level == 0 else tables.impulses[mode, 0, tables.strides[mode] - 1]
            after = np.concatenate([first[None], first @ powers[:-1]])
            tables.impulses[mode, level, : len(powers)] = np.cumsum(after, axis=0)
