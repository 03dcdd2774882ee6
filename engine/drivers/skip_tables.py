"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps."""

import math
from typing import NamedTuple

import numpy as np

from ..integrators import Integrator
from ..kernels.accelerated.certificate import CHUNK
from ..kernels.accelerated.located_skip import (
    ASKED,
    CONTACT,
    MISSING,
    TABULATED,
    size_of_skips,
    unpack_skips,
    write_piece_matrix,
)
from ..kernels.accelerated.matrix_skip import FREE, LEVELS, MODES, PRESSED, PULLED, SkipTables, columns_of
from ..kernels.accelerated.step_map import ENTRIES, REACHES
from ..kernels.compile.options import uncompiled
from ..kernels.compile.packing import aligned_zeros
from ..kernels.equations.contact_law import COMPRESSION, CUT, LIMITED
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.parameters import AT_WALL, TWO_BODIES, Parameters
from ..kernels.time_stepping import law_pieces
from ..kernels.time_stepping.contact_location import LocatedScheme
from ..kernels.time_stepping.law_step import LawScheme
from ..kernels.time_stepping.linear_step import COLUMNS, FORCE, GAP, STATE_ROWS, LinearScheme
from ..kernels.time_stepping.located import halvings_at
from .step_maps import bodies_of, stage_end, start_of_step, step_maps

LONGEST = ENTRIES  # stride: every step is then one entry of each level away
BLOCK = 16  # rows of a product: so small that BLAS does not wake other threads for it, which would take longer
DEEPEST = 4 / 27  # of t(1 − t)² between 0 and 1
ALONE = [1, 3, 5, 7, 8, 9]  # of u, what is left at a wall
SAME = 1e-12  # rows that differ from a multiple of another by less, as a share of their size, are not watched


def skip_tables(m: LinearScheme, p: Parameters) -> SkipTables:
    """The tables of all modes, with the steps of size Δτ of a scheme."""
    maps, touch = _maps_of_statuses(m), m.system.touch
    watched = [_watched_rows(maps, m, mode) for mode in range(MODES)]
    tables = _empty_tables(watched, p.eta)
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


class Piece(NamedTuple):
    """A part of a contact in which λ = Kδ + 2Dv."""

    stiffness: float
    damping: float
    kinks: tuple = ()  # factors of δ and v of what falls below zero at its end


