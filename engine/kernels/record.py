"""What a run leaves behind: arrays that the driver allocates, filled only over the kept periods."""

from typing import NamedTuple

import numpy as np

from .jit import jit

IMPACT_COLUMNS = 8  # τ, ξ, ξ₁′ and ξ₂′ before, ξ₁′ and ξ₂′ after, impulse, closing speed


class Record(NamedTuple):
    """Buffers of one call of a kernel, and how many of their rows are in use.

    ``section`` (periods, 4); ``impacts`` (capacity, IMPACT_COLUMNS); ``contacts`` (capacity, 2);
    ``phases`` (m,): the instants of a period, as shares of T from 0 on, at which samples are taken; ``samples``
    (periods sampled × m + 1, 5): ξ₁, ξ₁′, ξ₂, ξ₂′, λ, the last row at the end of the run, or (0, 5) if none are asked
    for; ``used`` int64 (2,): rows of impacts and contacts in use.
    """

    section: np.ndarray
    impacts: np.ndarray
    contacts: np.ndarray
    phases: np.ndarray
    samples: np.ndarray
    used: np.ndarray


def empty_record(periods: int, phases: np.ndarray, sampled_periods: int, capacity: int) -> Record:
    """Zeroed buffers for ``periods`` kept periods, of which the last ``sampled_periods`` are sampled."""
    samples = sampled_periods * len(phases) + 1 if sampled_periods else 0
    return Record(
        np.zeros((periods, 4)),
        np.zeros((capacity, IMPACT_COLUMNS)),
        np.zeros((capacity, 2)),
        phases,
        np.zeros((samples, 5)),
        np.zeros(2, dtype=np.int64),
    )


@jit
def no_room(record):
    """Whether impacts or contacts, where they are kept, fill their buffers."""
    impacts, contacts = record.impacts.shape[0], record.contacts.shape[0]
    return (impacts > 0 and record.used[0] >= impacts) or (contacts > 0 and record.used[1] >= contacts)
