"""Located steps of every integrator: a step of any length is its matrix, and skips are the plain loop's solution."""

import math
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    INTEGRATORS,
    LAWS_BY_RESTITUTION,
    Bathe,
    ExactPenalty,
    Excitation,
    Newmark,
    NewmarkBeta,
    Record,
    SemiImplicitEuler,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.drivers.located import stages_of
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.skip_tables import LocatedTables
from vibroscope.engine.drivers.step_maps import bodies_of, step_maps
from vibroscope.engine.drivers.step_modes import Piece
from vibroscope.engine.kernels.accelerated import located_skip
from vibroscope.engine.kernels.accelerated.located_skip import ASKED, CONTACT, FREE, MISSING
from vibroscope.engine.kernels.accelerated.skip_search import LEAST, UNLIMITED, find_skip
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.time_stepping import contact_location
from vibroscope.engine.kernels.time_stepping.contact_location import (
    contact_force,
    forcing_at,
    step_of_stages,
    with_accelerations,
)
from vibroscope.engine.kernels.time_stepping.located import located_scheme

from tests.law_numbers import law_numbers

SYSTEMS = System(mu=0.7, clearance=-0.2), System(wall=True, clearance=0.2, excitation=Excitation(constant1=0.3))
FIELDS = ("time", "position", "velocity_before", "velocity_after", "impulse", "closing_speed")


@pytest.mark.parametrize("kind", INTEGRATORS.values(), ids=INTEGRATORS)
@pytest.mark.parametrize("system", SYSTEMS, ids=["two", "wall"])
def test_a_step_of_any_length_is_its_matrix(system, kind):
    eta, k, part = 1.3, 7, 0.37
    method = TimeStepping(300.0, 5.0, 200, kind(), "located")
    p = parameters_of(system, eta, method)
    m = located_scheme(p)._replace(stages=stages_of(kind(), p))
    s, angle = part * m.h, 2 * math.pi * (k + 0.2) / 200
    maps = step_maps(bodies_of(p), kind(), s)
    one = (0.0, 0.0, 0.0) if system.wall else (0.4, -0.3, 0.2)
    for pressed in (False, True):
        gap = -0.02 if pressed else 0.3
        z = (*one, gap, 0.5, -1.5)
        x, g = z[0] - p.free_position, gap - p.free_gap
        begun = contact_force(m, pressed, z)
        y = (x, x + g, z[1], z[1] + z[4], z[2], z[2] + z[5], begun, math.cos(angle), math.sin(angle), 1.0)
        end = maps[int(pressed) if len(maps) == 2 else 2 + 3 * pressed] @ y
        found = step_of_stages(m, pressed, z, s, k, 0.2 * m.h)
        displaced = found[0] - p.free_position, found[1], found[2], *(np.add(found[3:], found[:3]))
        expected = end[[0, 2, 4, 1, 3, 5]] + (0, 0, 0, p.free_position + p.free_gap, 0, 0)
        np.testing.assert_allclose(displaced, expected, rtol=0, atol=1e-11)


def same(one, other, tolerance):
    """Compare what two runs keep."""
    assert (one.status, len(one.contacts)) == (other.status, len(other.contacts))
    assert other.cost.steps == pytest.approx(one.cost.steps, abs=5)  # rounding may spare a solve to locate a change
    np.testing.assert_allclose(other.contacts, one.contacts, rtol=0, atol=tolerance)
    np.testing.assert_allclose(other.section, one.section, rtol=0, atol=tolerance)
    pairs = [[getattr(run.impacts, name) for run in (one, other)] for name in FIELDS]
    pairs += [[getattr(run.trajectory, name) for run in (one, other)] for name in ("displacement", "velocity", "force")]
    for plain, skipped in pairs:
        np.testing.assert_allclose(skipped, plain, rtol=0, atol=1e4 * tolerance * max(1, np.abs(plain).max()))


METHODS = [TimeStepping(2500.0, 8.0, 1000, kind(), "located") for kind in INTEGRATORS.values()]
METHODS += [Newmark(stiffness, 8.0, steps, located=True) for stiffness in (50.0, 2500.0) for steps in (1000, 3000)]


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize("eta", [1.08, 2.76])
@pytest.mark.parametrize("system", [System(), *SYSTEMS], ids=["paper", "preload", "wall"])
def test_skips_are_the_plain_loop(system, eta, method):
    options = {"periods": 4, "keep": 4, "record": Record(2, 300)}
    one, other = (simulate(system, eta, replace(method, every_step=every), **options) for every in (True, False))
    same(one, other, 1e-10)


