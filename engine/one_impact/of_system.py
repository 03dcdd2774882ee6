"""The contact of a system's bodies alone with the step of a run, as verdicts, recommendations and rules speak of it.

A contact is solved at the closing speeds of a motion, and what it gives with its step is said in words: the restitution
over the instant of touch, and what goes wrong.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.contact import check_speed, restitution_of_units
from vibroscope.engine.drivers.alone import BLOWN_UP, STUCK
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.one_impact.forward import Span, WithStep, impact, instants_of
from vibroscope.engine.one_impact.instants import Instants
from vibroscope.engine.one_impact.question import Impact
from vibroscope.engine.units import written
from vibroscope.engine.wording import finite_or_none, percent

CLASSES = 12  # of speeds, of equal width, each solved at its mean
_SHOWN = 5e-4  # share of the touches from which on it is said
MOST_FOLLOWED = 2000.0  # steps in a contact; what more of them change shows in no digit, and takes a second to find


class OverMotion(NamedTuple):
    """What steps make of the contacts of a motion, over its closing speeds and over the instants of touch.

    Least and greatest are over all of them; in means and shares each speed counts as often as it occurs.
    """

    speed: np.ndarray  # (n,), the mean of each class of closing speeds that occurs
    count: np.ndarray  # (n,), how many
    speeds: Span  # of all
    restitution: Span
    penetration: Span  # the deepest of each contact, likewise
    force: Span
    steps: Span  # in which the force acts
    without_solution: float
    blown_up: float
    stuck: float


def over_motion(question: Impact, speeds: Sequence[float] | np.ndarray) -> OverMotion:
    """The contact at all closing speeds of a motion, with the step as it is.

    The restitution of a linear law does not depend on the speed: one solution does for all. Of others speeds are put
    into 12 classes of equal width, whose means are solved, and for the ends the least and the greatest speed.

    Parameters
    ----------
    question : Impact
        Of a method with a time step; its own speed has no part in the answer.
    speeds : (n,) array_like
        Above 0, as often as they occur: :attr:`Impacts.closing_speed` of a run.

    Raises
    ------
    ValueError
        If there is no speed, or one at which there is no such contact; if there is no time step.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, over_motion
    >>> hertz = Impact(TimeStepping(1e6, 1e5, 4, law="hunt-crossley"), 1.0, time_step=1e-3)
    >>> found = over_motion(hertz, [0.5, 0.5, 0.5, 2.0])
    >>> found.count.tolist(), [round(e, 2) for e in found.restitution]
    ([3, 1], [0.79, 0.91, 0.96])
    """
    speeds = np.array([check_speed(each) for each in speeds])
    if not len(speeds):
        raise ValueError("there is no closing speed: give those of a motion in which the bodies meet")
    least, greatest = float(speeds.min()), float(speeds.max())
    which = np.minimum((CLASSES * (speeds - least) / ((greatest - least) or 1.0)).astype(int), CLASSES - 1)
    counts = np.bincount(which)
    means = np.bincount(which, speeds)[counts > 0] / counts[counts > 0]
    counts = counts[counts > 0]
    solved = np.concatenate([means, [least, greatest]])
    weights = np.concatenate([counts, [0, 0]]) / counts.sum()
    found = _solved(question, solved)

    def share(of) -> float:
        return float(weights @ [each.share(of(each)) for each in found])

    def span(of) -> Span:
        ends = np.array([each.ends(of(each)) for each in found])
        known = weights * [each.share(np.isfinite(of(each))) for each in found]
        if not known.sum():
            return Span(np.nan, np.nan, np.nan)
        middle = known[known > 0] @ [each.mean(of(each)) for each, k in zip(found, known, strict=True) if k > 0]
        return Span(float(np.nanmin(ends)), float(middle / known.sum()), float(np.nanmax(ends)))

    return OverMotion(
        means,
        counts,
        Span(least, float(speeds.mean()), greatest),
        span(lambda each: each.restitution),
        span(lambda each: each.depth),
        span(lambda each: each.force),
        span(lambda each: each.steps),
        share(lambda each: each.unsolved),
        share(lambda each: each.code == BLOWN_UP),
        share(lambda each: each.code == STUCK),
    )


def _solved(question: Impact, speeds: np.ndarray) -> list[Instants]:
    """The contact at each of the speeds."""
    if question.depends_on_speed:
        return [instants_of(replace(question, speed=float(speed))) for speed in speeds]
    one = instants_of(question)
    grown = speeds / question.speed
    return [one._replace(depth=one.depth * times, force=one.force * times) for times in grown]


def steps_text(steps: float) -> str:
    """Steps in a contact, as they are written wherever they are counted."""
    return written(steps, 3)


def restitution_text(value: float) -> str:
    """A restitution with two decimals; with three digits where it is none any more."""
    return f"{value:z.2f}" if value < 9.995 else written(value, 3)


def ends_text(*ends: str) -> str:
    """From one to the other, or the one that both are."""
    return " to ".join(dict.fromkeys(ends))


def span_text(found: WithStep) -> str:
    """The restitution from the least to the greatest over the instant of touch; empty if no touch has a result."""
    if math.isnan(found.restitution.mean):
        return ""
    return ends_text(restitution_text(found.restitution.least), restitution_text(found.restitution.greatest))


def shares_text(found: WithStep) -> str:
    """The touches that do not end as they should, after a semicolon; empty if there are none."""
    kinds = {
        "have a step without a solution": found.without_solution,
        "have a step with two solutions": found.two_solutions,
        "blow up": found.blown_up,
        "stay together": found.stuck,
        "part faster than they came": found.gained,
    }
    texts = [f"{percent(share)} of the touches {words}" for words, share in kinds.items() if share > _SHOWN]
    return f"; {', '.join(texts)}" if texts else ""


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
