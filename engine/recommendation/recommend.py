"""Recommend K, D and the time step: the setting that meets a tolerance at the least cost.

The error is that of :class:`..divergence.error.Target`: the rms difference of the displacements from the reference,
relative to it, in phase with the excitation. A setting must also deliver the restitution of the system, and the peak
force that it would have without a time step (:mod:`.contacts`). :mod:`.step_search` searches the least number of steps
per period n, :mod:`.contact_search` the best K and D for each n. From the least n, :mod:`.middle` goes to the middle of
where the tolerances are met. No setting is recommended by a formula: every one that is returned was run from rest by
Newmark's method, and so were its neighbours, so that it does not meet the tolerances by chance (:mod:`.trials`).

The search sees the question with ten digits (:mod:`.rounded`), so that a further one does not change the answer; the
answer is verified for the question as it is.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice

from ..arguments import shown
from ..drivers.threads import thread_count
from ..methods import STEPPING, Newmark, Reference, TimeStepping, is_located, stages_of
from ..model import System, check_eta
from ..motions.description import describe
from ..motions.motion import motion
from ..motions.steady import Steady, steady
from ..motions.words import difference_in_kind
from ..simulate import simulate
from ..wording import html_table
from .contact_search import ContactSearch
from .contacts import Tolerances
from .front import monotone_front
from .limits import Limits
from .middle import MiddleSearch
from .range_trials import RangeTrials, steps_at
from .reasons import aperiodic_reference_reason, idle_reason, joint_damping_error, unmet_tolerance_reason
from .rounded import round_numbers
from .step_search import StepSearch
from .trials import NewmarkSetting, Trial, Trials, verification, with_setting

KINDS = 3  # settings whose kind of motion is looked at: evidence for one takes some tenths of a second
ENOUGH = 1.05  # times the least error: if nothing meets the tolerance, the cheapest setting within it is returned


class Suggested:
    """The base of the results of both searches."""

    best: Trial | None
    located: bool
    scheme: Newmark | TimeStepping | None
    tolerances: Tolerances

    @property
    def tolerance(self) -> float:
        """That of the displacements."""
        return self.tolerances.displacement

    @property
    def possible(self) -> float:
        """The least tolerance that ``best`` meets, rounded up to two digits; nan if there is no setting."""
        return math.nan if self.best is None else rounded_up(self.best.robust)

    def with_setting(self, setting: NewmarkSetting) -> Newmark | TimeStepping:
        """The method that the settings were tried with, with these numbers."""
        return with_setting(self.scheme or scheme_of(None, self.located), setting)


@dataclass(frozen=True, kw_only=True)
class Recommendation(Suggested):
    """Outcome of :func:`recommend`.

    Attributes
    ----------
    system, eta, reference, located
        The arguments.
    tolerances : Tolerances
        Those of the displacements, the restitution and the peak force.
    met : bool
        Whether the tolerances are met: by the setting itself, whether steps are skipped or all computed, by the same
        with half the step, and by nine in ten of its neighbours (n ± 2 %, K and D ± 1 %).
    best : Trial or None
        A setting that meets the tolerances with hardly more than the least number of steps, in the middle of where they
        are met: ``setting`` (K, D, n), ``error``, ``robust``, ``cost`` and ``contacts``. If none does, the cheapest
        whose robust error is within 5 % of the least found; None if every run diverged.
    ranges : dict
        Of "stiffness" and "damping", unless held: from where to where the tolerances are met if that number alone is
        changed; at least so far. Empty if they are not met.
    front : tuple of Trial
        Settings that no other one beats, cheapest first: along it cost and n rise, error and robust error fall. Each
        was run from rest, and with its neighbours. If ``met``, settings that meet the tolerance by chance are left out.
    joint_damping : float
        Error that no K, D or step can remove: that of the reference with derived joint damping, against the reference
        asked for; nan if it does not exist. A smaller error results from errors that cancel each other.
    reason : str
        Why nothing meets the tolerance and what to do; empty if ``met``.
    kind : str
        How the motion of ``best`` and the reference's differ in kind, in words; empty if they do not. Among the
        settings that meet the tolerance, one of the reference's kind is preferred.
    scheme : Newmark or TimeStepping
        What the settings were tried with; its own K, D and n have no effect.
    """

    system: System
    eta: float
    reference: Reference
    tolerances: Tolerances
    located: bool
    met: bool
    best: Trial | None
    ranges: dict[str, tuple[float, float]]
    front: tuple[Trial, ...]
    joint_damping: float
    reason: str
    kind: str = ""
    scheme: Newmark | TimeStepping | None = None

    def __repr__(self) -> str:
        how = "met" if self.met else f"not met: {self.reason}"
        return f"Recommendation({self.method} for a tolerance of {self.tolerance:g}, {how})"

    def _repr_html_(self) -> str:
        rows = {str(self.with_setting(each.setting)): f"error {each.robust:.3g}" for each in self.front}
        return html_table(repr(self), rows)

    @property
    def method(self) -> Newmark | TimeStepping | None:
        """The recommended setting as a method to simulate with; None if there is none."""
        return None if self.best is None else self.with_setting(self.best.setting)

    @property
    def solves(self) -> float:
        """Solves per period of ``best``: its cost, twice that with two stages in a step; nan if there is no setting."""
        return math.nan if self.best is None else self.best.cost * stages_of(self.scheme or scheme_of(None, False))

    @property
    def compensated(self) -> bool:
        """Whether the error is less than that of the joint damping alone: at this η, errors cancel each other."""
        return self.best is not None and self.best.error < self.joint_damping


def recommend(
    system: System,
    eta: float,
    *,
    tolerance: float = 0.05,
    restitution_tolerance: float | None = 0.1,
    force_tolerance: float | None = 0.2,
    located: bool = False,
    scheme: Newmark | TimeStepping | None = None,
    reference: Reference | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: Callable[[list[Trial]], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    **limits: float | None,
) -> Recommendation:
    """Find K, D and steps per period that meet the tolerance at the least cost.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    tolerance : float
        Largest rms error of the displacements, relative to the reference's.
    restitution_tolerance : float, optional
        How far the restitution that the contacts deliver may be from the system's; None: whatever it is.
    force_tolerance : float, optional
        How far the peak force may be from that of the same K, D and law without a time step, relative to it; None:
        whatever it is.
    located : bool
        Cut the steps at contact changes; the cost counts solves per period. Otherwise the paper's constant step.
    scheme : Newmark or TimeStepping, optional
        What the user's code has: integrator, contact status and law, in place of the paper's or of ``located``. Its K,
        D and n have no effect. A setting whose run stops at a step without a solution is never recommended.
    reference : Reference, optional
        The reference that errors are measured from; by default the paper's.
    threads : int, optional
        To try settings side by side; by default one for each core.
    progress : callable, optional
        Called in the calling thread with the fraction that is done at least, 0 to 1.
    partial : callable, optional
        Called in the calling thread with the front of the settings found so far, whenever some were tried with another
        n. Those that meet the tolerance are confirmed.
    cancelled : callable, optional
        Polled many times a second, by several threads; when it returns true the search is cancelled.
    **limits
        See :class:`.limits.Limits`: ``stiffness_max`` and ``steps_max``, the largest K and the most steps per period to
        try; ``stiffness`` and ``damping``, K and D if they are given and only the rest is looked for.

    Returns
    -------
    Recommendation
        The same for the same arguments, however many threads there are.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import System, recommend
    >>> found = recommend(System(), 2.76, tolerance=0.2, stiffness=12000, steps_max=4000)
    >>> found.met, found.best.setting.stiffness, found.best.robust <= 0.2
    (True, 12000.0, True)
    """
    eta = check_eta(eta)
    tolerances = Tolerances(tolerance, restitution_tolerance, force_tolerance)
    limited = Limits(**limits).of(system)
    threads = thread_count(threads)
    reference = reference or Reference()
    progress, partial = progress or no_progress, partial or no_progress
    found = steady(system, eta, reference, cancelled=cancelled)
    rounded = round_numbers(system), round_numbers(eta), round_numbers(reference)
    near = found if rounded == (system, eta, reference) else steady(*rounded, cancelled=cancelled)
    scheme = scheme_of(scheme, located)
    asked = {
        "system": system,
        "eta": eta,
        "reference": reference,
        "tolerances": tolerances,
        "located": is_located(scheme),
        "scheme": scheme,
    }
    without = {"met": False, "best": None, "ranges": {}, "front": (), "joint_damping": math.nan}
    if not (found.periodic and near.periodic):
        return Recommendation(**asked, **without, reason=aperiodic_reference_reason(found))
    idle = idle_reason(found)
    if idle:
        return Recommendation(**asked, **without, reason=idle)
    with ThreadPoolExecutor(threads) as pool:
        trials = Trials(near, scheme, pool, tolerances, cancelled)
        contact = ContactSearch(trials, system, limited, tolerance, force_tolerance)
        search = StepSearch(contact, tolerance, limited.steps_max, progress, partial)
        search.run()
        exact = trials if near is found else Trials(found, scheme, pool, tolerances, cancelled)
        middles = MiddleSearch(trials, limited, tolerance)
        best, kind = of_same_kind(
            [found], search.verified(middles, verification(trials, exact, tolerance)), scheme, cancelled
        )
        met, front = best is not None, search.front()
        if met:
            front = [trial for trial in front if trial.robust > tolerance or trial.cost > best.cost]
        else:
            best = described(cheapest_near_least(front), exact)
    joint_damping, reason = joint_damping_error(exact.target, reference, cancelled), ""
    if not met:
        reason = unmet_tolerance_reason(exact, front, joint_damping, tolerances, limited, cancelled)
    if best is not None:
        front = monotone_front(front, best)
    progress(1.0)
    return Recommendation(
        **asked,
        met=met,
        best=best,
        ranges=middles.ranges[best.setting] if met else {},
        front=tuple(front),
        joint_damping=joint_damping,
        reason=reason,
        kind=kind,
    )


def described(trial: Trial | None, trials: Trials | RangeTrials) -> Trial | None:
    """Return a trial that does not meet the tolerances with what a run from rest says of its contacts."""
    if trial is None:
        return None
    verified = trials.verify_alone(trial.setting)
    return trial._replace(
        error=verified.error,
        contacts=verified.contacts,
        excess=verified.excess,
        robust=max(trial.robust, verified.error),
    )


def scheme_of(scheme: Newmark | TimeStepping | None, located: bool) -> Newmark | TimeStepping:
    """Return the method that settings are tried with: the one that is given, or the paper's, located or not.

    Raises
    ------
    ValueError
        If it is no method with a time step.
    """
    if scheme is None:
        return Newmark(*NewmarkSetting(1.0, 0.0, 1000), located=located)
    if not isinstance(scheme, STEPPING):
        raise ValueError(f"scheme = {shown(scheme)} has no time step: give a Newmark or a TimeStepping")
    return scheme


def design_curve(
    system: System,
    etas: Sequence[float],
    *,
    progress: Callable[[float], None] | None = None,
    **options,
) -> list[Recommendation]:
    """Return a recommendation for each η: how K, D and n change with η.

    Parameters
    ----------
    system : System
    etas : sequence of float
        Excitation frequencies η = Ω/ω₁.
    progress : callable, optional
        Called with the fraction that is done at least, 0 to 1.
    **options
        Those of :func:`recommend`, whose exceptions are raised, too.
    """
    etas = [check_eta(eta) for eta in etas]
    progress = progress or no_progress
    return [
        recommend(system, eta, progress=lambda fraction, i=i: progress((i + fraction) / len(etas)), **options)
        for i, eta in enumerate(etas)
    ]


def recommend_schemes(
    system: System,
    eta: float,
    schemes: Sequence[Newmark | TimeStepping],
    *,
    progress: Callable[[float], None] | None = None,
    **options,
) -> list[Recommendation]:
    """Return a recommendation for each of several schemes, such as the integrators of a code, best first.

    First come those that meet the tolerance, by solves per period (:attr:`Recommendation.solves`), and where these are
    equal by the error that they keep to; then the others by that error.

    Parameters
    ----------
    schemes : sequence of Newmark or TimeStepping
        Their K, D and n have no effect.
    **options
        Those of :func:`recommend`, but for ``scheme`` and ``located``.

    Raises
    ------
    ValueError
        As :func:`recommend`, and if there is no scheme.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not schemes:
        raise ValueError("schemes is empty: give the methods to search over")
    progress = progress or no_progress
    found = [
        recommend(
            system,
            eta,
            scheme=scheme,
            progress=lambda fraction, i=i: progress((i + fraction) / len(schemes)),
            **options,
        )
        for i, scheme in enumerate(schemes)
    ]
    return sorted(found, key=_rank)


