"""The motion whose branch is searched for first: the search finds the others in its order, so a link holds it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from vibroscope.app.explorer.link import LINEAR
from vibroscope.app.explorer.parameters import START_FIELDS, bounds_of
from vibroscope.app.explorer.state import Setting

_NAMES = ("followed", *(name.replace("start", "followed") for name in START_FIELDS))  # in a link: η and the state


class Followed(NamedTuple):
    """The motion at ``initial`` (ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0), or that a run from there settles to."""

    eta: float
    initial: tuple[float, ...]

    @classmethod
    def of(cls, setting: Setting) -> Followed:
        """The motion from the start of a setting."""
        return cls(setting.eta, tuple(map(float, setting.initial)))

    def linked(self) -> dict[str, float]:
        """Numbers for a link, from which `linked_motion` reads the same; a state that is 0 is left out."""
        return {name: number for name, number in zip(_NAMES, (self.eta, *self.initial), strict=True) if number}


def linked_motion(choice: Mapping[str, float]) -> Followed | None:
    """The motion that the choices of a link name; None if they name none."""
    eta, *state = (choice.get(name) for name in _NAMES)
    return None if eta is None else Followed(eta, tuple(number or 0.0 for number in state))


def link_numbers() -> list[dict]:
    """Names and bounds of the numbers in a link."""
    bounds = [bounds_of("eta"), *[LINEAR] * len(START_FIELDS)]
    return [
        {"name": name, "low": low, "high": high, "whole": False}
        for name, (low, high) in zip(_NAMES, bounds, strict=True)
    ]


def without_motion(choice: Mapping[str, str | float]) -> dict[str, str | float]:
    """The choices of a link that the panel has, too."""
    return {name: value for name, value in choice.items() if name not in _NAMES}
