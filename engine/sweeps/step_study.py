"""The time-step study (paper, Figure 14): one motion with n steps per period, at fixed K and D.

A constant step misses each contact change by a part of a step, so that the section scatters. How fast that fades is
the observed order p in scatter ∝ n⁻ᵖ, the slope of a least-squares line through log scatter over log n. Beside each run
stands the one whose steps are cut at the contact changes (:func:`..methods.with_located_steps`), where
the contact law has such steps; and the error by the time step, this run − exact penalty, has an order too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.cells import CellResults, Cells
from vibroscope.engine.contact import stiffness_of_step
from vibroscope.engine.methods import Method, with_located_steps
from vibroscope.engine.model import COORDINATES
from vibroscope.engine.motions.section import scatter
from vibroscope.engine.result import Record
from vibroscope.engine.simulate import simulate
from vibroscope.engine.sweeps import variables as vocabulary
from vibroscope.engine.sweeps.errors import ReferenceMotion, reference_motion
from vibroscope.engine.sweeps.study import Study, start_of
from vibroscope.engine.sweeps.variables import StudyArray, Variable, status_variable, variables_of

PLOTTED = 2  # periods of a phase plot
INSTANTS = 500  # of each, at most
SCHEMES = {"fixed": 0, "located": 1}


@dataclass(frozen=True, eq=False, kw_only=True)
class StepStudy(Study):
    """A method with a time step over n at one η, K and D (paper, Figure 14), the step fixed and located.

    Raises
    ------
    ValueError
        If the steps of the method are located: they are half of the study of any other.

    Attributes
    ----------
    steps : (n,) ndarray
        Steps per period, ascending; the method's own have no effect.
    initial : (4,) tuple of float, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ of every run at τ = 0; rest, if not given.
    stiffness_of_step : float, optional
        s of K = s m/Δτ² (:func:`engine.stiffness_of_step`), if K follows the step, in place of the method's own: each
        number of steps has a K of its own, the array ``K`` of the result, and an exact penalty solution of its own.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, StepStudy, System, sweep
    >>> method = Newmark(2500, 8, 2000)
    >>> found = sweep(StepStudy(System(), method, 1.08, steps=[500, 1000, 2000], transient=200, sample=20))
    >>> found["spread"].dims, found["spread"].shape
    (('steps', 'scheme'), (3, 2))
    """

    steps: Sequence[int]
    initial: Sequence[float] | None = None
    stiffness_of_step: float | None = None
    kind: ClassVar[str] = "step"
    effort: ClassVar[int] = 10  # time goes by steps here, and the located step walks them all
    grid: ClassVar[tuple[str, ...]] = ("steps",)

    def __post_init__(self):
        super().__post_init__()
        self._set(initial=start_of(self.initial))
        if self.method.located:
            raise ValueError("located steps stand beside those of the study anyway: give status = 'start' or 'end'")
        if self.stiffness_of_step is not None:
            first = stiffness_of_step(self.system, self.eta, float(self.steps[0]), self.stiffness_of_step)
            self._set(method=replace(self.method, stiffness=first))

    @cached_property
    def schemes(self) -> dict[str, Method]:
        """The methods of `SCHEMES`: with its own steps, and with located ones."""
        return {"fixed": self.method, "located": with_located_steps(self.method)}

    @property
    def options(self) -> dict[str, object]:
        """The start, where it is not rest, and how K follows the step, where it does."""
        start = {} if self.initial is None else {"initial": list(self.initial)}
        return start if self.stiffness_of_step is None else start | {"stiffness_of_step": self.stiffness_of_step}

    @property
    def shown(self) -> tuple[str, str]:
        """The displacement and the velocity of which the sections are kept: of the observed body."""
        return COORDINATES[2 * self.system.observed_body - 2 :][:2]

    @property
    def cells(self) -> int:
        """Runs: each number of steps fixed and located."""
        return len(self.schemes) * super().cells

    @cached_property
    def arrays(self) -> dict[str, StudyArray]:
        """The axes and the reference."""
        joint_damping = self._reference.joint_damping
        own = self._numbers_at(self.steps)
        stiffness = {"K": StudyArray(("steps",), own["stiffness"], vocabulary.SWEPT["K"])} if own else {}
        return (
            super().arrays
            | stiffness
            | {
                "scheme": StudyArray(("scheme",), np.arange(len(self.schemes), dtype=np.int8), vocabulary.SCHEME),
                "sample": StudyArray(("sample",), np.arange(self.sample), vocabulary.SAMPLE),
                "error_joint_damping": StudyArray((), joint_damping, vocabulary.JOINT_DAMPING),
            }
        )

    @property
    def _reference(self) -> ReferenceMotion:
        return reference_motion(self.system, self.eta, self.initial)

    def cells_at(self, points, **more):
        """Cells with these numbers of steps, each from the start of the study."""
        cells = super().cells_at(points, **self._numbers_at(points["steps"]), **more)
        return cells if self.initial is None else replace(cells, initial=np.tile(self.initial, (len(cells), 1)))

    def _numbers_at(self, steps: np.ndarray) -> dict[str, np.ndarray]:
        """K at these numbers of steps, where it follows them."""
        if self.stiffness_of_step is None:
            return {}
        scale = self.stiffness_of_step
        return {"stiffness": np.array([stiffness_of_step(self.system, self.eta, n, scale) for n in steps.ravel()])}

    @property
    def inner_lengths(self) -> dict[str, int]:
        """Length of every dimension but that of the axis."""
        return super().inner_lengths | {"scheme": len(self.schemes), "instant": PLOTTED * INSTANTS + 1}

    @property
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell."""
        dims = ("steps", "scheme")
        found = variables_of(vocabulary.PENALTY_MOTION | vocabulary.SCATTER | vocabulary.ERRORS, dims)
        found |= {name: Variable((*dims, "instant"), "f8", vocabulary.PHASE_PLOT.format(name)) for name in COORDINATES}
        found["tau"] = Variable((*dims, "instant"), "f8", vocabulary.TIME)
        for name in self.shown:
            found[f"{name}_section"] = Variable((*dims, "sample"), "f8", vocabulary.SECTION.format(name))
        return found | {"status": status_variable(dims)}

    def conclusions(self, values) -> dict[str, StudyArray]:
        """Observed orders over the steps that are known."""
        found = {}
        for name, text in vocabulary.ORDERED.items():
            pairs = [observed_order(self.steps, values[name][:, scheme]) for scheme in range(len(self.schemes))]
            order, error = np.array(pairs).T
            found[f"order_of_{name}"] = StudyArray(("scheme",), order, vocabulary.ORDER.format(text))
            found[f"order_of_{name}_error"] = StudyArray(("scheme",), error, vocabulary.ORDER_ERROR)
        return found

    def compute(self, batch=None, *, before=None, threads=None, progress=None, cancelled=None):
        """The variables of a batch of cells."""
        points = self.points(batch)
        common = {"threads": threads, "cancelled": cancelled}
        follows = self.stiffness_of_step is not None
        models = points["steps"] if follows else points["steps"][:1]  # all have the same K unless it follows
        limits = replace(self.cells_at({"steps": models}), method=self.method.limit, steps=None)
        exact = self.run(limits, **common)
        exact = exact if follows else _repeated(exact, len(points["steps"]))
        columns = []
        for done, method in enumerate(self.schemes.values(), start=1):
            cells = replace(self.cells_at(points), method=method)
            found = self.run(cells, **common)
            errors = self._reference.errors(cells, found, exact, **common)
            values = vars(found) | dict(zip(vocabulary.ERRORS, errors, strict=True))
            values |= {f"{name}_section": found.section[:, :, COORDINATES.index(name)] for name in self.shown}
            columns.append(values | phase_plots(cells, found))
            if progress is not None:
                progress(done * len(points["steps"]))
        for values in columns:  # `found` is that of the located steps, the last of the schemes
            values["scatter"] = self._scatter(values["section"], found, exact)
        return {name: np.stack([values[name] for values in columns], axis=1) for name in self.variables}

    def _scatter(self, sections: np.ndarray, located: CellResults, exact: CellResults) -> list[float]:
        """Scatter about the points of the cycle of the located run, or of exact penalty where it has none.

        The period of a run with constant steps is no measure: its scatter can hide a cycle, and repeat itself by
        chance.
        """
        without_step = np.where(exact.period > 0, exact.period, exact.near_period)
        periods = np.maximum(np.where(located.period > 0, located.period, without_step), 1).tolist()
        body = self.system.observed_body
        return [scatter(section, period, body) for section, period in zip(sections, periods, strict=True)]


