"""Basins of attraction: which motion each start of a plane leads to, at one η, for any solver.

Every cell is certified by its own run (:mod:`.basin_motions`), never by its neighbours. Once all cells are known the
motions are numbered in the order of their shares, with those that a cell met for the first time.

Shares of a plane, and the dimension of the boundary between the basins.

The uncertainty exponent α (Grebogi, McDonald, Ott and Yorke, Physics Letters A 99 (1983) 415) says how the share f(ε)
of starts whose motion an error ε may change falls with that error, f ∝ ε^α. The boundary then has the dimension 2 − α
in a plane: 1 for a smooth curve, and the closer to 2 the less a smaller error helps. f(ε) is the share of the pairs of
cells ε apart along an axis that lead to different motions, and α the slope of log f over log ε. Its standard error has
two parts: that of the fit, since f of a fractal waves about the straight line, and that of a jackknife over the plane,
which leaves out one tile after the other.

Starts from which two solvers end on different motions: two basins of one plane, cell by cell.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from vibroscope.engine.arguments import checked, whole
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Kind
from vibroscope.engine.motions.search import KnownMotion
from vibroscope.engine.motions.section import SECTION_BATCHES, same_between_solvers
from vibroscope.engine.motions.tolerances import SAME_CYCLE
from vibroscope.engine.simulate import KEEP_LIMIT
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.basin_motions import AXES, OTHER, BasinSearch, StartPlane, basin_search, can_begin
from vibroscope.engine.sweeps.codes import KIND_FLAGS
from vibroscope.engine.sweeps.step_study import observed_order
from vibroscope.engine.sweeps.study import Study, ascending_values, start_of
from vibroscope.engine.sweeps.tolerances import SCATTERED
from vibroscope.engine.sweeps.variables import StudyArray, Variable, status_variable, variables_of

if TYPE_CHECKING:
    import xarray


SMALLEST_DISTANCE, LARGEST_DISTANCE = 1, 16  # cells between the two of a pair, doubled from one to the other
LARGEST_SHARE = 8  # of the shorter side: a larger distance compares the sides of the plane
TILES = 4  # along each side
FEWEST_DISTANCES = 3  # distances of a fit with an error


class Boundary(NamedTuple):
    """Uncertainty exponent α and dimension 2 − α of a boundary; nan where there is none, or too few cells.

    Attributes
    ----------
    exponent, dimension, error : float
        The standard error is that of both.
    """

    exponent: float
    dimension: float
    error: float


def share_error(share: float, cells: int) -> float:
    """Standard error of a share of so many starts: √(p(1 − p)/n), for a lattice an upper bound."""
    return float(np.sqrt(share * (1 - share) / cells)) if cells else np.nan


def boundary(motion: np.ndarray) -> Boundary:
    """The boundary between basins in a plane.

    Parameters
    ----------
    motion : (n, m) ndarray of int
        The motion of each cell; negative: none, and no pair.
    """
    distances = _distances(motion.shape)
    counts = np.array([_counts(motion, distance) for distance in distances]).reshape(-1, 2, TILES * TILES)
    slope, of_fit = _slope(distances, counts.sum(axis=2))
    without = [_slope(distances, np.delete(counts, tile, axis=2).sum(axis=2))[0] for tile in range(TILES * TILES)]
    of_plane = np.sqrt((len(without) - 1) * np.var(without)) if np.isfinite(without).all() else np.nan
    return Boundary(slope, 2 - slope, float(np.hypot(of_fit, of_plane)))


def _distances(shape: tuple[int, int]) -> list[int]:
    longest = min(LARGEST_DISTANCE, min(shape) // LARGEST_SHARE)
    return [2**k for k in range(LARGEST_DISTANCE.bit_length()) if SMALLEST_DISTANCE <= 2**k <= longest]


def _counts(motion: np.ndarray, distance: int) -> np.ndarray:
    """Pairs of cells so far apart that lead to different motions, and all pairs, by tile: (2, TILES²)."""
    found = np.zeros((2, TILES * TILES))
    tiles = np.add.outer(
        *(np.arange(n) * TILES // n * factor for n, factor in zip(motion.shape, (TILES, 1), strict=True))
    )
    for axis in range(2):
        near = np.take(motion, range(motion.shape[axis] - distance), axis)
        far = np.take(motion, range(distance, motion.shape[axis]), axis)
        tile = np.take(tiles, range(motion.shape[axis] - distance), axis)
        pairs = (near >= 0) & (far >= 0)
        for row, which in enumerate((pairs & (near != far), pairs)):
            found[row] += np.bincount(tile[which], minlength=TILES * TILES)
    return found


def _slope(distances: list[int], counts: np.ndarray) -> tuple[float, float]:
    """α and the standard error of the fit; ``counts`` (distances, 2): different pairs and all of them."""
    if (counts > 0).all(axis=1).sum() < FEWEST_DISTANCES:
        return np.nan, np.nan
    return observed_order(1 / np.array(distances), counts[:, 0] / np.maximum(counts[:, 1], 1))


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
        Which motions of the first are which of the second (:mod:`..motions.section`).
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


@dataclass(frozen=True, eq=False, kw_only=True)
class BasinStudy(Study):
    """Basins of attraction in a plane of starts: which motion each of them leads to.

    ``transient`` and ``sample`` are the periods that a cell runs, and of these the last ones, by which its motion is
    recognised, where no trapping region decides before. ``motion`` of the result numbers the motions by their shares.

    Attributes
    ----------
    plane : StartPlane
        The whole plane, on which the motions are found beforehand.
    x, y : (n,), (m,) ndarray
        Values along its axes, ascending.
    """

    plane: StartPlane
    x: Sequence[float]
    y: Sequence[float]
    transient: int = 1800
    sample: int = 256
    kind: ClassVar[str] = "basin"
    grid: ClassVar[tuple[str, ...]] = ("x", "y")

    def __post_init__(self):
        super().__post_init__()
        advice = "a motion that does not repeat itself is recognised by the averages of its sample"
        whole("sample", self.sample, 2 * SECTION_BATCHES, KEEP_LIMIT, advice)

    @classmethod
    @checked
    def over(
        cls,
        system: System,
        method: Method,
        eta: float,
        axes: Mapping,
        *,
        start: Sequence[float] | None = None,
        phase: float = 0.0,
        **periods: int,
    ) -> "BasinStudy":
        """The study of a whole plane.

        Parameters
        ----------
        system : System
        method : Reference, ExactPenalty or TimeStepping
        eta : float
            Excitation frequency η = Ω/ω₁.
        axes : dict of str to (n,) sequence
            Ascending values of two of ``xi1``, ``v1``, ``xi2``, ``v2``, and ``phase``, the share of the excitation
            period at which a run begins (reference, and exact penalty of the first law).
        start : (4,) sequence, optional
            The initial numbers that are not on an axis, of ξ₁, ξ₁′, ξ₂, ξ₂′; by default those of rest.
        phase : float
            Of every start where it is not on an axis, 0 to 1.
        **periods
            ``transient`` and ``sample``.

        Raises
        ------
        ValueError
            If a number is out of range.

        Examples
        --------
        >>> from vibroscope.engine import BasinStudy, Reference, System, sweep
        >>> plane = BasinStudy.over(System(), Reference(), 1.7, {"xi2": [1.0, 3.0], "v2": [0.0, 2.0]})
        >>> sweep(plane)["motion"].dims
        ('xi2', 'v2')
        """
        if len(axes) != 2:
            raise ValueError(
                f"a plane of starts has two axes, not {len(axes)}: give two different ones of {', '.join(AXES)}"
            )
        x, y = (ascending_values(name, values) for name, values in axes.items())
        spans = tuple((float(values[0]), float(values[-1])) for values in (x, y))
        plane = StartPlane(tuple(axes), spans, start_of(start) or system.rest, phase)
        return cls(system, method, eta, plane=plane, x=x, y=y, **periods)

    @property
    def axis_names(self) -> tuple[str, str]:
        """The numbers of the start that differ from cell to cell."""
        return self.plane.axes

    @cached_property
    def arrays(self) -> dict[str, StudyArray]:
        """The axes."""
        return {name: StudyArray((name,), values, vocabulary.STARTS[name]) for name, values in self.axes.items()}

    @property
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell."""
        dims = tuple(self.axes)
        found = variables_of(vocabulary.REACHED, dims)
        found["point"] = Variable((*dims, "component"), "f8", vocabulary.POINT)
        return found | {"status": status_variable(dims)}

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {"start": list(self.plane.start), "phase": self.plane.phase}

    def check(self) -> None:
        """Also the plane.

        Raises
        ------
        ValueError
            Naming the number, the range and what to do.
        """
        self.plane.check(self.system)
        super().check()
        starts, phases = self._starts(None)
        if (phases != 0).any() and not self._search.trapped:
            raise ValueError(
                f"a start phase needs a solver in closed form: the {self.method.name} method begins at phase 0; "
                "give the reference or the exact penalty solution of the first law, or other axes"
            )
        if not can_begin(self.system, self.method, starts).any():
            raise ValueError(
                "every start of this plane penetrates: the reference knows no penetration, give starts with a gap "
                f"ξ₂ − ξ₁ + {self.system.clearance:g} ≥ 0, or the penalty solution"
            )

    def compute(self, batch=None, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of a batch of cells."""
        starts, phases = self._starts(batch)
        found = self._search.label(starts, phases, threads=threads, progress=progress, cancelled=cancelled)
        values = {
            "reached": found.motion,
            "reached_period": found.period,
            "periods": found.periods,
            "point": found.point,
            "status": found.status,
        }
        return self.in_shape(values, self.points(batch))

    def conclusions(self, values: Mapping[str, np.ndarray]) -> dict[str, StudyArray]:
        """The motions in the order of their shares, the motion of each cell, and the boundary."""
        values = {name: np.asarray(values[name]) for name in ("reached", "reached_period", "point", "status")}
        motion, motions = self._numbered(values)
        counts = np.bincount(motion[motion >= 0], minlength=len(motions))
        cells = int(((motion >= 0) | (values["status"] > 0)).sum())
        shares = counts / max(cells, 1)
        edge = boundary(motion)
        rows = max((len(each.section) for each in motions), default=0)
        sections = np.full((len(motions), rows, 4), np.nan)
        for k, each in enumerate(motions):
            sections[k, : len(each.section)] = each.section
        found = {
            "motion": (tuple(self.axes), motion.astype(np.int32)),
            "motion_kind": (("motions",), np.array([KIND_FLAGS[each.kind] for each in motions], np.int8)),
            "motion_period": (("motions",), np.array([each.period for each in motions], np.int32)),
            "motion_share": (("motions",), shares),
            "motion_share_error": (("motions",), np.array([share_error(share, cells) for share in shares])),
            "motion_start": (("motions", "number"), self._first_starts(motion, len(motions))),
            "motion_section": (("motions", "row", "component"), sections),
            "uncertainty_exponent": ((), edge.exponent),
            "uncertainty_exponent_error": ((), edge.error),
            "boundary_dimension": ((), edge.dimension),
            "boundary_dimension_error": ((), edge.error),
        }
        texts = vocabulary.MOTIONS_REACHED
        return {name: StudyArray(dims, array, texts[name]) for name, (dims, array) in found.items()}

    @property
    def _search(self) -> BasinSearch:
        return basin_search(self.system, self.eta, self.method, self.plane, self.transient, self.sample)

    def _starts(self, batch) -> tuple[np.ndarray, np.ndarray]:
        x, y = (values.ravel() for values in self.points(batch).values())
        return self.plane.starts(x, y)

    def _numbered(self, values: dict[str, np.ndarray]) -> tuple[np.ndarray, list[KnownMotion]]:
        """The motion of each cell as an index, and the motions that any cell leads to, by their shares."""
        motion = values["reached"].astype(np.int64)
        motions = list(self._search.motions()) if (motion >= 0).any() else []
        for cell in np.argwhere(motion == OTHER):
            place = tuple(cell)
            if motion[place] == OTHER:  # not yet taken by one before
                alike = (motion == OTHER) & self._alike(values, place)
                motion[alike] = len(motions)
                motions.append(_motion_of_point(int(values["reached_period"][place]), values["point"][place]))
        counts = np.bincount(motion[motion >= 0], minlength=len(motions))
        order = [k for k in np.argsort(-counts, kind="stable") if counts[k]]
        numbers = np.full(len(motions) + 1, -1)
        numbers[order] = np.arange(len(order))
        return np.where(motion >= 0, numbers[np.maximum(motion, -1)], motion), [motions[k] for k in order]

    def _alike(self, values: dict[str, np.ndarray], place: tuple[int, ...]) -> np.ndarray:
        """The cells that lead to the same motion as a given cell, where the search had not found it beforehand."""
        period, point = values["reached_period"][place], values["point"][place]
        alike = values["reached_period"] == period
        if not period:  # no cycle: nothing distinguishes these
            return alike
        allowed = (SAME_CYCLE if self._search.closed_form else SCATTERED) * np.abs(point).max()
        return alike & (np.abs(values["point"] - point).max(axis=-1) <= allowed)

    def _first_starts(self, motion: np.ndarray, count: int) -> np.ndarray:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ and the phase of the first start that leads to each motion, (count, 5)."""
        starts, phases = self._starts(None)
        table = np.column_stack([starts, phases])
        first = [int(np.argmax(motion.ravel() == k)) for k in range(count)]
        return table[first].reshape(count, 5)


def _motion_of_point(period: int, point: np.ndarray) -> KnownMotion:
    return KnownMotion(Kind.PERIODIC if period else Kind.UNDECIDED, period, point[None])
