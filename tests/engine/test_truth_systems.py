"""Systems of every kind, free bodies, pulses and records against 60-digit solutions: events, states, forces.

What is allowed is what double precision can attain: the conditioning of the case, which is part of the file, and one
rounding error per radian of the fastest motion.
"""

import numpy as np
import pytest
from vibroscope.engine import Status

from tests import truth_stops_and_loads as stops_and_loads
from tests import truth_systems as systems
from tests.events import events_of
from tests.share import every

EPSILON = np.finfo(float).eps
MARGIN = 4  # rounding errors in each radian
SLOWEST = 1e-4  # of the impacts of an endless chatter, those that are compared: slower ones are summed up


def rates(response):
    """Angular frequencies in flight and in contact."""
    system, method = response.system, response.method
    contact = np.sqrt(getattr(method, "stiffness", 0.0) / system.mass_share)
    return max(1.0, *system.frequencies, response.eta), contact


def allowed(truth, case, response):
    """Largest error of a state."""
    free, contact = rates(response)
    touching = (response.contacts[:, 1] - response.contacts[:, 0]).sum()
    size = max(np.abs(truth.states(case)).max(), abs(response.system.clearance), response.eta)
    radians = response.window[1] * free + touching * contact
    return MARGIN * EPSILON * (truth.CASES[case]["condition"] + size * (1 + radians))


def listed(truth, case, events):
    """Without the slow impacts of an endless chatter, which the engine sums up."""
    if truth.CASES[case].get("threshold", 1) > truth.LIMIT:
        return events
    return [event for event in events if event[1] != 0 or -event[2] > SLOWEST]


def check_states_and_forces(truth, case, response):
    bound = allowed(truth, case, response)
    assert bound < 1e-8
    samples = response.trajectory
    x, v = samples.displacement[:, 1:], samples.velocity[:, 1:]
    np.testing.assert_allclose(np.column_stack([x[0], v[0], x[1], v[1]]), truth.states(case), rtol=0, atol=bound)
    each = len(x[0]) // len(response.section)
    np.testing.assert_array_equal(response.section, np.column_stack([x[0], v[0], x[1], v[1]])[each - 1 :: each])
    method, fastest = response.method, max(rates(response)[0], 1) ** 2
    slope = getattr(method, "stiffness", fastest) + 2 * getattr(method, "damping", fastest)
    np.testing.assert_allclose(samples.force[1:], truth.forces(case), rtol=0, atol=bound * slope)


def check_events(truth, case, response):
    found, expected = listed(truth, case, events_of(response)), listed(truth, case, truth.events(case))
    assert [kind for _, kind, _ in found] == [kind for _, kind, _ in expected]
    times, _, speeds = np.array(found, dtype=float).reshape(-1, 3).T
    true_times, _, true_speeds = np.array(expected, dtype=float).reshape(-1, 3).T
    within = allowed(truth, case, response)
    # an impact is late by δg/|g′|, the end of a permanent contact by δλ/|λ′|
    slow = np.where(true_speeds == 0, 1.0, np.minimum(1.0, np.abs(true_speeds)))
    assert (np.abs(times - true_times) < within * (1 + 1 / slow)).all()
    known = ~np.isnan(speeds)
    free, contact = rates(response)
    acceleration = (free**2 + contact) * max(1.0, np.abs(truth.states(case)).max())
    assert (np.abs(speeds - true_speeds)[known] < within * (1 + acceleration / slow[known])).all()


CASES = [(systems, case) for case in systems.CASES] + [(stops_and_loads, case) for case in stops_and_loads.CASES]


@pytest.mark.parametrize(("truth", "case"), every(CASES), ids=lambda each: each if isinstance(each, str) else "")
def test_states_forces_and_events(truth, case):
    response = truth.run(case)
    assert response.status is Status.OK
    check_states_and_forces(truth, case, response)
    check_events(truth, case, response)


LOADED = [
    case
    for case, entry in stops_and_loads.CASES.items()
    if case.startswith(("pulse|", "record|")) and "threshold" not in entry
]
SAME_AS_SPRING_AND_DAMPER = {
    "pieces": {
        "law": "bilinear",
        "penetration": 1e-3,
        "stiffening": 1.0 + EPSILON,
    },  # of one stiffness, with their kink
    "steps": {"law": "constant-restitution", "exponent": 1.0},  # of high order in contact
}


@pytest.mark.parametrize("law", SAME_AS_SPRING_AND_DAMPER.values(), ids=SAME_AS_SPRING_AND_DAMPER.keys())
@pytest.mark.parametrize("case", every(LOADED))
def test_other_laws_under_pulses_and_records(case, law):
    response = stops_and_loads.run(case, **law)
    assert response.status is Status.OK
    check_states_and_forces(stops_and_loads, case, response)
    check_events(stops_and_loads, case, response)


def test_the_file_holds_every_kind():
    """Clearance of both signs, walls, forces, phases, constants, free vibration; by both methods."""
    entries = systems.CASES.values()
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
    found = stops_and_loads.CASES
    assert len(found) >= 120
    for group in ("ball", "pair", "two stops", "pulse", "record"):
        assert sum(name.startswith(f"{group}|") for name in found) >= 18
    assert sum(name.startswith("weight|") for name in found) >= 16
    both = {(1, 1), (1, 2)}  # permanent contact begins at either stop
    begun = [{(kind, stop) for _, kind, _, stop in e["events"]} for e in found.values() if "threshold" in e]
    assert sum(both <= each for each in begun) >= 4