def _repeated(results: CellResults, n: int) -> CellResults:
    return CellResults(**{name: np.repeat(column, n, axis=0) for name, column in vars(results).items()})


def phase_plots(cells: Cells, found: CellResults) -> dict[str, np.ndarray]:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ and τ of each cell over the periods that follow its sample, each (n, instants)."""
    plots = {name: np.full((len(cells), PLOTTED * INSTANTS + 1), np.nan) for name in (*COORDINATES, "tau")}
    for i in np.flatnonzero(found.ok):
        run = simulate(
            cells.system_of(i),
            cells.eta[i],
            cells.method_of(i),
            periods=PLOTTED,
            keep=PLOTTED,
            initial=found.end[i],
            record=Record(PLOTTED, INSTANTS),
        )
        if not run.ok:
            continue
        (x1, x2), (v1, v2) = run.trajectory.displacement, run.trajectory.velocity
        for name, values in zip((*COORDINATES, "tau"), (x1, v1, x2, v2, run.trajectory.time), strict=True):
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
    usable = np.isfinite(sizes) & (sizes > 0)
    x, y = np.log(steps[usable]), np.log(sizes[usable])
    if len(x) < 2:
        return np.nan, np.nan
    x = x - x.mean()
    slope = (x @ y) / (x @ x)
    rest = y - y.mean() - slope * x
    error = np.sqrt((rest @ rest) / (len(x) - 2) / (x @ x)) if len(x) > 2 else np.nan
    return -slope, error
