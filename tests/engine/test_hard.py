"""All hard cases of hard.json: every event in kind and order, its time and speed, and every state.

What is allowed is what double precision can attain (engine/hardcases/cases.py), not what the engine happens to get.
"""

import numpy as np
import pytest
from vibroscope.engine import Status
from vibroscope.engine.hardcases.cases import SimulationSetup as Run
from vibroscope.engine.hardcases.cases import attainable_error as attainable
from vibroscope.engine.hardcases.cases import attainable_grazing_error as at_the_edge
from vibroscope.engine.hardcases.tolerances import MARGIN

from tests import hard
from tests.events import events_of
from tests.share import every

EPSILON = np.finfo(float).eps
GRAZES = ("grazing", "grazing-exact", "grazing-force")


def run_of(case):
    return Run(*hard.arguments(case, **changed(case)), hard.periods(case), hard.initial(case))


def changed(case):
    """The smallest threshold stands for its limit."""
    return {"threshold": 0.0} if hard.CASES[case]["method"].get("threshold", 1) < 1e-20 else {}


def dip(case):
    return float(hard.CASES[case]["dip"]) if case.split("|")[0] in GRAZES else None


def decided_by_rounding(case):
    """A dip closer to the surface than the start is to its own last digit."""
    return dip(case) is not None and abs(dip(case)) < EPSILON * max(map(abs, hard.initial(case)))


def allowed(case):
    """Largest error of a state."""
    run = run_of(case)
    found = attainable(run)
    if found is not None:
        return found
    law, flow, _ = case.split("|")
    clear = run_of(f"{law}|{flow}|1e-06")
    return attainable(clear) if dip(case) > MARGIN * EPSILON else at_the_edge(run, clear)


@pytest.mark.parametrize("case", every(name for name in hard.CASES if not decided_by_rounding(name)))
def test_events_and_states(case):
    run = run_of(case)
    response = run.solve()
    assert response.status is Status.OK
    bound = allowed(case)
    assert np.abs(response.section - hard.states(case)).max() < bound
    found, expected = events_of(response), hard.events(case)
    if hard.CASES[case]["omitted"]:  # of an endless chatter only some impacts are listed
        found = [event for event in found if event[1] != 0]
        expected = [event for event in expected if event[1] != 0]
    assert [kind for _, kind, _ in found] == [kind for _, kind, _ in expected]
    times, _, speeds = np.array(found, dtype=float).reshape(-1, 3).T
    true_times, _, true_speeds = np.array(expected, dtype=float).reshape(-1, 3).T
    within = bound + MARGIN * EPSILON * response.window[1] + grazing_error(case, response, true_speeds)
    assert (np.abs(times - true_times) < within).all()
    known = ~np.isnan(speeds)
    assert (np.abs(speeds - true_speeds)[known] < bend(case, response) * within[known]).all()


def grazing_error(case, response, speeds):
    """A gap that is zero at a small speed is so to its rounding over this speed; so is a force that dips below zero."""
    if dip(case) is None:
        return np.zeros(len(speeds))
    rounding = MARGIN * EPSILON * np.abs(response.section).max()
    if case.startswith("grazing-force"):
        return np.full(len(speeds), rounding / np.sqrt(abs(dip(case))))
    return rounding / np.where(speeds != 0, np.abs(speeds), np.inf)


def bend(case, response):
    """g″ is at most so: by how much a speed is off per time."""
    if dip(case) is None:
        return 1.0
    return response.system.kappa**2 * np.abs(response.section).max() + response.eta**2


@pytest.mark.parametrize("case", [name for name in hard.CASES if decided_by_rounding(name)])
def test_where_rounding_decides_the_result_is_one_of_the_two(case):
    """A dip to zero: with the graze or without, and then as near as the square root of rounding."""
    run = run_of(case)
    section = run.solve().section
    assert np.abs(section - hard.states(case)).max() < allowed(case)


@pytest.mark.parametrize("flow", "abcde")
def test_dips_1e_14_apart_are_told_apart(flow):
    above, below = (run_of(f"grazing|{flow}|{dip}").solve() for dip in ("1e-14", "-1e-14"))
    assert len(below.impacts) == len(above.impacts) + 1
