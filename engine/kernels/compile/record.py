"""What a run leaves behind: arrays that the driver allocates, filled only over the kept periods."""

from typing import NamedTuple

import numpy as np

from .options import jit, spliced

IMPACT_COLUMNS = 8  # τ, ξ, ξ₁′ and ξ₂′ before, ξ₁′ and ξ₂′ after, impulse, closing speed

_COLUMNS = np.array([4, IMPACT_COLUMNS, 2, 1, 5])


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


class Folded(NamedTuple):
    """A record whose arrays lie in one: a call from Python takes each array apart that it is given, at some cost."""

    flat: np.ndarray  # (n,) section, impacts, contacts, phases and samples, one after the other
    sizes: np.ndarray  # (7,) int64: rows of each, then ``used``
    views: Record


def empty_record(periods: int, phases: np.ndarray, sampled_periods: int, capacity: int) -> Folded:
    """Zeroed buffers for ``periods`` kept periods, of which the last ``sampled_periods`` are sampled."""
    samples = sampled_periods * len(phases) + 1 if sampled_periods else 0
    sizes = np.array([periods, capacity, capacity, len(phases), samples, 0, 0], dtype=np.int64)
    flat = np.zeros(int(sizes[:5] @ _COLUMNS))
    ends = np.cumsum(sizes[:5] * _COLUMNS)
    parts = [flat[end - n * c : end] for end, n, c in zip(ends, sizes, _COLUMNS, strict=False)]
    section, impacts, contacts, kept_phases, sampled = (
        part if c == 1 else part.reshape(-1, c) for part, c in zip(parts, _COLUMNS, strict=True)
    )
    kept_phases[:] = phases
    return Folded(flat, sizes, Record(section, impacts, contacts, kept_phases, sampled, sizes[5:]))


@spliced
def unfold_record(flat, sizes):
    """The record of a :class:`Folded`, as views of its arrays."""
    a = sizes[0] * 4
    b = a + sizes[1] * IMPACT_COLUMNS
    c = b + sizes[2] * 2
    d = c + sizes[3]
    e = d + sizes[4] * 5
    section, impacts = flat[:a].reshape((sizes[0], 4)), flat[a:b].reshape((sizes[1], IMPACT_COLUMNS))
    contacts, samples = flat[b:c].reshape((sizes[2], 2)), flat[d:e].reshape((sizes[4], 5))
    return Record(section, impacts, contacts, flat[c:d], samples, sizes[5:])


@jit
def no_room(record):
    """Whether impacts or contacts, where they are kept, fill their buffers."""
    impacts, contacts = record.impacts.shape[0], record.contacts.shape[0]
    return (impacts > 0 and record.used[0] >= impacts) or (contacts > 0 and record.used[1] >= contacts)
