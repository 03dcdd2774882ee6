"""Tables of a linear motion, held against another matrix exponential."""

import functools
import math

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import expm
from vibroscope.engine import ExactPenalty, Reference, System
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.motion import joined_generator, pressed_generator, separated_generator
from vibroscope.engine.kernels.linear.tables import POINTS, REACH, SCRATCH, full_generator, tabulate

GAP, FORCE = np.eye(6)[2], np.array([2.24, 0.05, 0.0, 0.0, 0.0, 0.0])
WORK = SCRATCH.read(SCRATCH.zeros())


class Table:
    """A phase, its generator, and what it watches at many instants of a block, by another exponential."""

    SAMPLES = 4096

    def __init__(self, generator, eta, row, fastest, constant=0.0):
        self.a, self.row, self.h = full_generator(generator, eta), row, REACH / fastest
        self.constant = constant
        self.phase = tabulate(generator, eta, row, self.h, (0.0, 0.0, constant))
        self.length = POINTS * self.h

    @functools.cached_property
    def rows(self):
        """The row at SAMPLES + 1 instants of the block: twice as many by each product, so that little is rounded."""
        rows, step = self.row[None], self.length / self.SAMPLES
        while len(rows) <= self.SAMPLES:
            rows = np.concatenate([rows, rows @ expm(self.a * (len(rows) * step))])
        return rows[: self.SAMPLES + 1]

    def value(self, s, z, derivative=0):
        """The watched quantity, or a derivative of it, at s."""
        relative = self.row @ np.linalg.matrix_power(self.a, derivative) @ expm(self.a * s) @ z
        return relative + (self.constant if derivative == 0 else 0.0)

    def samples(self, z):
        """The watched quantity at SAMPLES + 1 instants of the block."""
        return self.rows @ z + self.constant


def free(eta, d1, d2):
    """Generator without contact."""
    return separated_generator(parameters_of(System(d1=d1, d2=d2), eta, Reference()))


def pressed(stiffness, damping):
    """Generator in penalty contact at η = 2.76."""
    return pressed_generator(parameters_of(System(), 2.76, ExactPenalty(stiffness, damping)))


TABLES = {
    "flight": Table(free(1.08, 0.0033, 0.012), 1.08, GAP, 2.41),
    "flight, undamped": Table(free(2.76, 0.0, 0.0), 2.76, GAP, 2.76),
    "flight, resonant": Table(free(1.0, 0.0, 0.0), 1.0, GAP, 2.41),
    "flight, heavily damped": Table(free(1.7, 0.9, 0.95), 1.7, GAP, 2.41),
    "joined": Table(joined_generator(parameters_of(System(), 1.08, Reference())), 1.08, FORCE, 1.8),
    "flight, with a clearance": Table(free(1.08, 0.0033, 0.012), 1.08, GAP, 2.41, 1.3),
    "joined, preloaded": Table(joined_generator(parameters_of(System(), 1.7, Reference())), 1.7, FORCE, 1.8, -0.7),
    "pressed": Table(pressed(12000.0, 18.0), 2.76, -GAP, 165.0),
    "pressed, critically": Table(pressed(100.0, 6.8255), 2.76, -GAP, 20.0),
}
kinds = st.sampled_from(sorted(TABLES))
angles = st.floats(0.0, 2 * math.pi)
states = st.builds(
    lambda x, v, g, u, turn: (x, v, g, u, math.cos(turn), math.sin(turn)),
    *4 * (st.floats(-5.0, 5.0),),
    angles,
)


def size(table, z):
    """The largest that the terms of the watched quantity get in the block."""
    return float((np.abs(table.rows) @ np.abs(z)).max()) + abs(table.constant) + 1e-300
