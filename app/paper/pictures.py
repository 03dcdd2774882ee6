"""The data of the figures of the paper: the page draws them, an export writes them as tables.

A picture of a finding as tables for export.
"""

from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from vibroscope.app.export.formats import Series
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


_STATE = ("xi1", "velocity1", "xi2", "velocity2")


@singledispatch
def table_of(picture: Picture) -> list[Series]:
    """Tables of what the picture shows."""
    raise TypeError(f"no table for {type(picture).__name__}")


@table_of.register
def _(picture: PhasePlots) -> list[Series]:
    """Samples and section of each solution."""
    tables = []
    for solver, run in picture.runs.items():
        section = dict(zip(_STATE, run.section.reshape(-1, 4).T, strict=True))
        tables += [
            Series(solver, _sampled(run)),
            Series(f"{solver} section", section),
        ]
    return tables


@table_of.register
def _(picture: TimeHistory) -> list[Series]:
    """Samples, impacts and intervals of contact."""
    run = picture.run
    contacts = dict(zip(("contact_begin", "contact_end"), run.contacts.reshape(-1, 2).T, strict=True))
    return [
        Series("samples", _sampled(run)),
        Series("impacts", {"tau": run.impacts.time, "impulse": run.impacts.impulse}),
        Series("contacts", contacts),
    ]


@table_of.register
def _(picture: CellMap) -> list[Series]:
    """One row for each cell."""
    K, D = np.meshgrid(picture.stiffness, picture.damping)
    kind = np.array(picture.names)[picture.kind]
    return [Series("cells", {"K": K.ravel(), "D": D.ravel(), "kind": kind.ravel()})]


@table_of.register
def _(picture: Diagram) -> list[Series]:
    """One row for each point of the diagram."""
    xi1, xi2 = (row.ravel() for row in picture.displacement)
    eta = np.repeat(picture.eta, picture.displacement.shape[2])
    return [Series("reference", {"eta": eta, "xi1": xi1, "xi2": xi2})]


def _sampled(run: Response) -> dict[str, np.ndarray]:
    """Time τ and state over the sampled periods."""
    sampled = run.trajectory
    rows = (row for n in (0, 1) for row in (sampled.displacement[n], sampled.velocity[n]))
    return {"tau": sampled.time, **dict(zip(_STATE, rows, strict=True)), "force": sampled.force}
