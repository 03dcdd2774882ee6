"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps."""

import math
from itertools import combinations

import numpy as np

from ..integrators import Integrator
from ..kernels.accelerated.located_skip import (
    ASKED,
    CONTACT,
    MISSING,
    TABULATED,
    size_of_skips,
    unpack_skips,
    write_piece_matrix,
)
from ..kernels.accelerated.skip_search import (
    AT_WORTH,
    CHUNK,
    CHUNKS,
    FIRSTS,
    FREE,
    IN_MIDST,
    LEVELS,
    RISING,
    WORTHWHILE,
    SkipTables,
)
from ..kernels.accelerated.step_map import ENTRIES, PRESSED, REACHES
from ..kernels.compile.options import uncompiled
from ..kernels.compile.packing import aligned_zeros
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.parameters import Parameters
from ..kernels.time_stepping.contact_location import LocatedScheme
from ..kernels.time_stepping.linear_step import COLUMNS, FORCE, STATE_ROWS, LinearScheme
from ..kernels.time_stepping.located import halvings_at
from .step_maps import BETWEEN, bodies_of, stage_end, start_of_step, step_maps
from .step_modes import Mode, Piece, end_of_step, modes_of

LONGEST = ENTRIES  # stride: every step is then one entry of each level away
BLOCK = 16  # rows of a product: so small that BLAS does not wake other threads for it, which would take longer
LARGEST_CUBIC = 4 / 27  # of t(1 − t)² between 0 and 1
SAME_ROW = 1e-12  # rows that differ from a multiple of another by less, as a share of their size, are not watched


def skip_tables(m: LinearScheme, p: Parameters) -> SkipTables:
    """The tables of all modes, with the steps of size Δτ of a scheme."""
    modes, (x_of_u, _) = modes_of(m), _relative_basis(m.system.touch)
    begin = BETWEEN @ np.eye(2, COLUMNS) - m.system.touch * np.eye(COLUMNS)[-1]
    watched = [_distinct(mode, -begin if mode.pressed else begin) for mode in modes]
    tables = _empty_tables([rows for rows, *_ in watched], p.eta)
    for i, (mode, (rows, deciding, sought)) in enumerate(zip(modes, watched, strict=True)):
        # a gap may be a small difference of rows; a force is as large as its displacements make it
        tables.sizes[i, : len(rows)] = np.maximum(1.0, np.abs(rows[:, :2]).max(axis=1))
        tables.deciding[i], tables.sought[i], tables.statuses[i] = deciding, sought, mode.status
        felt = p if mode.force is None else p._replace(stiffness=mode.force.stiffness, damping=mode.force.damping)
        stride = _stride(felt, mode.force is not None, m.system.h)
        levels = _fill_mode(tables, i, _step_matrix(mode.end, m.turn, m.system.touch), rows @ x_of_u, stride)
        if mode.force is not None:
            _fill_impulses(tables, i, m.system.h * mode.mean_force @ x_of_u, levels)
    return tables


