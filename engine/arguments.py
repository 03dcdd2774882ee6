"""The border of the engine: the arguments of its public functions are what the annotations say, or refused in words.

Within the engine nothing is checked twice. Ranges are checked where the numbers are used (`require`).

An error names the value, what is allowed and what to do.
"""

import dataclasses
import difflib
import functools
import inspect
import math
import numbers
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

LARGEST_FLOAT = 1e308  # what a float can hold; nan and inf are refused with the range
_METHODS = f"{__package__}.methods"  # a function that cannot take every method says itself why
_SEQUENCES = (Iterable, Sequence)
Poll = Callable[[], bool]  # what a long computation calls many times a second: whether it is to end, with `Cancelled`


def checked(function: Callable) -> Callable:
    """The function with its arguments checked; numbers and flags of NumPy become those of Python.

    Raises
    ------
    ValueError
        If an argument is of another kind than annotated.
    """
    signature = inspect.signature(function)
    known = {
        name: parameter.annotation
        for name, parameter in signature.parameters.items()
        if parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    }

    plain = {name: _plain_types(annotation) for name, annotation in known.items()}
    names = tuple(signature.parameters)

    @functools.wraps(function)
    def call(*positional, **by_name):
        # Most arguments are plainly what is wanted, which is seen within some microseconds.
        if all(map(partial(_is_plain, plain), names, positional)) and all(
            map(partial(_is_plain, plain), by_name.keys(), by_name.values())
        ):
            return function(*positional, **by_name)
        bound = signature.bind(*positional, **by_name)
        for name in bound.arguments.keys() & known.keys():
            bound.arguments[name] = _checked(name, known[name], bound.arguments[name])
        return function(*bound.args, **bound.kwargs)

    return call


def check_fields(value: object) -> None:
    """Check the attributes of a frozen dataclass, as those of a public function's arguments.

    Raises
    ------
    ValueError
        If one is of another kind than annotated.
    """
    kinds = {each.name: each.type for each in dataclasses.fields(value)}
    set_fields(value, **{name: _checked(name, kind, getattr(value, name)) for name, kind in kinds.items()})


def set_fields(value: object, **checked: object) -> None:
    """Set fields of a frozen dataclass to what they were found to be, as its ``__post_init__`` may."""
    for name, found in checked.items():
        object.__setattr__(value, name, found)


def _plain_types(annotation: object) -> frozenset[type]:
    """Types of arguments that are taken as they are."""
    arms = typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)
    found = set()
    for arm in arms:
        if typing.get_origin(arm) in _SEQUENCES and typing.get_args(arm)[0] in (float, int, str):
            found |= {tuple, list}
        elif isinstance(arm, type) and typing.get_origin(arm) is None and arm is not inspect.Parameter.empty:
            found |= {float, int} if arm in (float, int) else {arm}
    return frozenset(found)


def _is_plain(plain: dict[str, frozenset[type]], name: str, value: object) -> bool:
    return type(value) in plain.get(name, ()) and (type(value) is not int or -LARGEST_FLOAT < value < LARGEST_FLOAT)


def _checked(name: str, annotation: object, value: object) -> object:
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        value = value.item()
    if not _fits(annotation, value):
        raise ValueError(f"{name} = {shown(value)} is not {_described(annotation)}")
    return bool(value) if annotation is bool else value


def _fits(annotation: object, value: object) -> bool:
    arms = typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)
    return any(_fits_one(arm, value) for arm in arms)


def _fits_one(annotation: object, value: object) -> bool:
    if annotation is float or annotation is int:
        return isinstance(value, numbers.Real) and (isinstance(value, float) or abs(value) < LARGEST_FLOAT)
    if annotation is bool:
        return isinstance(value, int) and value in (0, 1)
    if typing.get_origin(annotation) in _SEQUENCES:
        return hasattr(value, "__iter__") and _fit_elements(typing.get_args(annotation)[0], value)
    if not isinstance(annotation, type) or annotation is inspect.Parameter.empty:
        return True
    return isinstance(value, annotation) or annotation.__module__ == type(value).__module__ == _METHODS


def _fit_elements(annotation: object, values: Iterable) -> bool:
    """Whether the elements are of the class that is wanted; numbers and texts are checked where they are used."""
    if annotation in (float, int, str) or not isinstance(annotation, type) or isinstance(values, Iterator):
        return True
    return all(isinstance(value, annotation) for value in values)


def _described(annotation: object) -> str:
    arms = typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)
    names = {float: "a number", int: "a number", bool: "True or False", str: "a text", type(None): "None"}
    words = [
        "a sequence" if typing.get_origin(arm) in _SEQUENCES else names.get(arm, getattr(arm, "__name__", str(arm)))
        for arm in arms
    ]
    return " or ".join(dict.fromkeys(words))


def shown(value: object) -> str:
    """A value in a message: one line, and short however long it is."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # whole numbers beyond some thousand digits
        return "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:40]} … {text[-15:]}"


def require(name: str, value: float, low: float, high: float, advice: str, *, open_low=False, open_high=False) -> float:
    """``value`` as float if it is finite and lies between low and high.

    Raises
    ------
    ValueError
        Naming the value, the allowed range and what to do.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    above = number > low if open_low else number >= low
    below = number < high if open_high else number <= high
    if not (math.isfinite(number) and above and below):
        span = f"{'(' if open_low else '['}{low:g}, {high:g}{')' if open_high else ']'}"
        raise ValueError(f"{name} = {shown(value)} is outside {span}: {advice}")
    return number


def whole(name: str, value: float, low: int, high: int, advice: str) -> int:
    """``value`` as int if it is a whole number between low and high.

    Raises
    ------
    ValueError
        Naming the value, the allowed range and what to do.
    """
    number = require(name, value, low, high, advice)
    if number != int(number):
        raise ValueError(f"{name} = {shown(value)} is not a whole number: {advice}")
    return int(number)


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> str:
    """``value`` if it is one of the texts allowed; else a ValueError names them."""
    if not isinstance(value, str) or value not in allowed:
        raise ValueError(f"{name} = {shown(value)} is not one of {', '.join(allowed)}")
    return value


def near_names(name: str, known: Iterable[str]) -> list[str]:
    """The known names that are most like another one; none if no one is much like it."""
    close = difflib.get_close_matches(name, known, n=3)
    likeness = [difflib.SequenceMatcher(None, each, name).ratio() for each in close]
    return sorted(each for each, ratio in zip(close, likeness, strict=True) if ratio == likeness[0])


def flag(name: str, value: bool) -> bool:
    """``value`` as bool if it is True or False, NumPy's included; else a ValueError."""
    if type(value).__name__ not in ("bool", "bool_"):
        raise ValueError(f"{name} = {shown(value)} is not True or False")
    return bool(value)
