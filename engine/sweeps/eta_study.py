"""The bifurcation diagram (paper, Figure 3): Poincaré sections over η, or over any other parameter.

From rest each cell is on its own. Continued upwards or downwards, each starts from where its neighbour ended, so that a
motion is followed as long as it is stable; where the two ways differ, motions coexist (hysteresis).

Refinement halves each interval at whose ends the motion differs, level by level. A cell that it puts in between starts
from rest, or, continued, from the end of the neighbour it comes from; so the cells that were there before stay as they
are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.arguments import require, shown, whole
from vibroscope.engine.cells import CellResults, Cells
from vibroscope.engine.methods import check_has
from vibroscope.engine.model import COORDINATES
from vibroscope.engine.motions.description import CellKind
from vibroscope.engine.motions.judge import classify
from vibroscope.engine.motions.lyapunov import PERIODS_RANGE, Lyapunov, follow_cells
from vibroscope.engine.simulate import FARTHEST
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.codes import KIND_FLAGS, MISSING
from vibroscope.engine.sweeps.study import CELLS_LIMIT, Study, start_of
from vibroscope.engine.sweeps.tolerances import SAME_IMPACTS
from vibroscope.engine.sweeps.variables import StudyArray, Variable, status_variable, variables_of

OVER = tuple(vocabulary.SWEPT)
DIRECTIONS = ("rest", "up", "down")


@dataclass(frozen=True, eq=False, kw_only=True)
class EtaStudy(Study):
    """A bifurcation diagram over η (paper, Figure 3), or over another parameter.

    Attributes
    ----------
    values : (n,) ndarray
        Of the swept parameter, ascending.
    over : str
        ``eta``, ``K``, ``D``, ``steps`` or a constant of the system: `OVER` lists them.
    direction : {"rest", "up", "down"}
        From rest (or from ``initial``), or each value from the end of its neighbour below or above.
    coordinates : tuple of {"xi1", "v1", "xi2", "v2"}
        Of the section points to keep.
    initial : (4,) sequence or (n, 4) ndarray, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of each value, in place of rest; not for a continued or refined diagram. That of each
        cell where refinement of a continued diagram has put cells in.
    refine : int
        Levels of refinement: each halves the intervals at whose ends the motion differs.
    lyapunov : int
        Periods over which the largest Lyapunov exponent is averaged, from the end of the sample on (some 8,000;
        reference and exact penalty); 0: none is computed. Only it distinguishes chaotic from quasi-periodic motion;
        without, both are undecided.

    Examples
    --------
    >>> from vibroscope.engine import EtaStudy, Reference, System, sweep
    >>> found = sweep(EtaStudy(System(), Reference(), values=[2.7, 2.8, 2.9], transient=1000, sample=20))
    >>> found["period"].values.tolist(), found["xi2"].dims
    ([1, 2, 2], ('eta', 'sample'))
    """

    values: Sequence[float]
    over: str = "eta"
    direction: str = "rest"
    coordinates: Sequence[str] = ("xi1", "xi2")
    initial: Sequence[float] | None = None
    refine: int = 0
    lyapunov: int = 0
    kind: ClassVar[str] = "eta"
    grid: ClassVar[tuple[str, ...]] = ("values",)

    def __post_init__(self):
        super().__post_init__()
        self._check_choices()
        eta = float(self.values[0]) if self.over == "eta" else self.eta
        refine = whole("refine", self.refine, 0, 20, "give levels of refinement")
        lyapunov = self.lyapunov and whole(
            "lyapunov", self.lyapunov, *PERIODS_RANGE, "give periods to average over, or 0"
        )
        self._set(eta=eta, coordinates=tuple(self.coordinates), refine=refine, lyapunov=int(lyapunov))
        if self.initial is not None and not (isinstance(self.initial, np.ndarray) and self.initial.ndim == 2):
            if self.direction != "rest" or refine:
                raise ValueError(
                    "an initial state is for each value its own start: give direction='rest' and no refine"
                )
            self._set(initial=np.tile(start_of(self.initial), (len(self.values), 1)))

    def _check_choices(self) -> None:
        over, method = self.over, self.method
        if over not in OVER:
            raise ValueError(f"over = {shown(over)} is no parameter that can be swept: give one of {', '.join(OVER)}")
        check_has(method, over, self.system)
        if self.direction not in DIRECTIONS:
            raise ValueError(f"direction = {self.direction!r} is not one of {', '.join(DIRECTIONS)}")
        if unknown := [name for name in self.coordinates if name not in COORDINATES]:
            raise ValueError(f"coordinate {shown(unknown[0])} is not one of {', '.join(COORDINATES)}")
        if over != "eta" and self.eta is None:
            raise ValueError(f"a sweep over {over} needs an eta: give the excitation frequency")

    @property
    def sequential(self) -> bool:
        """Whether a batch starts from the end of the one before."""
        return self.direction != "rest" and self.initial is None

    @property
    def backwards(self) -> bool:
        """Whether the last batch comes first."""
        return self.direction == "down"

    @property
    def axis_names(self) -> tuple[str]:
        """The swept parameter."""
        return (self.over,)

    @cached_property
    def arrays(self) -> dict[str, StudyArray]:
        """The axis and the periods of the sample."""
        return super().arrays | {"sample": StudyArray(("sample",), np.arange(self.sample), vocabulary.SAMPLE)}

    @property
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell."""
        cell = (self.over,)
        found = variables_of(vocabulary.MOTION, cell)
        if not self.method.has_step:
            del found["longest_contact_steps"]
        found |= {name: Variable((*cell, "sample"), "f8", vocabulary.SECTION.format(name)) for name in self.coordinates}
        if self.lyapunov:
            found |= variables_of(vocabulary.EXPONENT, cell)
        found["motion"] = Variable(cell, "i1", vocabulary.KIND, KIND_FLAGS)
        found |= variables_of(vocabulary.IMPACT_PHASE, cell)
        if self.method.counts_solutions:
            found |= variables_of(vocabulary.SOLUTION_COUNTS, cell)
        found["end"] = Variable((*cell, "component"), "f8", vocabulary.END)
        return found | {"status": status_variable(cell)}

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {
            "direction": self.direction,
            "coordinates": list(self.coordinates),
            "initial": None if self.initial is None else self.initial.tolist(),
            "refine": self.refine,
            "lyapunov": self.lyapunov,
        }

    def cut(self, chunk):
        """The study of the cells of a chunk."""
        part = super().cut(chunk)
        return part if self.initial is None else replace(part, initial=self.initial[chunk[0]])

    def starts_of(self, chosen, ends):
        """Those of the study, if it has some."""
        return super().starts_of(chosen, ends) if self.initial is None else self.initial[chosen]

    def compute(self, batch=None, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of a batch of cells; continued, they run from end to end in the study's direction."""
        forwards = slice(None, None, -1 if self.backwards else 1)
        points = {name: values[forwards] for name, values in self.points(batch).items()}
        chain = np.zeros(len(points[self.over]), int) if self.sequential else None
        cells = self.cells_at(points, chain=chain)
        if self.initial is not None:
            part = slice(None) if batch is None else batch[0]
            cells = replace(cells, initial=self.initial[part][forwards])
        elif self.sequential and before is not None:
            cells = replace(cells, initial=self._after(before, cells.starts()))
        found = self.run(cells, threads=threads, progress=progress, cancelled=cancelled)
        values = vars(found) | {"motion": np.where(found.period > 0, CellKind.PERIODIC, CellKind.UNDECIDED)}
        if self.lyapunov:
            values |= self._exponents(cells, found, threads, cancelled)
        values["motion"] = np.where(found.ok, values["motion"], CellKind.ENDED_EARLY)
        values |= {name: found.section[:, :, COORDINATES.index(name)] for name in self.coordinates}
        return {name: values[name][forwards] for name in self.variables}

    def _after(self, before: dict[str, np.ndarray], starts: np.ndarray) -> np.ndarray:
        """The starts of a batch, (n, 4), the first of which goes on from the batch before."""
        last, starts = 0 if self.backwards else -1, starts.copy()
        if before["status"][last] == 0:
            starts[0] = before["end"][last]
        return starts

    def _exponents(self, cells: Cells, found: CellResults, threads: int | None, cancelled) -> dict[str, np.ndarray]:
        values = {name: np.full(len(cells), np.nan) for name in vocabulary.EXPONENT}
        values["motion"] = np.full(len(cells), CellKind.UNDECIDED)
        places = np.flatnonzero(found.ok & (np.abs(found.end) <= FARTHEST).all(axis=1))

        def judge(i: int, averaged: Lyapunov) -> None:
            values["lyapunov"][i], values["lyapunov_error"][i] = averaged.exponent, averaged.error
            values["motion"][i] = CellKind.PERIODIC if found.period[i] else CellKind[classify(averaged)[0].name]

        follow_cells(cells, places, found.end[places], self.lyapunov, judge, threads=threads, cancelled=cancelled)
        return values

    def check(self) -> None:
        """Also the refinement, and whether there is an exponent.

        Raises
        ------
        ValueError
            Naming the number, the range and what to do.
        """
        super().check()
        require("cells after refinement", self.cells * 2.0**self.refine, 1, CELLS_LIMIT, "refine less")
        if self.lyapunov and self.method.has_step:
            raise ValueError("a Lyapunov exponent needs a closed form: sweep with the reference or exact solver")

    def refined(self, found: dict[str, np.ndarray]) -> "EtaStudy | None":
        """Cells in the middle of the intervals in which the motion changes; None if there are none.

        Parameters
        ----------
        found : dict
            The axis and the variables of all cells so far, ascending along the axis.
        """
        left, middle = midpoints(self.over, found)
        if not len(middle):
            return None
        initial = None
        if self.direction != "rest":
            source = left + (self.direction == "down")
            reached = (found["status"][source] == 0) & (np.abs(found["end"][source]) <= FARTHEST).all(axis=1)
            initial = np.where(reached[:, None], found["end"][source], self.cells_at({self.over: middle}).starts())
        return replace(self, values=middle, initial=initial)


def midpoints(over: str, found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The values at which cells are to be inserted.

    Parameters
    ----------
    over : str
        Name of the axis; between two ``steps`` there is a midpoint only if they are not neighbours.
    found : dict
        The axis and the variables of all cells so far, ascending along the axis.

    Returns
    -------
    left : (m,) ndarray of int
        The cells at the lower ends of the intervals.
    middle : (m,) ndarray
        Values of the axis between them and the next.
    """
    axis = found[over]
    left = np.flatnonzero(changed_intervals(found))
    middle = 0.5 * (axis[left] + axis[left + 1])
    if over == "steps":
        middle = np.floor(middle)
    inside = (middle > axis[left]) & (middle < axis[left + 1])
    return left[inside], middle[inside]


def changed_intervals(found: dict[str, np.ndarray]) -> np.ndarray:
    """Between which neighbours the motion changes: another period, other impacts in it, or one of them ended early.

    Returns
    -------
    (n − 1,) ndarray of bool
    """
    status, period, impacts = found["status"], found["period"], found["impacts_per_period"]
    periodic = period > 0
    other_impacts = periodic[1:] & periodic[:-1] & ~(np.abs(np.diff(impacts)) <= SAME_IMPACTS)
    ended = (status != 0) & (status != MISSING)
    both = ended[1:] & ended[:-1]
    return ~both & ((np.diff(status) != 0) | (np.diff(period) != 0) | other_impacts)
