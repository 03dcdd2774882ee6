"""The conditions under which a penalty contact stands for an impact: it rebounds as asked, and the step resolves it.

K, D and the step have to fit each other: the restitution of the contact (:mod:`engine.contact`) follows from K and D,
the steps in a contact from K, D and the step, and what the step makes of the restitution from all of them
(:mod:`engine.one_impact`). A motion may agree with the reference although they fail, where errors cancel.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from vibroscope.engine.contact import contact_time, effective_restitution, equal_damping
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.encounters import delivered_restitution
from vibroscope.engine.divergence.tolerances import RESOLVED, SAME_RESTITUTION
from vibroscope.engine.methods import ExactPenalty, TimeStepping, contact_ranges
from vibroscope.engine.model import System
from vibroscope.engine.motions.tolerances import SHORT_CONTACT
from vibroscope.engine.motions.words import stays_together
from vibroscope.engine.one_impact.of_system import ContactAlone, contact_alone, span_as_dict
from vibroscope.engine.wording import finite_or_none, rounded, rounded_to


@dataclass(frozen=True)
class Conditions:
    """What a contact of a penalty method does, alone and without a step but for ``steps`` and ``alone``.

    Attributes
    ----------
    asked : float
        Restitution e of the reference.
    restitution : float
        That of K, D and law at the closing speed; nan where nothing collides and the law needs a speed.
    measured, lasts : float
        That which the short contacts of a run have, with its step and all forces, and the median τ that its contacts
        last; nan where there are none.
    duration : float
        τ that a contact lasts (:func:`engine.contact.contact_time`); nan likewise.
    steps : float
        Steps in that time; inf without a step.
    cut : bool
        Whether steps are cut where contact changes, so that few of them resolve a contact.
    alone : ContactAlone or None
        What its step makes of it; None where that is not looked at.
    """

    asked: float
    restitution: float
    duration: float
    steps: float
    cut: bool
    measured: float = math.nan
    lasts: float = math.nan
    alone: ContactAlone | None = field(default=None, repr=False, compare=False)

    @property
    def given(self) -> float:
        """The restitution that is measured, or else that of the law; 0 for bodies that do not part."""
        return float(np.maximum(0.0, self.restitution if math.isnan(self.measured) else self.measured))

    @property
    def rebounds(self) -> bool:
        """Whether the restitution is as asked, or not known."""
        return not abs(self.given - self.asked) > SAME_RESTITUTION

    @property
    def fit(self) -> bool:
        """Whether K and D give the restitution, whatever step and other forces make of it."""
        return not abs(self.restitution - self.asked) > SAME_RESTITUTION

    @property
    def resolved(self) -> bool:
        """Whether a contact has enough steps, or its steps are not known."""
        return self.cut or not self.steps < RESOLVED

    @property
    def hold(self) -> bool:
        """Whether the contact rebounds as asked and is resolved."""
        return self.rebounds and self.resolved

    def as_dict(self) -> dict:
        """Return plain numbers for scripts; None for those that are not known."""
        numbers = ("asked", "restitution", "measured", "duration", "lasts", "steps")
        return {
            **{name: finite_or_none(getattr(self, name)) for name in numbers},
            **span_as_dict(self.alone),
            "rebounds": self.rebounds,
            "resolved": self.resolved,
        }


def conditions(system: System, eta: float, method: ExactPenalty | TimeStepping, closing_speed: float) -> Conditions:
    """Return the conditions of a method at a closing speed, nan if nothing collides."""
    speed = 1.0 if method.linear else closing_speed
    restitution = math.nan if math.isnan(speed) else float(effective_restitution(system, method, speed))
    duration = float(contact_time(system.mass_share, method, speed))
    steps = duration * eta * method.steps / (2 * math.pi) if method.has_step else math.inf
    return Conditions(system.restitution, restitution, duration, steps, method.located)


def unequal_stops_text(system: System, method: ExactPenalty | TimeStepping, closing_speed: float) -> str:
    """Return which D the second stop needs where that of the first does not give what it asks for; else empty."""
    if not system.two_stops or method.damping is None:
        return ""
    other, factor = system.mirrored, system.stiffness_factor2
    first = equal_damping(system, method, method.stiffness, closing_speed)
    if not first > 0.0:  # no damper gives a restitution of 1, times whatever factor
        return ""
    second = replace(method, stiffness=factor * method.stiffness)
    ratio = equal_damping(other, second, second.stiffness, closing_speed) / first
    if not 0.0 < ratio < math.inf:
        return ""
    second = replace(second, damping=system.damping_factor2 * first)
    given = conditions(other, 1.0, second, closing_speed).restitution
    if not abs(given - other.restitution) > SAME_RESTITUTION:
        return ""
    asked, second = rounded(system.restitution, 2), rounded(other.restitution, 2)
    return (
        f"the stops ask for restitutions of {asked} and {second}: with the D that gives {asked} at the first, the "
        f"second gives {rounded(given, 2)}; damping_factor2 = {rounded(ratio, 3)} gives both"
    )


def with_equal_damping(system: System, method: TimeStepping, stiffness: float, closing_speed: float) -> TimeStepping:
    """Return a method with another K and the D of three digits that rebounds as asked; D as it is if none does."""
    changed = replace(method, stiffness=stiffness)
    damping = equal_damping(system, changed, stiffness, closing_speed)
    least, most = contact_ranges(method.law)[1]
    if not least <= damping <= most:
        return changed
    return replace(changed, damping=rounded_to(damping, 3))


def stay_together(comparison: Comparison) -> bool:
    """Whether the bodies part in neither motion, so that nothing rebounds: the spring gives way, and no more."""
    return stays_together(comparison.reference) and stays_together(comparison.penalty)


def contact_conditions(comparison: Comparison) -> Conditions:
    """What the contact of the penalty solution does, measured where it has short contacts, and with its step.

    The steps are those of a contact alone, or of the motion's where these last far longer. Of a run that ended early
    nothing is measured.
    """
    run, speed = comparison.runs.penalty, comparison.closing_speed
    found = conditions(run.system, run.eta, run.method, speed)
    found = replace(found, alone=contact_alone(run.system, run.eta, run.method, speed))
    if not run.ok:
        return found
    lasts = float(np.median(np.diff(run.contacts, axis=1))) if len(run.contacts) else np.nan
    steps = found.steps * lasts / found.duration if lasts > SHORT_CONTACT * found.duration else found.steps
    return replace(found, measured=delivered_restitution(run), lasts=lasts, steps=steps)
