"""Which K, D and time step to set instead: those that meet a tolerance at the least number of steps.

The error is that of :class:`..divergence.error.Target`: rms difference of the displacements from the reference,
relative to it, in step with the excitation. For each of a ladder of n, doubled from rung to rung, the best K and D are
searched for (:mod:`.search`); between the last rung that misses the tolerance and the first that meets it, n is
bisected.
Nothing is recommended by a formula: every setting that is returned was run by Newmark's method from rest, and its
neighbours were run as well, so that it does not meet the tolerance by luck (:mod:`.trials`).
"""

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from ..methods import Newmark, Reference
from ..model import System, check_eta, require, whole
from ..motions.steady import steady
from .climb import Climb
from .front import falling
from .reasons import joint_damping_part, why_no_error, why_not
from .search import Search
from .trials import Trial, Trials

TOLERANCE_RANGE = (1e-6, 1.0)
STIFFNESS_MAX_RANGE = (1.0, 1e11)
STEPS_MAX_RANGE = (4, 1_000_000)
ENOUGH = 1.05  # if nothing meets the tolerance: the cheapest whose error is within so much of the least


@dataclass(frozen=True)
class Recommendation:
    """Outcome of :func:`recommend`.

    Attributes
    ----------
    system, eta, reference, tolerance, located
        What was asked.
    met : bool
        Whether the tolerance is met: by the setting itself, leaping or walking, with half the step, and by nine in ten
        of its neighbours (n ± 2 %, K and D ± 1 %).
    best : Trial or None
        The setting with the least cost that meets the tolerance: ``setting`` (K, D, n), ``error``, ``robust`` and
        ``cost``. If none does, the cheapest whose robust error is within 5 % of the least found; None if nothing could
        be found.
    front : tuple of Trial
        Settings that no other one beats, cheapest first: along it cost and n rise, error and robust error fall. Each
        was run from rest, and with its neighbours. Settings that meet the tolerance by luck are left out.
    joint_damping : float
        Error that no K, D or step is to blame for: the reference with the joint damping that the dampers add up to,
        against the reference asked for. nan if there is none. An error below it is owed to errors that cancel each
        other.
    reason : str
        Why nothing meets the tolerance and what to do; empty if ``met``.
    """

    system: System
    eta: float
    reference: Reference
    tolerance: float
    located: bool
    met: bool
    best: Trial | None
    front: tuple[Trial, ...]
    joint_damping: float
    reason: str

    @property
    def method(self) -> Newmark | None:
        """The recommended setting, ready to be run; None if there is none."""
        return None if self.best is None else Newmark(*self.best.setting, located=self.located)

    @property
    def compensated(self) -> bool:
        """Whether the error is less than the joint damping alone makes: errors cancel each other, at this η."""
        return self.best is not None and self.best.error < self.joint_damping


def recommend(
    system: System,
    eta: float,
    *,
    tolerance: float = 0.05,
    located: bool = False,
    reference: Reference | None = None,
    stiffness_max: float = 1e6,
    steps_max: int = 65_536,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Recommendation:
    """K, D and steps per period that meet the tolerance at the least cost.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    tolerance : float
        Largest rms error of the displacements, relative to the reference's.
    located : bool
        Cut the steps at contact changes; cost is then solves per period. Otherwise the paper's constant step.
    reference : Reference, optional
        What errors are measured against; by default the paper's reference.
    stiffness_max : float
        Largest K to try.
    steps_max : int
        Largest number of steps per period to try.
    progress : callable, optional
        Called with the share that is done, 0 to 1, at most; in the calling thread.
    cancelled : callable, optional
        Polled many times a second, by several threads; when it returns true the search is withdrawn.

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
    """
    eta = check_eta(eta, system)
    tolerance = require("tolerance", tolerance, *TOLERANCE_RANGE, "give the relative rms error to keep to")
    stiffness_max = require("stiffness_max", stiffness_max, *STIFFNESS_MAX_RANGE, "give the largest K to try")
    steps_max = whole("steps_max", steps_max, *STEPS_MAX_RANGE, "give the most steps per period to try")
    reference = reference or Reference()
    told = progress or (lambda share: None)
    found = steady(system, eta, reference, cancelled=cancelled)
    asked = (system, eta, reference, tolerance, located)
    if not found.periodic:
        return Recommendation(*asked, False, None, (), math.nan, why_no_error(found))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        trials = Trials(found, located, pool, cancelled)
        climb = Climb(Search(trials, system, eta, stiffness_max, tolerance), tolerance, steps_max, told)
        climb.up()
        climb.between()
        climb.complete()
        climb.walk()
        front, met = climb.front(), climb.met
    best = met[0] if met else _enough(front)
    part, reason = joint_damping_part(trials.target, reference, cancelled), ""
    if not met:
        reason = why_not(trials, front, part, tolerance, (stiffness_max, steps_max), cancelled)
    if best is not None:
        front = falling(front, best)
    told(1.0)
    return Recommendation(*asked, bool(met), best, tuple(front), part, reason)


def design_curve(
    system: System,
    etas: Sequence[float],
    *,
    progress: Callable[[float], None] | None = None,
    **options,
) -> list[Recommendation]:
    """How K, D and n must change with η: one recommendation each, with the options of :func:`recommend`."""
    etas = [check_eta(eta, system) for eta in etas]
    told = progress or (lambda share: None)
    return [
        recommend(system, eta, progress=lambda share, i=i: told((i + share) / len(etas)), **options)
        for i, eta in enumerate(etas)
    ]


def _enough(front: list[Trial]) -> Trial | None:
    """The cheapest of which little more could be had."""
    least = min((trial.robust for trial in front), default=math.inf)
    return next((trial for trial in front if trial.robust <= ENOUGH * least), None)
