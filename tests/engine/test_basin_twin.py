"""Basins against their plain twin: each cell run for long by itself, and its section compared."""

import numpy as np
import pytest
from vibroscope.engine import (
    BasinStudy,
    ExactPenalty,
    Excitation,
    Record,
    Reference,
    System,
    run_cells,
    simulate,
    sweep,
)
from vibroscope.engine.cells import Cells
from vibroscope.engine.drivers.section import period_of

from tests.share import every

VALUES = np.linspace(-7.3, 8.1, 14)
NAMES = ("xi1", "v1", "xi2", "v2")


def plain_starts(found, start):
    x, y = found["motion"].dims
    starts = np.tile(np.array(start, float), (found["motion"].size, 1))
    grid = np.meshgrid(found[x], found[y], indexing="ij")
    starts[:, NAMES.index(x)], starts[:, NAMES.index(y)] = (values.ravel() for values in grid)
    return starts


def nearest_motion(found, section):
    """Which motion a long run is on: by the distance of each of its rows from the nearest point of each cycle."""
    distances = []
    for rows in found["motion_section"].values:
        cycle = rows[np.isfinite(rows).all(axis=1)]
        distances.append(np.abs(section[:, None] - cycle).max(axis=2).min(axis=1).max())
    return int(np.argmin(distances)), min(distances)


@pytest.mark.parametrize(
    ("system", "eta", "method", "axes", "start"),
    every(
        [
            (System(), 3.2, Reference(), ("xi2", "v2"), (0, 0, 0, 0)),
            (System(), 3.2, Reference(), ("v1", "v2"), (-1, 0, 2, 0)),
            (System(), 1.9, Reference(), ("xi1", "v1"), (0, 0, 9, 0)),
            (System(), 1.08, Reference(), ("xi2", "v2"), (0, 0, 0, 0)),
            (System(), 3.2, ExactPenalty(12000.0, 18.0), ("xi1", "xi2"), (0, 1, 0, 2)),
            (System(wall=True, clearance=9.0), 2.2, Reference(), ("xi1", "v1"), (0, 0, 0, 0)),
        ]
    ),
)
def test_each_cell_ends_on_the_motion_of_its_own_long_run(system, eta, method, axes, start):
    found = sweep(BasinStudy.over(system, method, eta, dict(zip(axes, (VALUES, VALUES), strict=True)), start=start))
    starts, labels = plain_starts(found, start), found["motion"].values.ravel()
    penetrates = isinstance(method, Reference) & (system.gap(starts[:, 0], starts[:, 2]) < 0)
    np.testing.assert_array_equal(labels == -4, penetrates)
    allowed = ~penetrates
    cells = Cells(system, np.full(allowed.sum(), eta), method, initial=starts[allowed])
    run = run_cells(cells, transient=3000, sample=64, recurrence=0)
    for label, section in zip(labels[allowed], run.section, strict=True):
        motion, distance = nearest_motion(found, section)
        assert label == motion
        assert distance < 1e-7
        assert period_of(section) == found["motion_period"].values[label]
    shares = np.bincount(labels[allowed]) / allowed.sum()
    np.testing.assert_allclose(found["motion_share"], shares)
    np.testing.assert_allclose(found["motion_share_error"], np.sqrt(shares * (1 - shares) / allowed.sum()))


def test_a_start_phase_is_the_excitation_turned_forward():
    """The run of the turned system, brought to phase 0 by a sample of its last period."""
    system, eta, method, phase = System(), 3.2, Reference(), 0.25
    speeds = np.linspace(-6, 7, 8)
    found = sweep(BasinStudy.over(system, method, eta, {"phase": [phase, 0.75], "v2": speeds}, start=(-1, 0, 1, 0)))
    turned = System(excitation=Excitation(base_phase=2 * np.pi * phase))
    for label, speed in zip(found["motion"].values[0], speeds, strict=True):
        run = simulate(turned, eta, method, periods=3000, keep=24, initial=(-1, 0, 1, speed), record=Record(24, 4))
        trajectory = run.trajectory
        rows = np.concatenate([trajectory.displacement, trajectory.velocity])[[0, 2, 1, 3]].T[3::4]
        motion, distance = nearest_motion(found, rows)
        assert label == motion
        assert distance < 1e-6
