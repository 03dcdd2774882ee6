"""The penalty solution in words, integrator, contact status and law; and the contact force. No panel import.

An impact has an impulse and no peak force. Where a contact is shorter than the samples show, the impulse is given with
its duration and its mean.
"""

import math
from dataclasses import fields
from typing import TYPE_CHECKING

from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.engine import INTEGRATORS, Method, TimeStepping, Units, counted, written
from vibroscope.engine.law_table import numbers_of
from vibroscope.engine.units import time_text

if TYPE_CHECKING:  # it imports the whole description of motions
    from vibroscope.engine import Motion

CUT = "cut at contact"  # of steps that end where contact changes, as titles and legends have it
STEP_NAMES = {"fixed": "constant step", "located": f"step {CUT}"}
_STATUSES = {
    "start": "contact status from the start of the step",
    "end": "contact status iterated to the end of the step",
    "located": "steps cut where contact changes",
}


def name_of_integrator(name: str) -> str:
    """The name of an integrator alone, as "HHT-α"."""
    return INTEGRATORS[name].short_title()


def name_of_method(method: Method) -> str:
    """A penalty solution with a time step in a few words, as "HHT-α, forces averaged (α = −0.05)"."""
    if not method.has_step:
        return str(method.name)
    if not method.has_choices:
        return f"Newmark, {CUT}" if method.located else "Newmark"
    own = method.integrator
    values = {each.name: written(getattr(own, each.name)).replace("-", "−") for each in fields(own)}
    labels = {name: FIELDS[name].label if name in FIELDS else name for name in values}
    numbers = ", ".join(f"{labels[name]} = {value}" for name, value in values.items())
    return f"{own.title} ({numbers})" if numbers else own.title


def words_of_method(method: Method) -> str:
    """Name, contact status and law of a method; empty for Newmark's, the page's default."""
    if not method.has_choices:
        return ""
    law = FIELDS["law"].choices[method.law]
    damper = ", its damper from the restitution" if method.damping is None else ""
    return f"{name_of_method(method)}; {_STATUSES.get(method.status, method.status)}; contact law {law}{damper}"


def words_of_scheme(method: TimeStepping) -> str:
    """Name, contact status and law of any method with a time step."""
    law = FIELDS["law"].choices[method.law]
    return f"{name_of_integrator(method.integrator.name)}; {_STATUSES[method.status]}; contact law {law}"


def full_words(method: Method, *, wall: bool = False) -> str:
    """Any method with its numbers, as the head of a report, in characters that each terminal has.

    ``wall``: the system has one, and so no joint damping.
    """
    if method.rigid:
        damping = {"table": "as measured", "derived": "that of both dampers"}[method.joint_damping]
        joint = "" if wall else f"; joint damping {damping}"
        return f"reference{joint}; threshold {method.threshold:g}"
    own = ", ".join(f"{name} {getattr(method, name):g}" for name in numbers_of(method.law))
    law = f"{method.law} ({own})" if own else method.law
    damper = "D from the restitution" if method.damping is None else f"D = {method.damping:g}"
    numbers = f"K = {method.stiffness:g}, {damper}"
    if not method.has_step:
        return f"exact penalty; contact law {law}; {numbers}"
    integrator = method.integrator
    own = ", ".join(f"{each.name} {getattr(integrator, each.name):g}" for each in fields(integrator))
    name = f"{integrator.name} ({own})" if own else integrator.name
    every = "; every step taken" if method.every_step else ""
    return f"{name}; {_STATUSES[method.status]}; contact law {law}; {numbers}, {method.steps} steps a period{every}"


def brief_name(method: TimeStepping) -> str:
    """The name of a method in titles and legends, without numbers and default choices, as "HHT-α, Hunt–Crossley"."""
    parts = [name_of_integrator(method.integrator.name)]
    if method.status == "end":
        parts.append("status at the end")
    if not method.linear:
        parts.append(FIELDS["law"].choices[method.law])
    return ", ".join(parts)


def scheme_as_dict(method: TimeStepping) -> dict[str, str]:
    """Integrator, contact status and law for a file."""
    return {"integrator": method.integrator.name, "status": method.status, "law": method.law}


def scheme_texts(method: TimeStepping) -> dict[str, str]:
    """Integrator, contact status and law with their numbers, as texts for `app.explorer.reading.read_setting`."""
    names = ("status", "without_solution", "law", "initial_acceleration")
    numbers = {name: repr(value) for name, value in method.law_numbers.items() if value is not None}
    own = {each.name: repr(getattr(method.integrator, each.name)) for each in fields(method.integrator)}
    choices = {name: getattr(method, name) for name in names}
    choices["damper"] = "restitution" if method.damping is None else "typed"
    return {"integrator": method.integrator.name, **own, **numbers, **choices}


def has_peak_force(motion: "Motion") -> bool:
    """Whether a peak force has a meaning: not where the bodies meet in impacts alone."""
    return not (motion.peak_force == 0 and motion.impacts_per_period > 0)


def plain_motion(motion: "Motion") -> dict:
    """A motion as JSON without dimension; a peak force that has no meaning is None."""
    return motion.as_dict() | ({} if has_peak_force(motion) else {"peak_force": None})


def force_text(units: Units, eta: float, motion: "Motion", method: Method) -> str:
    """Peak force, or what takes its place; empty without contact.

    Where the motion does not repeat itself in the periods that have samples, others may have a higher one, and that is
    said.
    """
    impulse = f"impulse {units.text('impulse', motion.impulse)} per period"
    if math.isnan(motion.peak_force):
        duration = motion.contact_share * 2 * math.pi / eta
        if not duration > 0:
            return ""
        mean = units.text("force", motion.impulse / duration)
        lasts = time_text(units.physical("time", duration))
        return f"contacts too short to sample a peak force: {impulse} in {lasts} of contact, mean {mean}"
    peak = f"peak force {units.text('force', motion.peak_force)}" if motion.peak_force > 0 else ""
    if peak and not 0 < motion.period <= motion.sampled:
        peak += f" in {counted(motion.sampled, 'period')}"
    if method.rigid and motion.impacts_per_period > 0:
        where = f"{peak} in permanent contact; " if peak else ""
        return f"{where}impacts have an impulse and no peak force: {impulse}"
    return peak
