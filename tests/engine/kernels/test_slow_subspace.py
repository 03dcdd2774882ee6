"""The slow subspace against eigenvectors, and against a run that does without it."""

import numpy as np
from vibroscope.engine import ExactPenalty, System, simulate
from vibroscope.engine.drivers import event_driven

STIFF = System(), 2.76, ExactPenalty(1e8, 3e4)


def test_a_run_without_the_separation_gives_the_same_motion_and_takes_longer(monkeypatch):
    how = {"periods": 3, "keep": 3}
    separated = simulate(*STIFF, **how)
    monkeypatch.setattr(event_driven, "separating_circles", lambda rows: np.zeros((len(rows), 2)))
    whole = simulate(*STIFF, **how)
    np.testing.assert_allclose(separated.section, whole.section, rtol=0, atol=1e-9)
    assert len(separated.contacts) == len(whole.contacts)
    assert separated.cost.evaluations < whole.cost.evaluations
