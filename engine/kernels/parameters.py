"""The numbers that define one run: what Python hands to compiled code, and what every table is set up from."""

from typing import NamedTuple

import numpy as np

from .compile.options import jit_no_alloc
from .compile.packing import Layout


class Parameters(NamedTuple):
    """The numbers of one run, in the order in which tables depend on them: flight, contact, laws."""

    eta: float
    kappa: float
    d1: float
    d2: float
    steps: float  # n; 0 for the solvers in closed form
    kappa3: float
    d3: float
    mu: float
    mass_share: float  # μ/(1 + μ)
    stiffness: float
    damping: float
    restitution: float
    threshold: float
    law: float  # index in equations.contact_law.LAWS


FOR_FLIGHT = Parameters._fields.index("steps") + 1  # numbers that the tables of flight depend on …
FOR_CONTACT = Parameters._fields.index("damping") + 1  # … and those of contact

unpack_parameters = Layout(Parameters).unpack


def no_keys() -> np.ndarray:
    """The keys of tables that have not been set up: no number equals them."""
    return np.full((2, len(Parameters._fields)), np.nan)


@jit_no_alloc
def renew_key(key, row, count):
    """Whether one of the first ``count`` numbers has changed; the key then holds the new ones."""
    changed = False
    for k in range(count):
        changed |= key[k] != row[k]
        key[k] = row[k]
    return changed
