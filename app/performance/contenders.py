"""Solvers of one problem under one interface, so that they can be timed in turns.

All contenders take turns in one process, and medians over many turns count; a ratio is the median of the turns' own
ratios. A machine that is slower for a while is then slower for all, and since seconds are the processor's, other
programs do not count. Each timed run follows a short one that is not timed, which brings code and tables back into the
caches. Only solving is timed, not what a solver prepares once: the engine's tables, heyoka's compilation.
"""

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from vibroscope.app.performance.peers import PeerSolver
from vibroscope.engine import Method, Response, System, simulate

PERIODS = 200
CHECKED = 10  # periods after which a state is compared with the truth
SYSTEM = System()


@dataclass(frozen=True)
class Contender:
    """A solver of one problem from rest.

    Attributes
    ----------
    name : str
    solve : callable
        Takes the number of periods; returns processor seconds and the state at their end, (4,).
    """

    name: str
    solve: Callable[[int], tuple[float, np.ndarray]]


def engine_seconds(solve: Callable[[], Response]) -> tuple[float, Response]:
    """Processor seconds in compiled code, from above, and the response.

    The response counts them by the wall clock, which goes on while another program has the processor; then the
    processor seconds of the whole call, its preparation included, are the closer bound.
    """
    begin = time.thread_time()
    response = solve()
    return min(response.cost.seconds, time.thread_time() - begin), response


def engine_contender(name: str, eta: float, method: Method) -> Contender:
    """A solver of the engine; its state is nan where the run ended early."""

    def solve(periods):
        seconds, response = engine_seconds(lambda: simulate(SYSTEM, eta, method, periods=periods, keep=1))
        return seconds, response.section[-1] if response.ok else np.full(4, math.nan)

    return Contender(name, solve)


def peer_contender(name: str, run: PeerSolver) -> Contender:
    """A solver that is not the engine's, with nothing left to prepare."""

    def solve(periods):
        begin = time.thread_time()
        state = run(periods)
        return time.thread_time() - begin, state

    return Contender(name, solve)


def run_seconds(contender: Contender, periods: int) -> float:
    """Seconds of one run, its code and tables fresh in the caches."""
    if periods > CHECKED:
        contender.solve(CHECKED)
    return contender.solve(periods)[0]


def time_in_turns(contenders: Iterable[Contender], periods: int, rounds: int) -> dict[str, np.ndarray]:
    """Microseconds per period of each contender in each round, (rounds,); in a round all take turns."""
    contenders = list(contenders)
    for contender in contenders:  # compiles
        contender.solve(CHECKED)
    turns = [[run_seconds(contender, periods) for contender in contenders] for _ in range(rounds)]
    seconds = dict(zip((contender.name for contender in contenders), np.array(turns).T, strict=True))
    return {name: spent / periods * 1e6 for name, spent in seconds.items()}


def ratio(turns: dict[str, np.ndarray], theirs: str, ours: str) -> float | None:
    """How many times as long ``theirs`` takes as ``ours``; None if it did not run."""
    return float(np.median(turns[theirs] / turns[ours])) if theirs in turns else None