OTHER_LAWS = [Newmark(2500.0, 8.0, 1000, located=True, law="cut")]
for law, kind in zip(CONTACT_LAWS[1:], cycle(INTEGRATORS.values()), strict=False):
    damping = None if law in LAWS_BY_RESTITUTION else 8.0
    OTHER_LAWS.append(TimeStepping(2500.0, damping, 1000, kind(), "located", law=law, **law_numbers(law)))


@pytest.mark.parametrize("method", OTHER_LAWS, ids=repr)
@pytest.mark.parametrize("eta", [1.08, 2.76])
@pytest.mark.parametrize("system", [System(), *SYSTEMS], ids=["paper", "preload", "wall"])
def test_skips_are_the_plain_loop_with_every_law(system, eta, method, monkeypatch):
    """Tables are made of flights and, where a law is piecewise linear, of its pieces; of no other mode."""
    options = {"periods": 4, "keep": 4, "record": Record(2, 300)}
    one = simulate(system, eta, replace(method, every_step=True), **options)
    watched, skipping = [], located_skip.integrate_law_skipping

    def seen(m, skips, *arguments):
        watched.append(skips.tables.counts)
        return skipping(m, skips, *arguments)

    monkeypatch.setattr(located_skip, "integrate_law_skipping", seen)
    other = simulate(system, eta, method, **options)
    flight, *contact = watched[-1]
    assert flight == 1
    assert (max(contact, default=0) > 1) == (method.law in ("cut", "limited", "compression"))
    same(one, other, 1e-9)


WITHIN_ONE_STEP = [  # settings in which a contact that begins and ends within one step was ended where it begins
    (-0.3, 1.5017488916437565, 489.4599268299594, 33.46878220254852, 338, "compression"),
    (0.0, 1.8793099358465852, 447.89756948785134, 33.577324586432866, 336, "compression"),
    (0.1, 3.4296659071506945, 1693.7697214447767, 34.3143359679797, 100, "cut"),
    (-0.3, 0.5645528615324789, 349.8611687526164, 10.993387989260333, 753, "compression"),
]


@pytest.mark.parametrize(("clearance", "eta", "stiffness", "damping", "steps", "law"), WITHIN_ONE_STEP)
def test_a_contact_within_one_step_does_not_end_where_it_begins(clearance, eta, stiffness, damping, steps, law):
    """Rounding shows whether it does: both ways of taking the same steps then part by tenths."""
    system = System(clearance=clearance, d1=0.05, d2=0.05)
    method = TimeStepping(stiffness, damping, steps, SemiImplicitEuler(), "located", law=law)
    runs = [simulate(system, eta, replace(method, every_step=every), periods=4, keep=4) for every in (True, False)]
    assert len(runs[0].contacts) == len(runs[1].contacts)
    np.testing.assert_allclose(runs[1].section, runs[0].section, rtol=0, atol=1e-10)


def test_a_contact_whose_end_is_looked_for_at_its_beginning_ends_where_it_ends(monkeypatch):
    """With x + sv, v = v₀ + sa, the gap θ(v + θa) of a contact is zero twice; rounding decides its sign at one."""
    method = TimeStepping(2500.0, 8.0, 60, SemiImplicitEuler(), "located")
    p = parameters_of(System(), 1.08, method)
    m = located_scheme(p)._replace(stages=stages_of(method.integrator, p))
    z = with_accelerations(m.pressed, (0.0, 0.0, 0.0, 0.0, -1.0, 0.0), forcing_at(m, 0, 0.0))
    for length in np.linspace(0.6, 1.0, 100) * m.h:
        end = step_of_stages(m, True, z, length, 0, 0.0)
        for begin in (1e-17, 1e-16, 1e-15):
            monkeypatch.setattr(contact_location, "root_by_curvature", lambda *_, found=begin * length: found)
            theta, *_ = uncompiled(contact_location.locate_change)(m, True, z, end, length, 0, 0.0)
            assert theta == pytest.approx(-z[4] / z[5], rel=1e-9)


