"""A run has the same bits wherever it is cut, and whatever of it is kept and sampled."""

import dataclasses

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    Bathe,
    CentralDifference,
    ExactPenalty,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    Record,
    Reference,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.law_table import CONTACT_LAWS, LAWS_BY_RESTITUTION

from tests.law_numbers import SKIPPED, law_numbers

BETWEEN_STOPS = System(clearance=0.4, clearance2=1.1, stiffness_factor2=2.0, damping_factor2=0.5)
BETWEEN_WALLS = System(wall=True, d1=0.05, clearance=0.3, clearance2=0.5)


def with_law(law, kind=ExactPenalty, **more):
    exponent = {"impact": 2.2, "constant-restitution": 2.0}.get(law)
    return kind(
        1200.0, damping=None if law in LAWS_BY_RESTITUTION else 8.0, law=law, **law_numbers(law, exponent), **more
    )


REFERENCES = [Reference(), Reference("derived"), Reference(threshold=0.0)]
LOCATED = [Newmark(12_000.0, 18.0, 150, located=True), Newmark(1e6, 0.0, 37, located=True)]
LOCATED += [Newmark(12_000.0, 18.0, 3000, located=True, law=law) for law in ("kelvin-voigt", "cut")]
LOCATED += [TimeStepping(12_000.0, 18.0, 1000, kind(), "located") for kind in (NewmarkBeta, Bathe)]
LOCATED.append(TimeStepping(12_000.0, 18.0, 1000, HHTInterpolated(), "located", law="compression"))
LOCATED += [with_law(law, TimeStepping, steps=150, status="located") for law in ("cut", "limited", "flores", "impact")]
WHOLE = [  # steps are skipped where they are small
    TimeStepping(12_000.0, 18.0, 2000, integrator, status, "keep", law, **law_numbers(law))
    for integrator, status, law in (*SKIPPED, (CentralDifference(), "start", "kelvin-voigt"))
]
ALONE = [ExactPenalty(12_000.0, 18.0), Newmark(12_000.0, 18.0, 2000), Newmark(12_000.0, 18.0, 500)]
STOPS = [Reference(), Reference(threshold=0.0), ExactPenalty(4000.0, 5.0), Newmark(4000.0, 5.0, 2000)]
STOPS += [ExactPenalty(4000.0, None if law == "flores" else 5.0, law=law) for law in ("cut", "hunt-crossley", "flores")]
STOPS += [Newmark(4000.0, 5.0, 400, located=True), TimeStepping(4000.0, 5.0, 400, HHT(), status="located")]
STOPS += [TimeStepping(4000.0, 5.0, 2000, HHT(), status="end", without_solution="keep")]
STOPS += [TimeStepping(4000.0, 5.0, 2000, Bathe()), TimeStepping(4000.0, 5.0, 4000, CentralDifference())]
CASES = [(System(), eta, each) for eta in (1.08, 1.70) for each in REFERENCES]
CASES += [(System(), 1.70, each) for each in (*ALONE, *LOCATED, *WHOLE)]
CASES += [(System(), 1.08, with_law(law)) for law in CONTACT_LAWS[1:]]
CASES += [(BETWEEN_STOPS, 1.70, Newmark(12_000.0, 18.0, 2000)), *((BETWEEN_WALLS, 1.3, each) for each in STOPS)]


@pytest.mark.parametrize(("system", "eta", "method"), CASES)
def test_a_run_is_the_same_wherever_it_is_cut_and_whatever_is_kept(system, eta, method, monkeypatch):
    """The rest of it pauses at every change of contact."""
    start = (0.1, 0.9, 0.0, 0.0) if system is BETWEEN_WALLS else None
    kept = {"keep": 6, "record": Record(2, 300)}
    long = simulate(system, eta, method, periods=20, keep=20, record=Record(20, 300), initial=start)
    whole = simulate(system, eta, method, periods=20, initial=start, **kept)
    first = simulate(system, eta, method, periods=13, keep=1, initial=start)
    monkeypatch.setattr("vibroscope.engine.drivers.base.CAPACITY", 1)
    monkeypatch.setattr("vibroscope.engine.drivers.located.LocatedDriver.solves_per_call", 7)
    rest = simulate(system, eta, method, periods=8, initial=first.checkpoint, **kept)
    assert rest.checkpoint == whole.checkpoint
    assert len(whole.impacts) + len(whole.contacts) > 3
    np.testing.assert_array_equal(long.section[-6:], whole.section)
    np.testing.assert_array_equal(long.contacts[long.contacts[:, 1] > whole.window[0]], whole.contacts)
    for name in ("section", "contacts"):
        np.testing.assert_array_equal(getattr(rest, name), getattr(whole, name))
    for part in ("impacts", "trajectory"):
        for field in dataclasses.fields(getattr(whole, part)):
            one, other = (getattr(getattr(run, part), field.name) for run in (rest, whole))
            np.testing.assert_array_equal(one, other)
    for field in dataclasses.fields(whole.trajectory):
        last, every = (getattr(run.trajectory, field.name) for run in (whole, long))
        np.testing.assert_array_equal(last, every[..., -last.shape[-1] :])
