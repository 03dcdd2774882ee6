"""The difference of a penalty solution from the reference under a load, and its parts (Eq. (53))."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.grid import about_rest, rms
from vibroscope.engine.divergence.parts import Difference, DifferenceSeries, PerSolution, known, part_names
from vibroscope.engine.load import Load
from vibroscope.engine.methods import ExactPenalty, Reference, TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.result import Response
from vibroscope.engine.simulate import simulate_load, under_load
from vibroscope.engine.transients.run import CYCLE, FREE_CYCLES, Instants, Transient, samples_of, transient

COMPARED_SAMPLES = 20_000  # of a run, at most so many steps of which are compared


@dataclass(frozen=True)
class TransientDifference:
    """Outcome of :func:`engine.transient_difference`.

    Attributes
    ----------
    penalty, reference : Transient
    exact : Transient
        The penalty solution without a time step: what its K and D give.
    series : DifferenceSeries
        All four solutions at steps of the penalty solution, from τ = 0 on: no shifts, since all begin at once.
    """

    penalty: Transient
    reference: Transient
    exact: Transient
    series: DifferenceSeries

    @property
    def difference(self) -> Difference:
        """Its size and that of each part: rms of the displacements over the run, relative to the reference."""
        series, run = self.series, self.reference.response
        parts = {name: series.relative(getattr(series, name)) for name in part_names(run.system, run.method)}
        return Difference("displacements", series.relative(series.total), known(parts), law=self.law)

    @property
    def law(self) -> str:
        """The contact law of the penalty solution."""
        return self.penalty.response.method.law


def transient_difference(
    system: System,
    load: Load,
    penalty: TimeStepping | ExactPenalty,
    reference: Reference | None = None,
    *,
    free: float = FREE_CYCLES * CYCLE,
    initial: Sequence[float] | None = None,
    cancelled: Poll | None = None,
) -> TransientDifference:
    """Run a penalty solution and the reference under a load, and split their difference into its parts.

    Parameters
    ----------
    system, load, free, initial, cancelled
        As those of :func:`engine.transient`.
    penalty : TimeStepping or ExactPenalty
    reference : Reference, optional

    Returns
    -------
    TransientDifference

    Raises
    ------
    ValueError
        As :func:`engine.transient`, and if one of the four solutions ends early.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Load, Newmark, System, transient_difference
    >>> body = System(wall=True, d1=0.05, clearance=0.5)
    >>> found = transient_difference(body, Load.half_sine(-1.0, 3.0), Newmark(1000, 7, 400))
    >>> found.difference.largest, found.series.residual < 1e-12
    ('regularisation', True)
    """
    own = Reference() if reference is None else reference
    if penalty.rigid:
        raise ValueError(
            "penalty is a reference: give a penalty solution, whose difference from the reference is split"
        )
    of_own = {"free": free, "initial": initial, "cancelled": cancelled}
    first, second = transient(system, load, penalty, **of_own), transient(system, load, own, **of_own)
    without_step = transient(system, load, penalty.limit, **of_own) if penalty.has_step else first
    methods = PerSolution(penalty, penalty.limit, Reference("derived", own.threshold), own)
    driven, stepped = under_load(system, load, penalty, free)
    record = samples_of(driven, stepped)
    shares = record.phases(max(1, stepped.steps))
    stride = -(-len(shares) // COMPARED_SAMPLES)
    grid = Instants.of(shares[::stride])

    def samples(method) -> np.ndarray:
        run = simulate_load(driven, method, record=grid, initial=initial, cancelled=cancelled)
        return _rows(run)

    at_steps = _rows(first.response)[:, :-1:stride] if penalty.has_step else samples(methods.exact)[:, :-1]
    exact, derived, ref = (samples(method)[:, :-1] for method in methods[1:])
    time = grid.shares * driven.excitation.load.length
    runs = PerSolution(at_steps, exact, derived, ref)
    series = DifferenceSeries(time, runs, PerSolution(0, 0, 0, 0), rms(about_rest(ref[:2], system)), 1)
    return TransientDifference(first, second, without_step, series)


def _rows(run: Response) -> np.ndarray:
    """ξ₁, ξ₂, ξ₁′, ξ₂′ of the samples of a run that reached its end, (4, n)."""
    if not run.ok:
        raise ValueError(f"{run.method.name}: {run.ending}")
    return np.vstack([run.trajectory.displacement, run.trajectory.velocity])
