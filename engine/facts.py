"""Sentences that keep their facts: words, quantities with their dimension, symbols and choices; and their printer.

What the engine says of a result is a :class:`Statement`: text, which as a `str` has numbers without dimension and the
names that Python and the command line have for symbols and choices. It keeps the parts that it is made of, so that
:func:`print_statement` writes the same sentence in any units and with other names, whenever that is asked for. No
sentence is read again to find its numbers.

Statements are joined by ``+``, :func:`stated` and :func:`joined`. An f-string and `str.join` keep the text alone.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from vibroscope.engine.units import Units, time_text, written
from vibroscope.engine.wording import NOT_KNOWN, rounded_to

# Symbols that are others where numbers have a dimension.
_IN_UNITS = {"D": "2D", "eta": "f", "η": "f", "ξ₁": "x₁", "ξ₂": "x₂", "Δτ": "Δt"}
_QUANTITIES = {"K": "contact_stiffness", "D": "contact_damping", "eta": "frequency", "η": "frequency"}
_SET = {*_QUANTITIES.values(), "time"}  # quantities of numbers that are set
_STATEMENT = "statement"
ALL_DIGITS = 12  # of a number that was given, and is repeated as it is


class Amount(NamedTuple):
    """A number of the model with a dimension.

    Attributes
    ----------
    value : float
        Without dimension.
    quantity : str
        Its name in :data:`.units.QUANTITIES`.
    digits : int
        Significant digits. A number that is set is rounded to them before it is converted, so that both texts state
        one number; what is found is rounded where it is printed.
    bare : bool
        Whether its unit stands with a later number, as in "1.6 to 12.7 Hz".
    """

    value: float
    quantity: str
    digits: int = 4
    bare: bool = False

    def __str__(self) -> str:
        return written(self.value, self.digits) if math.isfinite(self.value) else NOT_KNOWN

    def in_units(self, units: Units) -> str:
        """The number in units, with its unit unless that follows."""
        if not math.isfinite(self.value):
            return NOT_KNOWN
        value = rounded_to(self.value, self.digits) if self.quantity in _SET else self.value
        if self.quantity == "time":
            return time_text(units.physical("time", value))
        text = units.text(self.quantity, value, 4 if self.quantity in _SET else min(self.digits, 4))
        return text.partition(" ")[0] if self.bare else text


class Symbol(NamedTuple):
    """A symbol whose form depends on the units or on who reads it, such as "D", "eta" or "ξ₂"."""

    name: str

    def __str__(self) -> str:
        return self.name


class Choice(NamedTuple):
    """One or several values of a setting that is no number, by their names in Python.

    ``text`` is what stands for them in plain text, if that is more than their names joined by "or".
    """

    field: str
    values: tuple[str, ...]
    text: str = ""

    def __str__(self) -> str:
        return self.text or " or ".join(self.values)


class Dimensionless(NamedTuple):
    """Words that stand only where numbers have no dimension, such as "τ = " before a time: a unit says as much."""

    words: str

    def __str__(self) -> str:
        return self.words


Fact = Amount | Symbol | Choice | Dimensionless
_FACTS = {"value": Amount, "name": Symbol, "field": Choice, "words": Dimensionless}  # by a key that each alone has

ETA, OMEGA1 = Symbol("eta"), Symbol("omega1")


class Statement(str):
    """Text without units, and the parts that it is made of.

    Parameters
    ----------
    *parts : str, Statement, Amount, Symbol, Choice or Dimensionless
        They follow each other without spaces.

    Attributes
    ----------
    parts : tuple of str, Amount, Symbol, Choice and Dimensionless

    Examples
    --------
    >>> from vibroscope.engine import Units, print_statement
    >>> from vibroscope.engine.facts import equation
    >>> text = equation("D", 18) + " leaves 5 %"
    >>> text, print_statement(text, Units(omega1=62.8, m1=25.0))
    ('D = 18 leaves 5 %', '2D = 56520 N·s/m leaves 5 %')
    """

    parts: tuple

    def __new__(cls, *parts):  # noqa: D102 - said by the class
        flat = [one for part in parts for one in parts_of(part)]
        found = super().__new__(cls, "".join(map(str, flat)))
        found.parts = tuple(_merged(flat))
        return found

    def __getnewargs__(self):  # so that copies and pickles are made of the parts
        return self.parts

    def __add__(self, other):
        return Statement(self, other) if isinstance(other, str) else NotImplemented

    def __radd__(self, other):
        return Statement(other, self) if isinstance(other, str) else NotImplemented

    @property
    def facts(self) -> tuple[Fact, ...]:
        """The parts that are no words."""
        return tuple(part for part in self.parts if not isinstance(part, str))

    @property
    def head(self) -> "Statement":
        """What stands for it where there is little room: all of it, but of a :class:`Reason`."""
        return self


class Reason(Statement):
    """A statement with a head that says the essential, and the rest behind it."""

    def __new__(cls, head="", rest=""):  # noqa: D102 - said by the class
        found = super().__new__(cls, head, rest)
        found._head, found._rest = Statement(head), rest
        return found

    def __getnewargs__(self):
        return self._head, self._rest

    @property
    def head(self) -> Statement:
        """The essential."""
        return self._head


class Ending(Statement):
    """Why a run ended early, as "what: cause; advice", or "what: cause; advice: limit".

    Parameters
    ----------
    what, cause, advice : str or Statement
        What happened and where, why, and what to change.
    limit : str, optional
        The limit that was passed, if it is known.
    """

    def __new__(cls, what="", cause="", advice="", limit=""):  # noqa: D102 - said by the class
        found = super().__new__(cls, what, ": ", cause, "; ", advice, *((": ", limit) if limit else ()))
        found.what, found.cause, found.advice, found.limit = what, cause, advice, limit
        return found

    def __getnewargs__(self):
        return self.what, self.cause, self.advice, self.limit

    @property
    def brief(self) -> Statement:
        """What happened, and the limit that was passed."""
        return joined(": ", filter(None, (self.what, self.limit)))

    @property
    def without_advice(self) -> Statement:
        """What happened, and why."""
        return joined(": ", (self.what, self.cause))


def parts_of(text: "str | Statement | Fact") -> tuple:
    """The parts of a statement; of text or a fact itself.

    Raises
    ------
    TypeError
        If it is none of them, as a number is that nobody has written.
    """
    if not isinstance(text, str | Fact):
        raise TypeError(f"a statement has no part {text!r}: give text, or a fact")
    return text.parts if isinstance(text, Statement) else (text,)


def _merged(parts: Iterable) -> Iterable:
    """The parts, words that follow each other as one."""
    words = ""
    for part in parts:
        if isinstance(part, str):
            words += part
            continue
        if words:
            yield words
        words = ""
        yield part
    if words:
        yield words


def stated(template: str, *parts: str | Fact) -> Statement:
    """A statement with parts in the places of ``{}``.

    Raises
    ------
    ValueError
        If there are more places than parts, or fewer.
    """
    first, *others = template.split("{}")
    return Statement(first, *(each for pair in zip(parts, others, strict=True) for each in pair))


def joined(separator: str, texts: Iterable[str | Fact]) -> Statement:
    """Statements with a separator between them."""
    return Statement(*[part for text in texts for part in (separator, text)][1:])


def equation(name: str, value: float, digits: int = 6, relation: str = " = ") -> Statement:
    """A number of a setting with its symbol, as "K = 2500"; one without a dimension is plain text."""
    quantity = _QUANTITIES.get(name)
    return Statement(Symbol(name), relation, Amount(value, quantity, digits) if quantity else f"{value:.{digits}g}")


def span(name: str, low: float, high: float, digits: int = 6) -> Statement:
    """A range of a number of a setting, as "K = 100 to 2500"; in units with the unit behind both ends."""
    quantity = _QUANTITIES.get(name)
    if quantity is None:
        return Statement(f"{name} = {low:.{digits}g} to {high:.{digits}g}")
    ends = Amount(low, quantity, digits, bare=True), Amount(high, quantity, digits)
    return Statement(Symbol(name), " = ", ends[0], " to ", ends[1])


def sentence(text: str | Statement) -> Statement:
    """Text with a capital letter and a full stop, without spaces around it."""
    first, *others = parts_of(text) or ("",)
    if isinstance(first, str):
        first = first.lstrip()
        first = first[:1].upper() + first[1:]
    *others, last = first, *others
    last = last.rstrip() if isinstance(last, str) else last
    return Statement(*others, last, "" if str(last).endswith(".") else ".")


def message_of(error: BaseException) -> str:
    """The message of an error, which `str` gives without its parts."""
    return error.args[0] if error.args and isinstance(error.args[0], Statement) else str(error)


def print_statement(
    text: str | Statement, units: Units | None = None, name: Callable[[Symbol | Choice], str] = str
) -> str:
    """Text with its numbers in units, and with names of symbols and choices.

    Parameters
    ----------
    text : str or Statement
        Plain text stays as it is.
    units : Units, optional
        Those of the contact law, where K and D occur; without them numbers have no dimension.
    name : callable, optional
        What stands for a symbol that has no other form in these units, and for a choice.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, System, Units, motion, print_statement, repetition
    >>> found = repetition(motion(System(), 2.76, Newmark(12000, 18, 8000)))
    >>> print_statement(found, Units(base_amplitude=0.5, system="mm-t-s"))
    'repeats every period, blurred by the time step (±0.017 mm in x₂)'
    """

    def printed(part: str | Fact) -> str:
        if isinstance(part, str):
            return part
        if isinstance(part, Amount):
            return str(part) if units is None else part.in_units(units)
        if isinstance(part, Dimensionless):
            return str(part) if units is None else ""
        known = units is not None and isinstance(part, Symbol) and _IN_UNITS.get(part.name)
        return known or name(part)

    return "".join(map(printed, text.parts)) if isinstance(text, Statement) else text


def as_json(value: object) -> object:
    """A value for `json.dumps`, in which each statement is ``{"statement": [part, …]}``."""
    if isinstance(value, Statement):
        return {_STATEMENT: [part if isinstance(part, str) else part._asdict() for part in value.parts]}
    if isinstance(value, Mapping):
        return {key: as_json(each) for key, each in value.items()}
    return [as_json(each) for each in value] if isinstance(value, list | tuple) else value


def read_statement(kept: dict) -> dict | Statement:
    """The ``object_hook`` with which `json.loads` reads what :func:`as_json` made."""
    return Statement(*map(_read_part, kept[_STATEMENT])) if kept.keys() == {_STATEMENT} else kept


def _read_part(kept: str | Mapping) -> str | Fact:
    if isinstance(kept, str):
        return kept
    kind = next(kind for key, kind in _FACTS.items() if key in kept)
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in kept.items()})
