"""Where a penalty solution leaves the reference, and by how much."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..methods import ExactPenalty, Newmark, Reference
from ..model import System
from ..motions.description import Motion, describe
from ..motions.motion import motion
from ..result import Record, Response
from ..simulate import simulate
from .encounters import Encounters, encounters
from .error import Target
from .grid import PER_PERIOD
from .parts import PARTS, Parts, Runs, parts_of
from .regularisation import Regularisation, split_regularisation
from .statistics import Statistics, statistics


@dataclass(frozen=True)
class Comparison:
    """Newmark's penalty solution beside the reference. Numbers are nan where a run that they need ended early.

    Attributes
    ----------
    runs : Runs of Response
        Newmark, exact penalty, reference with derived joint damping, reference.
    motions : Runs of Motion
        What moves in each, as their kept periods show.
    reference, penalty : Motion
        The reference's motion and Newmark's; :meth:`with_evidence` has found what they are.
    pointwise : bool
        Whether all four motions repeat, Newmark's but for scatter. Only then they stay in step with the excitation, and
        a difference at each instant means something; otherwise ``statistics`` does.
    parts : Parts or None
        The difference and its parts as series; None if Newmark or the reference ended early.
    total, time_step, regularisation, joint_damping : float
        Rms of the displacements in each over the kept periods, relative to the reference's.
    residual : float
        Largest deviation of the sum of the parts from the total at any instant, in base amplitudes.
    encounters : Encounters or None
        How contacts match impacts; None unless the reference repeats.
    grid : Record
        Of one period of the series.
    """

    runs: Runs[Response]
    motions: Runs[Motion]
    reference: Motion
    penalty: Motion
    pointwise: bool
    parts: Parts | None
    total: float
    time_step: float
    regularisation: float
    joint_damping: float
    residual: float
    encounters: Encounters | None
    grid: Record

    @property
    def complete(self) -> bool:
        """Whether all four runs reached their end."""
        return all(run.ok for run in self.runs)

    @cached_property
    def statistics(self) -> Statistics | None:
        """Differences of the sections, from runs of another 1,000 periods; None if ``pointwise``, or without parts."""
        return statistics(self.runs) if self.parts and not self.pointwise else None

    def with_evidence(self, cancelled: Callable[[], bool] | None = None) -> "Comparison":
        """The same, with multipliers and Lyapunov exponents of the reference's motion and Newmark's.

        It takes some tenths of a second where they do not repeat (:func:`..motions.motion`).

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        runs = self.runs.reference, self.runs.penalty
        told = (motion(run.system, run.eta, run.method, cancelled=cancelled) for run in runs)
        return replace(self, **dict(zip(("reference", "penalty"), told, strict=True)))

    def split(self) -> Regularisation:
        """What the regularisation is made of; runs the reference twice more.

        Raises
        ------
        ValueError
            If a run ended early.
        """
        if not self.complete:
            raise ValueError("a run ended early, so that there is no regularisation to split: see the runs' messages")
        return split_regularisation(self.parts, self.runs.exact.method, self.runs.derived, self.grid)


def compare(
    system: System,
    eta: float,
    penalty: Newmark,
    *,
    reference: Reference | None = None,
    periods: int = 2050,
    keep: int = 50,
    responses: Iterable[Response] = (),
    per_period: int = PER_PERIOD,
    cancelled: Callable[[], bool] | None = None,
) -> Comparison:
    """Compare a penalty solution with the reference, both from rest, and tell what the difference is made of.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    penalty : Newmark
    reference : Reference, optional
        By default the paper's. With derived joint damping there is no part of the joint's.
    periods, keep : int
        Excitation periods to run, and the last of them to compare.
    responses : iterable of Response
        Any of the four runs if they were made already, with the same system, η, periods and keep, with samples or
        without.
    per_period : int
        Samples per period at most; they are Newmark's own steps.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is withdrawn.

    Raises
    ------
    ValueError
        If a number is out of range, or a response belongs to none of the four runs.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not isinstance(penalty, Newmark):
        raise ValueError(f"{penalty} has no time step: compare Newmark, whose limit it is")
    reference = reference or Reference()
    runs = _runs(system, eta, penalty, reference, periods, keep, responses, cancelled)
    motions = Runs(*(describe(run) for run in runs))
    # a reference that only nearly repeats has no step to scatter it: it wanders, and nothing stays in step with it
    pointwise = bool(motions.reference.period) and all(found.near_period for found in motions)
    comparable = runs.penalty.ok and runs.reference.ok
    parts = parts_of(runs, motions, per_period) if comparable else None
    period = motions.reference.period
    matched = encounters(runs.reference, runs.penalty, period, parts.shifts.reference) if parts and period else None
    return Comparison(
        runs=runs,
        motions=motions,
        reference=motions.reference,
        penalty=motions.penalty,
        pointwise=pointwise,
        parts=parts,
        **{name: parts.relative(getattr(parts, name)) if parts else np.nan for name in ("total", *PARTS)},
        residual=parts.residual if parts else np.nan,
        encounters=matched,
        grid=Record(1, per_period, penalty.steps),
    )


def _runs(system, eta, penalty, reference, periods, keep, responses, cancelled) -> Runs[Response]:
    """The four runs, those that are at hand taken as they are."""
    methods = Runs(
        penalty,
        ExactPenalty(penalty.stiffness, penalty.damping),
        replace(reference, joint_damping="derived"),
        reference,
    )
    given = {response.method: response for response in responses}
    for response in given.values():
        asked = (system, eta, periods, keep)
        if response.method not in methods or (response.system, response.eta, response.periods, response.keep) != asked:
            raise ValueError(
                f"a response of {response.method} at eta = {response.eta:g} over {response.periods} periods, "
                f"{response.keep} kept, is none of the four that are compared: {', '.join(map(str, methods))}"
            )
    for method in methods:
        if method not in given:
            given[method] = simulate(system, eta, method, periods=periods, keep=keep, cancelled=cancelled)
    return Runs(*(given[method] for method in methods))


def nearest_attractor(found: Comparison, cancelled: Callable[[], bool] | None = None) -> float:
    """Error of the penalty solution from the motion that the reference has when it starts from the penalty's state.

    The reference may have several motions at the same parameters. A penalty solution that agrees with one of them is
    not wrong because another is reached from rest.

    Returns
    -------
    float
        As ``total``; inf if the reference does not repeat from there, or a run ended early.
    """
    run = found.runs.reference
    if not found.runs.penalty.ok:
        return np.inf
    x1, v1, x2, v2 = found.runs.penalty.section[-1]
    start = (x1, v1, max(x1, x2), v2)  # the reference knows no penetration
    options = {"periods": run.periods, "keep": run.keep, "initial": start, "cancelled": cancelled}
    there = simulate(run.system, run.eta, run.method, **options)
    target = Target(there) if there.ok else None
    return target.error(found.runs.penalty) if target and target.periodic else np.inf
