"""The errors of many cells and their parts, against a plain twin that samples each motion by itself."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import Cells, ExactPenalty, Newmark, Record, Reference, System, run_cells, simulate
from vibroscope.engine.divergence.grid import repeat_cycle, rms, samples_by_period
from vibroscope.engine.result import Checkpoint
from vibroscope.engine.sweeps.errors import ERROR_SAMPLES, reference_motion

from tests.share import every

SYSTEM = System()
TRANSIENT, SAMPLE = 450, 25
CONTACTS = {"stiffness": [2500.0, 12000.0, 40000.0], "damping": [8.0, 18.0, 60.0]}


def sampled(eta, method, state, periods, steps):
    """ξ₁ and ξ₂ from a state on, (2, periods, m)."""
    start = Checkpoint(SYSTEM, eta, method, 0, state)
    record = Record(periods, ERROR_SAMPLES, steps)
    run = simulate(SYSTEM, eta, method, periods=periods, keep=periods, initial=start, record=record)
    return samples_by_period(run)[:2]


def least(one, other, shifts):
    """Root mean square of the difference with the shift that makes it least."""
    return min(rms(one - np.roll(repeat_cycle(other, one.shape[1]), -shift, axis=1)) for shift in range(shifts))


def errors_of(reference, method, state, exact_state):
    """Error, part of the time step and part of the regularisation of one cell."""
    p, eta = reference.period, reference.table.reference.eta
    periods, steps = (SAMPLE - 1) // p * p, method.steps or None
    record = Record(1, ERROR_SAMPLES, steps)
    table, derived = (target.cycle(record)[0] for target in (reference.table, reference.derived))
    size = reference.table.cycle(record)[1]
    penalty = sampled(eta, method, state, periods, steps)
    total = least(penalty, table, p) / size
    if exact_state is None:
        return total, np.nan, np.nan
    exact = penalty if steps is None else sampled(eta, method.limit, exact_state, periods, steps)
    return total, least(penalty, exact, p) / size, least(exact, derived, p) / size


@pytest.mark.parametrize(
    ("eta", "method"),
    every(
        [
            (2.76, Newmark(1, 1, 2000)),
            (2.9, Newmark(1, 1, 500)),
            (2.9, ExactPenalty(1, 1)),
            (2.9, Newmark(1, 1, 500, located=True)),
            (2.9, Newmark(1, 1, 500, every_step=True)),
        ]
    ),
)
def test_errors_of_cells_are_those_of_their_samples(eta, method):
    reference = reference_motion(SYSTEM, eta)
    assert reference.splits
    cells = Cells(SYSTEM, [eta] * 3, method, **CONTACTS)
    how = {"transient": TRANSIENT, "sample": SAMPLE}
    found = run_cells(cells, **how)
    is_exact = isinstance(method, ExactPenalty)
    exact = found if is_exact else run_cells(replace(cells, method=method.limit), **how)
    errors = reference.errors(cells, found, exact)
    alone = reference.errors(cells, found, None)
    assert np.isfinite(errors[0]).all()
    assert np.isfinite(errors[1:]).any()
    np.testing.assert_array_equal(alone[0], errors[0])
    assert np.isnan(alone[1:]).all()
    for i in range(3):
        alike = exact.near_period[i] == reference.period
        twin = errors_of(reference, cells.method_of(i), found.section[i, 0], exact.section[i, 0] if alike else None)
        np.testing.assert_allclose(errors[:, i], twin, rtol=1e-11, atol=1e-12)


def test_a_cell_that_ended_early_has_no_error_and_does_not_change_the_others():
    cells = Cells(SYSTEM, [2.76] * 3, Newmark(1, 1, 2000), **CONTACTS)
    found = run_cells(cells, transient=TRANSIENT, sample=SAMPLE)
    whole = reference_motion(SYSTEM, 2.76).errors(cells, found, None)
    found.status[1] = 1
    errors = reference_motion(SYSTEM, 2.76).errors(cells, found, None)
    assert np.isnan(errors[:, 1]).all()
    np.testing.assert_array_equal(errors[:, [0, 2]], whole[:, [0, 2]])


@pytest.mark.parametrize("eta", [2.76, 3.25])  # a motion of one period, and one of two
def test_the_first_impact_of_the_reference_is_where_a_run_has_it(eta):
    reference = reference_motion(SYSTEM, eta)
    run = simulate(SYSTEM, eta, Reference(), periods=2000, keep=reference.period)
    (first,) = run.impacts.time
    assert reference.first_impact == pytest.approx(first / run.period % 1, abs=1e-6)


def test_a_run_without_samples_is_refused():
    with pytest.raises(ValueError, match="holds no samples"):
        samples_by_period(simulate(SYSTEM, 2.76, Reference(), periods=2, keep=1))
