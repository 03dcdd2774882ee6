"""Record buffers: arrays that a driver allocates and a kernel fills over the kept periods."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_spliced, uncompiled
from vibroscope.engine.kernels.compile.views import shaped

IMPACT_COLUMNS = 8  # τ, ξ, ξ₁′ and ξ₂′ before, ξ₁′ and ξ₂′ after, impulse, closing speed

_COLUMNS = np.array([4, IMPACT_COLUMNS, 2, 1, 5])


class Buffers(NamedTuple):
    """Buffers of one call of a kernel, and how many of their rows are in use.

    ``section`` (periods, 4); ``impacts`` (capacity, IMPACT_COLUMNS); ``contacts`` (capacity, 2);
    ``phases`` (m,): the instants of a period at which samples are taken, as shares of T from 0 on; ``samples``
    (periods sampled × m + 1, 5): ξ₁, ξ₁′, ξ₂, ξ₂′, λ, the last row at the end of the run, or (0, 5) if none are asked
    for; ``used`` int64 (2,): rows of impacts and contacts in use.
    """

    section: np.ndarray
    impacts: np.ndarray
    contacts: np.ndarray
    phases: np.ndarray
    samples: np.ndarray
    used: np.ndarray


class PackedBuffers(NamedTuple):
    """Buffers that lie in one array, since a call from Python takes time for each array argument."""

    flat: np.ndarray  # (n,) section, impacts, contacts, phases and samples, one after the other
    sizes: np.ndarray  # (7,) int64: rows of each, then ``used``
    views: Buffers


def make_buffers(periods: int, phases: np.ndarray, sampled_periods: int, capacity: int) -> PackedBuffers:
    """Zeroed buffers for ``periods`` kept periods, of which the last ``sampled_periods`` are sampled."""
    samples = sampled_periods * len(phases) + 1 if sampled_periods else 0
    sizes = np.array([periods, capacity, capacity, len(phases), samples, 0, 0], dtype=np.int64)
    flat = np.zeros(int(sizes[:5] @ _COLUMNS))
    views = uncompiled(unpack_buffers)(flat, sizes)
    views.phases[:] = phases
    return PackedBuffers(flat, sizes, views)


@jit_spliced
def unpack_buffers(flat, sizes):
    """The buffers as views of a packed array."""
    a = sizes[0] * 4
    b = a + sizes[1] * IMPACT_COLUMNS
    c = b + sizes[2] * 2
    d = c + sizes[3]
    e = d + sizes[4] * 5
    section, impacts = shaped(flat[:a], (sizes[0], 4)), shaped(flat[a:b], (sizes[1], IMPACT_COLUMNS))
    contacts, samples = shaped(flat[b:c], (sizes[2], 2)), shaped(flat[d:e], (sizes[4], 5))
    return Buffers(section, impacts, contacts, flat[c:d], samples, sizes[5:])


@jit_inlined
def no_room(buffers):
    """Whether impacts or contacts, where they are recorded, fill their buffers."""
    impacts, contacts = buffers.impacts.shape[0], buffers.contacts.shape[0]
    return (impacts > 0 and buffers.used[0] >= impacts) or (contacts > 0 and buffers.used[1] >= contacts)


class OpenContact(NamedTuple):
    """The contact that is open, as every solver keeps it until it ends."""

    begun: float  # τ since the start of the run
    closing: float  # closing speed at its beginning; 0 if it began without an impact, or before the kept periods
    position: float  # ξ₁ at its beginning
    speed1: float  # ξ₁′
    speed2: float  # ξ₂′
    impulse: float  # ∫λ dτ so far


@jit_inlined
def no_contact():
    """No contact is open."""
    return OpenContact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit_inlined
def unrecorded_contact(begun):
    """A contact that begins outside the kept periods, so that its impact is not recorded."""
    return OpenContact(begun, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit_inlined
def with_impulse(contact, impulse):
    """The open contact with another impulse."""
    t = contact
    return OpenContact(t.begun, t.closing, t.position, t.speed1, t.speed2, impulse)


@jit_inlined
def record_impact(buffers, time, position, before, after, impulse, closing):
    """Append an impact; ``before`` and ``after``: ξ₁′ and ξ₂′."""
    row = buffers.impacts[buffers.used[0]]
    row[0], row[1], row[2], row[3] = time, position, before[0], before[1]
    row[4], row[5], row[6], row[7] = after[0], after[1], impulse, closing
    buffers.used[0] += 1


@jit_inlined
def record_contact(buffers, contact, end, after, impact):
    """Append a contact that ends at τ = ``end``, and its impact if it has one; ``after``: ξ₁′ and ξ₂′ at the end."""
    row = buffers.contacts[buffers.used[1]]
    row[0], row[1] = contact.begun, end
    buffers.used[1] += 1
    if impact and contact.closing > 0.0:
        before = contact.speed1, contact.speed2
        record_impact(buffers, contact.begun, contact.position, before, after, contact.impulse, contact.closing)
