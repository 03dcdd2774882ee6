"""The instants at which a run under a load is sampled, so that its peaks are known."""

from dataclasses import dataclass, field

import numpy as np
from vibroscope.engine.checks import require
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.result import Record
from vibroscope.engine.simulate import SAMPLES_LIMIT

CYCLE_SAMPLES = 128  # in the fastest cycle without contact: a peak between them is missed by 3e-4 of it at most
CONTACT_SAMPLES = 64  # in a contact
CONTACT_CYCLE = 12  # … at least so many in a cycle of a penalty contact that lasts


@dataclass(frozen=True, eq=False)
class Instants(Record):
    """A request for samples at given shares of a run."""

    shares: np.ndarray = field(default_factory=lambda: np.zeros(1))

    @classmethod
    def of(cls, shares: np.ndarray) -> "Instants":
        """The record of these shares, of one period."""
        return cls(1, len(shares), None, shares)

    def phases(self, steps: int) -> np.ndarray:
        """The shares themselves."""
        return self.shares


def instants_of(system: System, method: Method, contacts: np.ndarray, depth: float = 0.0) -> np.ndarray:
    """Shares of the run at which it is sampled: even ones, the beginnings of segments of the load, and contacts.

    ``depth``: the deepest penetration, at which a spring of another law than Kδ is stiffest.
    """
    load = system.excitation.load
    fastest = max(1.0, 1.0 if system.wall else system.kappa, load.frequency)
    count = int(np.ceil(CYCLE_SAMPLES * fastest * load.length / (2 * np.pi)))
    stiffer = max(1.0, system.stiffness_factor2)  # of two stops
    rate = 0.0
    if not method.rigid:
        n = method.spring_exponent
        stiffer *= (method.stiffening or 1.0) * n * depth ** (n - 1.0)
        rate = np.sqrt(stiffer * method.stiffness / system.mass_share)
    lengths = contacts[:, 1] - contacts[:, 0]
    within = CONTACT_SAMPLES + (CONTACT_CYCLE * rate * lengths / (2 * np.pi)).astype(int)
    total = count + len(load.segments) + int(within.sum())
    require("samples", total, 1, SAMPLES_LIMIT, "take a shorter load, or a shorter time after it")
    spans = zip(contacts, within, strict=True)
    inside = [np.linspace(*span, number, endpoint=False) for span, number in spans]
    shares = np.concatenate(
        [np.arange(count) / count, load.segments[:, 0] / load.length, *(x / load.length for x in inside)]
    )
    shares = np.unique(shares)
    return shares[shares < 1.0]
