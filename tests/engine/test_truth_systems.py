"""Systems with clearance or preload, walls, forces and weights against 60-digit solutions: events, states, forces.

What is allowed is what double precision can attain: the conditioning of the case, which is part of the file, and one
rounding error per radian of the fastest motion.
"""

import numpy as np
import pytest
from vibroscope.engine import Record, Status, simulate

from tests import truth_systems as truth
from tests.events import events_of
from tests.share import every

EPSILON = np.finfo(float).eps
MARGIN = 4  # rounding errors in each radian
SLOWEST = 1e-4  # of the impacts of an endless chatter, those that are compared: slower ones are summed up


def solve(case):
    entry, (system, eta, method) = truth.CASES[case], truth.arguments(case)
    return simulate(
        system,
        eta,
        method,
        periods=entry["periods"],
        keep=entry["periods"],
        initial=tuple(entry["start"]),
        record=Record(entry["periods"], truth.samples_per_period(case)),
    )


def rates(response):
    """Angular frequencies in flight and in contact."""
    system, method = response.system, response.method
    contact = np.sqrt(getattr(method, "stiffness", 0.0) / system.mass_share)
    return max(1.0, *system.frequencies, response.eta), contact


def allowed(case, response):
    """Largest error of a state."""
    free, contact = rates(response)
    touching = (response.contacts[:, 1] - response.contacts[:, 0]).sum()
    size = max(np.abs(truth.states(case)).max(), abs(response.system.clearance), response.eta)
    radians = response.window[1] * free + touching * contact
    return MARGIN * EPSILON * (truth.CASES[case]["condition"] + size * (1 + radians))


def listed(case, events):
    """Without the slow impacts of an endless chatter, which the engine sums up."""
    if truth.CASES[case].get("threshold", 1) > truth.LIMIT:
        return events
    return [event for event in events if event[1] != 0 or -event[2] > SLOWEST]


def check_states_and_forces(case, response):
    bound = allowed(case, response)
    assert bound < 1e-8
    samples = response.trajectory
    x, v = samples.displacement[:, 1:], samples.velocity[:, 1:]
    np.testing.assert_allclose(np.column_stack([x[0], v[0], x[1], v[1]]), truth.states(case), rtol=0, atol=bound)
    np.testing.assert_array_equal(response.section, np.column_stack([x[0], v[0], x[1], v[1]])[1::2])
    method, fastest = response.method, max(rates(response)[0], 1) ** 2
    slope = getattr(method, "stiffness", fastest) + 2 * getattr(method, "damping", fastest)
    np.testing.assert_allclose(samples.force[1:], truth.forces(case), rtol=0, atol=bound * slope)


def check_events(case, response):
    found, expected = listed(case, events_of(response)), listed(case, truth.events(case))
    assert [kind for _, kind, _ in found] == [kind for _, kind, _ in expected]
    times, _, speeds = np.array(found, dtype=float).reshape(-1, 3).T
    true_times, _, true_speeds = np.array(expected, dtype=float).reshape(-1, 3).T
    within = allowed(case, response)
    # an impact is late by δg/|g′|, the end of a permanent contact by δλ/|λ′|
    slow = np.where(true_speeds == 0, 1.0, np.minimum(1.0, np.abs(true_speeds)))
    assert (np.abs(times - true_times) < within * (1 + 1 / slow)).all()
    known = ~np.isnan(speeds)
    free, contact = rates(response)
    acceleration = (free**2 + contact) * max(1.0, np.abs(truth.states(case)).max())
    assert (np.abs(speeds - true_speeds)[known] < within * (1 + acceleration / slow[known])).all()


@pytest.mark.parametrize("case", every(truth.CASES))
def test_states_forces_and_events(case):
    response = solve(case)
    assert response.status is Status.OK
    check_states_and_forces(case, response)
    check_events(case, response)


def test_the_file_holds_every_kind():
    """Clearance of both signs, walls, forces, phases, constants, free vibration; by both methods."""
    entries = truth.CASES.values()
    assert len(entries) >= 120
    for method in ("reference", "exact"):
        some = [entry for entry in entries if entry["method"] == method]
        assert sum(entry["system"].get("clearance", 0) > 0 for entry in some) > 10
        assert sum(entry["system"].get("clearance", 0) < 0 for entry in some) > 10
        assert sum(entry["system"].get("wall", False) for entry in some) > 10
        assert sum(entry["excitation"].get("force2", 0) != 0 for entry in some) > 5
        assert sum(entry["excitation"].get("constant1", 0) != 0 for entry in some) > 5
        assert sum(entry["excitation"] == {"base": 0.0} for entry in some) > 2
        assert sum(not entry["system"] and not entry["excitation"] for entry in some) >= 2
