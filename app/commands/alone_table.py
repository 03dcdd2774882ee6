"""``vibroscope compare --alone``: the difference over each number alone, as tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from vibroscope.engine import Method, Units, percent, written
from vibroscope.engine.divergence.alone import Alone, Curve
from vibroscope.engine.methods import METHOD_NUMBERS

_HEADS = {"K": "K", "D": "D", "steps": "steps a period"}
_PHYSICAL = {"K": ("stiffness", "K"), "D": ("damping", "2D")}  # name in Units.settings, which is a quantity, and symbol
_LEAST = 1e-4  # a smaller part is rounding
_RESOLVED = {"K": "10 steps in a contact, fewer above", "steps": "10 steps in a contact, fewer below"}


def alone_lines(found: Alone | None, eta: float, method: Method, units: Units | None) -> list[str]:
    """Return a table for each number: values, what each leaves, and marks; K and D in ``units``, too, if given."""
    if found is None:
        return ["", "There is nothing to search for over K, D and the step."]
    lines = []
    for name, curve in found.curves.items():
        rows = [(_HEADS[name], _unit(name, units), "left", "")]
        rows += [
            ("none" if math.isinf(v) else written(v), _physical(name, v, eta, method, units), left, mark)
            for v, left, mark in _rows(found, curve)
        ]
        widths = [max(len(row[i]) for row in rows) for i in range(3)]
        lines.append("")
        for row in rows:
            cells = [cell.rjust(width) for cell, width in zip(row, widths, strict=False) if width]
            lines.append("  ".join([*cells, row[-1]]).rstrip())
    if any(curve.best is not None for curve in found.curves.values()):
        lines += ["", "At best: the middle of where a number works, by the median of the values within 10 %."]
    if found.floor > _LEAST:
        lines += ["", f"The joint damping makes {percent(found.floor)}: no K, D or step mends that."]
    return lines


def _rows(found: Alone, curve: Curve) -> Iterator[tuple[float, str, str]]:
    """Value, what it leaves, and marks, by ascending values; inf steps are none."""
    left = dict(zip(curve.values.tolist(), curve.left.tolist(), strict=True))
    better = "" if curve.best is not None else "; no value that was tried leaves less"
    marks: dict[float, list[str]] = {curve.present: [f"present{better}"]}
    left[curve.present] = found.total
    if curve.best is not None:
        left[curve.best.value] = curve.best.left
        marks.setdefault(curve.best.value, []).append("at best")
    for value, words in ((curve.equal, "equal restitution"), (curve.resolved, _RESOLVED.get(curve.name, ""))):
        if math.isfinite(value):
            marks.setdefault(value, []).append(words)
    for value in sorted({*left, *marks}):
        text = "" if value not in left else percent(left[value]) if math.isfinite(left[value]) else "ended early"
        yield value, text, "; ".join(marks.get(value, ()))


def _unit(name: str, units: Units | None) -> str:
    if units is None or name not in _PHYSICAL:
        return ""
    quantity, symbol = _PHYSICAL[name]
    return f"{symbol} / ({units.unit(quantity)})".replace("·", ".")


def _physical(name: str, value: float, eta: float, method: Method, units: Units | None) -> str:
    """The value in units, as the settings of a run with it have it."""
    if units is None or name not in _PHYSICAL:
        return ""
    run = replace(method, **{METHOD_NUMBERS[name]: value})
    return written(units.settings(eta, run)[_PHYSICAL[name][0]])
