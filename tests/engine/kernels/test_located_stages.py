"""Located steps of every integrator: a step of any length is its matrix, cut where contact changes, of its order."""

import math

import numpy as np
import pytest
from vibroscope.engine import (
    INTEGRATORS,
    Bathe,
    ExactPenalty,
    Excitation,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.drivers.located import scheme_of_run
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.step_maps import bodies_of, stage_ends, stage_maps
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.motion import displacements
from vibroscope.engine.kernels.time_stepping import law_pieces
from vibroscope.engine.kernels.time_stepping.contact_location import force_of, forcing_at, step_from
from vibroscope.engine.kernels.time_stepping.stage import with_accelerations

from tests.naive_stepping import Twin

SYSTEMS = System(mu=0.7, clearance=-0.2), System(wall=True, clearance=0.2, excitation=Excitation(constant1=0.3))


@pytest.mark.parametrize("kind", INTEGRATORS.values(), ids=INTEGRATORS)
@pytest.mark.parametrize("system", SYSTEMS, ids=["two", "wall"])
def test_a_step_of_any_length_is_its_matrix_and_that_of_the_plain_twin(system, kind):
    eta, k, part = 1.3, 7, 0.37
    method = TimeStepping(300.0, 5.0, 200, kind(), "located")
    p = parameters_of(system, eta, method)
    m = scheme_of_run(p, method)
    s, angle = part * m.h, 2 * math.pi * (k + 0.2) / 200
    b, twin = bodies_of(p), Twin(system, eta, method)
    maps, twin.h = stage_maps(b, kind(), s), s
    one = (0.0, 0.0, 0.0) if system.wall else (0.4, -0.3, 0.2)
    for pressed in (False, True):
        gap = -0.02 if pressed else 0.3
        z = (*one, gap, 0.5, -1.5)
        begun = force_of(m, p.gain, pressed, z)
        x = (z[0], z[3], z[1], z[4], z[2], z[5], begun, math.cos(angle), math.sin(angle), 1.0)
        *_, last = stage_ends(maps, [b.contact if pressed else None] * len(maps))
        found = step_from(m, p.gain, pressed, z, s, (k, 0.2 * m.h))
        np.testing.assert_allclose(found, (last.end @ x)[[0, 2, 4, 1, 3, 5]], rtol=0, atol=1e-11)
        *_, end = twin.stages((*of_bodies(m, z), begun), angle / eta, lambda solve, status=pressed: solve(status))
        np.testing.assert_allclose(of_bodies(m, found), end[:3], rtol=0, atol=1e-11)


def of_bodies(m, z):
    """Displacements, velocities and accelerations of both bodies, (3, 2), of a motion x, v, a, g, u, b."""
    x, v, a, g, u, b = z
    x1, v1, x2, v2 = uncompiled(displacements)(m, x, v, g, u)
    _, a1, _, a2 = uncompiled(displacements)(m, x, a, g, b)
    return np.array([[x1, x2], [v1, v2], [a1, a2]])


WITHIN_ONE_STEP = [  # settings in which a contact that begins and ends within one step was ended where it begins
    (-0.3, 1.5017488916437565, 489.4599268299594, 33.46878220254852, 338, "compression"),
    (0.0, 1.8793099358465852, 447.89756948785134, 33.577324586432866, 336, "compression"),
    (0.1, 3.4296659071506945, 1693.7697214447767, 34.3143359679797, 100, "cut"),
    (-0.3, 0.5645528615324789, 349.8611687526164, 10.993387989260333, 753, "compression"),
]


@pytest.mark.parametrize(("clearance", "eta", "stiffness", "damping", "steps", "law"), WITHIN_ONE_STEP)
def test_a_contact_within_one_step_does_not_end_where_it_begins(clearance, eta, stiffness, damping, steps, law):
    """Rounding shows whether it does: runs whose starts differ by rounding then part by tenths, not by its root."""
    system = System(clearance=clearance, d1=0.05, d2=0.05)
    method = TimeStepping(stiffness, damping, steps, SemiImplicitEuler(), "located", law=law)
    x1, v1, x2, v2 = system.rest
    starts = [(x1, v1, x2 + change, v2) for change in (0.0, 1e-15, -2e-15)]
    one, *others = [simulate(system, eta, method, periods=4, keep=4, initial=start) for start in starts]
    for other in others:
        assert len(one.contacts) == len(other.contacts)
        np.testing.assert_allclose(other.section, one.section, rtol=0, atol=1e-6)


def test_a_contact_whose_end_is_looked_for_at_its_beginning_ends_where_it_ends(monkeypatch):
    """With x + sv, v = v₀ + sa, the gap θ(v + θa) of a contact is zero twice; rounding decides its sign at one."""
    method = TimeStepping(2500.0, 8.0, 60, SemiImplicitEuler(), "located")
    p = parameters_of(System(), 1.08, method)
    m = scheme_of_run(p, method)
    z = with_accelerations(m.pressed, (0.0, 0.0, 0.0, 0.0, -1.0, 0.0), forcing_at(m, (0, 0.0)))
    for length in np.linspace(0.6, 1.0, 100) * m.h:
        end = step_from(m, p.gain, True, z, length, (0, 0.0))
        for begin in (1e-17, 1e-16, 1e-15):
            monkeypatch.setattr(law_pieces, "root_by_curvature", lambda *_, found=begin * length: found)
            arguments = m, p.gain, law_pieces.MAIN, law_pieces.GAP, z, end, length, (0, 0.0)
            theta, *_ = uncompiled(law_pieces.locate_end)(*arguments)
            assert theta == pytest.approx(-z[4] / z[5], rel=1e-9)


METHODS = [TimeStepping(12000.0, 18.0, 1000, kind(), "located") for kind in (NewmarkBeta, Bathe)]
METHODS += [Newmark(12000.0, 18.0, 3000, located=True, law=law) for law in ("kelvin-voigt", "cut")]
METHODS.append(TimeStepping(12000.0, 18.0, 1000, HHTInterpolated(), "located", law="compression"))


@pytest.mark.parametrize(("integrator", "order"), [(NewmarkBeta(), 2), (Bathe(0.5), 2)], ids=repr)
def test_located_steps_have_the_order_of_the_integrator(integrator, order):
    options = {"periods": 2, "keep": 2}
    exact = simulate(System(), 1.08, ExactPenalty(100.0, 5.0), **options).section
    errors = []
    for steps in (500, 2000):
        method = TimeStepping(100.0, 5.0, steps, integrator, "located")
        errors.append(np.abs(simulate(System(), 1.08, method, **options).section - exact).max())
    assert math.log(errors[0] / errors[1], 4) == pytest.approx(order, abs=0.2)
