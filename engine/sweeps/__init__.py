"""Studies over many cells: bifurcation diagram, K–D plane, time step, steps without a solution, basins of attraction.

`study` defines a study; the five are `eta_study`, `plane_study`, `step_study`, `no_solution_study`, `basin_study`.
`growth` runs a study batch by batch (`batches`), on this machine or on a `cluster`, and holds the results in `memory`
or in a `store`, which lies in a folder or at a URL (`store_location`). `cache` keeps studies for the explorer.
`digest` and `provenance` identify the code and the numbers that a result comes from. Results are xarray Datasets.
"""

from typing import TYPE_CHECKING

from vibroscope.engine.model import COORDINATES
from vibroscope.engine.sweeps.basin_motions import AXES, StartPlane
from vibroscope.engine.sweeps.basin_study import BasinDifference, BasinStudy, basin_difference, difference_of
from vibroscope.engine.sweeps.batches import COARSEST, Progress, empty_values, nearest_known
from vibroscope.engine.sweeps.cache import cached_dataset, grow_cached, grow_picture
from vibroscope.engine.sweeps.codes import KIND_FLAGS, MISSING
from vibroscope.engine.sweeps.digest import engine_digest
from vibroscope.engine.sweeps.eta_study import DIRECTIONS, OVER, EtaStudy
from vibroscope.engine.sweeps.growth import Partial, RunOptions, grow, run
from vibroscope.engine.sweeps.motion_kinds import (
    CellKind,
    grow_kinds,
    judge_runs,
    kind_words,
    known_kinds,
    unknown_kinds,
)
from vibroscope.engine.sweeps.no_solution_study import NoSolutionStudy
from vibroscope.engine.sweeps.plane_study import PlaneStudy
from vibroscope.engine.sweeps.step_study import SCHEMES, StepStudy
from vibroscope.engine.sweeps.store import check_store
from vibroscope.engine.sweeps.study import Study

if TYPE_CHECKING:
    import xarray


def sweep(study: Study, *, keep: bool = False, **how) -> "xarray.Dataset":
    """Run a study.

    Parameters
    ----------
    study : Study
        What is swept and what is run: `EtaStudy`, `PlaneStudy`, `StepStudy`, `NoSolutionStudy` or `BasinStudy`.
    keep : bool
        Keep the result in the user's cache, under every number and the digest of the engine's code; the least recently
        used result is dropped. The only further keywords are ``progress`` and ``cancelled`` then.
    **how
        Those of `RunOptions`, which do not change the result: where to keep it, and on which machines to run it.

    Returns
    -------
    xarray.Dataset
        Its dimensions are the axes of the study; the module of each study names the variables.

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
    >>> from vibroscope.engine import ExactPenalty, PlaneStudy, System, sweep
    >>> plane = PlaneStudy(System(), ExactPenalty(1, 1), 2.76, K=[2000, 12000], D=[18], transient=200, parts=False)
    >>> sweep(plane)["period"].shape
    (2, 1)
    """
    return cached_dataset(study, **how) if keep else run(study, RunOptions(**how))
