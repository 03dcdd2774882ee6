"""Basins of attraction: which motion each start of a plane leads to, at one η, for any solver.

Every cell is certified by its own run (:mod:`.basin_motions`), never by its neighbours. Once all cells are known the
motions are numbered in the order of their shares, with those that a cell met for the first time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.arguments import checked
from vibroscope.engine.checks import whole
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.description import Kind
from vibroscope.engine.motions.sameness import SECTION_BATCHES
from vibroscope.engine.motions.search import KnownMotion
from vibroscope.engine.motions.tolerances import SAME_CYCLE
from vibroscope.engine.simulate import KEEP_LIMIT
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.axis import ascending_values, start_of
from vibroscope.engine.sweeps.basin_boundary import boundary, share_error
from vibroscope.engine.sweeps.basin_motions import OTHER, BasinSearch, basin_search
from vibroscope.engine.sweeps.codes import KIND_FLAGS
from vibroscope.engine.sweeps.start_plane import AXES, StartPlane, can_begin
from vibroscope.engine.sweeps.study import Study
from vibroscope.engine.sweeps.tolerances import SCATTERED
from vibroscope.engine.sweeps.variables import StudyArray, Variable, status_variable, variables_of


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