def _rank(found: Recommendation) -> tuple[float, ...]:
    """The sort key of recommendations."""
    if found.best is None:
        return (2.0,)
    robust = found.best.robust
    return (0.0, found.solves, robust) if found.met else (1.0, robust)


def of_same_kind(
    found: Sequence[Steady],
    trials: Iterable[Trial],
    scheme: Newmark | TimeStepping,
    cancelled: Callable[[], bool] | None,
) -> tuple[Trial | None, str]:
    """Return the first of a few trials whose motion is of the reference's kind, and ""; else the first, and why not.

    With several motions of the reference, the setting of a trial holds at the highest η, and is that of a range. None
    if there is no trial.
    """
    highest, first, kinds = max(one.response.eta for one in found), None, []
    for trial in islice(trials, KINDS):
        first, setting = first or trial, trial.setting
        methods = (
            with_setting(scheme, setting._replace(steps=steps_at(one.response.eta, highest, setting.steps)))
            for one in found
        )
        kinds.append([_kind(one, method, cancelled) for one, method in zip(found, methods, strict=True)])
        if not any(kinds[-1]):
            return trial, ""
    if first is None:
        return None, ""
    different = [(one.response.eta, kind) for one, kind in zip(found, kinds[0], strict=True) if kind]
    return first, "; ".join(kind if len(found) == 1 else f"at eta = {eta:.4g} {kind}" for eta, kind in different)


def _kind(found: Steady, method: Newmark | TimeStepping, cancelled: Callable[[], bool] | None) -> str:
    """How the motion of a setting differs from the reference's in kind, in words; empty if it does not."""
    reference, run = describe(found.response, found.period), found.response
    penalty = describe(simulate(run.system, run.eta, method, cancelled=cancelled))
    if penalty.near_period != reference.near_period:  # a time step may scatter the section
        penalty = motion(run.system, run.eta, method, cancelled=cancelled)
    return difference_in_kind(reference, penalty)


def rounded_up(error: float) -> float:
    """Round up to two significant digits."""
    unit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / unit - 1e-9) * unit:.2g}")


def no_progress(_: object) -> None:
    """Ignore the progress, or a partial result."""


def cheapest_near_least(front: list[Trial]) -> Trial | None:
    """Return the cheapest trial whose robust error is hardly above the least."""
    least = min((trial.robust for trial in front), default=math.inf)
    return next((trial for trial in front if trial.robust <= ENOUGH * least), None)
