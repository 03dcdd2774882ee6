"""The K–D plane (paper, Figures 11 and 12): what each pair of contact stiffness and damping makes of the motion.

Beside each cell of Newmark's method stands the same cell without a time step: what differs between the two is an
artefact of Δτ. The paper's two criteria are `period` (bifurcated or not) and `longest_contact_steps` (below 30, it
takes a contact for a sudden impact); the third, which it names and leaves undone, is `impact_phase_error`, the instant
of impact against the reference's.

The curve of equal restitution: the relative motion in contact is a damped oscillation of ω_c = √(K(1 + 1/μ)) and ζ =
D(1 + 1/μ)/ω_c, half a turn of which returns the share e(ζ) = exp(−πζ/√(1 − ζ²)) of the closing speed. Solved for the D
that returns e, D = ζ(e) √(K μ/(1 + μ)) with ζ(e) = −ln e/√(π² + ln² e).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..batch import run_cells
from ..cells import CellResults
from ..methods import ExactPenalty, Newmark
from ..model import System
from .chunks import Chunk
from .parts import parts_of
from .study import STATUS_FLAGS, Study, Variable, Whole

DESCRIBED = {
    "period": ("i4", "excitation periods until the motion repeats itself; 0: aperiodic"),
    "near_period": ("i4", "the same, scatter within 3 % of the section's size forgiven; 0: aperiodic"),
    "impacts_per_period": ("f8", "contacts that begin per excitation period"),
    "contact_share": ("f8", "share of the time in contact"),
    "longest_contact": ("f8", "longest contact, in units of tau"),
    "longest_contact_steps": ("f8", "longest contact in time steps"),
    "spread": ("f8", "standard deviation of xi2 over the section"),
}
AGAINST_REFERENCE = {
    "impact_phase": "instant of the first impact in the last cycle, as a share of T",
    "impact_phase_error": "the same less the reference's, between -1/2 and 1/2",
}
ERRORS = {
    "error": "penalty less reference: rms of both displacements over that of the reference",
    "error_time_step": "its part by the time step, Newmark less exact penalty",
    "error_regularisation": "its part by K and D, exact penalty less reference with derived joint damping",
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
        own = {name: Variable(dims, kind, meaning) for name, (kind, meaning) in DESCRIBED.items()}
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
        told = {name: getattr(found, name) for name in DESCRIBED}
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


def equal_restitution_damping(system: System, stiffness: np.ndarray) -> np.ndarray:
    """D at which a single contact of stiffness K returns the share e of the closing speed; D ≥ 0, no unit.

    Parameters
    ----------
    stiffness : array_like
        K.
    """
    e = system.restitution
    ratio = 1.0 if e == 0 else -math.log(e) / math.hypot(math.pi, math.log(e))
    return ratio * np.sqrt(np.asarray(stiffness) * system.mass_share)
