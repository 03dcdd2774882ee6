"""What the sentences of a verdict state, read from their words: changes and what each leaves, counts, kinds, times."""

import re
from dataclasses import replace
from typing import NamedTuple

from vibroscope.engine import NewmarkBeta, with_located_steps

_SHARE = r"(?P<left>more than 1000|\d+(?:\.\d+)?) %"
_NUMBER = r"[\d.]+(?:e[+-]?\d+)?"
_STEPS = r"(?P<steps>\d[\d,]*) steps a period"
_CHANGE = re.compile(
    rf"(?P<what>(?:K = (?P<K>{_NUMBER}))?(?:, )?(?:\bD = (?P<D>{_NUMBER}))?(?:, )?(?:{_STEPS})?"
    r"|no time step|without it|status \w+|steps cut where contact changes|that at the (?:end|start)"
    r"|integrator newmark|Newmark's ¼ and ½, which damp nothing,|(?:the )?law limited(?:, which has none,)?"
    rf"|no joint damping of its own)(?: would leave| leaves| leave)? {_SHARE}"
)


class Left(NamedTuple):
    """A change as it is printed, and what it is said to leave.

    ``name`` is "K", "D", "steps", "limit" (no time step), "status", "integrator", "law", "joint damping", or "several".
    """

    name: str
    left: float
    numbers: dict
    words: str


def changes_in(text):
    """Every change that a text says to leave something, in its order."""
    return [_left(found, text) for found in _CHANGE.finditer(text) if found["what"].strip(", ")]


def _left(found, text):
    names = {"K": "stiffness", "D": "damping", "steps": "steps"}
    numbers = {name: float(found[name].replace(",", "")) for name in names if found[name]}
    settings = {names[name]: int(value) if name == "steps" else value for name, value in numbers.items()}
    what, left = found["what"].strip(", "), share(found["left"])
    if len(numbers) > 1:
        return Left("several", left, settings, what)
    if numbers:
        return Left(next(iter(numbers)), left, settings, what)
    joint = "joint damping" in what or (what == "without it" and re.search("[Jj]oint damping[^:]* to blame", text))
    if joint:
        return Left("joint damping", left, {}, what)
    if what in ("no time step", "without it"):
        return Left("limit", left, {}, what)
    if what.startswith(("integrator", "Newmark")):
        return Left("integrator", left, {"integrator": NewmarkBeta()}, what)
    if "law" in what:
        return Left("law", left, {"law": "limited"}, what)
    status = "located" if "cut" in what else what.split()[-1]
    return Left("status", left, {"status": status}, what)


def share(text):
    """A percentage as a fraction; what is only said to be large as 10."""
    return 10.0 if text.startswith("more") else float(text) / 100


def apply(method, change):
    """The method with a change as a user would set it; None if it is not one of the method."""
    if change.name == "joint damping":
        return method
    if change.name == "limit":
        return method.limit
    if change.numbers.get("status") == "located":
        return with_located_steps(method)
    return replace(method, **change.numbers)


def first(pattern, texts):
    """The numbers of the first text that holds a pattern with groups; None if there is none."""
    found = next(filter(None, (re.search(pattern, text) for text in texts)), None)
    return found and [float(each.replace(",", "")) for each in found.groups()]


def kinds_in(headline):
    """What a headline says of how the penalty solution repeats, and the reference; None if it says nothing."""
    found = re.search(
        r"the penalty solution ((?:is|repeats|nearly|does|blew)[^;]*?), the reference ([^;]*?)(?:, and |;)", headline
    )
    return found and found.groups()