class LocatedTables:
    """The tables of located steps of size Δτ and of their pieces, made as a run asks for them.

    ``pieces``: those of a contact; none if contacts are not skipped.

    Attributes
    ----------
    packed : tuple of two ndarray
        A :class:`..kernels.accelerated.located_skip.LocatedSkips`.
    skips : LocatedSkips
        The same as views, for loops that solve most steps in contact: from a packed one they take a tenth longer.
    arrays : SkipTables
        Its tables.
    """

    def __init__(self, m: LocatedScheme, p: Parameters, integrator: Integrator, pieces: list[Piece]):
        self._scheme, self._parameters, self._integrator, self._pieces = m, p, integrator, pieces
        halvings, _ = uncompiled(halvings_at)(m, True, 0.0)
        modes = CONTACT + len(pieces) * (1 + min(halvings, TABULATED))
        most = 1 + max((len(piece.kinks) for piece in pieces), default=0) * self._takes_of_force()
        size = size_of_skips(modes, most, m.steps)
        self.packed = aligned_zeros(size), np.zeros(4 + 2 * modes, dtype=np.int64)
        floats, whole = self.packed
        numbers = 2 * math.pi / p.eta, float(p.free_position)
        whole[:4], floats[-2:] = (modes, most, len(pieces), m.steps), numbers
        skips, angle = uncompiled(unpack_skips)(*self.packed), 2 * math.pi * np.arange(m.steps) / m.steps
        skips.angles[:] = np.cos(angle), np.sin(angle)
        self.arrays = skips.tables._replace(period=numbers[0])
        self.skips = skips._replace(tables=self.arrays, pieces=len(pieces), rest=numbers[1])
        self.arrays.counts[:] = MISSING
        begun = CONTACT + len(pieces) * halvings  # the mode in which a contact begins, if that is skipped
        self.arrays.counts[[mode for mode in (FREE, begun) if mode < modes]] = ASKED  # hardly a run does without them

    def make_asked(self) -> None:
        """Make the tables that the kernel has asked for."""
        for mode in np.flatnonzero(self.arrays.counts == ASKED):
            self._make(int(mode))

    def _make(self, mode: int) -> None:
        """Make the tables of a mode."""
        m, tables = self._scheme, self.arrays
        halvings, kind = divmod(mode - CONTACT, max(len(self._pieces), 1)) if mode != FREE else (0, 0)
        law = self._pieces[kind] if mode != FREE else None
        h = m.h / 2**halvings
        p = self._parameters
        if law:
            p = p._replace(stiffness=law.stiffness, damping=law.damping)
        unit = np.eye(COLUMNS)
        piece, entries, stride = self._piece_matrix(p, law, h), ENTRIES, _stride(p, law is not None, h)
        if halvings > 0 and stride > 1:
            most = 2.0 / m.step_per_age  # no more pieces follow each other, Eq. (13); both levels are searched alike
            stride = min(stride, math.ceil(math.sqrt(most)))
            entries = min(ENTRIES, int(most / stride) + 1)
        gap, kinks = (-1.0, 0.0) if law is None else (1.0, 0.0), law.kinks if law else ()
        begins = np.concatenate(
            [_rows_of([gap], 0), *(_rows_of(kinks, 0) + side * h / 3 * _rows_of(kinks, 1) for side in (-1, 1) if kinks)]
        )
        rows = np.concatenate([begins @ piece, *self._felt(p, law, h)])
        tables.counts[mode], tables.begins[mode, : len(rows), -1] = len(rows), 1.0  # where a stage takes the force: one
        tables.begins[mode, : len(begins)] = begins
        tables.sizes[mode, : len(rows)] = 1.0
        if kinks:
            tables.sizes[mode, : len(rows)] = np.maximum(1.0, np.abs(rows[:, :4]).max(axis=1))  # ξ₁, g and their rates
        levels = _fill_mode(tables, mode, piece, rows, stride, entries)
        if mode == FREE:
            rates = np.vstack([unit[3], unit[3] @ levels[0][: RISING * CHUNK - 1]])
            tables.rates[:] = rates.reshape(RISING, CHUNK, -1).transpose(0, 2, 1)
        with np.errstate(all="ignore"):
            within = levels[0][: max(stride - 1, 0)], levels[-1]
            if kinks:
                mean = begins[:1] @ (piece - unit) / h
                rates = _rows_of([gap], 1)
                bound = _supremum(rates - mean, *within) + _supremum(rates @ piece - mean, *within)
                tables.dips[mode, :1] = bound * (h * LARGEST_CUBIC)
            else:  # |g″| at ends of pieces
                tables.dips[mode, :1] = _supremum(unit[5:6], *within) * (h**2 / 2)
        if law:
            force = _rows_of([(law.stiffness, 2.0 * law.damping)], 0)[0]
            _fill_impulses(tables, mode, 0.5 * h * force @ (unit + piece), levels)

    def _takes_of_force(self) -> int:
        """Of each kink, how many rows are watched: two for steps, and where stages take the force elsewhere."""
        kind = self._integrator
        return 2 + len(kind.stages) * (len(kind.stages) > 1 or kind.explicit)

    def _felt(self, p: Parameters, law: Piece | None, h: float) -> list[np.ndarray]:
        """Rows of the kinks of a piece where the stages take its force, if that is not between the ends of a step."""
        if not law or not law.kinks or self._takes_of_force() == 2:
            return []
        (x_of_u, _), bodies, points, found = _relative_basis(-p.free_gap), bodies_of(p), [start_of_step()], []
        for stage in self._integrator.stages:
            point, _, gap, rate = stage_end(bodies, self._integrator, stage, points, np.eye(COLUMNS + 2)[FORCE], 1, h)
            points.append(point)
            found.append(np.array([-by_depth * gap - by_speed * rate for by_depth, by_speed in law.kinks]))
        return [rows[:, :COLUMNS] @ x_of_u for rows in found]

    def _piece_matrix(self, p: Parameters, law: Piece | None, h: float) -> np.ndarray:
        """Φ of a piece of length h."""
        m, pressed = self._scheme, law is not None
        if m.stages.count > 0:
            end = end_of_step(step_maps(bodies_of(p), self._integrator, h), int(pressed))
            return _step_matrix(end, p.eta * h, -p.free_gap)
        matrix = np.empty((COLUMNS, COLUMNS))
        write_piece_matrix(m, pressed, h, p.free_position, matrix)
        return matrix


def _rows_of(factors: list[tuple[float, float]], order: int) -> np.ndarray:
    """Rows of u that are sums of δ and v with these factors, or their first derivatives."""
    unit = np.eye(COLUMNS)
    return np.array(
        [-by_depth * unit[1 + 2 * order] - by_speed * unit[3 + 2 * order] for by_depth, by_speed in factors]
    )


