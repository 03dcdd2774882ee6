"""The fields of a system, of its excitation and of its units, each declared once, where its class has it.

What a number means, its unit in a file, what it may be, and what to do where it is not, stand with its default. The
class checks itself by that, and files, tables of the documentation and entries in physical units read it.
"""

from dataclasses import field, fields
from functools import cache
from typing import Any, NamedTuple

from vibroscope.engine.arguments import require, set_fields
from vibroscope.engine.wording import end_text


class Range(NamedTuple):
    """The range of a number, from low to high; open ends are excluded."""

    low: float
    high: float
    open_low: bool = False
    open_high: bool = False

    def holds(self, value: float) -> bool:
        """Whether a number lies between the ends."""
        above = value > self.low if self.open_low else value >= self.low
        return above and (value < self.high if self.open_high else value <= self.high)

    def words(self, unit: str) -> str:
        """The range in a sentence, as "above 0, at most 1000 kg"."""
        low, high = map(end_text, self[:2])
        first = f"above {low}, " if self.open_low else f"from {low} to "
        last = f"below {high}" if self.open_high else f"at most {high}" if self.open_low else high
        return f"{first}{last} {unit}".rstrip()


class Described(NamedTuple):
    """A field of a class: its meaning and unit as a file states them, and what it may be.

    Attributes
    ----------
    meaning, unit : str
    allowed : Range or None
        None of what is no number.
    advice : str
        What to do where it is out of range.
    words : str
        What it may be, where that is not the range alone.
    of_body_2 : bool
        Whether a wall has no such number.
    optional : bool
        Whether None may stand for it.
    """

    meaning: str
    unit: str
    allowed: Range | None
    advice: str = ""
    words: str = ""
    of_body_2: bool = False
    optional: bool = False

    @property
    def allowed_words(self) -> str:
        """What it may be, as in a file: "0 to below 1"."""
        return self.words or self.allowed.words("").removeprefix("from ")

    def check(self, name: str, value: float) -> float:
        """The number as float, -0.0 as 0.0; raises as :func:`.arguments.require`."""
        low, high, open_low, open_high = self.allowed
        return require(name, value, low, high, self.advice, open_low=open_low, open_high=open_high) + 0.0


def described(default: Any, *words: Any, **more: Any) -> Any:
    """A field of a dataclass with its default; the rest are those of :class:`Described`."""
    return field(default=default, metadata={"described": Described(*words, **more)})


@cache
def described_fields(kind: type) -> dict[str, Described]:
    """What each described field of a dataclass is, by its name."""
    return {each.name: each.metadata["described"] for each in fields(kind) if "described" in each.metadata}


def check_numbers(value: Any, without: tuple[str, ...] = ()) -> None:
    """Check the numbers of a frozen dataclass, but for those ``without``.

    Raises
    ------
    ValueError
        If one is out of range.
    """
    for name, each in described_fields(type(value)).items():
        number = getattr(value, name)
        if each.allowed is not None and name not in without and not (each.optional and number is None):
            set_fields(value, **{name: each.check(name, number)})
