"""Steps without a solution over K and Δτ: where "contact does not converge" in a code that iterates the contact status.

With the contact status from the end of the step, neither status may agree with its own end, since the damper's force
jumps where the bodies touch (docs/theory/penalty.md). A cell counts such steps over its whole run, and those with two
solutions; a run that stops at the first one says after how many periods.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from vibroscope.engine.result import STATUSES, Status
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.study import Study
from vibroscope.engine.sweeps.variables import Variable, status_variable, variables_of

_STOPPED = STATUSES.index(Status.WITHOUT_SOLUTION)


@dataclass(frozen=True, eq=False, kw_only=True)
class NoSolutionStudy(Study):
    """Steps without a solution over K and the steps per period, at one η and the method's D.

    Attributes
    ----------
    K, steps : (n,), (m,) ndarray
        Contact stiffness and steps per period, ascending; the method's own have no effect. ``transient`` and ``sample``
        are run; the motion is described by the sample.

    Examples
    --------
    >>> from vibroscope.engine import NoSolutionStudy, System, TimeStepping, sweep
    >>> method = TimeStepping(500, 18, 100, status="end")
    >>> study = NoSolutionStudy(System(), method, 2.76, K=[500, 5000], steps=[100, 400], transient=20, sample=10)
    >>> found = sweep(study)
    >>> found["steps_without_solution"].dims, bool(found["steps_without_solution"].any())
    (('K', 'steps'), True)
    """

    K: Sequence[float]
    steps: Sequence[int]
    transient: int = 150
    kind: ClassVar[str] = "no-solution"
    effort: ClassVar[int] = 10  # time goes by steps here
    grid: ClassVar[tuple[str, ...]] = ("K", "steps")

    def __post_init__(self):
        super().__post_init__()
        if not self.method.counts_solutions:
            raise ValueError(
                "each step has one solution: give a method that takes the contact status from the end of steps, "
                "TimeStepping with status = 'end'"
            )

    @property
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell."""
        dims = tuple(self.axes)
        return variables_of(vocabulary.SOLUTIONS, dims) | {"status": status_variable(dims)}

    def compute(self, batch=None, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of a batch of cells."""
        points = self.points(batch)
        cells = self.cells_at(points)
        how = {"threads": threads, "progress": progress, "cancelled": cancelled}
        found = self.run(cells, coordinates=(2,), **how)
        until = np.where(found.status == _STOPPED, found.steps_taken / cells.steps_each(), np.nan)
        return self.in_shape(vars(found) | {"periods_until_stopped": until}, points)