def _empty_tables(watched: list[np.ndarray], eta: float) -> SkipTables:
    modes, most = len(watched), max(len(rows) for rows in watched)
    return SkipTables(
        rows=np.zeros((modes, most, LEVELS, CHUNKS, COLUMNS, CHUNK)),
        firsts=np.zeros((modes, most, FIRSTS, COLUMNS)),
        bounds=np.zeros((modes, most, COLUMNS)),
        sizes=np.zeros((modes, most)),
        counts=np.array([len(rows) for rows in watched]),
        deciding=np.zeros(modes, dtype=np.int64),
        sought=np.zeros(modes, dtype=np.int64),
        statuses=np.zeros(modes, dtype=np.int64),
        strides=np.zeros(modes, dtype=np.int64),
        columns=np.zeros((modes, LEVELS, ENTRIES, COLUMNS, COLUMNS)),
        impulses=np.zeros((modes, LEVELS, ENTRIES, COLUMNS)),
        begins=np.zeros((modes, 0, COLUMNS)),
        dips=np.zeros((modes, 0, COLUMNS)),
        rates=np.zeros((0, COLUMNS, CHUNK)),
        period=2 * math.pi / eta,
    )


def _distinct(mode: Mode, begin: np.ndarray) -> tuple[np.ndarray, int, int]:
    """The rows of a mode that no others imply, how many of them decide, and how many of these are sought through.

    ``begin``: the gap at the beginning of a step, which the end of the one before has said to be positive.
    """
    sought, others = [], []
    for row in mode.deciding:
        if not _is_implied(row, sought + others):
            (others if _is_implied(row, [mode.gap, begin]) and not _is_implied(row, [mode.gap]) else sought).append(row)
    deciding = sought + others
    rows = deciding if _is_implied(mode.gap, sought) else [*deciding, mode.gap]
    return np.array(rows), len(deciding), len(sought)


def _is_implied(row: np.ndarray, others: list[np.ndarray]) -> bool:
    """Whether a row is a sum of positive multiples of at most two others."""
    row = row / np.abs(row).max()
    scaled = [other / np.abs(other).max() for other in others]
    for some in [*((one,) for one in scaled), *combinations(scaled, 2)]:
        factors, *_ = np.linalg.lstsq(np.transpose(some), row)
        if factors.min() > 0.0 and np.abs(factors @ some - row).max() <= SAME_ROW:
            return True
    return False


def _relative_basis(touch: float) -> tuple[np.ndarray, np.ndarray]:
    """The matrices that make x of u, and u of x."""
    x_of_u = np.eye(COLUMNS)
    x_of_u[[1, 3, 5], [0, 2, 4]] = 1.0
    x_of_u[1, -1] = touch
    u_of_x = np.eye(COLUMNS)
    u_of_x[[1, 3, 5], [0, 2, 4]] = -1.0
    u_of_x[1, -1] = -touch
    return x_of_u, u_of_x


def _step_matrix(end: np.ndarray, turn: float, touch: float) -> np.ndarray:
    """Φ of a step from its end as rows of x; the phase of the excitation grows by ``turn``."""
    matrix, (x_of_u, u_of_x) = np.eye(COLUMNS), _relative_basis(touch)
    matrix[:STATE_ROWS] = end[:STATE_ROWS]
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
            change = step - np.eye(len(step))
            supremum = _supremum(rows @ change @ change, levels[0][: stride - 1], levels[1][:-1])
            tables.bounds[mode, : len(rows)] = supremum * (stride**2 / 8)
        for level, powers in enumerate(levels):
            tables.columns[mode, level, : len(powers)] = powers.transpose(0, 2, 1)
            first = rows if level == 0 else rows @ levels[0][stride - 2]
            after = np.zeros((ENTRIES, *rows.shape))
            after[0], after[1 : len(powers)] = first, first @ powers[:-1]
            tables.firsts[mode, : len(rows), level] = first
            chunks = after.reshape(CHUNKS, CHUNK, *rows.shape)
            tables.rows[mode, : len(rows), level] = chunks.transpose(2, 0, 3, 1)
            if level > 0:
                worth = math.ceil(WORTHWHILE / stride)
                tables.firsts[mode, : len(rows), [IN_MIDST, AT_WORTH]] = after[[max(worth // 2, 1) - 1, worth - 1]]
    return levels


def _supremum(rows: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Largest |element| of the rows and of their products with matrices of ``inner``, of ``outer`` and of both."""
    begun = np.concatenate([rows[None], rows @ inner])
    largest = np.abs(begun).max(axis=0)
    columns = outer.shape[-1]
    side_by_side = outer.transpose(1, 0, 2).reshape(columns, -1)  # one product of matrices instead of many
    for r in range(largest.shape[0]):
        for i in range(0, len(begun), BLOCK):
            images = np.abs(begun[i : i + BLOCK, r] @ side_by_side).max(axis=0).reshape(-1, columns)
            np.maximum(largest[r], images.max(axis=0), out=largest[r])
    return largest


def _fill_impulses(tables: SkipTables, mode: int, row: np.ndarray, levels: list[np.ndarray]) -> None:
    """Write the impulses of a mode; ``row``: that of its first step."""
    with np.errstate(all="ignore"):
        for level, powers in enumerate(levels):
            first = row if level == 0 else tables.impulses[mode, 0, tables.strides[mode] - 1]
            after = np.concatenate([first[None], first @ powers[:-1]])
            tables.impulses[mode, level, : len(powers)] = np.cumsum(after, axis=0)
