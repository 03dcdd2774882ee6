"""The time-step study (paper, Figure 14): what n steps per period make of one motion, at fixed K and D.

A constant step misses each contact change by a part of a step, so that the section scatters. How fast that fades is
the observed order p in spread ∝ n⁻ᵖ, the slope of a least-squares line through log spread over log n. Beside each run
stands the one whose steps land on the contact changes; and the error by the time step, Newmark − exact penalty, has an
order too.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..batch import run_cells
from ..cells import CellResults, Cells
from ..methods import ExactPenalty
from ..result import Record
from ..simulate import simulate
from .axis import ascending
from .chunks import Chunk
from .errors import parts_of
from .study import Study
from .variables import ERRORS, OF_PENALTY, STATUS_FLAGS, Variable, Whole

SHOWN = 2  # periods of a phase plot
INSTANTS = 500  # of each, at most
COLUMNS = ("xi1", "v1", "xi2", "v2")
SCHEMES = {"fixed": 0, "located": 1}


@dataclass(frozen=True, eq=False)
class StepStudy(Study):
    """Newmark over n, the step fixed and located.

    Attributes
    ----------
    steps : (n,) ndarray
        Ascending.
    """

    steps: np.ndarray = None
    kind: ClassVar[str] = "step"

    def __post_init__(self):
        super().__post_init__()
        self._take(steps=ascending("steps", self.steps))

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """The swept parameters."""
        return {"steps": self.steps}

    @property
    def cells(self) -> int:
        """Runs: each number of steps fixed and located."""
        return len(SCHEMES) * super().cells

    @property
    def periods_per_cell(self) -> int:
        """What chunks are cut by: time goes by steps here, and the located step walks them all."""
        return 10 * super().periods_per_cell

    @cached_property
    def whole(self) -> dict[str, Whole]:
        """What is known beforehand."""
        return super().whole | {
            "scheme": Whole(("scheme",), np.array([0, 1], dtype=np.int8), "0: fixed step, 1: located step"),
            "sample": Whole(("sample",), np.arange(self.sample), "period of the sample"),
            "error_joint_damping": Whole(
                (), parts_of(self.system, self.eta).joint_damping, "reference with derived less with table damping"
            ),
        }

    @property
    def lengths(self) -> dict[str, int]:
        """Length of every dimension."""
        return super().lengths | {"instant": SHOWN * INSTANTS + 1}

    @property
    def variables(self) -> dict[str, Variable]:
        """What a cell tells."""
        dims = ("steps", "scheme")
        found = {name: Variable(dims, kind, meaning) for name, (kind, meaning) in OF_PENALTY.items()}
        found |= {name: Variable(dims, "f8", meaning) for name, meaning in ERRORS.items()}
        found |= {name: Variable((*dims, "instant"), "f8", f"{name} of the phase plot") for name in COLUMNS}
        found["tau"] = Variable((*dims, "instant"), "f8", "time of the phase plot from a section on; nan after its end")
        for name in ("xi2", "v2"):
            found[f"{name}_section"] = Variable((*dims, "sample"), "f8", f"{name} at tau = 0 mod T, oldest first")
        return found | {"status": Variable(dims, "i1", "how the run ended", STATUS_FLAGS)}

    def cut(self, chunk: Chunk) -> "StepStudy":
        """The same study of the cells of a chunk."""
        return replace(self, steps=self.steps[chunk[0]])

    def conclusions(self, found) -> dict[str, Whole]:
        """Observed orders."""
        told = {}
        for name, meaning in (("spread", "the spread"), ("error_time_step", "the error by the time step")):
            pairs = [observed_order(self.steps, found[name].values[:, scheme]) for scheme in SCHEMES.values()]
            order, error = np.array(pairs).T
            told[f"order_of_{name}"] = Whole(("scheme",), order, f"p in n^-p for {meaning}, by least squares")
            told[f"order_of_{name}_error"] = Whole(("scheme",), error, "standard error of that slope")
        return told

    def compute(self, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of all cells."""
        points = self.points()
        how = {"transient": self.transient, "sample": self.sample, "threads": threads, "cancelled": cancelled}
        beside = replace(self, method=ExactPenalty(self.method.stiffness, self.method.damping))
        exact = run_cells(Cells(self.system, [self.eta], beside.method), **how)
        exact = _repeated(exact, len(points["steps"]))
        columns = []
        for done, located in enumerate((False, True), start=1):
            scheme = replace(self, method=replace(self.method, located=located))
            cells = scheme.cells_at(points)
            found = run_cells(cells, **how)
            told = {name: getattr(found, name) for name in (*OF_PENALTY, "status")}
            errors = parts_of(self.system, self.eta).errors(cells, found, exact, threads=threads, cancelled=cancelled)
            told |= dict(zip(ERRORS, errors, strict=True))
            told |= {f"{name}_section": found.section[:, :, COLUMNS.index(name)] for name in ("xi2", "v2")}
            columns.append(told | phase_plots(cells, found))
            if progress is not None:
                progress(done * len(points["steps"]))
        return {name: np.stack([told[name] for told in columns], axis=1) for name in self.variables}


def _repeated(results: CellResults, n: int) -> CellResults:
    return CellResults(**{name: np.repeat(column, n, axis=0) for name, column in vars(results).items()})


def phase_plots(cells: Cells, found: CellResults) -> dict[str, np.ndarray]:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ and τ of each cell over the periods that follow its sample, each (n, instants)."""
    plots = {name: np.full((len(cells), SHOWN * INSTANTS + 1), np.nan) for name in (*COLUMNS, "tau")}
    for i in np.flatnonzero(found.ok):
        start, record = found.end[i], Record(SHOWN, INSTANTS)
        run = simulate(
            cells.system_of(i),
            cells.eta[i],
            cells.method_of(i),
            periods=SHOWN,
            keep=SHOWN,
            initial=start,
            record=record,
        )
        if not run.ok:
            continue
        (x1, x2), (v1, v2) = run.trajectory.displacement, run.trajectory.velocity
        for name, values in zip((*COLUMNS, "tau"), (x1, v1, x2, v2, run.trajectory.time), strict=True):
            plots[name][i, : len(values)] = values
    return plots


def observed_order(steps: np.ndarray, sizes: np.ndarray) -> tuple[float, float]:
    """p and its standard error in size ∝ n⁻ᵖ, by least squares on the logarithms.

    Parameters
    ----------
    steps, sizes : (m,) ndarray
        Sizes that are zero, negative or nan have no logarithm and are left out.

    Returns
    -------
    order, error : float
        nan with fewer than two, the error with fewer than three points.
    """
    fine = np.isfinite(sizes) & (sizes > 0)
    x, y = np.log(steps[fine]), np.log(sizes[fine])
    if len(x) < 2:
        return np.nan, np.nan
    x = x - x.mean()
    slope = (x @ y) / (x @ x)
    rest = y - y.mean() - slope * x
    error = np.sqrt((rest @ rest) / (len(x) - 2) / (x @ x)) if len(x) > 2 else np.nan
    return -slope, error
