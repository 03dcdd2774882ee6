"""The linear pieces of a contact law: in each the force is a spring, a damper and a constant."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import MAIN, OTHER, count_kinks, factors, is_piecewise_linear, kink
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.time_stepping.newmark import Scheme


class Piece(NamedTuple):
    """A part of a contact in which λ = Kδ + 2Dv + f."""

    stiffness: float
    damping: float
    push: float = 0.0  # f
    kinks: tuple[tuple[float, float, float], ...] = ()  # factors of δ, v and 1 of what falls below zero at its end


def pieces_of(p: Parameters | Scheme) -> dict[int, Piece]:
    """The pieces of a law that is piecewise linear, by their numbers; none of another one.

    The main piece ends with each of its kinks in another one, in the order of their numbers; these end in the main one.
    """
    if not uncompiled(is_piecewise_linear)(p.law):
        return {}
    scale = np.array([p.stiffness, p.gain, p.stiffness * p.penetration])  # of δ, v and 1
    others = range(OTHER, OTHER + uncompiled(count_kinks)(p.law))
    rows = [np.array([uncompiled(kink)(p.law, k, p.stiffening, *unit) for unit in np.diag(scale)]) for k in others]
    kinks = {MAIN: rows} | {piece: [-row] for piece, row in zip(others, rows, strict=True)}
    formulas = {piece: scale * uncompiled(factors)(p.law, piece, p.stiffening) for piece in kinks}
    return {
        piece: Piece(stiffness, 0.5 * gain, push, tuple(map(tuple, kinks[piece])))
        for piece, (stiffness, gain, push) in formulas.items()
    }
