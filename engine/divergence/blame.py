"""Which number is to blame for a difference: one definition, applied to what the search over each number found.

Let T be the difference, L the least that any change leaves, and L(x) what the best change of one number or choice x
leaves, by the median of its neighbourhood (:mod:`.alone`). What chance explains counts as left in any case. Then

- x is *to blame* if it removes three quarters of what can be removed, L(x) ≤ T − ¾(T − L), and no other leaves less
  than two thirds of what x leaves. All x of which this holds are named: one alone, or each of two or more.
- Another law is named only where no number does as well. Status and integrator are what a time step consists of. They
  are named in place of the steps where they do as well.
- The joint damping is named only where its part is the largest of all, and larger than chance.
- If nothing does so alone, and K with D at equal restitution, or both with a step that resolves the contact, leave
  less, these are named *together*.
- Otherwise nothing is to blame: nothing removes HELPS of the difference, or what is left is more than APART.
"""

from dataclasses import dataclass

from ..methods import ExactPenalty
from .agreement import SAME
from .alone import Alone, Change, enough_steps, search_together
from .compare import Comparison
from .conditions import conditions
from .encounters import mean_closing_speed
from .remaining import Remaining

REMOVED = 0.75  # share of what can be removed that a number to blame removes
EQUAL = 1.2  # times the least: a number that leaves no more is to blame as well, whatever it removes
TIE = 1.5  # times the least: the same of a number that removes as much as that
HELPS = 0.25  # share of the difference that must be removed for anything to be to blame
APART = 0.85  # of the reference: motions that are left so far apart have nothing in common
NEARLY = 1.3  # times as much may be left with a status, integrator or number of steps that stands for no step at all
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
    """

    changes: tuple[Change, ...] = ()
    together: Change | None = None
    least: float = 0.0
    more_steps: Change | None = None


def find_blame(comparison: Comparison, found: Alone, remaining: Remaining) -> Blame:
    """Return what is to blame, by some more runs where no number does alone."""
    difference = comparison.difference
    total, chance = difference.total, difference.chance
    changes = [each for each in found.changes if each.changed != "joint damping" or _counts(comparison)]
    alone = max(min((each.robust for each in changes), default=total), chance)
    least, together = alone, None
    if alone > (1.0 - REMOVED) * total:
        together = min(search_together(comparison, remaining), key=lambda each: each.robust, default=None)
        least = max(min(alone, together.robust if together else total), chance)
    if total <= max(SAME, chance) or least > (1.0 - HELPS) * total:
        return Blame(least=min(least, total))
    enough = total - REMOVED * (total - least)
    if alone <= min(enough, APART):
        enough = max(EQUAL * alone, min(TIE * alone, enough))
        named = [each for each in changes if max(each.robust, chance) <= enough]
        return _of_numbers(comparison, _narrowed(named), remaining, least)
    return Blame(together=together if together and together.robust <= APART else None, least=least)


def _of_numbers(comparison: Comparison, named: list[Change], remaining: Remaining, least: float) -> Blame:
    """Name changes, those after which the contact holds first; a step with a number of steps that does."""
    steps = next((each for each in named if each.changed in ("steps", *OF_STEPS)), None)
    more = None
    if steps is not None and (steps.changed != "steps" or isinstance(steps.method, ExactPenalty)):
        more = enough_steps(comparison, remaining, max(NEARLY * steps.robust, SAME, comparison.difference.chance))
    if more is not None and steps.changed == "steps":
        named = [more if each is steps else each for each in named]
    run, speed = comparison.runs.penalty, mean_closing_speed(comparison.runs.reference)

    def fails(change: Change) -> bool:
        return change.method is not None and not conditions(run.system, run.eta, change.method, speed).hold

    return Blame(tuple(sorted(named, key=lambda each: (fails(each), each.robust))), None, least, more)


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
    enough = max(NEARLY * min(each.robust for each in of_steps), SAME)
    choice = next((each for each in of_steps if each.changed in OF_STEPS and each.robust <= enough), of_steps[0])
    return [each for each in named if each is choice or each not in of_steps]
