"""What a search for K, D and the time step is asked."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace

import numpy as np
from vibroscope.engine.arguments import check_fields, shown
from vibroscope.engine.methods import Newmark, Reference, TimeStepping
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.recommendation.contacts import Tolerances
from vibroscope.engine.recommendation.limits import Limits
from vibroscope.engine.recommendation.trials import NewmarkSetting, with_setting
from vibroscope.engine.wording import rounded_to

MOST_ETAS = 50
DIGITS = 10  # of a question: what depends on further ones is rounding, and a search must not answer it differently
_UNSET = NewmarkSetting(1.0, 0.0, 1000)  # what a search does not read


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
        object.__setattr__(self, "etas", etas)
        object.__setattr__(self, "scheme", with_setting(self.scheme, _UNSET))
        object.__setattr__(self, "limits", self.limits.of(self.system))

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
