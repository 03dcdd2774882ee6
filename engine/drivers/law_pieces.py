"""The linear pieces of a contact law: in each the force is a spring, a damper and a constant."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import (
    MAIN,
    OTHER,
    ContactLaw,
    count_kinks,
    factors,
    is_piecewise_linear,
    kink,
)


class Piece(NamedTuple):
    """A part of a contact in which λ = Kδ + 2Dv + f."""

    stiffness: float
    damping: float
    push: float = 0.0  # f
    kinks: tuple[tuple[float, float, float], ...] = ()  # factors of δ, v and 1 of what falls below zero at its end


def pieces_of(law: ContactLaw) -> dict[int, Piece]:
    """The pieces of a law that is piecewise linear, by their numbers; none of another one.

    The main piece ends with each of its kinks in another one, in the order of their numbers; these end in the main one.
    """
    if not uncompiled(is_piecewise_linear)(law.kind):
        return {}
    scale = np.array([law.stiffness, law.gain, law.stiffness * law.penetration])  # of δ, v and 1
    others = range(OTHER, OTHER + uncompiled(count_kinks)(law.kind))
    rows = [np.array([uncompiled(kink)(law, k, *unit) for unit in np.diag(scale)]) for k in others]
    kinks = {MAIN: rows} | {piece: [-row] for piece, row in zip(others, rows, strict=True)}
    formulas = {piece: scale * uncompiled(factors)(law, piece) for piece in kinks}
    return {
        piece: Piece(stiffness, 0.5 * gain, push, tuple(map(tuple, kinks[piece])))
        for piece, (stiffness, gain, push) in formulas.items()
    }
