"""The contact of a system's bodies alone with the step of a run, as verdicts, recommendations and rules speak of it."""

import math
from typing import NamedTuple

from vibroscope.engine.contact import restitution_of_units
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.one_impact.forward import Span, WithStep, impact
from vibroscope.engine.one_impact.question import Impact
from vibroscope.engine.one_impact.words import restitution_text, shares_text, span_text, steps_text
from vibroscope.engine.wording import finite_or_none

MOST_FOLLOWED = 2000.0  # steps in a contact; what more of them change shows in no digit, and takes a second to find


class ContactAlone(NamedTuple):
    """What a contact gives without a step, and with the step of a run."""

    question: Impact
    restitution: float  # without a step
    found: WithStep | None  # None where it does not depend on the step: cut until the contact is resolved, or tiny

    @property
    def words(self) -> str:
        """The restitution, as "0.46 without a step, 0.45 to 0.51 with 17.7 steps in it"."""
        without = f"{restitution_text(self.restitution)} without a step"
        if self.found is None:
            return without
        steps = f"with {steps_text(self.question.steps_per_contact)} steps in it{shares_text(self.found)}"
        return f"{without}, {span_text(self.found) or 'none at any touch'} {steps}"

    @property
    def sentence(self) -> str:
        """The same as a sentence."""
        return f"Once its force is over, a contact alone has a restitution of {self.words}."

    def is_off(self, tolerance: float, asked: float) -> bool:
        """Whether with the step, at any touch, the restitution is further than a tolerance from what was asked."""
        e = self.found and self.found.restitution
        return e is not None and not max(abs(e.least - asked), abs(e.greatest - asked)) <= tolerance


def contact_alone(system: System, eta: float, method: TimeStepping, closing_speed: float) -> ContactAlone | None:
    """Solve a contact of a system's bodies alone, with the step that a method has at η.

    Parameters
    ----------
    system : System
    eta : float
    method : Newmark or TimeStepping
    closing_speed : float
        nan where nothing collides; spring and damper need none.

    Returns
    -------
    ContactAlone or None
        None where there is no closing speed, or no such contact can be followed.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, System
    >>> from vibroscope.engine.one_impact.of_system import contact_alone
    >>> contact_alone(System(), 2.76, Newmark(12000, 16.1, 700), 1.0).words
    '0.50 without a step, 0.33 to 0.60 with 6.16 steps in it'
    """
    speed = 1.0 if method.linear and math.isnan(closing_speed) else closing_speed
    step = 2.0 * math.pi / (eta * method.steps)
    try:
        question = Impact(method, speed, system.mass_share, step, restitution=system.restitution)
    except ValueError:
        return None
    resolved = method.resolves_contacts or question.steps_per_contact > MOST_FOLLOWED
    # not `without_step`, which follows a contact that creeps back for a second
    restitution = restitution_of_units(question.unit_method, question.restitution)
    return ContactAlone(question, restitution, None if resolved else impact(question))


def alone_as_dict(alone: ContactAlone | None) -> dict[str, float | None]:
    """Plain numbers of a contact alone for scripts; None for those that are not known."""
    return {
        "contact_alone_steps": alone and alone.question.steps_per_contact,
        "contact_alone_restitution": alone and alone.restitution,
        **span_as_dict(alone, "contact_alone_restitution"),
    }


def span_as_dict(alone: ContactAlone | None, name: str = "restitution") -> dict[str, float | None]:
    """The restitution with the step over the instant of touch for scripts; None where it is not known."""
    e = alone and alone.found and alone.found.restitution
    return {f"{name}_{end}": e and finite_or_none(getattr(e, end)) for end in Span._fields}
