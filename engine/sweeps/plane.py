"""The K–D plane (paper, Figures 11 and 12): what each pair of contact stiffness and damping makes of the motion.

Beside each cell of Newmark's method stands the same cell without a time step: what differs between the two is an
artefact of Δτ. The paper's two criteria are `period` (bifurcated or not) and `longest_contact_steps` (below 30, it
takes a contact for a sudden impact); the third, which it names and leaves undone, is `impact_phase_error`, the instant
of impact against the reference's.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..batch import run_cells
from ..cells import CellResults
from ..divergence.contact import equal_restitution_damping
from ..methods import ExactPenalty, Newmark
from .axis import ascending
from .chunks import Chunk
from .errors import parts_of
from .study import Study
from .variables import ERRORS, OF_PENALTY, STATUS_FLAGS, Variable, Whole

AGAINST_REFERENCE = {
    "impact_phase": "instant of the first impact in the last cycle, as a share of T",
    "impact_phase_error": "the same less the reference's, between -1/2 and 1/2",
}


@dataclass(frozen=True, eq=False)
class PlaneStudy(Study):
    """Penalty cells over K and D at one η.

    Attributes
    ----------
    K, D : (n,), (m,) ndarray
    parts : bool
        Also the exact penalty method beside Newmark, and the errors against the reference.
    """

    K: np.ndarray = None
    D: np.ndarray = None
    parts: bool = True
    kind: ClassVar[str] = "plane"

    def __post_init__(self):
        super().__post_init__()
        self._take(K=ascending("K", self.K), D=ascending("D", self.D))

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """The swept parameters."""
        return {"K": self.K, "D": self.D}

    @property
    def beside(self) -> bool:
        """Whether the exact penalty method runs beside."""
        return self.parts and isinstance(self.method, Newmark)

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {"parts": self.parts}

    @property
    def variables(self) -> dict[str, Variable]:
        """What a cell tells."""
        dims = ("K", "D")
        own = {name: Variable(dims, kind, meaning) for name, (kind, meaning) in OF_PENALTY.items()}
        own |= {name: Variable(dims, "f8", meaning) for name, meaning in AGAINST_REFERENCE.items()}
        found = dict(own)
        if not isinstance(self.method, Newmark):
            del found["longest_contact_steps"]
        if self.parts:
            found |= {name: Variable(dims, "f8", meaning) for name, meaning in ERRORS.items()}
        if self.beside:
            del own["longest_contact_steps"]
            found |= {
                f"exact_{name}": variable._replace(meaning=f"exact penalty: {variable.meaning}")
                for name, variable in own.items()
            }
            found["exact_status"] = Variable(dims, "i1", "exact penalty: how the run ended", STATUS_FLAGS)
        return found | {"status": Variable(dims, "i1", "how the run ended; diverged: blown up", STATUS_FLAGS)}

    @cached_property
    def whole(self) -> dict[str, Whole]:
        """What is known beforehand."""
        reference = parts_of(self.system, self.eta)
        curve = equal_restitution_damping(self.system, self.K)
        return super().whole | {
            "D_equal_restitution": Whole(("K",), curve, "D at which a single contact returns the share e"),
            "reference_period": Whole((), np.int32(reference.table.period), "period of the reference; 0: aperiodic"),
            "reference_impacts_per_period": Whole((), reference.impacts_per_period, "impacts per excitation period"),
            "reference_impact_phase": Whole((), reference.first_impact, AGAINST_REFERENCE["impact_phase"]),
            "error_joint_damping": Whole((), reference.joint_damping, "reference with derived less with table damping"),
        }

    def cut(self, chunk: Chunk) -> "PlaneStudy":
        """The same study of the cells of a chunk."""
        rows, columns = chunk
        return replace(self, K=self.K[rows], D=self.D[columns])

    def compute(self, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of all cells."""
        cells = self.cells_at(self.points())
        stages = _Stages(progress, len(cells), 1 + self.beside + self.parts)
        pace = {"threads": threads, "cancelled": cancelled}
        how = {"transient": self.transient, "sample": self.sample, "coordinates": (2,), **pace}
        found = run_cells(cells, **how, progress=stages.next())
        values = self._told(found)
        exact = found
        if self.beside:
            without_step = replace(cells, method=ExactPenalty(1.0, 0.0), steps=None)
            exact = run_cells(without_step, **how, progress=stages.next())
            values |= {f"exact_{name}": column for name, column in self._told(exact).items()}
        if self.parts:
            parts = parts_of(self.system, self.eta)
            errors = parts.errors(cells, found, exact, **pace, progress=stages.next())
            values |= dict(zip(ERRORS, errors, strict=True))
        return {name: values[name].reshape(self.shape) for name in self.variables}

    def _told(self, found: CellResults) -> dict[str, np.ndarray]:
        told = {name: getattr(found, name) for name in OF_PENALTY}
        apart = found.phase - parts_of(self.system, self.eta).first_impact
        return told | {
            "impact_phase": found.phase,
            "impact_phase_error": apart - np.round(apart),
            "status": found.status,
        }


class _Stages:
    """Progress in cells where each cell takes several runs."""

    def __init__(self, progress: Callable[[int], None] | None, cells: int, count: int):
        self._progress, self._cells, self._count, self._stage = progress, cells, count, -1

    def next(self) -> Callable[[int], None] | None:
        """What to tell the progress of the next stage."""
        self._stage += 1
        before = self._stage * self._cells
        if self._progress is None:
            return None
        return lambda done: self._progress((before + done) // self._count)
