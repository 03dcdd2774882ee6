"""The data of the figures of the paper: the page draws them, an export writes them as tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from vibroscope.engine import Diagram, Response


@dataclass(frozen=True, eq=False)
class PhasePlots:
    """Phase plots in one frame.

    Attributes
    ----------
    runs : dict
        Responses with samples by the name of their solver.
    """

    runs: dict[str, Response]


@dataclass(frozen=True, eq=False)
class TimeHistory:
    """Displacements and contact force over the last two periods of a response with samples."""

    run: Response


@dataclass(frozen=True, eq=False)
class CellMap:
    """Cells of a K–D plane by kind.

    Attributes
    ----------
    stiffness, damping : (m,), (n,) ndarray
        Centres of the cells, evenly spaced in their logarithms.
    kind : (n, m) ndarray of int
        Index into ``names``.
    names : tuple of str
        The kinds.
    at : tuple of float
        K and D of the set that the claim is about.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    kind: np.ndarray
    names: tuple[str, ...]
    at: tuple[float, float]


Picture = PhasePlots | TimeHistory | CellMap | Diagram
