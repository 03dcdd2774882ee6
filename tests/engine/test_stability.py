"""Every case of ``vibroscope stability``, that the list is complete, and that long runs leave nothing behind."""

import gc
import resource
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Newmark, Reference, Status, System, simulate
from vibroscope.engine.hardcases.cases import Case, hard_cases
from vibroscope.engine.hardcases.condition import EPSILON, Run, attainable, sensitivity
from vibroscope.engine.hardcases.judgement import outcome

CASES = {case.name: case for case in hard_cases()}


@pytest.mark.parametrize("name", CASES)
def test_a_hard_case_ends_as_expected(name):
    found = outcome(CASES[name])
    assert found.passed, found.failures


def test_the_list_holds_what_was_asked_for():
    runs = [case.run for case in CASES.values()]
    newmark = [run.method for run in runs if isinstance(run.method, Newmark)]
    exact = [run.method for run in runs if isinstance(run.method, ExactPenalty)]
    rests = {run.system.restitution for run in runs if isinstance(run.method, Reference)}
    assert {0.0, 0.99, 1.0} <= rests
    assert min(abs(run.system.kappa - 1) for run in runs) < 2e-7
    assert {1.0, 2.41, 1.8} <= {run.eta for run in runs}
    assert any(run.system.d1 == run.system.d2 == run.system.d3 == 0 for run in runs)
    assert {1.0, 1e9} <= {method.stiffness for method in exact}
    assert {0.0, 1e6} <= {method.damping for method in exact}
    assert {20, 1_000_000} <= {method.steps for method in newmark if method.located}
    assert {20, 1_000_000} <= {method.steps for method in newmark if not method.located}
    assert max(run.periods for run in runs) == 1_000_000
    assert len(CASES) == len(hard_cases())  # no two of one name


def test_a_wrong_answer_is_noticed():
    """Another damper, another start, a status that is not expected: the judge is not blind."""
    case = CASES["resonance: resonance|1.8|damped|table"]
    assert outcome(case).passed
    system = replace(case.run.system, d1=case.run.system.d1 * (1 + 1e-9))
    assert not outcome(replace(case, run=replace(case.run, system=system))).passed
    assert not outcome(replace(case, statuses=(Status.DIVERGED,))).passed
    assert not outcome(replace(CASES["chaos: two starts"], compared=Run(System(), 1.75, Reference(), 8000))).passed


@pytest.mark.parametrize(
    "run",
    [
        Run(System(), 1.08, Reference(), 3),
        Run(System(), 2.76, ExactPenalty(12000, 18), 5),
        Run(System(), 2.76, Reference(), 5, (-0.5, 1.0, 0.75, -2.0)),
    ],
)
def test_the_measured_sensitivity_foretells_a_change(run):
    """A change of data by 1e-8 changes the result by no more than foretold, and η's alone by a fair share of that."""
    foretold = sensitivity(run) * 1e-8
    moved = replace(run, eta=run.eta * (1 + 1e-8)).solve().section
    change = np.abs(moved - run.solve().section).max()
    assert 0.05 * foretold < change < 1.01 * foretold


def test_a_graze_has_no_sensitivity():
    assert attainable(CASES["grazing: grazing|a|-1e-14"].run) is None


@pytest.mark.parametrize("method", [Reference(), Reference(threshold=0.0), ExactPenalty(12000, 18)])
def test_memory_does_not_grow_with_the_periods(method):
    def peak(periods):
        gc.collect()
        tracemalloc.start()
        simulate(System(), 2.76, method, periods=periods, keep=50)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    simulate(System(), 2.76, method, periods=60, keep=50)
    few, before = peak(1000), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    many, after = peak(1_000_000), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert many < few + 64 * 1024  # the driver's notes of five hundred calls: a sixth of a byte a period
    unit = 1 if sys.platform == "darwin" else 1024
    assert (after - before) * unit < 4 * 1024**2  # what compiled code would leak, tracemalloc does not see


def test_states_that_repeat_leave_no_drift():
    """The same periodic motion after a thousand and a million periods, to what rounding leaves of it."""
    run = Run(System(), 2.76, Reference(), 40)
    early, late = (simulate(System(), 2.76, Reference(), periods=n, keep=1).section for n in (1000, 1_000_000))
    assert np.abs(early - late).max() < attainable(run)
    assert attainable(run) < 1e5 * EPSILON * np.abs(late).max()


def test_a_case_of_one_s_own():
    case = Case("mine", Run(System(), 2.76, ExactPenalty(100.0, 1.0), 3))
    found = outcome(case)
    assert found.passed
    assert np.isnan(found.error)
    assert found.residual < found.balanced
