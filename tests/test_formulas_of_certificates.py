"""The formulas of curvature bounds and of the slow subspace are what kernels compute, read as in `test_formulas.py`."""

import cmath
import re

import numpy as np
import pytest
from scipy.linalg import expm
from vibroscope.engine import ExactPenalty, Newmark, Reference, System
from vibroscope.engine.drivers.event_driven import separating_circles, set_up
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES, FREE, PRESSED, TABLES, fill_tables, step_map
from vibroscope.engine.kernels.equations.motion import pressed_generator, separated_generator
from vibroscope.engine.kernels.event_driven.setup import fast_projector
from vibroscope.engine.kernels.linear.tables import POINTS, POWERS, curvature_bound, full_generator
from vibroscope.engine.kernels.time_stepping.newmark import scheme_of

from tests.displayed import Matrix, compares, of_pages, sides, value

PAGES = of_pages()
SYSTEM, ETA = System(mu=0.7, kappa=1.8, d1=0.1, d2=0.2, clearance=0.1), 1.3
RANDOM = np.random.default_rng(23)


class ByElement(Matrix):
    """A matrix of which the magnitude is that of each element."""

    def __mul__(self, other):
        return ByElement(self.rows @ other.rows)

    def __abs__(self):
        return np.abs(self.rows)


def states(count):
    """Random states of a phase, the last two numbers a cosine and a sine."""
    turn = RANDOM.uniform(0, 6, count)
    return np.column_stack([RANDOM.uniform(-2, 2, (count, 4)), np.cos(turn), np.sin(turn)])


@compares(35)
def test_the_curvature_bound_of_a_block():
    """No less than the displayed bound with the supremum over the whole block, and not much more."""
    phase = set_up(SYSTEM, ETA, Reference()).views.flight
    h, w = phase.spacing, phase.rows[:6, POWERS]
    a = full_generator(separated_generator(parameters_of(SYSTEM, ETA, Reference())), ETA)
    transitions = np.array([expm(a * s) for s in np.linspace(0, POINTS * h, 4 * POINTS + 1)])
    symbols = {"w": ByElement(w[None]), "A": Matrix(a), "E": Matrix(transitions), "sup": lambda one: one.max(axis=0)[0]}
    each = PAGES[35].rpartition(" ≤ ")[2].replace("Σᵢ ", "").replace("ᵢ", "")
    for z in states(20):
        bound = value(each, symbols | {"z": z}).sum()
        largest = np.abs(w @ a @ a @ transitions @ z).max()
        assert largest <= bound * (1 + 1e-12)
        by_elements, exact = (value(sides(PAGES[35])[1], {"h": h, "sup": float, "f″": up}) for up in (bound, largest))
        assert exact <= by_elements * (1 + 1e-12)
        assert by_elements <= curvature_bound(phase, tuple(z)) * (1 + 1e-12)
        assert curvature_bound(phase, tuple(z)) < 1.2 * by_elements


def level_of_steps(state):
    """Of a level of Newmark's steps: the map of one, ρ with the sign of the state, stride, bound of b, signed gaps."""
    m = scheme_of(parameters_of(System(), 1.08, Newmark(2500.0, 8.0, 2000)))
    tables = TABLES.read(TABLES.zeros())
    fill_tables(tables, m, 1.08, state, (2.41, 90.0)[state])
    one = step_map(m, 1.08, state == PRESSED)
    rho = one.gap * (-1 if state == PRESSED else 1)
    return one.matrix, rho, int(tables.strides[state, 1]), tables.curvatures[state, 1]


@pytest.mark.parametrize("state", [FREE, PRESSED])
@compares(45, 46)
def test_the_bound_of_a_level_of_steps(state):
    phi, rho, s, curvature = level_of_steps(state)
    closest = np.inf
    for z in states(4) * (1, 0.01, 1e-3, 1e-4, 1, 1):
        powers, gaps = np.eye(6), []
        for _ in range(ENTRIES * s):
            gaps.append(rho @ powers @ z)
            powers = phi @ powers
        symbols = {"ρ": Matrix(rho[None]), "Φ": Matrix(phi), "z": Matrix(z[:, None]), "sup": float}
        seconds = np.diff(gaps, 2)
        for j in (2, 50, 300):
            symbols["Φʲ⁻²"] = Matrix(np.linalg.matrix_power(phi, j - 2))
            assert value(sides(PAGES[45])[1], symbols) == pytest.approx(abs(seconds[j - 2]), rel=1e-6, abs=1e-15)
        largest = np.abs(seconds).max()
        b = value(sides(PAGES[45], 1)[1], {"B": largest, "s": s})
        assert b <= curvature @ np.abs(z)  # the kernel takes the supremum element by element
        for begin in range(0, (ENTRIES - 1) * s, s):
            ends = gaps[begin], gaps[begin + s]
            for k in range(s + 1):
                u = k / s
                chord = ends[0] * (1 - u) + ends[1] * u
                least = value(PAGES[46].partition(" ≥ ")[2], {"chord": chord, "u": u, "b": b})
                assert gaps[begin + k] >= least - 1e-12
                if 0 < k < s and chord - gaps[begin + k] > 1e-9:
                    closest = min(closest, (chord - least) / (chord - gaps[begin + k]))
    assert 1 - 1e-6 < closest < 1.5  # the bound is nearly reached


@compares(44)
def test_the_projector_on_the_slow_subspace():
    """The displayed integral by 500 nodes, of the whole matrix."""
    problem = System(), 2.76, ExactPenalty(1e8, 3e4)
    rows = pressed_generator(parameters_of(*problem))
    a, ((radius, slowest),) = full_generator(rows, 2.76), separating_circles(np.array([parameters_of(*problem)]))
    rates = np.abs(np.linalg.eigvals(a))
    assert rates[rates <= radius].max() == pytest.approx(slowest)
    before, integrand = re.fullmatch(r"(.*) ∮ (.*) dν,", sides(PAGES[44])[1] + ",").groups()
    total, nodes = Matrix(np.zeros((6, 6))), 500
    for k in range(nodes):
        turn = cmath.exp(2j * cmath.pi * (k + 0.5) / nodes)
        one = value(integrand, {"ν": radius * turn, "A": Matrix(a)})
        total = total + Matrix(one.rows * (2j * cmath.pi / nodes * radius * turn))  # dν
    slow = value(before, {"i": 1j}) * total
    assert np.abs(slow.rows.imag).max() < 1e-9 * np.abs(slow.rows).max()
    fast = np.eye(6) - slow.rows.real
    np.testing.assert_allclose(fast_projector(rows, 2.76, radius), fast[:4], atol=1e-9 * np.abs(fast).max())
