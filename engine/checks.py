"""Checks of numbers, choices and flags, with errors that name the value, what is allowed and what to do."""

import math

from vibroscope.engine.arguments import shown


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


def flag(name: str, value: bool) -> bool:
    """``value`` as bool if it is True or False, NumPy's included; else a ValueError."""
    if type(value).__name__ not in ("bool", "bool_"):
        raise ValueError(f"{name} = {shown(value)} is not True or False")
    return bool(value)
