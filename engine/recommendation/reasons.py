"""Why no setting meets a tolerance, in words: runs without a time step and without joint damping find the cause."""

import math
from dataclasses import replace

from vibroscope.engine.arguments import Poll
from vibroscope.engine.contact import equal_damping, equal_restitution_damping
from vibroscope.engine.divergence.conditions import unequal_stops_text
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.grid import PER_PERIOD
from vibroscope.engine.facts import ETA, Amount, Reason, Statement, equation, joined, stated
from vibroscope.engine.methods import Reference, TimeStepping
from vibroscope.engine.motions.description import describe
from vibroscope.engine.motions.steady import Steady, steady
from vibroscope.engine.motions.words import touching
from vibroscope.engine.recommendation.contacts import Tolerances
from vibroscope.engine.recommendation.question import SettingQuestion
from vibroscope.engine.recommendation.trials import MISSES, VERIFIED, Trial, Trials
from vibroscope.engine.result import Record
from vibroscope.engine.simulate import KEEP, LONG, simulate
from vibroscope.engine.wording import percent, rounded


def aperiodic_reference_reason(found: Steady) -> Reason:
    """Say that the reference does not repeat itself, so that no error exists at each instant."""
    if not found.response.ok:
        return Reason(f"the reference itself ended as {found.response.status}", ": " + found.response.message)
    return Reason(
        stated("the reference's motion at {} does not repeat itself", equation("eta", found.response.eta)),
        stated(
            " ({}), so two solutions drift apart whatever K, D and the step are, and no error exists at each instant: "
            "set K, D and n by a neighbouring {} with periodic motion, and compare statistics (motion type, impacts "
            "per period, section)",
            found.message,
            ETA,
        ),
    )


def idle_reason(found: Steady) -> Statement:
    """Say that there is nothing to recommend: nothing drives the bodies, or nothing touches; else empty."""
    if not found.response.system.excitation.drives:
        return Statement(
            "Nothing drives the bodies, so that they come to rest: there is no steady motion that K and D could change."
        )
    described = describe(found.response, found.period)
    fact = touching(described)
    if fact and described.contact_share > 0 and found.response.system.wall:
        return Statement(
            f"{fact} Body 1 rests against the wall: it does not move, so that no error relative to its motion exists."
        )
    return Statement(fact if described.contact_share == 0.0 else "")


def joint_damping_error(target: Target, reference: Reference, cancelled: Poll | None = None) -> float:
    """Return the error of the reference with derived joint damping, which no K, D or time step can remove.

    nan if that motion does not repeat itself.
    """
    run = target.reference
    derived = steady(run.system, run.eta, replace(reference, joint_damping="derived"), cancelled=cancelled)
    return target.error(derived.response, cancelled) if derived.periodic else math.nan


def error_without_time_step(target: Target, method: TimeStepping, cancelled: Poll | None = None) -> float:
    """Return the error of the limit of a method without a time step, which K and D alone cause."""
    run = target.reference
    options = {"periods": LONG, "keep": KEEP, "record": Record(KEEP, PER_PERIOD), "cancelled": cancelled}
    return target.error(simulate(run.system, run.eta, method.limit, **options), cancelled)


