"""``vibroscope branch --from-basin``: the motions that a study of basins found, and which of them are on no branch."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine import Branch, BranchQuestion, continue_branch
from vibroscope.engine.sweeps import KIND_FLAGS, check_store

BESIDE = 0.1  # of the distance of two neighbouring orbits: so far from the chord between them one may lie
SAME = 1e-6  # of the size of a motion: closer is equal


class BasinSeeds(NamedTuple):
    """The periodic motions of a study of basins.

    Attributes
    ----------
    target : str
        Where it is.
    eta : float
    numbers : dict
        Those of the system and of the method, by name.
    sections : tuple of (p, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ of each motion at τ = 0, T, … (p − 1)T.
    """

    target: str
    eta: float
    numbers: dict[str, dict]
    sections: tuple[np.ndarray, ...]

    def check(self, question: BranchQuestion) -> None:
        """Raise a ValueError if the study is of another system, η or method, or lies outside the range."""
        of_method = {name: getattr(question.method, name, None) for name in self.numbers["method"]}
        ours = {"eta": question.eta} | question.system.as_dict() | of_method
        theirs = {"eta": self.eta} | self.numbers["system"] | self.numbers["method"]
        for name, value in theirs.items():
            if ours.get(name) != value:
                raise ValueError(
                    f"{self.target} is of {name} = {value}, and here it is {ours.get(name)}: branches begin at the "
                    "motions of the same problem; give its numbers"
                )
        low, value, high = question.low, question.value, question.high
        if not low <= value <= high:
            raise ValueError(
                f"{question.over} = {value:g} of {self.target} lies outside {low:g} … {high:g}: take it in"
            )

    def unknown(self, question: BranchQuestion, found: list[Branch], cancelled: Callable[[], bool]) -> Iterator[Branch]:
        """Follow each motion that lies on no branch found so far."""
        for rows in self.sections:
            known = any(passes(branch, question.value, rows) for branch in found)
            if len(rows) <= question.max_period and not known:
                yield continue_branch(replace(question, initial=rows[0]), cancelled=cancelled)


def read_basin(target: str) -> BasinSeeds:
    """The motions of a result of ``vibroscope sweep basin``.

    Raises
    ------
    ValueError
        If it is none, or not complete.
    """
    import xarray

    check_store(target)  # raises a ValueError in words where there is no result
    found = xarray.open_zarr(target)
    if "motion_section" not in found:
        raise ValueError(f"{target} is no complete result of `vibroscope sweep basin`")
    numbers = {name: json.loads(found.attrs[name]) for name in ("system", "method")}
    names = ("motion_kind", "motion_period", "motion_section")
    kinds, periods, sections = (found[name].values for name in names)
    periodic = KIND_FLAGS["periodic"]
    motions = (rows[:period] for kind, period, rows in zip(kinds, periods, sections, strict=True) if kind == periodic)
    return BasinSeeds(target, float(found.attrs["eta"]), numbers, tuple(motions))


def passes(branch: Branch, value: float, rows: np.ndarray) -> bool:
    """Whether a branch passes a motion (p, 4) where its number has a value, whichever period of the cycle is first."""
    if branch.period != len(rows):
        return False
    sides = branch.values - value
    for k in np.flatnonzero(sides[:-1] * sides[1:] <= 0):
        (low, high), ends = sides[[k, k + 1]], branch.sections[[k, k + 1]]
        share = 0.0 if low == high else low / (low - high)
        between, apart = ends[0] + share * (ends[1] - ends[0]), np.abs(ends[1] - ends[0]).max()
        away = min(np.abs(np.roll(rows, turn, axis=0) - between).max() for turn in range(len(rows)))
        if away <= BESIDE * apart + SAME * np.abs(rows).max():
            return True
    return False
