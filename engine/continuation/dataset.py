"""Branches as labelled arrays (xarray)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets import LENGTH, SPEED, labelled
from ..model import COORDINATES
from .branch import Branch
from .margins import POINT_KINDS

if TYPE_CHECKING:
    import xarray as xr


def branches_dataset(branches: Sequence[Branch], over: str | None = None) -> "xr.Dataset":
    """Branches of periodic motions, one after the other.

    Parameters
    ----------
    branches : sequence of Branch
        Over one number.
    over : str, optional
        That number; needed where there is no branch.

    Returns
    -------
    xarray.Dataset
        Of each ``orbit``: the number that varies, ``branch``, ``period``, ``stable``, ``section`` (cycle, coordinate;
        nan beyond the period), ``multiplier_real`` and ``multiplier_imag`` (multiplier). Of each ``point``: its kind,
        value, branch and state.
    """
    import xarray as xr

    over = over or branches[0].over
    longest = max((branch.period for branch in branches), default=1)
    count = sum(len(branch.values) for branch in branches)
    section, first = np.full((count, longest, 4), np.nan), 0
    for branch in branches:
        section[first : first + len(branch.values), : branch.period] = branch.sections
        first += len(branch.values)
    of_orbit = [np.full(len(branch.values), k) for k, branch in enumerate(branches)]
    periods = [np.full(len(branch.values), branch.period) for branch in branches]
    multipliers = np.concatenate([np.empty((0, 4), complex), *(branch.multipliers for branch in branches)])
    values = np.concatenate([np.empty(0), *(branch.values for branch in branches)])
    stable = np.concatenate([np.empty(0, bool), *(branch.stable for branch in branches)])
    points = [(k, point) for k, branch in enumerate(branches) for point in branch.points]
    kinds = np.array([POINT_KINDS.index(point.kind) for _, point in points], dtype="i1")
    states = np.array([point.state for _, point in points]).reshape(-1, 4)
    names = " ".join(kind.replace(" ", "_") for kind in POINT_KINDS)
    flags = {"long_name": "kind of the point", "flag_values": list(range(len(POINT_KINDS))), "flag_meanings": names}
    per_cycle, rows = "per cycle", ("orbit", "multiplier")
    return xr.Dataset(
        {
            over: labelled("orbit", values, "number that varies", "1"),
            "branch": labelled("orbit", np.concatenate([np.empty(0, int), *of_orbit]), "branch of the orbit", "1"),
            "period": labelled(
                "orbit", np.concatenate([np.empty(0, int), *periods]), "excitation periods of the cycle", "1"
            ),
            "stable": labelled("orbit", stable, "stable", "1"),
            "section": labelled(("orbit", "cycle", "coordinate"), section, "Poincaré section", f"{LENGTH}, {SPEED}"),
            "multiplier_real": labelled(rows, multipliers.real, "Floquet multipliers", per_cycle),
            "multiplier_imag": labelled(rows, multipliers.imag, "Floquet multipliers", per_cycle),
            "point_kind": ("point", kinds, flags),
            "point_value": labelled("point", [point.value for _, point in points], "number that varies", "1"),
            "point_branch": labelled("point", [k for k, _ in points], "branch of the point", "1"),
            "point_state": labelled(("point", "coordinate"), states, "state at tau = 0 mod T", f"{LENGTH}, {SPEED}"),
        },
        attrs={"over": over, "coordinates_of_states": " ".join(COORDINATES)},
    )
