"""The K–D plane (paper, Figures 11 and 12): the motion with each pair of contact stiffness and damping.

Beside each cell of Newmark's method stands the same cell without a time step: what differs between the two is an
artefact of Δτ. The paper's two criteria are `period` (bifurcated or not) and `longest_contact_steps` (below 30, it
takes a contact for a sudden impact); the third, which it names and leaves undone, is `impact_phase_error`, the instant
of impact against the reference's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import ClassVar

import numpy as np
from vibroscope.engine.cells import CellResults
from vibroscope.engine.contact import equal_restitution_damping
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.errors import reference_motion
from vibroscope.engine.sweeps.study import Study
from vibroscope.engine.sweeps.variables import StudyArray, Variable, status_variable, variables_of


@dataclass(frozen=True, eq=False, kw_only=True)
class PlaneStudy(Study):
    """The K–D plane at one η (paper, Figures 11 and 12): cells of a penalty method, whose own K and D have no effect.

    Attributes
    ----------
    K, D : (n,), (m,) ndarray
        Contact stiffness and damping, ascending, usually evenly spaced in the logarithm.
    parts : bool
        Also the exact penalty method beside one with a time step, and the errors against the reference in three parts:
        three to ten times the time.
    only : tuple of str
        Names of the variables to compute, beside ``status``; empty: all. Runs that none of them needs are left out.
        ``exact_error``, the exact penalty method's own error, and ``end``, from which kinds of motion are judged, are
        computed only where they are named here, the first with ``error``.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, PlaneStudy, System, sweep
    >>> plane = PlaneStudy(System(), Newmark(1, 1, 500), 2.76, K=[2000, 12000], D=[8, 18], transient=200, sample=20)
    >>> found = sweep(plane)
    >>> found["error"].dims, found["exact_period"].shape
    (('K', 'D'), (2, 2))
    """

    K: Sequence[float]
    D: Sequence[float]
    transient: int = 450
    parts: bool = True
    only: Sequence[str] = ()
    kind: ClassVar[str] = "plane"
    grid: ClassVar[tuple[str, ...]] = ("K", "D")

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {"parts": self.parts}

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell."""
        dims = ("K", "D")
        own = variables_of(vocabulary.PENALTY_MOTION | vocabulary.IMPACT_PHASE | vocabulary.PHASE_ERROR, dims)
        found = dict(own)
        if not self.method.has_step:
            del found["longest_contact_steps"]
        if self.method.counts_solutions:
            found |= variables_of(vocabulary.SOLUTION_COUNTS, dims)
        if self.parts:
            found |= variables_of(vocabulary.ERRORS, dims)
        if self.parts and self.method.has_step:
            del own["longest_contact_steps"]
            if "exact_error" in self.only:
                own["error"] = found["error"]
            found |= {
                f"exact_{name}": variable._replace(description=vocabulary.EXACT.format(variable.description))
                for name, variable in own.items()
            }
            found["exact_status"] = status_variable(dims, vocabulary.EXACT.format(vocabulary.STATUS))
        if "end" in self.only:
            found["end"] = Variable((*dims, "component"), "f8", vocabulary.END)
        if self.only:
            found = {name: found[name] for name in self.only if name != "status"}
        return found | {"status": status_variable(dims, f"{vocabulary.STATUS}; diverged: blown up")}

    @cached_property
    def arrays(self) -> dict[str, StudyArray]:
        """The axes, the curve of equal restitution, and the reference."""
        reference = reference_motion(self.system, self.eta)
        curve = equal_restitution_damping(self.system, self.K)
        about_reference = {
            "reference_period": np.int32(reference.table.period),
            "reference_impacts_per_period": reference.impacts_per_period,
            "reference_impact_phase": reference.first_impact,
        }
        return (
            super().arrays
            | {"D_equal_restitution": StudyArray(("K",), curve, vocabulary.EQUAL_RESTITUTION)}
            | {name: StudyArray((), value, vocabulary.REFERENCE[name]) for name, value in about_reference.items()}
            | {"error_joint_damping": StudyArray((), reference.joint_damping, vocabulary.JOINT_DAMPING)}
        )

    def compute(self, batch=None, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of a batch of cells."""
        points = self.points(batch)
        cells = self.cells_at(points)
        names = self.variables
        beside = any(name.startswith("exact_") for name in names)
        split = "error_time_step" in names
        runs = 1 + beside + ("error" in names) + ("exact_error" in names)
        passes = _Passes(progress, len(cells), runs)
        common = {"threads": threads, "cancelled": cancelled}
        found = exact = self.run(cells, **common, progress=passes.next())
        values = self._described(found)
        if beside:
            without_step = replace(cells, method=self.method.limit, steps=None)
            exact = self.run(without_step, **common, progress=passes.next())
            values |= {f"exact_{name}": column for name, column in self._described(exact).items()}
        if "error" in names:
            errors = partial(reference_motion(self.system, self.eta).errors, **common)
            found_errors = errors(cells, found, exact if split else None, progress=passes.next())
            values |= dict(zip(vocabulary.ERRORS, found_errors, strict=True))
            if "exact_error" in names:
                values["exact_error"] = errors(without_step, exact, None, progress=passes.next())[0]
        return self.in_shape(values, points)

    def _described(self, found: CellResults) -> dict[str, np.ndarray]:
        if "impact_phase_error" not in self.variables:
            return vars(found)
        apart = found.impact_phase - reference_motion(self.system, self.eta).first_impact
        return vars(found) | {"impact_phase_error": apart - np.round(apart)}


class _Passes:
    """Progress in cells where each cell takes several runs."""

    def __init__(self, progress: Callable[[int], None] | None, cells: int, count: int) -> None:
        self._progress, self._cells, self._count, self._number = progress, cells, count, -1

    def next(self) -> Callable[[int], None] | None:
        """The progress callable of the next run."""
        self._number += 1
        before = self._number * self._cells
        if self._progress is None:
            return None
        return lambda done: self._progress((before + done) // self._count)
