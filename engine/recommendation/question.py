"""What a search for K, D and the time step is asked, its limits, and what it recommends."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace

import numpy as np
from vibroscope.engine.arguments import check_fields, require, set_fields, shown, whole
from vibroscope.engine.methods import DAMPING_RANGE, STIFFNESS_RANGE, Newmark, Reference, TimeStepping
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.one_impact.of_system import ContactAlone
from vibroscope.engine.recommendation.contacts import Contacts, Tolerances
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial, steps_at, with_setting
from vibroscope.engine.wording import html_table, rounded_to, rounded_up

STIFFNESS_MAX_RANGE = (1.0, 1e11)
STEPS_MAX_RANGE = (4, 1_000_000)
STIFFEST = 1e6  # times the stiffer spring: the largest K that is tried unless another is given
MOST_ETAS = 50
DIGITS = 10  # of a question: what depends on further ones is rounding, and a search must not answer it differently
_UNSET = NewmarkSetting(1.0, 0.0, 1000)  # what a search does not read


def largest_stiffness(system: System) -> float:
    """Return the largest K that a search tries unless another is given, of two digits."""
    return min(rounded_to(STIFFEST * system.stiffer_spring, 2), STIFFNESS_MAX_RANGE[1])


@dataclass(frozen=True)
class Limits:
    """Limits of a search, and what it holds fixed.

    Parameters
    ----------
    stiffness_max : float, optional
        Largest K to try; by default :func:`largest_stiffness` of the system.
    steps_max : int
        Largest number of steps per period to try.
    stiffness, damping : float, optional
        K and D, if they are given and not looked for.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    """

    stiffness_max: float | None = None
    steps_max: int = 65_536
    stiffness: float | None = None
    damping: float | None = None

    def __post_init__(self):
        most = "give the most steps per period to try"
        checked = {"steps_max": whole("steps_max", self.steps_max, *STEPS_MAX_RANGE, most)}
        if self.stiffness_max is not None:
            largest = "give the largest K to try"
            checked["stiffness_max"] = require("stiffness_max", self.stiffness_max, *STIFFNESS_MAX_RANGE, largest)
        if self.stiffness is not None:
            checked["stiffness"] = require("stiffness", self.stiffness, *STIFFNESS_RANGE, "give the K to hold")
        if self.damping is not None:
            checked["damping"] = require("damping", self.damping, *DAMPING_RANGE, "give the D to hold")
        set_fields(self, **checked)

    def of(self, system: System) -> "Limits":
        """The limits for a system, all of them numbers."""
        return self if self.stiffness_max is not None else replace(self, stiffness_max=largest_stiffness(system))


@dataclass(frozen=True)
class SettingQuestion:
    """K, D and a time step are asked for, with which a system at one η, or at each of several, keeps to tolerances.

    Attributes
    ----------
    system : System
    etas : float or sequence of float
        Excitation frequencies η = Ω/ω₁ that one setting shall serve, one or more; kept in ascending order.
    tolerances : Tolerances
        Of the displacements, of the restitution that contacts deliver, and of the peak force.
    limits : Limits
        How large K and the steps per period may be, and what is held; ``steps_max`` holds for the lowest η, where a
        period has the most steps.
    scheme : TimeStepping
        What the user's code has: integrator, contact status and law. Its K, D and n have no effect. A setting whose run
        stops at a step without a solution is never recommended.
    reference : Reference
        The reference that errors are measured from.

    Raises
    ------
    ValueError
        If a number is out of range, there are no frequencies or more than MOST_ETAS, or the scheme has no time step.

    Examples
    --------
    >>> from vibroscope.engine import SettingQuestion, System
    >>> SettingQuestion(System(), [2.8, 2.6]).etas
    (2.6, 2.8)
    """

    system: System
    etas: float | Sequence[float]
    tolerances: Tolerances = field(default_factory=Tolerances)
    limits: Limits = field(default_factory=Limits)
    scheme: TimeStepping = field(default_factory=lambda: Newmark(*_UNSET))
    reference: Reference = field(default_factory=Reference)

    def __post_init__(self):
        given = [self.etas] if isinstance(self.etas, str | bytes) or not np.iterable(self.etas) else self.etas
        etas = tuple(sorted({check_eta(eta) for eta in given}))
        if not 1 <= len(etas) <= MOST_ETAS:
            raise ValueError(
                f"{len(etas)} different eta are outside [1, {MOST_ETAS}]: give the ends of the range and some between"
            )
        check_fields(self)
        if not self.scheme.has_step:
            raise ValueError(f"scheme = {shown(self.scheme)} has no time step: give a Newmark or a TimeStepping")
        set_fields(self, etas=etas, scheme=with_setting(self.scheme, _UNSET), limits=self.limits.of(self.system))

    @property
    def is_range(self) -> bool:
        """Whether one setting is to serve several η."""
        return len(self.etas) > 1

    @property
    def located(self) -> bool:
        """Whether steps are cut at contact changes, so that the cost counts solves."""
        return self.scheme.located


def round_numbers(value):
    """Return a number, or a dataclass with all its numbers, rounded to DIGITS significant digits.

    Examples
    --------
    >>> from vibroscope.engine.recommendation.question import round_numbers
    >>> round_numbers(1.18 * (1 + 1e-12))
    1.18
    """
    if is_dataclass(value):
        numbers = {each.name: round_numbers(getattr(value, each.name)) for each in fields(value) if each.init}
        return replace(value, **numbers)
    return rounded_to(value, DIGITS) if isinstance(value, float) else value


@dataclass(frozen=True)
class Served:
    """The result of the recommended setting at one η.

    Attributes
    ----------
    eta : float
    steps : int
        Steps per period of the recommended time step, rounded up.
    error, robust, contacts, excess
        See :class:`.trials.Trial`.
    """

    eta: float
    steps: int
    error: float
    robust: float
    contacts: Contacts | None
    excess: float


@dataclass(frozen=True, kw_only=True)
class Recommendation:
    """Outcome of :func:`.search.recommend`.

    Attributes
    ----------
    question : SettingQuestion
    eta : float
        The highest excitation frequency at which the reference repeats itself; the steps per period of ``best`` and
        ``front`` belong to it. The lowest that was asked for if there is none.
    met : bool
        Whether the tolerances are met at all ``served``: by the setting itself, whether steps are skipped or all
        computed, by the same with half the step, and, at the η asked for, by nine in ten of its neighbours (n ± 2 %,
        K and D ± 1 %).
    best : Trial or None
        A setting that meets the tolerances with hardly more than the least number of steps, in the middle of where they
        are met: ``setting`` (K, D, n), ``error``, ``robust``, ``cost`` and ``contacts``. With several η its errors are
        the largest, its contacts those that are furthest off. If none meets the tolerances, the cheapest whose robust
        error is within 5 % of the least found; None if every run diverged.
    ranges : dict
        Of "stiffness" and "damping", unless held: from where to where the tolerances are met if that number alone is
        changed; at least so far. Empty if they are not met.
    front : tuple of Trial
        Settings that no other one beats, cheapest first: along it cost and n rise, error and robust error fall. Each
        was run from rest, and with its neighbours. If ``met``, settings that meet the tolerance by chance are left out.
    served : tuple of Served
        What ``best`` does at each η, lowest first; those between the η asked for are here if the tolerance is met.
    left_out : tuple of float
        The η at which no error exists, since the reference does not repeat itself, or K and D have no effect.
    joint_damping : float
        Error that no K, D or step can remove, where ``best`` has its largest: that of the reference with derived joint
        damping, against the reference asked for; nan if it does not exist. A smaller error results from errors that
        cancel each other.
    alone : ContactAlone or None
        What a contact alone gives with ``best`` at ``eta``, at the closing speed of the reference, without the step and
        with it; None if there is no setting, or no such contact.
    limit : str or Statement
        Of several η: at which the error is largest, and which part of it: what limits the range.
    reason : str or Statement
        Why nothing meets the tolerance and what to do; empty if ``met``.
    kind : str or Statement
        How, and at which η, the motion of ``best`` and the reference's differ in kind, in words; empty if they do not.
        Among the settings that meet the tolerance, one of the reference's kind is preferred.
    """

    question: SettingQuestion
    eta: float
    met: bool
    best: Trial | None = None
    ranges: dict[str, tuple[float, float]]
    front: tuple[Trial, ...] = ()
    served: tuple[Served, ...] = ()
    left_out: tuple[float, ...] = ()
    joint_damping: float = math.nan
    alone: ContactAlone | None = field(default=None, compare=False)  # follows from the others
    limit: str = ""
    reason: str = ""
    kind: str = ""

    def __repr__(self) -> str:
        how = "met" if self.met else f"not met: {self.reason}"
        return f"Recommendation({self.method} for a tolerance of {self.tolerance:g}, {how})"

    def _repr_html_(self) -> str:
        rows = {str(self.with_setting(each.setting)): f"error {each.robust:.3g}" for each in self.front}
        return html_table(repr(self), rows)

    @property
    def scheme(self) -> TimeStepping:
        """What the settings were tried with; its own K, D and n have no effect."""
        return self.question.scheme

    @property
    def tolerances(self) -> Tolerances:
        """Those asked for."""
        return self.question.tolerances

    @property
    def tolerance(self) -> float:
        """That of the displacements."""
        return self.tolerances.displacement

    @property
    def possible(self) -> float:
        """The least tolerance that ``best`` meets, rounded up to two digits; nan if there is no setting."""
        return math.nan if self.best is None else rounded_up(self.best.robust)

    @property
    def method(self) -> TimeStepping | None:
        """The recommended setting as a method to simulate with at ``eta``; None if there is none."""
        return self.method_at(self.eta)

    def method_at(self, eta: float) -> TimeStepping | None:
        """Return the recommended setting as a method with its time step at an η; None if there is none."""
        if self.best is None:
            return None
        setting = self.best.setting
        return self.with_setting(setting._replace(steps=steps_at(eta, self.eta, setting.steps)))

    def with_setting(self, setting: NewmarkSetting) -> TimeStepping:
        """The method that the settings were tried with, with these numbers."""
        return with_setting(self.scheme, setting)

    @property
    def time_step(self) -> float:
        """Δτ, in units of 1/ω₁; nan if there is no setting."""
        return math.nan if self.best is None else 2 * math.pi / (self.eta * self.best.setting.steps)

    @property
    def solves(self) -> float:
        """Solves per period of ``best``: its cost, twice that with two stages in a step; nan if there is no setting."""
        return math.nan if self.best is None else self.best.cost * self.scheme.stages

    @property
    def compensated(self) -> bool:
        """Whether the error is less than that of the joint damping alone: at this η, errors cancel each other."""
        return self.best is not None and self.best.error < self.joint_damping
