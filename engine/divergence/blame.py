"""Which number is to blame for a difference: one definition, applied to what the search over each number found.

Let T be the difference, and L(x) what the best change of one number or choice x leaves, by the median of its
neighbourhood (:mod:`.alone`). What chance explains counts as left in any case. L is the least of all L(x), or what K
with D at equal restitution leaves, if that is less than two thirds of it.

- x is *to blame* if it removes three quarters of what can be removed, L(x) ≤ T − ¾(T − L), and half of T, and no other
  leaves less than two thirds of what x leaves. All x of which this holds are named: one alone, or each of two or more.
- Where the contact rebounds as asked and is resolved (:mod:`.conditions`), a change after which it does not is no x:
  what it leaves less is errors that cancel, and gone with another step.
- Another law is named only where no number does as well. Status and integrator are what a time step consists of. They
  are named in place of the steps where they do as well.
- The joint damping is named only where its part is the largest of all, and larger than chance.
- If no number does so alone, or only where errors cancel (:mod:`.conditions`), K and D, or K, D and a step that
  resolves the contact, are named *together* if they leave less than two thirds of what any number leaves alone, and at
  most half of T.
- Otherwise nothing is to blame; nor if what is left is more than APART.
"""

import math
from dataclasses import dataclass, replace

from vibroscope.engine.divergence.alone import Alone, Change
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.conditions import conditions, stay_together
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.search import enough_steps, search_together
from vibroscope.engine.divergence.tolerances import APART, EQUALLY, HALF, NEARLY, REMOVED, SAME_CURVE, TIE, WORKS
from vibroscope.engine.methods import ExactPenalty, TimeStepping

OF_STEPS = ("status", "integrator")


@dataclass(frozen=True)
class Blame:
    """The numbers or choices to blame.

    Attributes
    ----------
    changes : tuple of Change
        One for each that is to blame, each alone; the one to try first comes first. Empty if nothing is.
    together : Change or None
        Several numbers that have to be changed together, if none is to blame alone.
    least : float
        What is left at best, of all that was tried.
    more_steps : Change or None
        Where the time step, its status or integrator is to blame: a number of steps that does nearly as well.
    cancelling : tuple of Change
        Those after which the contact does not rebound as asked, or is not resolved: errors cancel.
    """

    changes: tuple[Change, ...] = ()
    together: Change | None = None
    least: float = 0.0
    more_steps: Change | None = None
    cancelling: tuple[Change, ...] = ()


def find_blame(comparison: Comparison, found: Alone, remaining: Remaining) -> Blame:
    """Return what is to blame, by some more runs where no number removes three quarters alone."""
    difference = comparison.difference
    total, chance = difference.total, difference.chance
    changes = [each for each in found.changes if each.changed != "joint damping" or _counts(comparison)]
    if holds(comparison, comparison.runs.penalty.method):
        changes = [each for each in changes if not contact_fails(comparison, each)]
    alone = max(min((each.robust for each in changes), default=total), chance)
    if total <= max(SAME_CURVE, chance):
        return Blame(least=min(alone, total))
    most, pair = min(HALF * total, APART), None
    if alone > (1.0 - REMOVED) * total:
        pair = _better(search_together(comparison, remaining), alone, chance)
    least = pair.robust if pair else alone
    if alone <= min(most, enough := total - REMOVED * (total - least)):
        enough = max(EQUALLY * alone, min(TIE * alone, enough))
        named = [each for each in changes if max(each.robust, chance) <= enough]
        found_alone = _of_numbers(comparison, _narrowed(named), remaining, least)
        if pair is None or len(found_alone.cancelling) < len(found_alone.changes):
            return found_alone
    if pair is None or pair.robust > most:
        pair = _better(search_together(comparison, remaining, with_step=True), least, chance) or pair
    if pair is not None and pair.robust <= most and (pair := _as_compared(pair, remaining)).robust <= most:
        return Blame(together=pair, least=pair.robust)
    return Blame(least=min(alone, total))


def _as_compared(change: Change, remaining: Remaining) -> Change:
    """The change with what a comparison with it has, whose runs may be longer than those of a search."""
    found = remaining.compared(change.method)
    left = found.total if found and math.isfinite(found.total) else math.inf
    return replace(change, left=left, robust=max(change.robust, left / WORKS), difference=found)


def _better(together: Change | None, alone: float, chance: float) -> Change | None:
    """The change of several numbers if it leaves less than two thirds of what one alone leaves, and not by chance."""
    return together if together is not None and TIE * max(together.robust, chance) <= alone else None


def _of_numbers(comparison: Comparison, named: list[Change], remaining: Remaining, least: float) -> Blame:
    """Name changes, those after which the contact holds first; a step with a number of steps that does."""
    steps = next((each for each in named if each.changed in ("steps", *OF_STEPS)), None)
    more = None
    if steps is not None and (steps.changed != "steps" or not steps.method.has_step):
        more = enough_steps(comparison, remaining, max(NEARLY * steps.robust, SAME_CURVE, comparison.difference.chance))
    if more is not None and steps.changed == "steps":
        named = [more if each is steps else each for each in named]
    cancelling = tuple(each for each in named if contact_fails(comparison, each))
    named = sorted(named, key=lambda each: (each in cancelling, each.robust))
    return Blame(tuple(named), None, least, more, tuple(each for each in named if each in cancelling))


def contact_fails(comparison: Comparison, change: Change) -> bool:
    """Whether after a change the contact does not rebound as asked, or is not resolved: what agrees then is luck."""
    return change.method is not None and not holds(comparison, change.method)


def holds(comparison: Comparison, method: ExactPenalty | TimeStepping) -> bool:
    """Whether the contact of a method rebounds as asked and is resolved, or the bodies never part."""
    run, speed = comparison.runs.penalty, comparison.closing_speed
    return stay_together(comparison) or conditions(run.system, run.eta, method, speed).hold


def _counts(comparison: Comparison) -> bool:
    """Whether the part of the joint damping is the largest, and no chance."""
    parts = comparison.difference.parts
    return comparison.difference.largest == "joint_damping" and parts["joint_damping"] > comparison.difference.chance


def _narrowed(named: list[Change]) -> list[Change]:
    """The changes with one of the time step: the choice within it that does nearly as well, or else the steps."""
    numbers = [each for each in named if each.changed != "law"]
    named = numbers or named  # another law is named only where no number does as well
    of_steps = [each for each in named if each.changed in ("steps", *OF_STEPS)]
    if not of_steps:
        return named
    enough = max(NEARLY * min(each.robust for each in of_steps), SAME_CURVE)
    choice = next((each for each in of_steps if each.changed in OF_STEPS and each.robust <= enough), of_steps[0])
    return [each for each in named if each is choice or each not in of_steps]
