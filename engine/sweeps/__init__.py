"""Studies over many cells: bifurcation diagram, K–D plane, time step, steps without a solution, basins of attraction.

`study` defines a study; the five are `eta_study`, `plane_study`, `step_study`, `no_solution_study`, `basin_study`.
`growth` runs a study batch by batch (`batches`), on this machine or on a `cluster`, and holds the results in `memory`
or in a `store`, which lies in a folder or at a URL (`store_location`). `cache` keeps studies for the explorer.
`digest` and `provenance` identify the code and the numbers that a result comes from. Results are xarray Datasets.

All functions take further keywords that do not change the result: those of `RunOptions`, for where to keep the
result and on which machines to run the study. With ``keep=True`` it goes to the user's cache, under every number and
the digest of the engine's code; the least recently used result is dropped, and the only further keywords are
``progress`` and ``cancelled``. The functions raise what :func:`.growth.grow` raises.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .. import laws
from ..methods import Method, Newmark, TimeStepping
from ..model import System
from .axis import ascending_values, start_of
from .basin_difference import BasinDifference, basin_difference, difference_of
from .basin_study import BasinStudy
from .batches import COARSEST, nearest_known
from .cache import cached_dataset, grow_cached, grow_picture
from .codes import KIND_FLAGS, MISSING
from .digest import engine_digest
from .eta_study import COORDINATES, DIRECTIONS, OVER, EtaStudy
from .growth import Partial, RunOptions, grow, run
from .memory import empty_values
from .motion_kinds import CellKind, judge_cells, judge_runs, kind_words, known_kinds, unknown_kinds
from .no_solution_study import NoSolutionStudy
from .plane_study import PlaneStudy
from .progress import Progress
from .start_plane import AXES, StartPlane
from .step_study import SCHEMES, StepStudy
from .store import check_store
from .study import Study

if TYPE_CHECKING:
    import xarray

__all__ = [
    "AXES",
    "COARSEST",
    "COORDINATES",
    "DIRECTIONS",
    "KIND_FLAGS",
    "MISSING",
    "OVER",
    "SCHEMES",
    "BasinDifference",
    "BasinStudy",
    "CellKind",
    "EtaStudy",
    "NoSolutionStudy",
    "Partial",
    "PlaneStudy",
    "Progress",
    "RunOptions",
    "StartPlane",
    "StepStudy",
    "basin_difference",
    "check_store",
    "difference_of",
    "empty_values",
    "engine_digest",
    "grow",
    "grow_cached",
    "grow_picture",
    "judge_cells",
    "judge_runs",
    "kind_words",
    "known_kinds",
    "nearest_known",
    "sweep_basin",
    "sweep_eta",
    "sweep_no_solution",
    "sweep_plane",
    "sweep_step",
    "unknown_kinds",
]


def sweep_eta(
    system: System,
    method: Method,
    values: Sequence[float],
    *,
    over: str = "eta",
    eta: float | None = None,
    transient: int = 2000,
    sample: int = 50,
    direction: str = "rest",
    coordinates: Sequence[str] = ("xi1", "xi2"),
    refine: int = 0,
    lyapunov: int = 0,
    initial: Sequence[float] | None = None,
    **how,
) -> "xarray.Dataset":
    """The bifurcation diagram over η (paper, Figure 3), or over another parameter.

    Parameters
    ----------
    system : System
    method : Reference, ExactPenalty, Newmark or TimeStepping
    values : (n,) sequence
        Of the swept parameter, ascending.
    over : str
        ``eta``, ``K``, ``D``, ``steps`` or a constant of the system: `OVER` lists them.
    eta : float, optional
        Excitation frequency, where another parameter is swept.
    transient, sample : int
        Periods before the section is taken, and points of it.
    direction : {"rest", "up", "down"}
        From rest (or from ``initial``), or each value from the end of its neighbour below or above.
    coordinates : sequence of {"xi1", "v1", "xi2", "v2"}
        Of the section to keep.
    refine : int
        Levels of refinement: each halves the intervals at whose ends the motion differs.
    lyapunov : int
        Periods over which to average the largest Lyapunov exponent (some 8,000; reference and exact penalty); 0: none.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of each value, in place of rest; not for a continued or refined diagram.
    **how
        Where to keep the result and how to run it: see :mod:`engine.sweeps`.

    Returns
    -------
    xarray.Dataset
        Dimensions (over, ``sample``); see :mod:`.sweeps.eta_study` for the variables.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        If ``out`` cannot be written, or no Dask scheduler answers.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, sweep_eta
    >>> found = sweep_eta(System(), Reference(), [2.7, 2.8, 2.9], transient=1000, sample=20)
    >>> found["period"].values.tolist(), found["xi2"].dims
    ([1, 2, 2], ('eta', 'sample'))
    """
    more = {"over": over, "values": values, "direction": direction, "coordinates": coordinates}
    if initial is not None:
        if direction != "rest" or refine:
            raise ValueError("an initial state is for each value its own start: give direction='rest' and no refine")
        more["initial"] = np.tile(start_of(initial), (len(values), 1))
    study = EtaStudy(system, method, eta, transient, sample, **more, refine=refine, lyapunov=lyapunov)
    return _run(study, **how)


def sweep_plane(
    system: System,
    eta: float,
    K: Sequence[float],
    D: Sequence[float],
    *,
    steps: int | None = 2000,
    located: bool = False,
    scheme: Newmark | TimeStepping | None = None,
    transient: int = 450,
    sample: int = 50,
    parts: bool = True,
    **how,
) -> "xarray.Dataset":
    """The K–D plane at one η (paper, Figures 11 and 12).

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    K, D : (n,), (m,) sequence
        Contact stiffness and damping, ascending, usually evenly spaced in the logarithm.
    steps : int or None
        Newmark's steps per period; None for the exact penalty method, which has none.
    located : bool
        Cut Newmark's steps at the contact changes.
    scheme : Newmark or TimeStepping, optional
        What a code has (integrator, contact status, law), in place of ``located``; its K, D and n have no effect.
    transient, sample : int
        Periods before the motion is described, and periods described.
    parts : bool
        Also the exact penalty method beside Newmark, and the errors against the reference in three parts: three to
        ten times the time.
    **how
        Where to keep the result and how to run it: see :mod:`engine.sweeps`.

    Returns
    -------
    xarray.Dataset
        Dimensions (``K``, ``D``); see :mod:`.sweeps.plane_study` for the variables.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        If ``out`` cannot be written, or no Dask scheduler answers.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept.

    Examples
    --------
    >>> from vibroscope.engine import System, sweep_plane
    >>> found = sweep_plane(System(), 2.76, K=[2000, 12000], D=[8, 18], steps=500, transient=200, sample=20)
    >>> found["error"].dims, found["exact_period"].shape
    (('K', 'D'), (2, 2))
    """
    K, D = ascending_values("K", K), ascending_values("D", D)
    if steps is None and located:
        raise ValueError("the exact penalty method has no step that could be located: give steps, or leave located out")
    first = float(K[0]), float(D[0])
    method = _with_numbers(scheme, *first, steps or 2000, located)
    method = method.limit if steps is None else method
    return _run(PlaneStudy(system, method, eta, transient, sample, K=K, D=D, parts=parts), **how)


def sweep_step(
    system: System,
    eta: float,
    K: float | None,
    D: float,
    steps: Sequence[int],
    *,
    stiffness_of_step: float | None = None,
    scheme: Newmark | TimeStepping | None = None,
    transient: int = 2000,
    sample: int = 50,
    initial: Sequence[float] | None = None,
    **how,
) -> "xarray.Dataset":
    """The motion over the number of steps at one η, K and D (paper, Figure 14), the located step beside it.

    Parameters
    ----------
    system : System
    eta, K, D : float
        K is None where it follows the step.
    steps : (n,) sequence of int
        Steps per period, ascending.
    stiffness_of_step : float, optional
        s of K = s m/Δτ², in place of K: each number of steps has a K of its own, the array ``K`` of the result.
    scheme : Newmark or TimeStepping, optional
        What a code has (integrator, contact status, law), its steps not located; its K, D and n have no effect. By
        default Newmark's method.
    transient, sample : int
        Periods before the section is taken, and points of it.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ of every run at τ = 0, the reference's included, in place of rest.
    **how
        Where to keep the result and how to run it: see :mod:`engine.sweeps`.

    Returns
    -------
    xarray.Dataset
        Dimensions (``steps``, ``scheme``), scheme 0 with the fixed and 1 with the located step; see
        :mod:`.sweeps.step_study` for the variables.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        If ``out`` cannot be written, or no Dask scheduler answers.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept.

    Examples
    --------
    >>> from vibroscope.engine import System, sweep_step
    >>> found = sweep_step(System(), 1.08, 2500, 8, [500, 1000, 2000], transient=200, sample=20)
    >>> found["spread"].dims, found["spread"].shape
    (('steps', 'scheme'), (3, 2))
    """
    steps = ascending_values("steps", steps)
    if stiffness_of_step is not None:
        if K is not None:
            raise ValueError(f"K = {K!r} and stiffness_of_step both give the contact stiffness: leave K at None")
        K = laws.stiffness_of_step(system, eta, float(steps[0]), stiffness_of_step)
    method = _with_numbers(scheme, K, D, int(steps[0]))
    own = {"steps": steps, "initial": initial, "stiffness_of_step": stiffness_of_step}
    return _run(StepStudy(system, method, eta, transient, sample, **own), **how)


def sweep_no_solution(
    system: System,
    eta: float,
    K: Sequence[float],
    D: float,
    steps: Sequence[int],
    *,
    scheme: TimeStepping | None = None,
    transient: int = 150,
    sample: int = 50,
    **how,
) -> "xarray.Dataset":
    """Steps without a solution over K and the steps per period, with the contact status at the end of steps.

    Parameters
    ----------
    system : System
    eta, D : float
    K, steps : (n,), (m,) sequence
        Contact stiffness and steps per period, ascending.
    scheme : TimeStepping, optional
        Integrator, law, and what is done without a solution; its K, D and n have no effect. By default Newmark's method
        that stops.
    transient, sample : int
        Their sum is the number of periods that are run; the motion is described by the sample.
    **how
        Where to keep the result and how to run it: see :mod:`engine.sweeps`.

    Returns
    -------
    xarray.Dataset
        Dimensions (``K``, ``steps``); see :mod:`.sweeps.no_solution_study` for the variables.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        If ``out`` cannot be written, or no Dask scheduler answers.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept.

    Examples
    --------
    >>> from vibroscope.engine import System, sweep_no_solution
    >>> found = sweep_no_solution(System(), 2.76, [500, 5000], 18, [100, 400], transient=20, sample=10)
    >>> found["steps_without_solution"].dims, bool(found["steps_without_solution"].any())
    (('K', 'steps'), True)
    """
    K, steps = ascending_values("K", K), ascending_values("steps", steps)
    scheme = TimeStepping(1.0, 0.0, 1000, status="end") if scheme is None else scheme
    method = _with_numbers(scheme, float(K[0]), D, int(steps[0]))
    return _run(NoSolutionStudy(system, method, eta, transient, sample, K=K, steps=steps), **how)


def sweep_basin(
    system: System,
    eta: float,
    method: Method,
    x: Sequence[float],
    y: Sequence[float],
    *,
    axes: Sequence[str] = ("xi2", "v2"),
    start: Sequence[float] | None = None,
    phase: float = 0.0,
    transient: int = 1800,
    sample: int = 256,
    **how,
) -> "xarray.Dataset":
    """Basins of attraction in a plane of starts: which motion each of them leads to.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference, ExactPenalty, Newmark or TimeStepping
    x, y : (n,), (m,) sequence
        Values along the axes, ascending.
    axes : (str, str)
        Two of ``xi1``, ``v1``, ``xi2``, ``v2``, and ``phase``, the share of the excitation period at which a run begins
        (reference, and exact penalty of the first law).
    start : (4,) sequence, optional
        The initial numbers that are not on an axis, of ξ₁, ξ₁′, ξ₂, ξ₂′; by default those of rest.
    phase : float
        Of every start where it is not on an axis, 0 to 1.
    transient, sample : int
        Periods that a cell runs, and of these the last ones, by which its motion is recognised, where no trapping
        region decides before.
    **how
        Where to keep the result and how to run it: see :mod:`engine.sweeps`.

    Returns
    -------
    xarray.Dataset
        Dimensions of the axes; see :mod:`.sweeps.basin_study` for the variables. `motion` numbers the motions by their
        shares.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        If ``out`` cannot be written, or no Dask scheduler answers.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept.
    """
    if len(axes) != 2:
        raise ValueError(f"a plane of starts has two axes, not {len(axes)}: give two of {', '.join(AXES)}")
    x, y = (ascending_values(name, values) for name, values in zip(axes, (x, y), strict=True))
    spans = tuple((float(values[0]), float(values[-1])) for values in (x, y))
    plane = StartPlane(tuple(axes), spans, start_of(start) or system.rest, phase)
    return _run(BasinStudy(system, method, eta, transient, sample, plane=plane, x=x, y=y), **how)


def _with_numbers(
    scheme: Newmark | TimeStepping | None, K: float, D: float, steps: int, located: bool = False
) -> Newmark | TimeStepping:
    """A method with these numbers: the scheme, or Newmark's."""
    if scheme is None:
        return Newmark(K, D, steps, located=located)
    return replace(scheme, stiffness=K, damping=D, steps=steps)


def _run(study: Study, *, keep: bool = False, **how) -> "xarray.Dataset":
    if keep:
        return cached_dataset(study, **how)
    return run(study, RunOptions(**how))
