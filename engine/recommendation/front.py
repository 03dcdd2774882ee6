"""The front of error against cost: settings that no other one beats."""

from collections.abc import Iterable

from .trials import Trial


def front_of(trials: Iterable[Trial]) -> list[Trial]:
    """Trials that no other beats in cost and robust error at once, cheapest first."""
    front: list[Trial] = []
    for trial in sorted(trials, key=lambda t: (t.cost, t.robust)):
        if not front or trial.robust < front[-1].robust:
            front.append(trial)
    return front


def falling(front: list[Trial], through: Trial) -> list[Trial]:
    """The longest part of a front, through one of its trials, along which n rises and the own error falls as well.

    What is left out owed its own error to luck, or has cheaper steps (if they are cut), but more of them.
    """
    at = front.index(through)
    before = [trial for trial in front[:at] if _follows(trial, through)]
    after = [trial for trial in front[at + 1 :] if _follows(through, trial)]
    return [*_longest(before), through, *_longest(after)]


def _longest(front: list[Trial]) -> list[Trial]:
    """The longest chain in which each trial follows the one before; of several, one that ends early."""
    chains: list[list[Trial]] = []  # the longest that ends with each trial
    for trial in front:
        earlier = (chain for chain in chains if _follows(chain[-1], trial))
        chains.append([*max(earlier, key=len, default=[]), trial])
    return max(chains, key=len, default=[])


def _follows(one: Trial, other: Trial) -> bool:
    return other.setting.steps > one.setting.steps and other.error < one.error
