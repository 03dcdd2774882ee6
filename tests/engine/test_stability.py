"""The hard cases of ``vibroscope stability``: each one, their completeness, and memory and drift of long runs."""

import gc
import resource
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Reference, Status, System, simulate
from vibroscope.engine.hardcases.cases import (
    EPSILON,
    HardCase,
    SimulationSetup,
    attainable_error,
    hard_cases,
    sensitivity,
)
from vibroscope.engine.hardcases.judgement import outcome

from tests.share import every

CASES = {case.name: case for case in hard_cases()}


@pytest.mark.parametrize("name", every(CASES))
def test_a_hard_case_ends_as_expected(name):
    found = outcome(CASES[name])
    assert found.passed, found.failures


def test_the_hard_cases_cover_the_extreme_parameters():
    setups = [case.setup for case in CASES.values()]
    newmark = [setup.method for setup in setups if setup.method.has_step]
    exact = [setup.method for setup in setups if isinstance(setup.method, ExactPenalty)]
    restitutions = {setup.system.restitution for setup in setups if isinstance(setup.method, Reference)}
    assert {0.0, 0.99, 1.0} <= restitutions
    assert min(abs(setup.system.kappa - 1) for setup in setups) < 2e-7
    assert {1.0, 2.41, 1.8} <= {setup.eta for setup in setups}
    assert any(setup.system.d1 == setup.system.d2 == setup.system.d3 == 0 for setup in setups)
    assert {1.0, 1e9} <= {method.stiffness for method in exact}
    assert {0.0, 1e6} <= {method.damping for method in exact}
    assert {20, 1_000_000} <= {method.steps for method in newmark if method.located}
    assert {20, 1_000_000} <= {method.steps for method in newmark if not method.located}
    assert max(setup.periods for setup in setups) == 1_000_000
    assert len(CASES) == len(hard_cases())  # every name is unique


def test_the_hard_cases_cover_every_kind_of_system():
    """With the reference and the exact penalty each: walls, preload, forces on both, weights, nothing that drives."""
    setups = [case.setup for case in CASES.values()]
    for method in (Reference, ExactPenalty):
        systems = [setup.system for setup in setups if isinstance(setup.method, method)]
        assert sum(system.wall for system in systems) >= 5
        assert sum(system.clearance < 0 for system in systems) >= 5
        assert sum(system.clearance > 0 for system in systems) >= 5
        assert any(system.excitation.force1 and system.excitation.force2 for system in systems)
        assert any(system.excitation.constant1 and system.excitation.constant2 for system in systems)
        assert any(not system.excitation.drives for system in systems)


def test_a_wrong_number_of_a_general_system_is_noticed():
    """Of a wall with preload: clearance, force and impacts that differ by little or by one make the case fail."""
    case = CASES["any system: sticking|wall, threshold|reference"]
    assert outcome(case).passed
    system = replace(case.setup.system, clearance=case.setup.system.clearance * (1 + 1e-9))
    assert not outcome(replace(case, setup=replace(case.setup, system=system))).passed
    setup = replace(case.setup, method=replace(case.setup.method, threshold=0.02))
    assert "events differ from the truth" in outcome(replace(case, setup=setup, allowed=1.0)).failures


def test_a_wrong_result_is_noticed():
    """Another damper, another excitation, and a status that is not expected make a case fail."""
    case = CASES["resonance: resonance|1.8|damped|table"]
    assert outcome(case).passed
    system = replace(case.setup.system, d1=case.setup.system.d1 * (1 + 1e-9))
    assert not outcome(replace(case, setup=replace(case.setup, system=system))).passed
    assert not outcome(replace(case, statuses=(Status.DIVERGED,))).passed
    chaos, other = CASES["chaos: two starts"], SimulationSetup(System(), 1.75, Reference(), 1000)
    assert not outcome(replace(chaos, setup=replace(chaos.setup, periods=1000), compared=other)).passed


@pytest.mark.parametrize(
    "setup",
    [
        SimulationSetup(System(), 1.08, Reference(), 3),
        SimulationSetup(System(), 2.76, ExactPenalty(12000, 18), 5),
        SimulationSetup(System(), 2.76, Reference(), 5, (-0.5, 1.0, 0.75, -2.0)),
    ],
)
def test_the_sensitivity_predicts_the_effect_of_a_change(setup):
    """A relative change of η by 1e-8 changes the result by at most the prediction for all data, and a part of it."""
    predicted = sensitivity(setup) * 1e-8
    changed = replace(setup, eta=setup.eta * (1 + 1e-8)).solve().section
    change = np.abs(changed - setup.solve().section).max()
    assert 0.05 * predicted < change < 1.01 * predicted


def test_a_grazing_impact_has_no_attainable_error():
    assert attainable_error(CASES["grazing: grazing|a|-1e-14"].setup) is None


@pytest.mark.parametrize("method", every([Reference(), Reference(threshold=0.0), ExactPenalty(12000, 18)]))
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
    assert many < few + 64 * 1024  # what the driver notes in each of 500 calls
    unit = 1 if sys.platform == "darwin" else 1024
    assert (after - before) * unit < 4 * 1024**2  # tracemalloc does not see leaks of compiled code


def test_a_periodic_motion_does_not_drift_in_a_million_periods():
    setup = SimulationSetup(System(), 2.76, Reference(), 40)
    early, late = (simulate(System(), 2.76, Reference(), periods=n, keep=1).section for n in (1000, 1_000_000))
    assert np.abs(early - late).max() < attainable_error(setup)
    assert attainable_error(setup) < 1e5 * EPSILON * np.abs(late).max()


def test_a_case_without_truth_is_judged_by_its_energy():
    case = HardCase("own", SimulationSetup(System(), 2.76, ExactPenalty(100.0, 1.0), 3))
    found = outcome(case)
    assert found.passed
    assert np.isnan(found.error)
    assert found.residual < found.balanced
