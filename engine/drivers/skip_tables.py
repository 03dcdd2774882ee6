"""Tables by which one-step methods skip steps (:mod:`..kernels.accelerated.matrix_skip`), made of their step maps.

A mode (:class:`Mode`) is what a step is while nothing changes. All quantities are rows of factors of u before the step
(:mod:`.step_maps`).
"""

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.law_pieces import Piece, pieces_of
from vibroscope.engine.drivers.step_maps import root_of_piece, stage_ends
from vibroscope.engine.kernels.accelerated.matrix_skip import (
    AT_WORTH,
    CHUNK,
    CHUNKS,
    FIRSTS,
    FREE,
    IN_MIDST,
    LEVELS,
    WORTHWHILE,
    SkipTables,
)
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES, PRESSED, REACHES
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import CUT, OTHER, takes_larger
from vibroscope.engine.kernels.equations.motion import free_rate, pressed_rate
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.time_stepping.linear_step import COLUMNS, GAP, RATE, STATE_ROWS, LinearScheme
from vibroscope.engine.kernels.time_stepping.newmark import LIMIT

LONGEST = ENTRIES  # stride: every step is then one entry of each level away
BLOCK = 16  # rows of a product: so small that BLAS does not wake other threads for it, which would take longer
SAME_ROW = 1e-12  # rows that differ from a multiple of another by less, as a share of their size, are not watched


class Mode(NamedTuple):
    """Steps that are alike."""

    end: np.ndarray  # (ROWS, COLUMNS) the end of a step
    pressed: bool  # whether the gap is closed
    status: int  # that of its stages
    deciding: list[np.ndarray]  # what is positive where a step belongs to the mode
    gap: np.ndarray  # the gap at the end, with the sign by which it is positive while contact does not change
    force: Piece | None = None  # spring and damper that act
    mean_force: np.ndarray | None = None  # λ over the step


def modes_of(m: LinearScheme) -> list[Mode]:
    """The modes of steps of size Δτ: flight, then those in contact in the order in which they mostly follow."""
    pieces = list(pieces_of(m.system.law).values())
    # the first piece, if bodies that part at touch are in it
    pulling = next((piece for piece in pieces[:1] if all(held > speed for _, speed, held in piece.kinks)), None)
    if not uncompiled(takes_larger)(m.system.law.kind, OTHER):
        pieces[:2] = pieces[1::-1]  # where the bodies touch, the damper is at its limit
    return [_mode_of_piece(m, piece, pulling) for piece in (None, *pieces)]


def _mode_of_piece(m: LinearScheme, piece: Piece | None, pulling: Piece | None) -> Mode:
    """The mode of a piece of a law, or its flight.

    ``pulling``: the piece in which a law pulls near touch, if there is one: with the status "end" the other status must
    not agree with its own end either.
    """
    maps, deciding, forces, one = m.maps[0], [], [], np.eye(COLUMNS)[-1]
    for i, (free, own, push, end) in enumerate(stage_ends(maps, [piece] * len(maps))):
        if pulling and m.at_end:
            other = -free[GAP] if piece else free[GAP] + own[GAP] * root_of_piece(pulling, free, own)
            deciding.append(other)
        forces.append(push)
        if piece:
            deciding += [held * one - depth * end[GAP] - speed * end[RATE] for depth, speed, held in piece.kinks]
        if m.at_end or i + 1 < len(maps):  # where it is closed with these forces, it is without them, too
            deciding.append(-end[GAP] if piece else end[GAP])
        elif piece and piece.stiffness > m.system.law.stiffness:  # the damper at its limit pushes where the spring does
            deciding.append(-end[GAP])
    gap = -end[1] if piece else end[1]  # where a law takes it, it is another one with some methods
    if not piece and m.system.reach < LIMIT:  # beyond, the next step is seen from the other stop
        deciding.append(m.system.reach * one - gap)
    if m.system.law.relative != 0.0:  # the closing speed is that before the plain step which begins a contact
        deciding.append(gap)
    acts = piece is not None and not (m.system.law.kind == CUT and piece.stiffness == 0.0)
    mode = Mode(end, piece is not None, int(acts), deciding, gap)
    if not piece or piece.stiffness == 0.0:
        return mode
    mean = sum(weight * force for weight, force in zip(m.weights, forces, strict=False))
    return mode._replace(force=piece, mean_force=mean)


def skip_tables(m: LinearScheme, p: Parameters) -> SkipTables:
    """The tables of all modes, with the steps of size Δτ of a scheme."""
    modes, begin = modes_of(m), np.eye(COLUMNS)[1]
    watched = [_distinct(mode, -begin if mode.pressed else begin) for mode in modes]
    tables = _empty_tables([rows for rows, *_ in watched], p.eta)
    for i, (mode, (rows, deciding, sought)) in enumerate(zip(modes, watched, strict=True)):
        # a gap may be a small difference of rows; a force is as large as its displacements make it
        tables.sizes[i, : len(rows)] = np.maximum(1.0, np.abs(rows[:, :2]).max(axis=1))
        tables.deciding[i], tables.sought[i], tables.statuses[i] = deciding, sought, mode.status
        felt = p if mode.force is None else p._replace(stiffness=mode.force.stiffness, damping=mode.force.damping)
        stride = _stride(felt, mode.force is not None, m.system.h)
        levels = _fill_mode(tables, i, _step_matrix(mode.end, m.turn), rows, stride)
        if mode.force is not None:
            _fill_impulses(tables, i, m.system.h * mode.mean_force, levels)
    return tables


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


def _step_matrix(end: np.ndarray, turn: float) -> np.ndarray:
    """Φ of a step from its end; the phase of the excitation grows by ``turn``."""
    matrix = np.eye(COLUMNS)
    matrix[:STATE_ROWS] = end[:STATE_ROWS]
    c, s = math.cos(turn), math.sin(turn)
    matrix[-3:-1, -3:-1] = [[c, -s], [s, c]]
    return matrix


def _powers(matrix: np.ndarray) -> np.ndarray:
    """The first powers of a matrix, each a product of two earlier ones."""
    powers = matrix[None]
    while len(powers) < ENTRIES:
        powers = np.concatenate([powers, powers[-1] @ powers])
    return powers


def _stride(p: Parameters, pressed: bool, h: float) -> int:
    """Steps of length h from entry to entry of the coarser level."""
    rate, reach = (pressed_rate, REACHES[PRESSED]) if pressed else (free_rate, REACHES[FREE])
    return min(int(reach / (uncompiled(rate)(p) * h)), LONGEST)


def _fill_mode(tables: SkipTables, mode: int, step: np.ndarray, rows: np.ndarray, stride: int) -> list[np.ndarray]:
    """Write the watched rows of a mode and the powers of its step, of each level, and return the powers.

    The coarser level is made if the stride is more than a step.
    """
    with np.errstate(all="ignore"):  # of a method that is not stable: a number beyond bounds skips nothing
        levels = [_powers(step)]
        if stride > 1:
            tables.strides[mode] = stride
            levels.append(_powers(levels[0][stride - 1]))
            change = step - np.eye(len(step))
            supremum = _supremum(rows @ change @ change, levels[0][: stride - 1], levels[1][:-1])
            tables.bounds[mode, : len(rows)] = supremum * (stride**2 / 8)
        for level, powers in enumerate(levels):
            tables.columns[mode, level] = powers.transpose(0, 2, 1)
            first = rows if level == 0 else rows @ levels[0][stride - 2]
            after = np.zeros((ENTRIES, *rows.shape))
            after[0], after[1:] = first, first @ powers[:-1]
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
            tables.impulses[mode, level] = np.cumsum(after, axis=0)
