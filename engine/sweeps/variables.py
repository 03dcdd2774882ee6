"""The arrays of a result: what each of them is, and what the studies tell of a cell in the same words."""

from typing import NamedTuple

import numpy as np

from ..cells import STATUSES

MISSING = -1  # status and other flags of a cell that was not computed yet
STATUS_FLAGS = {str(status): i for i, status in enumerate(STATUSES)} | {"missing": MISSING}

# What `engine.run_cells` tells of a motion: name, dtype, meaning.
DESCRIBED = {
    "period": ("i4", "excitation periods until the motion repeats itself; 0: aperiodic"),
    "near_period": ("i4", "the same, scatter within 3 % of the section's size forgiven; 0: aperiodic"),
    "impacts_per_period": ("f8", "impacts per excitation period"),
    "contacts_per_period": ("f8", "contacts that begin per excitation period (reference: permanent contacts)"),
    "contact_share": ("f8", "share of the time in contact"),
    "longest_contact": ("f8", "longest contact, in units of tau"),
    "longest_contact_steps": ("f8", "longest contact in time steps"),
    "spread": ("f8", "standard deviation of xi2 over the section"),
}
# The same of a penalty method, which knows no impacts but the beginnings of its contacts.
OF_PENALTY = {name: told for name, told in DESCRIBED.items() if name != "contacts_per_period"}
OF_PENALTY["impacts_per_period"] = ("f8", "contacts that begin per excitation period")
ERRORS = {
    "error": "penalty less reference: rms of both displacements over that of the reference",
    "error_time_step": "its part by the time step, Newmark less exact penalty",
    "error_regularisation": "its part by K and D, exact penalty less reference with derived joint damping",
}


class Variable(NamedTuple):
    """One array of a result: its dimensions, dtype, meaning, and the names of whole numbers that are flags."""

    dims: tuple[str, ...]
    dtype: str
    meaning: str
    flags: dict[str, int] | None = None

    @property
    def fill(self) -> float | int:
        """What stands in cells that were not computed (yet)."""
        return np.nan if self.dtype.startswith("f") else MISSING

    @property
    def attributes(self) -> dict[str, object]:
        """Units and meaning, by the CF conventions."""
        named = {"units": "1", "long_name": self.meaning}
        if self.flags:
            named |= {"flag_values": list(self.flags.values()), "flag_meanings": " ".join(self.flags)}
        return named


class Whole(NamedTuple):
    """An array that is known before any cell is computed, and kept in one piece: coordinates, curves, the reference."""

    dims: tuple[str, ...]
    values: np.ndarray
    meaning: str

    @property
    def attributes(self) -> dict[str, object]:
        """Units and meaning, by the CF conventions."""
        return {"units": "1", "long_name": self.meaning}
