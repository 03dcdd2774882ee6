"""Decks: the input of other codes, with the system and the numbers that are set. One module for each code."""

from collections.abc import Sequence

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.decks import abaqus, ansys, calculix, modelica, opensees
from vibroscope.app.export.decks.problem import KEEP, PERIODS, DeckProblem, check
from vibroscope.engine import CONTACT_STATUSES, WITHOUT_SOLUTION, System, free_length

DECKS = {"opensees": opensees, "calculix": calculix, "abaqus": abaqus, "ansys": ansys, "modelica": modelica}


def deck(code: str, problem: DeckProblem) -> str:
    """The text of a deck for a code of :data:`DECKS`; raises ValueError, in one line, for what it cannot express."""
    own = DECKS[code]
    check(problem, own)
    return own.TEMPLATE.format(**own.parts(problem), **problem.parts(own))


def usual_length(code: str, system: System, eta: float, steps: int, initial: Sequence[float] | None) -> tuple[int, int]:
    """How many periods a deck runs unless it is said, and how many of them it writes.

    Fewer are run where a table needs a row for each step. A free vibration is written from its start, with which a
    measurement of it is compared, to its first contact at least.
    """
    drives = system.excitation.drives
    wanted = PERIODS if drives else free_length(system, eta, initial, contacts=1)["periods"]
    periods = max(1, min(wanted, getattr(DECKS[code], "MOST_STEPS", wanted * steps) // steps))
    return periods, min(KEEP, periods) if drives else periods


def problem_of(setting: Setting, code: str) -> DeckProblem:
    """The problem of a deck from the page: its setting, with the contact status left to the code."""
    own = {"located": "no", "status": CONTACT_STATUSES[0], "without_solution": WITHOUT_SOLUTION[0]}
    method = setting._replace(**own).penalty
    initial = None if setting.from_rest else setting.initial
    length = usual_length(code, setting.system, setting.eta, method.steps, initial)
    return DeckProblem(setting.system, setting.eta, method, setting.scale, initial, *length)
