"""The slow subspace against eigenvectors, and against a run that does without it."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, System, simulate
from vibroscope.engine.drivers import event_driven
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.motion import pressed_generator
from vibroscope.engine.kernels.event_driven.setup import fast_projector
from vibroscope.engine.kernels.linear.tables import full_generator

STIFF = System(), 2.76, ExactPenalty(1e8, 3e4)


def test_the_fast_part_is_that_of_the_eigenvectors():
    rows = pressed_generator(parameters_of(*STIFF))
    radius, slowest = event_driven.separating_circles(np.array([parameters_of(*STIFF)]))[0]
    values, vectors = np.linalg.eig(full_generator(rows, 2.76))
    fast = np.abs(values) > radius
    assert 0 < fast.sum() < 6
    assert np.abs(values[~fast]).max() == pytest.approx(slowest)
    right = (vectors[:, fast] @ np.linalg.inv(vectors)[fast]).real
    found = fast_projector(rows, 2.76, radius)
    np.testing.assert_allclose(found, right[:4], atol=1e-10 * np.abs(right).max())


def test_a_run_without_the_separation_gives_the_same_motion_and_takes_longer(monkeypatch):
    how = {"periods": 3, "keep": 3}
    separated = simulate(*STIFF, **how)
    monkeypatch.setattr(event_driven, "separating_circles", lambda rows: np.zeros((len(rows), 2)))
    whole = simulate(*STIFF, **how)
    np.testing.assert_allclose(separated.section, whole.section, rtol=0, atol=1e-9)
    assert len(separated.contacts) == len(whole.contacts)
    assert separated.cost.evaluations < whole.cost.evaluations
