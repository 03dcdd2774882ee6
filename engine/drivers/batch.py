"""Driver of many cells: room, rules and order for the compiled code that runs them."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.accelerated.skip import SIZE as LEAPS_SIZE
from ..kernels.accelerated.skip import SLOTS
from ..kernels.accelerated.step_map import FREE, REACHES
from ..kernels.batch import run as kernel
from ..kernels.batch import section_statistics as tally
from ..kernels.batch.course import EXACT, LEAPS, REFERENCE
from ..kernels.batch.recurrence import CYCLE
from ..kernels.compile.packing import room
from ..kernels.compile.record import empty_record
from ..kernels.event_driven import setup
from ..kernels.event_driven.state import Anchor, Touch
from ..methods import ExactPenalty, Method, Newmark, Reference
from ..motions.section import MOST_NEARLY, SCATTER, TOLERANCE
from .base import CAPACITY
from .event_driven import COMPLETION
from .newmark import SHORTEST_STRIDE
from .slow_subspace import circles
from .threads import Worker

_KINDS = {Reference: REFERENCE, ExactPenalty: EXACT, Newmark: LEAPS}


class Plan(NamedTuple):
    """What is asked of every cell."""

    transient: int
    sample: int
    early_stop: bool
    coordinates: tuple[int, ...]


def compiled_for(method: Method, numbers: np.ndarray) -> bool:
    """Whether compiled code runs these cells: all but those whose every step is walked."""
    if not isinstance(method, Newmark):
        return True
    cells = setup.Cell(*numbers.T)
    fastest = np.maximum(np.maximum(cells.kappa, cells.eta), 1.0)
    strides = SHORTEST_STRIDE * fastest * 2 * math.pi / cells.eta / cells.steps
    return not (method.every_step or method.located) and bool((strides <= REACHES[FREE]).all())


def empty_results(n: int, plan: Plan) -> kernel.Results:
    """Results of cells that have not been run."""
    return kernel.Results(
        status=np.zeros(n, dtype=np.int64),
        section=np.full((n, plan.sample, len(plan.coordinates)), np.nan),
        numbers=np.full((n, tally.NUMBERS), np.nan),
        end=np.full((n, 4), np.nan),
        periods=np.zeros(n, dtype=np.int64),
    )


def compiled_worker(
    method: Method,
    numbers: np.ndarray,
    initial: np.ndarray,
    order: np.ndarray,
    chained: np.ndarray,
    plan: Plan,
    results: kernel.Results,
):
    """What gives each thread its worker (see :func:`.threads.share_out`).

    Parameters
    ----------
    numbers : (n, len(Cell)) ndarray
    initial : (n, 4) ndarray
    order : (n,) ndarray of int64
        The cells in the order of their places.
    chained : (n,) ndarray of bool
        Whether the cell at a place goes on from the one at the place before.
    """
    kind = _KINDS[type(method)]
    columns = np.array(plan.coordinates, dtype=np.int64)
    rules = TOLERANCE, SCATTER, MOST_NEARLY, COMPLETION
    settings = kernel.Plan(kind, plan.transient, plan.sample, plan.early_stop, columns, *rules)
    between = circles(numbers) if kind == EXACT else np.zeros((len(order), 2))
    work = kernel.Work(order, chained, numbers, initial, between)

    def worker() -> Worker:
        own = make_room(kind, plan.sample)
        return lambda places, signals, slot: kernel.run_cells(work, places, settings, own, results, signals, slot)

    return worker


def make_room(kind: int, sample: int) -> kernel.Room:
    """Room for one thread."""
    leaping = kind == LEAPS
    slots = SLOTS if leaping else len(Anchor._fields) + len(Touch._fields) - 1
    nothing, cycle, kept = (empty_record(rows, np.zeros(1), 0, CAPACITY if rows else 0) for rows in (0, CYCLE, sample))
    return kernel.Room(
        folded=room(LEAPS_SIZE if leaping else setup.CLOSED_SIZE),
        keys=setup.no_keys(),
        state=np.zeros(slots),
        before=np.zeros(slots),
        nothing=nothing.flat,
        no_sizes=nothing.sizes,
        cycle=cycle.flat,
        cycle_sizes=cycle.sizes,
        kept=kept.flat,
        kept_sizes=kept.sizes,
        cycle_log=np.zeros((CYCLE, tally.COLUMNS)),
        log=np.zeros((sample, tally.COLUMNS)),
    )
