"""What the user has set: validated numbers, and their printing in the page's address.

Everything from outside (address, typed text, slider, forged message) passes
through `read`, as text, and is taken whole or not at all. No panel import.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple
from urllib.parse import parse_qsl, urlencode

import param

# A number as a person writes one. Stricter than float(), which also takes
# "nan", "inf", "1_000", other scripts' digits and any length.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?", re.ASCII)
_LONGEST_NUMBER = 40
_LONGEST_ADDRESS = 2000


class Refused(ValueError):
    """A value from outside that is not taken; the text is for the user."""

    def __init__(self, name: str, text: str) -> None:
        super().__init__(text)
        self.name = name


class Setting(NamedTuple):
    """One complete, valid setting of the explorer; hashable, so it can key a cache."""

    eta: float
    K: float
    D: float
    steps: int
    joint_damping: str
    frame: str
    coordinate: str


class Explorer(param.Parameterized):
    """The sliders and switches, with hard bounds."""

    eta = param.Number(1.08, bounds=(0.5, 4.0), label="η", doc="Excitation frequency Ω/ω₁")
    K = param.Number(2500.0, bounds=(10.0, 1e5), label="K", doc="Penalty stiffness")
    D = param.Number(8.0, bounds=(0.1, 100.0), label="D", doc="Penalty damping")
    steps = param.Integer(2000, bounds=(100, 32_000), label="T/Δτ", doc="Time steps per excitation period")
    joint_damping = param.Selector(
        default="table",
        objects=["table", "derived"],
        label="Joint damping d₃",
        doc="d₃ of the reference in permanent contact: the paper's table, or what the two dampers add up to",
    )
    frame = param.Selector(
        default="relative",
        objects=["relative", "absolute"],
        label="Displacement",
        doc="Displacement relative to the base, or as a fixed sensor sees it",
    )
    coordinate = param.Selector(
        default="xi2",
        objects=["xi1", "xi2"],
        label="Diagram shows",
        doc="Coordinate in the bifurcation diagram",
    )

    def setting(self) -> Setting:
        """A frozen copy of all values."""
        return Setting(**{name: getattr(self, name) for name in Setting._fields})

    def apply(self, texts: Mapping[str, str]) -> None:
        """Take all of ``texts``, or raise `Refused` and take none."""
        self.param.update(**read(texts))


def read(texts: Mapping[str, str]) -> dict[str, float | int | str]:
    """Values for the known names in ``texts``; raises `Refused` at the first bad one."""
    values: dict[str, float | int | str] = {}
    for name, text in texts.items():
        if name in Setting._fields:
            values[name] = _read_one(name, text)
    return values


def _read_one(name: str, text: object) -> float | int | str:
    rule = Explorer.param[name]
    if isinstance(rule, param.Selector):
        return _read_choice(name, text, rule.objects)
    return _read_number(name, text, rule.bounds, isinstance(rule, param.Integer))


def _read_choice(name: str, text: object, choices: list[str]) -> str:
    if not isinstance(text, str) or text not in choices:
        raise Refused(name, f"{name} must be {' or '.join(choices)}, not {_quote(text)}.")
    return text


def _read_number(name: str, text: object, bounds: tuple[float, float], whole: bool) -> float | int:
    low, high = bounds
    kind = "a whole number" if whole else "a number"
    wanted = f"{name} must be {kind} from {low:g} to {high:g}, not {_quote(text)}."
    if not isinstance(text, str) or len(text) > _LONGEST_NUMBER:
        raise Refused(name, wanted)
    if not _NUMBER.fullmatch(text.strip()):
        raise Refused(name, wanted)
    value = float(text)
    if not (math.isfinite(value) and low <= value <= high) or (whole and value != int(value)):
        raise Refused(name, wanted)
    return int(value) if whole else value


def _quote(text: object) -> str:
    """What was given, short enough to show."""
    shown = text if isinstance(text, str) else type(text).__name__
    printable = "".join(c if c.isprintable() else "�" for c in shown[:30])
    return f"“{printable}{'…' if len(shown) > 30 else ''}”"


def parse_address(query: str) -> dict[str, str]:
    """The known names in an address's query string, as text, each at most once."""
    query = query.removeprefix("?")
    if len(query) > _LONGEST_ADDRESS:
        raise Refused("address", "This address is too long to be one of this page's.")
    texts: dict[str, str] = {}
    for name, text in parse_qsl(query, keep_blank_values=True, errors="replace"):
        if name not in Setting._fields:
            continue  # links pick up other pages' parameters on their way
        if name in texts:
            raise Refused(name, f"The address gives {name} twice.")
        texts[name] = text
    return texts


def print_number(value: float | int) -> str:
    """The shortest text that reads back as exactly ``value``."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value)


def texts_of(setting: Setting) -> dict[str, str]:
    """Every value as the text that `read` takes back exactly."""
    return {name: value if isinstance(value, str) else print_number(value) for name, value in setting._asdict().items()}


def print_address(setting: Setting) -> str:
    """The query string that restores ``setting``; values at their default in switches are left out."""
    texts = texts_of(setting)
    numbers = {name: texts[name] for name in ("eta", "K", "D", "steps")}
    switches = {
        name: texts[name]
        for name in ("joint_damping", "frame", "coordinate")
        if texts[name] != Explorer.param[name].default
    }
    return urlencode(numbers | switches)
