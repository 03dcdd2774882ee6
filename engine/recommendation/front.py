"""The Pareto front of error against cost: settings that no other setting beats in both."""

from collections.abc import Iterable

from vibroscope.engine.recommendation.trials import Trial


def pareto_front(trials: Iterable[Trial]) -> list[Trial]:
    """Return the trials that no other trial beats in both cost and robust error, cheapest first."""
    front: list[Trial] = []
    for trial in sorted(trials, key=lambda trial: (trial.cost, trial.robust)):
        if not front or trial.robust < front[-1].robust:
            front.append(trial)
    return front


def monotone_front(front: list[Trial], through: Trial) -> list[Trial]:
    """Return the longest part of a front through a trial along which n rises and the own error falls.

    ``through`` takes the place of a trial of the front with the same cost. A trial that is left out had a small own
    error by chance, or cheaper steps (if they are located) but more of them.
    """
    before = [trial for trial in front if trial.cost < through.cost and _follows(trial, through)]
    after = [trial for trial in front if trial.cost > through.cost and _follows(through, trial)]
    return [*_longest_chain(before), through, *_longest_chain(after)]


def _longest_chain(front: list[Trial]) -> list[Trial]:
    """Return the longest chain in which each trial follows the one before; of several, one that ends early."""
    chains: list[list[Trial]] = []  # the longest chain that ends with each trial
    for trial in front:
        earlier = (chain for chain in chains if _follows(chain[-1], trial))
        chains.append([*max(earlier, key=len, default=[]), trial])
    return max(chains, key=len, default=[])


def _follows(one: Trial, other: Trial) -> bool:
    """Whether the other trial has more steps and a smaller own error."""
    return other.setting.steps > one.setting.steps and other.error < one.error
