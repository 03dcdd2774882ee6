"""Both solvers against 60-digit solutions."""

import numpy as np
import pytest
from vibroscope.engine import Newmark, Reference, System, simulate

from tests import naive_stops, truth

REFERENCES = [
    ("ref|1.08|published", 1.08, Reference("table")),
    ("ref|2.76|derived", 2.76, Reference("derived")),
]


def events_of(response):
    """As in truth.json: 0 impact, 1 permanent contact begins, 2 it ends."""
    found = [(t, 0, -u) for t, u in zip(response.impacts.time, response.impacts.closing_speed, strict=True)]
    end = response.window[1]
    for begin, until in response.contacts:
        found += [(begin, 1, 0.0)] + ([(until, 2, 0.0)] if until < end else [])
    return sorted(found, key=lambda event: event[:2])


@pytest.mark.parametrize(("case", "eta", "method"), REFERENCES)
def test_reference_states(case, eta, method):
    section = simulate(System(), eta, method, periods=200, keep=200).section
    for periods, state in truth.states(case).items():
        assert np.abs(section[periods - 1] - state).max() < 1e-10, f"after {periods} periods"


@pytest.mark.parametrize(("case", "eta", "method"), REFERENCES)
def test_reference_finds_every_event_in_kind_and_order(case, eta, method):
    found = events_of(simulate(System(), eta, method, periods=10, keep=10))
    expected = truth.events(case)
    assert [kind for _, kind, _ in found] == [kind for _, kind, _ in expected]
    for column, tolerance in ((0, 1e-9), (2, 1e-9)):
        assert max(abs(one[column] - two[column]) for one, two in zip(found, expected, strict=True)) < tolerance


@pytest.mark.parametrize("eta", [0.7, 1.08, 1.70, 2.2, 2.76, 3.25])
def test_reference_finds_the_events_of_its_naive_twin(eta):
    system, method = System(), Reference("derived")
    expected, state = naive_stops.reference(system, eta, system.derived_joint_damping, method.threshold, 5)
    response = simulate(system, eta, method, periods=5, keep=5)
    found = events_of(response)
    assert [kind for _, kind, _ in found] == [kind for _, kind, *_ in expected]
    np.testing.assert_allclose([t for t, _, _ in found], [t for t, *_ in expected], atol=1e-8)
    np.testing.assert_allclose(response.section[-1], state, atol=1e-8)


@pytest.mark.parametrize(
    ("case", "eta", "stiffness", "damping"),
    [("pen|2.76|12000,18", 2.76, 12000, 18), ("pen|1.08|2500,8", 1.08, 2500, 8)],
)
def test_newmark_tends_to_the_exact_penalty_solution(case, eta, stiffness, damping):
    """First order, because each contact change is mislocated within its step; errors scatter, so a fit over many n."""
    steps = np.unique(np.geomspace(2000, 64_000, 25).astype(int))
    exact = np.array(truth.states(case)[1])
    errors = []
    for n in steps:
        section = simulate(System(), eta, Newmark(stiffness, damping, int(n)), periods=1, keep=1).section
        errors.append(np.abs(section[0] - exact).max())
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.7 < order < 2.1
    assert max(errors[-5:]) < 0.1 * max(errors[:5])