def unmet_tolerance_reason(
    trials: Trials, front: list[Trial], joint_damping: float, question: SettingQuestion, cancelled: Poll | None = None
) -> Reason:
    """Say what keeps the error above the tolerance, and what to do about it.

    Parameters
    ----------
    trials : Trials
    front : list of Trial
        The settings found, least error last; may be empty.
    joint_damping : float
        From :func:`joint_damping_error`.
    question : SettingQuestion
    """
    target, tolerances, limits = trials.target, question.tolerances, question.limits
    tolerance = tolerances.displacement
    stiffness_max = limits.stiffness_max if limits.stiffness is None else limits.stiffness
    if not front:
        none = stated(
            "no {} gave a run that reached its end within {} steps",
            equation("K", stiffness_max, relation=" up to "),
            str(limits.steps_max),
        )
        if trials.scheme.counts_solutions and trials.scheme.without_solution == "stop":
            return Reason(
                none, ": with contact at the end, a step has no solution sooner or later; keep its status or halve it"
            )
        return Reason(none, ": allow more steps")
    system, least = target.reference.system, front[-1]
    error = percent(least.robust, beside=tolerance)
    kept = f"the least robust error, which half the step and 9 in 10 neighbours keep to, is {error}"
    found = f"{kept}, with {least.setting.steps} steps per period"
    if joint_damping > tolerance:
        return Reason(
            f"the joint damping alone makes an error of {percent(joint_damping)}",
            f": the reference holds d3 = {system.d3:g} in permanent contact, the two dampers give "
            f"{system.derived_joint_damping:.3g}, and K, D and the step are not made to supply the rest; {found}. "
            "Allow a larger tolerance, or compare with the derived joint damping (d3 from d1 and d2)",
        )
    if least.robust <= tolerance:
        return _contacts_reason(least, tolerances)
    return _reason_of_numbers(trials, least, stiffness_max, found, question, cancelled)


def _reason_of_numbers(
    trials: Trials, least: Trial, stiffness_max: float, found: str, question: SettingQuestion, cancelled: Poll | None
) -> Reason:
    """Say which of the step, the dampers of two stops, what is held, and K keeps the displacements off."""
    target, tolerance, limits = trials.target, question.tolerances.displacement, question.limits
    system = target.reference.system
    damping = limits.damping
    if damping is None:
        damping = equal_damping(system, trials.scheme, stiffness_max, trials.closing_speed)
        damping = damping if math.isfinite(damping) else equal_restitution_damping(system, stiffness_max)
    stiffest = stiffness_max, damping
    pairs = dict.fromkeys(((least.setting.stiffness, least.setting.damping), stiffest))  # one, where both are held
    methods = [replace(trials.scheme, stiffness=stiffness, damping=d) for stiffness, d in pairs]
    if min(error_without_time_step(target, method, cancelled) for method in methods) <= tolerance:
        advice = "allow more steps" + ("" if trials.located else ", or cut them where contact changes")
        why = f": without one, K and D would meet the tolerance; {found}: {advice}"
        return Reason("the time step is to blame", why)
    if words := unequal_stops_text(system, methods[0], trials.closing_speed):
        return Reason("the dampers of the stops are to blame", f": {words}; {found}")
    held = [
        equation(name, value) for name, value in (("K", limits.stiffness), ("D", limits.damping)) if value is not None
    ]
    if held:
        return Reason(
            stated("{}, which is held, is to blame", joined(" and ", held)),
            f": the error stays too large even without a time step; {found}: let the search choose",
        )
    return Reason(
        "K is to blame",
        stated(
            ": up to {} the contact stays too soft, even without a time step; {}: allow a larger K",
            Amount(stiffness_max, "contact_stiffness", 6),
            found,
        ),
    )


def _contacts_reason(least: Trial, tolerances: Tolerances) -> Reason:
    """Say that displacements are met, and what is not."""
    found = f"the displacements keep to {percent(tolerances.displacement)} with {least.setting.steps} steps per period"
    if least.excess <= 1.0:
        return Reason(
            f"{found}, but not reliably",
            f": run from rest, more than {MISSES} of {VERIFIED} settings within one or two "
            "per cent of K, D and the steps miss it, or stop: allow more steps",
        )
    asked = [
        f"{name} within {value}"
        for name, value in (
            ("a restitution", tolerances.restitution and rounded(tolerances.restitution, 2)),
            ("a peak force", tolerances.force and percent(tolerances.force)),
        )
        if value
    ]
    what = f"{found}, but the contacts do not with {' and '.join(asked) or 'a restitution of 1'}"
    return Reason(what, ": allow more steps")
