"""Starts from which two solvers end on different motions: two basins of one plane, cell by cell."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.motions.sameness import same_between_solvers
from vibroscope.engine.sweeps.basin_boundary import share_error

if TYPE_CHECKING:
    import xarray

DIFFERENT, SAME_MOTION, NO_STATEMENT = 1, 0, -1  # of a cell


@dataclass(frozen=True, eq=False)
class BasinDifference:
    """The starts from which two solvers end on different motions.

    Attributes
    ----------
    cells : (n, m) ndarray of int8
        DIFFERENT, SAME_MOTION, or NO_STATEMENT where one of them knows no start or no end.
    share, error : float
        Share of the cells with a statement in which they differ, with its standard error; nan without any.
    same : (k, l) ndarray of bool
        Which motions of the first are which of the second (:mod:`..motions.sameness`).
    """

    cells: np.ndarray
    share: float
    error: float
    same: np.ndarray

    def __repr__(self) -> str:
        first, second = self.same.shape
        motions = f"{first} and {second} motions, {self.same.any(1).sum()} in both"
        return f"BasinDifference({100 * self.share:.2f} ± {100 * self.error:.2f} % of the starts; {motions})"


def basin_difference(first: "xarray.Dataset", second: "xarray.Dataset") -> BasinDifference:
    """The starts from which two solvers end on different motions.

    Parameters
    ----------
    first, second : xarray.Dataset
        Of a :class:`engine.BasinStudy`, over the same cells.

    Raises
    ------
    ValueError
        If these are no basins of the same cells.
    """
    tables = []
    for each in (first, second):
        if "motion_section" not in each:
            raise ValueError("the dataset is no complete basin: give the result of a BasinStudy")
        names = ("motion", "motion_period", "motion_section")
        tables.append({name: np.asarray(each[name].values) for name in names})
    axes = first["motion"].dims
    if axes != second["motion"].dims or not all(np.array_equal(first[name], second[name]) for name in axes):
        raise ValueError("the basins are not of the same cells: sweep both over the same axes and values")
    return difference_of(*tables)


def difference_of(first: Mapping[str, np.ndarray], second: Mapping[str, np.ndarray]) -> BasinDifference:
    """Compare the arrays ``motion``, ``motion_period`` and ``motion_section`` of two basins of the same cells."""
    same = np.array(
        [
            [same_between_solvers(one, period, other, other_period) for other, other_period in _motions(second)]
            for one, period in _motions(first)
        ],
        dtype=bool,
    ).reshape(len(first["motion_period"]), len(second["motion_period"]))
    one, other = first["motion"], second["motion"]
    both = (one >= 0) & (other >= 0)
    cells = np.full(one.shape, NO_STATEMENT, np.int8)
    cells[both] = np.where(same[one[both], other[both]], SAME_MOTION, DIFFERENT)
    known = int(both.sum())
    share = float((cells == DIFFERENT).sum() / known) if known else np.nan
    return BasinDifference(cells, share, share_error(share, known), same)


def _motions(table: Mapping[str, np.ndarray]) -> list[tuple[np.ndarray, int]]:
    """Section and period of each motion."""
    sections = [rows[np.isfinite(rows).all(axis=1)] for rows in table["motion_section"]]
    return list(zip(sections, map(int, table["motion_period"]), strict=True))
