"""What a search recommends."""

import math
from dataclasses import dataclass, field

from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.one_impact.of_system import ContactAlone
from vibroscope.engine.recommendation.contacts import Contacts, Tolerances
from vibroscope.engine.recommendation.question import SettingQuestion
from vibroscope.engine.recommendation.range_trials import steps_at
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial, with_setting
from vibroscope.engine.wording import html_table, rounded_up


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
    """Outcome of :func:`.recommend.recommend`.

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