@pytest.mark.parametrize("method", [METHODS[0], METHODS[4], METHODS[-1], OTHER_LAWS[0], OTHER_LAWS[2]], ids=repr)
def test_skips_do_not_depend_on_where_a_run_is_cut(method):
    """Chaotic motion: the last bit would show."""
    method = replace(method, stiffness=12000.0, damping=18.0)
    whole = simulate(System(), 1.70, method, periods=60, keep=20, record=Record(7, 300))
    begun = simulate(System(), 1.70, method, periods=31, keep=1).checkpoint
    rest = simulate(System(), 1.70, method, periods=30, keep=3, initial=begun)
    np.testing.assert_array_equal(whole.section[-3:], rest.section)
    again = simulate(System(), 1.70, method, periods=60, keep=60)
    np.testing.assert_array_equal(whole.section, again.section[-20:])
    assert whole.cost.steps == again.cost.steps


@pytest.mark.parametrize(("integrator", "order"), [(NewmarkBeta(), 2), (Bathe(0.5), 2)], ids=repr)
def test_located_steps_have_the_order_of_the_integrator(integrator, order):
    options = {"periods": 2, "keep": 2}
    exact = simulate(System(), 1.08, ExactPenalty(100.0, 5.0), **options).section
    errors = []
    for steps in (500, 2000):
        method = TimeStepping(100.0, 5.0, steps, integrator, "located")
        errors.append(np.abs(simulate(System(), 1.08, method, **options).section - exact).max())
    assert math.log(errors[0] / errors[1], 4) == pytest.approx(order, abs=0.2)


def test_a_flight_that_rises_from_the_surface_is_skipped_at_once():
    """No dip is looked for in its first step, and those that follow begin beyond what a gap can fall within a step."""
    method = Newmark(2500.0, 8.0, 1000, located=True)
    p = parameters_of(System(), 1.08, method)
    made = LocatedTables(located_scheme(p), p, NewmarkBeta(), [Piece(2500.0, 8.0)])
    made.make_asked()
    tables, us = made.arrays, np.zeros((LEAST + 1, 10))
    us[0] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0
    coarse, fine = find_skip(tables, FREE, us, 0.0, UNLIMITED)
    gaps = np.concatenate([chunk.T @ us[0] for chunk in tables.rows[FREE, 0, 0]])
    assert coarse * tables.strides[FREE] + fine > len(gaps)
    assert (gaps > 0).all()


@pytest.mark.parametrize("halvings", [None, 0, 2, 5], ids=["flight", "contact", "quarters", "shortest"])
def test_no_gap_dips_within_a_piece_by_more_than_its_bound(halvings):
    """The largest |g″| over all pieces of both levels, formed piece by piece."""
    method = Newmark(2500.0, 8.0, 1000, located=True)
    p = parameters_of(System(), 1.08, method)
    m = located_scheme(p)
    made, mode = (
        LocatedTables(m, p, NewmarkBeta(), [Piece(2500.0, 8.0)]),
        FREE if halvings is None else CONTACT + halvings,
    )
    tables, length = made.arrays, m.h / 2 ** (halvings or 0)
    tables.counts[:] = MISSING
    tables.counts[mode] = ASKED
    made.make_asked()
    assert tables.counts[mode] == 1
    assert (np.delete(tables.counts, mode) < 0).all()
    x_of_u = np.eye(10)
    x_of_u[[1, 3, 5], [0, 2, 4]] = 1.0
    step = np.eye(10)
    step[:7] = step_maps(bodies_of(p), NewmarkBeta(), length)[int(mode != FREE), :7]
    c, s = math.cos(1.08 * length), math.sin(1.08 * length)
    step[7:9, 7:9] = [[c, -s], [s, c]]
    step[6] *= mode != FREE
    step = np.linalg.solve(x_of_u, step @ x_of_u)
    np.testing.assert_allclose(tables.columns[mode, 0, 0].T, step, rtol=1e-9, atol=1e-12)
    entries = np.count_nonzero(tables.columns[mode, 1].any(axis=(1, 2)))
    row, largest = np.eye(10)[5], 0.0
    for _ in range(max(128, (entries + 1) * int(tables.strides[mode]))):
        largest, row = np.maximum(largest, np.abs(row)), row @ step
    assert (tables.dips[mode, 0] >= largest * length**2 / 2 * (1 - 1e-9)).all()
    assert (tables.dips[mode, 0] <= 1.01 * largest * length**2 / 2 + 1e-18).all()
