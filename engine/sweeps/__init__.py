"""Studies over many cells: the bifurcation diagram, the K–D plane, the time step.

`study` says what a study is and `eta`, `plane`, `step` what each of the three computes; `chunks` cuts it, `store`
keeps it, `runner` and `cluster` run it, `provenance` signs it. Results are xarray Datasets.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..methods import ExactPenalty, Method, Newmark, Reference
from ..model import System, whole
from ..motions.lyapunov import PERIODS_RANGE
from ..simulate import KEEP_LIMIT, PERIODS_LIMIT
from .axis import ascending
from .cache import kept
from .eta import COORDINATES, DIRECTIONS, EtaStudy
from .plane import PlaneStudy
from .progress import Progress
from .runner import Run, run
from .step import StepStudy
from .study import MEANING, OF_CELLS, Study

if TYPE_CHECKING:
    import xarray

__all__ = ["COORDINATES", "DIRECTIONS", "OVER", "Progress", "Run", "sweep_eta", "sweep_plane", "sweep_step"]

OVER = tuple(MEANING)
LEVELS = 20  # of refinement


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
    **how,
) -> "xarray.Dataset":
    """The bifurcation diagram over η (paper, Figure 3), or over another parameter.

    Parameters
    ----------
    system : System
    method : Reference, ExactPenalty or Newmark
    values : (n,) sequence
        Of the swept parameter, ascending.
    over : str
        ``eta``, ``K``, ``D``, ``steps`` or a constant of the system: `OVER` lists them.
    eta : float, optional
        Excitation frequency, where another parameter is swept.
    transient, sample : int
        Periods before the section is taken, and points of it.
    direction : {"rest", "up", "down"}
        From rest, or each value from the end of its neighbour below or above.
    coordinates : sequence of {"xi1", "v1", "xi2", "v2"}
        Of the section to keep.
    refine : int
        Levels of refinement: each halves the intervals at whose ends the motion differs.
    lyapunov : int
        Periods over which to average the largest Lyapunov exponent (some 8,000; reference and exact penalty); 0: none.
    **how
        See `Run`: where to keep the result, on which machines to run it. Or ``keep=True``: in the user's cache, under
        every number and the engine's sources, the least recently used dropped; then only ``progress`` and
        ``cancelled`` beside it.

    Returns
    -------
    xarray.Dataset
        Dimensions (over, ``sample``); see :mod:`.eta` for the variables.

    Raises
    ------
    ValueError, OSError, Cancelled
        See :func:`.runner.run`.
    """
    values = ascending(over, values)
    if over not in OVER:
        raise ValueError(f"over = {over!r} is no parameter that can be swept: give one of {', '.join(OVER)}")
    if over in OF_CELLS and not isinstance(method, Newmark if over == "steps" else (Newmark, ExactPenalty)):
        raise ValueError(f"the {method.name} method has no {over}: sweep another parameter, or give another solver")
    if over == "restitution" and not isinstance(method, Reference):
        raise ValueError(f"the {method.name} method has no impact law and so no restitution: sweep D instead")
    if direction not in DIRECTIONS:
        raise ValueError(f"direction = {direction!r} is not one of {', '.join(DIRECTIONS)}")
    if unknown := [name for name in coordinates if name not in COORDINATES]:
        raise ValueError(f"coordinate {unknown[0]!r} is not one of {', '.join(COORDINATES)}")
    if over != "eta" and eta is None:
        raise ValueError(f"a sweep over {over} needs an eta: give the excitation frequency")
    at = float(values[0]) if over == "eta" else eta
    more = {"over": over, "values": values, "direction": direction, "coordinates": tuple(coordinates)}
    more["refine"] = whole("refine", refine, 0, LEVELS, "give levels of refinement")
    if lyapunov:
        more["lyapunov"] = whole("lyapunov", lyapunov, *PERIODS_RANGE, "give periods to average over, or 0")
    return _found(EtaStudy(system, method, at, *_periods(transient, sample), **more), **how)


def sweep_plane(
    system: System,
    eta: float,
    K: Sequence[float],
    D: Sequence[float],
    *,
    steps: int | None = 2000,
    located: bool = False,
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
    transient, sample : int
        Periods before the motion is described, and periods described.
    parts : bool
        Also the exact penalty method beside Newmark, and the errors against the reference in three parts: three to
        ten times the time.
    **how
        See `Run`: where to keep the result, on which machines to run it. Or ``keep=True``: in the user's cache, under
        every number and the engine's sources, the least recently used dropped; then only ``progress`` and
        ``cancelled`` beside it.

    Returns
    -------
    xarray.Dataset
        Dimensions (``K``, ``D``); see :mod:`.plane` for the variables.

    Raises
    ------
    ValueError, OSError, Cancelled
        See :func:`.runner.run`.
    """
    K, D = ascending("K", K), ascending("D", D)
    if steps is None and located:
        raise ValueError("the exact penalty method has no step that could be located: give steps, or leave located out")
    first = float(K[0]), float(D[0])
    method = ExactPenalty(*first) if steps is None else Newmark(*first, steps, located=located)
    return _found(PlaneStudy(system, method, eta, *_periods(transient, sample), K=K, D=D, parts=parts), **how)


def sweep_step(
    system: System,
    eta: float,
    K: float,
    D: float,
    steps: Sequence[int],
    *,
    transient: int = 2000,
    sample: int = 50,
    **how,
) -> "xarray.Dataset":
    """Newmark's motion over the number of steps at one η, K and D (paper, Figure 14), the located step beside it.

    Parameters
    ----------
    system : System
    eta, K, D : float
    steps : (n,) sequence of int
        Steps per period, ascending.
    transient, sample : int
        Periods before the section is taken, and points of it.
    **how
        See `Run`: where to keep the result, on which machines to run it. Or ``keep=True``: in the user's cache, under
        every number and the engine's sources, the least recently used dropped; then only ``progress`` and
        ``cancelled`` beside it.

    Returns
    -------
    xarray.Dataset
        Dimensions (``steps``, ``scheme``), scheme 0 with the fixed and 1 with the located step; see :mod:`.step` for
        the variables.

    Raises
    ------
    ValueError, OSError, Cancelled
        See :func:`.runner.run`.
    """
    steps = ascending("steps", steps)
    study = StepStudy(system, Newmark(K, D, int(steps[0])), eta, *_periods(transient, sample), steps=steps)
    return _found(study, **how)


def _found(study: Study, *, keep: bool = False, **how) -> "xarray.Dataset":
    if keep:
        return kept(study, **how)
    return run(study, Run(**how))


def _periods(transient: int, sample: int) -> tuple[int, int]:
    return (
        whole("transient", transient, 0, PERIODS_LIMIT, "give the periods before the sample"),
        whole("sample", sample, 1, KEEP_LIMIT, "give the periods to describe"),
    )
