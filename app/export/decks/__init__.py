"""Decks: the input of other codes, with the system and the numbers that are set. One module for each code."""

from dataclasses import replace

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.decks import abaqus, ansys, calculix, modelica, opensees
from vibroscope.app.export.decks.problem import KEEP, PERIODS, Problem
from vibroscope.engine import CONTACT_STATUSES, Newmark

DECKS = {"opensees": opensees, "calculix": calculix, "abaqus": abaqus, "ansys": ansys, "modelica": modelica}


def deck(code: str, problem: Problem) -> str:
    """The text of a deck for a code of :data:`DECKS`; raises ValueError, in one line, for what it cannot express."""
    return DECKS[code].write(problem)


def usual_periods(code: str, steps: int) -> int:
    """How many periods a deck runs unless it is said: fewer where a table needs a row for each step."""
    return max(1, min(PERIODS, getattr(DECKS[code], "MOST_STEPS", PERIODS * steps) // steps))


def problem_of(setting: Setting, code: str) -> Problem:
    """What a deck of the page describes: its setting, with the contact status of the code."""
    method, status = setting.penalty, DECKS[code].STATUS
    if isinstance(method, Newmark):
        method = replace(method, located=False)
    elif status in CONTACT_STATUSES:
        method = replace(method, status=status, without_solution="stop")
    initial = None if setting.from_rest else setting.initial
    periods = usual_periods(code, method.steps)
    return Problem(setting.system, setting.eta, method, setting.scale, initial, periods, min(KEEP, periods))
