"""Solve the published cases and compare."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from vibroscope.app.validation.cases import PublishedCase, PublishedFigure, cases
from vibroscope.app.validation.measures import MEASURES, SolvedCase

# unit of a figure: the quantity of `Units` that it belongs to
_KINDS = {
    "N": "force",
    "s": "time",
    "m": "displacement",
    "m/s": "velocity",
    "N·s": "impulse",
    "Hz": "frequency",
}
_ARGUMENT_KINDS = {"time": "time", "force": "force"}  # arguments of measures that have a dimension


@dataclass(frozen=True)
class ComparedFigure:
    """A published figure beside ours.

    Attributes
    ----------
    case : PublishedCase
    quantity : PublishedFigure
    ours : float
        In the unit of the quantity.
    seconds : float
        What it took, the solution included where it was not there yet.
    """

    case: PublishedCase
    quantity: PublishedFigure
    ours: float
    seconds: float

    @property
    def difference(self) -> float | None:
        """(ours − published)/published; None where nothing is published."""
        return None if self.quantity.published is None else self.ours / self.quantity.published - 1

    @property
    def error(self) -> float:
        """|ours − recomputed|, relative to the recomputed figure."""
        return abs(self.ours / self.quantity.recomputed - 1)

    @property
    def agrees(self) -> bool:
        """Whether our figure is the recomputed one, within what the file allows."""
        return self.error <= self.quantity.within


def validate(chosen: Iterable[PublishedCase] | None = None) -> Iterator[ComparedFigure]:
    """Yield the comparison of each figure, case by case; by default of all cases."""
    for case in cases() if chosen is None else chosen:
        run = SolvedCase(case)
        for quantity in case.quantities:
            begin = time.perf_counter()
            ours = _measured(run, quantity)
            yield ComparedFigure(case, quantity, ours, time.perf_counter() - begin)


def _measured(run: SolvedCase, quantity: PublishedFigure) -> float:
    """Our figure in the unit of the quantity."""
    units, arguments = run.case.units, dict(quantity.arguments)
    if units is not None:
        for name, kind in _ARGUMENT_KINDS.items():
            if name in arguments:
                arguments[name] = units.model(kind, arguments[name])
    ours = MEASURES[quantity.measure](run, **arguments)
    return ours if units is None or not quantity.unit else units.physical(_KINDS[quantity.unit], ours)


def as_dict(comparison: ComparedFigure) -> dict:
    """The JSON of one figure."""
    case, quantity = comparison.case, comparison.quantity
    return {
        "case": case.key,
        "title": case.title,
        "source": case.source,
        "what": quantity.what,
        "unit": quantity.unit,
        "published": quantity.published,
        "formula": case.formula,
        "recomputed": quantity.recomputed,
        "ours": comparison.ours,
        "difference": comparison.difference,
        "error": comparison.error,
        "allowed": quantity.within,
        "agrees": comparison.agrees,
        "seconds": comparison.seconds,
        "note": quantity.note,
    }