def pieces_of(law: LawScheme) -> list[Piece]:
    """The pieces of a law that is piecewise linear; none of another one."""
    found, margin = [], uncompiled(law_pieces.margin_of)
    count = {CUT: 2, LIMITED: 3, COMPRESSION: 2}.get(law.law, 0)
    for piece in range(law_pieces.MAIN, law_pieces.MAIN + count):
        stiffness, gain = uncompiled(law_pieces.formula_of)(law, law.gain, piece)
        causes = range(law_pieces.FIRST, law_pieces.FIRST + uncompiled(law_pieces.kinks)(law, piece))
        kinks = [[margin(law, law.gain, piece, which, *unit) for unit in ((1.0, 0.0), (0.0, 1.0))] for which in causes]
        found.append(Piece(stiffness, 0.5 * gain, tuple(map(tuple, kinks))))
    return found


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
        self._wall = AT_WALL if m.wall else TWO_BODIES
        halvings, _ = uncompiled(halvings_at)(m, True, 0.0)
        modes = CONTACT + len(pieces) * (1 + min(halvings, TABULATED))
        most = 1 + max((len(piece.kinks) for piece in pieces), default=0) * self._takes_of_force()
        size = size_of_skips(modes, most, m.steps, columns_of(self._wall))
        self.packed = aligned_zeros(size), np.zeros(4 + 2 * modes, dtype=np.int64)
        floats, whole = self.packed
        numbers = 2 * math.pi / p.eta, float(p.free_position)
        whole[:4], floats[-2:] = (modes, most, len(pieces), m.steps), numbers
        skips, angle = uncompiled(unpack_skips)(*self.packed, self._wall), 2 * math.pi * np.arange(m.steps) / m.steps
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
        basis, unit = self._basis(law), np.eye(COLUMNS)
        piece, entries, stride = self._piece_matrix(p, law, h), ENTRIES, _stride(p, law is not None, h)
        if halvings > 0 and stride > 1:
            most = 2.0 / m.step_per_age  # no more pieces follow each other, Eq. (13); both levels are searched alike
            stride = min(stride, math.ceil(math.sqrt(most)))
            entries = min(ENTRIES, int(most / stride) + 1)
        gap, kinks = (-1.0, 0.0) if law is None else (1.0, 0.0), law.kinks if law else ()
        begins = np.concatenate(
            [_rows_of([gap], 0), *(_rows_of(kinks, 0) + side * h / 3 * _rows_of(kinks, 1) for side in (-1, 1) if kinks)]
        )
        begins = begins @ basis
        rows = np.concatenate([begins @ piece, *(rows @ basis for rows in self._felt(p, law, h))])
        tables.counts[mode], tables.begins[mode, : len(rows), -1] = len(rows), 1.0  # where a stage takes the force: one
        tables.begins[mode, : len(begins)] = begins
        tables.sizes[mode, : len(rows)] = 1.0
        if kinks:
            of_motion = 2 if self._wall else 4  # displacements and velocities
            tables.sizes[mode, : len(rows)] = np.maximum(1.0, np.abs(rows[:, :of_motion]).max(axis=1))
        levels = _fill_mode(tables, mode, piece, rows, stride, entries)
        if mode == FREE:
            rate = unit[3] @ basis
            tables.rates[:, 0], tables.rates[:, 1:] = rate, (rate @ levels[0][: CHUNK - 1]).T
        with np.errstate(all="ignore"):
            within = levels[0][: max(stride - 1, 0)], levels[-1]
            if kinks:
                mean = begins[:1] @ (piece - np.eye(len(piece))) / h
                rates = _rows_of([gap], 1) @ basis
                bound = _supremum(rates - mean, *within) + _supremum(rates @ piece - mean, *within)
                tables.dips[mode, :1] = bound * (h * DEEPEST)
            else:  # |g″| at ends of pieces
                tables.dips[mode, :1] = _supremum(unit[5:6] @ basis, *within) * (h**2 / 2)
        if law:
            force = _rows_of([(law.stiffness, 2.0 * law.damping)], 0)[0] @ basis
            _fill_impulses(tables, mode, 0.5 * h * force @ (np.eye(len(piece)) + piece), levels)

    def _basis(self, law: Piece | None) -> np.ndarray:
        """What the numbers of u are of those that the kernel has, (COLUMNS, n): at a wall λ follows from g and g′."""
        if not self._wall:
            return np.eye(COLUMNS)
        basis = np.eye(COLUMNS)[:, ALONE]
        if law:
            basis[6] = _rows_of([(law.stiffness, 2.0 * law.damping)], 0)[0, ALONE]
        return basis

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
            maps = step_maps(bodies_of(p), self._integrator, h)
            step = _step_matrix(maps, int(pressed), p.eta * h, -p.free_gap)
            return step[ALONE] @ self._basis(law) if self._wall else step
        matrix = np.empty(2 * (columns_of(self._wall),))
        write_piece_matrix(m, pressed, h, p.free_position, matrix, self._wall)
        return matrix


def _rows_of(factors: list[tuple[float, float]], order: int) -> np.ndarray:
    """Rows of u that are sums of δ and v with these factors, or their first derivatives."""
    unit = np.eye(COLUMNS)
    return np.array(
        [-by_depth * unit[1 + 2 * order] - by_speed * unit[3 + 2 * order] for by_depth, by_speed in factors]
    )


def _empty_tables(watched: list[list], eta: float) -> SkipTables:
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
        begins=np.zeros((modes, 0, COLUMNS)),
        dips=np.zeros((modes, 0, COLUMNS)),
        rates=np.zeros((COLUMNS, 0)),
        period=2 * math.pi / eta,
        wall=TWO_BODIES,
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
            change = step - np.eye(len(step))
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
