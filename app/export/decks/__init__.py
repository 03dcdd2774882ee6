"""Decks: the input of other codes, with the system and the numbers that are set. One module for each code."""

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.decks import abaqus, ansys, calculix, modelica, opensees
from vibroscope.app.export.decks.problem import KEEP, PERIODS, DeckProblem
from vibroscope.engine import CONTACT_STATUSES, WITHOUT_SOLUTION

DECKS = {"opensees": opensees, "calculix": calculix, "abaqus": abaqus, "ansys": ansys, "modelica": modelica}


def deck(code: str, problem: DeckProblem) -> str:
    """The text of a deck for a code of :data:`DECKS`; raises ValueError, in one line, for what it cannot express."""
    return DECKS[code].write(problem)


def usual_periods(code: str, steps: int) -> int:
    """How many periods a deck runs unless it is said: fewer where a table needs a row for each step."""
    return max(1, min(PERIODS, getattr(DECKS[code], "MOST_STEPS", PERIODS * steps) // steps))


def problem_of(setting: Setting, code: str) -> DeckProblem:
    """The problem of a deck from the page: its setting, with the contact status left to the code."""
    own = {"located": "no", "status": CONTACT_STATUSES[0], "without_solution": WITHOUT_SOLUTION[0]}
    method = setting._replace(**own).penalty
    initial = None if setting.from_rest else setting.initial
    periods = usual_periods(code, method.steps)
    return DeckProblem(setting.system, setting.eta, method, setting.scale, initial, periods, min(KEEP, periods))
