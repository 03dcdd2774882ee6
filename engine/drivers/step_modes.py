"""The modes of a one-step method (:mod:`..kernels.accelerated.matrix_skip`): its steps while nothing changes.

All quantities are rows of factors of x before the step (:mod:`.step_maps`).
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.law_pieces import Piece, pieces_of
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import CUT, KELVIN_VOIGT, OTHER, takes_larger
from vibroscope.engine.kernels.time_stepping.law_step import linear_root
from vibroscope.engine.kernels.time_stepping.linear_step import BEFORE, COLUMNS, FORCE, GAP, OWN, RATE, LinearScheme


class Mode(NamedTuple):
    """Steps that are alike."""

    end: np.ndarray  # (STATE_ROWS + 1, COLUMNS) the end of a step
    pressed: bool  # whether the gap is closed
    status: int  # that of its stages
    deciding: list[np.ndarray]  # what is positive where a step belongs to the mode
    gap: np.ndarray  # the gap at the end, with the sign by which it is positive while contact does not change
    force: Piece | None = None  # spring and damper that act
    mean_force: np.ndarray | None = None  # λ over the step


def modes_of(m: LinearScheme) -> list[Mode]:
    """The modes of steps of size Δτ: flight, then those in contact in the order in which they mostly follow."""
    law = m.system.law.kind
    if law <= CUT:
        found = [_mode_of_statuses(m, False, 0), _mode_of_statuses(m, True, 1)]
        return found if law == KELVIN_VOIGT else [*found, _mode_of_statuses(m, True, 0)]
    pieces = list(pieces_of(m.system.law).values())
    # the first piece, if bodies that part at touch are in it
    pulling = next((piece for piece in pieces[:1] if all(held > speed for _, speed, held in piece.kinks)), None)
    if not uncompiled(takes_larger)(law, OTHER):
        pieces[:2] = pieces[1::-1]  # where the bodies touch, the damper is at its limit
    return [_mode_of_piece(m, piece, pulling) for piece in (None, *pieces)]


def end_of_step(maps: np.ndarray, status: int) -> np.ndarray:
    """The end of a step all stages of which have a status; ``maps``: :func:`.step_maps.step_maps`."""
    end = _stages(maps, status)[-1][status].copy()
    end[FORCE] *= status
    return end


def _stages(maps: np.ndarray, status: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The ends of each stage without and with contact, if all stages before have this status."""
    pairs = [(maps[0], maps[1])]
    if len(maps) > 2:
        pairs.append((maps[2 + 2 * status], maps[3 + 2 * status]))
    return pairs


def _gap_at_end(m: LinearScheme, end: np.ndarray) -> np.ndarray:
    """The gap at the end of a step; where a law takes it, it is another one with some methods."""
    return end[1] - end[0] - m.system.touch * np.eye(COLUMNS)[-1]


def _mode_of_statuses(m: LinearScheme, pressed: bool, status: int) -> Mode:
    """A mode of spring and damper, which with the law that is cut act in a contact where they push."""
    maps, side, deciding = m.maps[0], -1.0 if pressed else 1.0, []
    cut, acts, pairs = m.system.law.kind == CUT, 1.0 if status else -1.0, _stages(m.maps[0], status)
    for i, (without, with_force) in enumerate(pairs):
        if m.at_end:  # either status wants that of the mode; a force that pushes makes the gap larger
            ends = ((without, with_force)[status],) if cut else (without, with_force)
            deciding += [side * end[GAP] for end in ends]
            deciding += [acts * with_force[FORCE]] if pressed and cut else []
            continue
        if i + 1 < len(pairs):  # the status from the start of the next stage
            deciding.append(side * (without, with_force)[status][GAP])
        if pressed and cut:
            deciding.append(acts * with_force[FORCE])
    end = end_of_step(maps, status)
    mode = Mode(end, pressed, status, deciding, side * _gap_at_end(m, end))
    if not status:
        return mode
    mean = sum(weight * pair[1][FORCE] for weight, pair in zip(m.weights, pairs, strict=False))
    return mode._replace(force=Piece(m.system.law.stiffness, m.system.damper), mean_force=mean)


def _mode_of_piece(m: LinearScheme, piece: Piece | None, pulling: Piece | None) -> Mode:
    """The mode of a piece of another law, or its flight; ``m.maps`` are those of a step without contact.

    ``pulling``: the piece in which a law pulls near touch, if there is one: with the status "end" the other status must
    not agree with its own end either.
    """
    maps, deciding, push, forces = m.maps[0], [], np.zeros(COLUMNS), []
    one = np.eye(COLUMNS)[-1]
    for i, stage in enumerate(maps):
        free = stage[:, :COLUMNS] + np.outer(stage[:, BEFORE], push)
        slopes = stage[:, OWN]
        free[FORCE], push = 0.0, np.zeros(COLUMNS)
        if acting := piece or pulling:
            known = acting.push * one, free[GAP], free[RATE], slopes[GAP], slopes[RATE]
            found = uncompiled(linear_root)(acting.stiffness, 2.0 * acting.damping, *known)
            push = found if piece else push
            if pulling and m.at_end:
                deciding.append(-free[GAP] if piece else free[GAP] + slopes[GAP] * found)
        end = free + np.outer(slopes, push)
        end[FORCE] = push
        forces.append(push)
        side = -1.0 if piece else 1.0
        if piece:
            deciding += [held * one - depth * end[GAP] - speed * end[RATE] for depth, speed, held in piece.kinks]
        if m.at_end or i + 1 < len(maps):  # where it is closed with these forces, it is without them, too
            deciding.append(side * end[GAP])
        elif piece and piece.stiffness > m.system.law.stiffness:  # the damper at its limit pushes where the spring does
            deciding.append(-end[GAP])
    gap = side * _gap_at_end(m, end)
    if m.system.law.relative != 0.0:  # the closing speed is that before the plain step which begins a contact
        deciding.append(gap)
    mode = Mode(end[: GAP + 1], piece is not None, int(piece is not None), deciding, gap)
    if not piece or piece.stiffness == 0.0:
        return mode
    mean = sum(weight * force for weight, force in zip(m.weights, forces, strict=False))
    return mode._replace(force=piece, mean_force=mean)
