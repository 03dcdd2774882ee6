"""One impact: closed forms without a step, a plain twin with it, all instants of touch, and what is chosen from it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    INTEGRATORS,
    Bathe,
    CentralDifference,
    ExactPenalty,
    Impact,
    Material,
    NewmarkBeta,
    SemiImplicitEuler,
    TimeStepping,
    damping_bounds,
    force_courses,
    hertz_stiffness,
    impact,
    largest_step,
    over_speeds,
    over_steps,
    stiffness_bounds,
    stiffness_for,
)
from vibroscope.engine.one_impact.forward import touches_of

K, V, M = 3e6, 2.5, 4.0


def question(law="kelvin-voigt", e=0.5, steps=5.0, status="start", integrator=None, **numbers):
    """A contact in SI units that shall have a restitution, with so many steps in it."""
    given = {"impact": {"penetration": 2e-3}, "bilinear": {"penetration": 1e-3, "stiffening": 3.0}}.get(law, {})
    method = TimeStepping(K, 0.0, 4, integrator or NewmarkBeta(), status, law=law, **given)
    return Impact(method, V, M, 1e-4, **numbers).with_restitution(e).with_steps_per_contact(steps)


# --- without a step ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("zeta", [0.05, 0.3, 0.8])
def test_spring_and_damper_without_a_step_are_as_in_the_textbook(zeta):
    omega, found = math.sqrt(K / M), Impact(ExactPenalty(K, zeta * math.sqrt(K * M)), V, M).without_step
    root, angle = math.sqrt(1 - zeta**2), math.acos(zeta)
    assert found.restitution == pytest.approx(math.exp(-math.pi * zeta / root), rel=1e-12)
    assert found.time == pytest.approx(math.pi / (omega * root), rel=1e-11)
    assert found.penetration == pytest.approx(V / omega * math.exp(-zeta * angle / root), rel=1e-11)
    begins = 2 * zeta * omega * V * M  # the damper's jump; the force turns later if ζ is below a half
    turn = math.atan2(root * (1 - 4 * zeta**2), zeta * (3 - 4 * zeta**2)) / (omega * root)
    depth = V / (omega * root) * math.exp(-zeta * omega * turn) * math.sin(omega * root * turn)
    rate = V * math.exp(-zeta * omega * turn) * math.cos(omega * root * turn) - zeta * omega * depth
    peak = K * depth + 2 * zeta * omega * M * rate if turn > 0 else 0.0
    assert found.force == pytest.approx(max(begins, peak), rel=1e-10)


def test_an_elastic_hertz_contact_is_as_in_the_textbook():
    found = Impact(ExactPenalty(K, 0.0, "hunt-crossley"), V, M).without_step
    depth = (5 * M * V**2 / (4 * K)) ** 0.4  # Johnson, Contact Mechanics, Eq. (11.20), and (11.24)
    assert found.penetration == pytest.approx(depth, rel=1e-9)
    assert found.force == pytest.approx(K * depth**1.5, rel=1e-9)
    assert found.time == pytest.approx(2.94 * depth / V, rel=2e-3)
    assert found.restitution == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_a_law_gives_the_restitution_that_was_asked_for_whatever_the_units(law):
    assert question(law).without_step.restitution == pytest.approx(0.5, abs=1e-9)


# --- with a step ------------------------------------------------------------------------------------------------------


def twin(zeta, h, s, status):
    """Speed after a contact of mass, spring and closing speed one by Newmark's formulas; nan without a solution."""
    g, v, a, c, contact = float(s * h), -1.0, 0.0, 2 * zeta, False
    for i in range(10_000):
        p, q, was = g + h * v + h * h / 4 * a, v + h / 2 * a, v

        def end(contact, p=p, q=q):
            new = -contact * (p + c * q) / (1 + contact * (h * h / 4 + c * h / 2))
            return p + h * h / 4 * new, q + h / 2 * new, new

        if status == "start":
            contact = g <= 0.0
        else:
            contact = next((each for each in (contact, not contact) if (end(each)[0] <= 0.0) == each), None)
            if contact is None:
                return math.nan
        g, v, a = end(contact)
        if i > 1 and g > 0.0 and v > 0.0 and abs(v - was) < 1e-13:
            return v
    return 0.0


def explicit_twin(zeta, h, s):
    """The same by central differences, whose damper feels the velocity at half steps."""
    g, v, a = s * h, -1.0, 0.0
    for i in range(10_000):
        half, was = v + h / 2 * a, v
        g += h * half
        a = -(g + 2 * zeta * half) if g <= 0.0 else 0.0
        v = half + h / 2 * a
        if i > 1 and g > 0.0 and v > 0.0 and abs(v - was) < 1e-13:
            return v
    return 0.0


TWINS = {
    "start": (NewmarkBeta(), "start", lambda *numbers: twin(*numbers, "start")),
    "end": (NewmarkBeta(), "end", lambda *numbers: twin(*numbers, "end")),
    "explicit": (CentralDifference(), "start", explicit_twin),
}


@pytest.mark.parametrize("name", TWINS)
@pytest.mark.parametrize("steps", [1.5, 5.0, 21.3])
def test_each_touch_is_that_of_the_plain_formulas(name, steps):
    integrator, status, plain = TWINS[name]
    asked = question(steps=steps, status=status, integrator=integrator)
    instants = np.linspace(0.013, 0.987, 29)
    found = touches_of(asked).run(instants)
    h = asked.time_step / asked.units.time
    wanted = np.array([plain(asked.ratio, h, s) for s in instants])
    solved = np.isfinite(wanted)
    assert solved.sum() > 20
    assert np.where(found[:, -1] == 0, found[:, 0], 0.0)[solved] == pytest.approx(wanted[solved], abs=1e-11)
    assert (found[~solved, -1] > 0).all()  # it has ended without a solution


@pytest.mark.parametrize("name", TWINS)
@pytest.mark.parametrize("steps", [1.5, 5.0])
def test_least_mean_and_greatest_are_those_of_a_fine_scan(name, steps):
    integrator, status, plain = TWINS[name]
    asked = question(steps=steps, status=status, integrator=integrator)
    found, h = impact(asked), asked.time_step / asked.units.time
    scan = np.array([plain(asked.ratio, h, s) for s in (np.arange(4000) + 0.5) / 4000])
    solved = scan[np.isfinite(scan)]
    between = 16 / len(scan)  # from the last of these to an end, e changes by less
    assert solved.min() - between <= found.restitution.least <= solved.min()
    assert solved.max() <= found.restitution.greatest <= solved.max() + between
    assert found.restitution.mean == pytest.approx(solved.mean(), abs=1e-3)
    assert found.without_solution == pytest.approx(1 - len(solved) / len(scan), abs=1e-3)


@pytest.mark.parametrize("law", ["kelvin-voigt", "limited", "compression", "jankowski"])
@pytest.mark.parametrize("status", ["start", "end"])
def test_extremes_and_shares_are_those_of_a_scan_whatever_the_law(law, status):
    """Kinks along a piece are found, and where a step begins to have two solutions, though the restitution goes on."""
    asked = question(law, steps=3.3, status=status)
    scan = touches_of(asked).run((np.arange(20_000) + 0.5) / 20_000)
    rate, _, depth, force = scan[scan[:, -1] == 0].T[:4]
    found = impact(asked)
    assert found.restitution == pytest.approx((rate.min(), rate.mean(), rate.max()), abs=1e-3)
    assert found.penetration == pytest.approx(depth.max() * asked.units.length, rel=1e-4)
    assert found.force == pytest.approx(force.max() * asked.units.force, rel=1e-4)
    assert found.two_solutions == pytest.approx((scan[:, 7] > 0).mean(), abs=2e-4)
    assert found.without_solution == pytest.approx((scan[:, 6] > 0).mean(), abs=2e-4)


def test_the_ends_of_pieces_are_found_and_what_a_linear_law_gives_is_linear_between_them():
    asked = question(steps=5.0)
    found, h = impact(asked), asked.time_step / asked.units.time
    pieces = found.instant[:, -1] - found.instant[:, 0]
    jump = np.flatnonzero((pieces < 1e-11) & (np.ptp(found.restitutions, axis=1) > 0.1))
    assert len(jump) == 1  # from five steps to six
    at = found.instant[jump[0], 0]
    sides = [twin(asked.ratio, h, at + side, "start") for side in (-1e-9, 1e-9)]
    assert abs(sides[0] - sides[1]) > 0.3
    long = pieces > 1e-3
    bent = found.restitutions[long] @ [1.0, 0.0, -2.0, 0.0, 1.0]
    assert abs(bent).max() < 1e-9
    assert found.steps == (5, 6)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_small_steps_of_every_integrator_and_status_give_what_the_law_gives(law):
    for kind in INTEGRATORS.values():
        for status in ("start", "end", "located"):
            if status == "end" and kind.explicit:
                continue
            asked = question(law, steps=150.0, status=status, integrator=kind())
            found = impact(asked).restitution
            assert found.least <= found.mean <= found.greatest
            assert found.mean == pytest.approx(0.5, abs=0.025), (kind.name, status)


def test_it_does_not_depend_on_the_units_and_scales_with_them():
    asked = question("hunt-crossley", steps=7.0)
    found = impact(asked)
    alone = Impact(asked.unit_method, 1.0, 1.0, asked.time_step / asked.units.time)
    same = impact(alone)
    assert found.restitution == pytest.approx(same.restitution, rel=1e-12)
    assert found.penetration == pytest.approx(same.penetration * asked.units.length, rel=1e-12)
    assert found.force == pytest.approx(same.force * asked.units.force, rel=1e-12)
    assert found.energy_lost.least == pytest.approx(1 - found.restitution.greatest**2)


def test_a_constant_force_acts_before_during_and_after_the_contact():
    weight = replace(question(e=1.0, steps=400.0, status="located"), force=0.2 * M * V * math.sqrt(K / M))
    found = impact(weight).restitution
    assert found.mean == pytest.approx(1.0, abs=1e-4)  # no energy is lost: it is back at touch with its speed
    depth = weight.without_step.penetration
    assert 0.5 * K * depth**2 == pytest.approx(0.5 * M * V**2 + weight.force * depth, rel=1e-9)
    damped = replace(question(e=0.6, steps=400.0, status="located"), force=weight.force)
    assert impact(damped).restitution.mean == pytest.approx(damped.without_step.restitution, abs=1e-3)


def test_shares_of_touches_that_end_otherwise():
    assert impact(question(steps=0.4)).blown_up == pytest.approx(1.0)
    stuck = impact(question().with_contact(damping=3 * math.sqrt(K * M)).with_steps_per_contact(20.0))
    assert (stuck.stuck, stuck.restitution.greatest) == (pytest.approx(1.0), 0.0)
    jumps = impact(question(status="end", steps=5.0))
    assert 0.01 < jumps.without_solution < 0.2
    assert 0.01 < jumps.two_solutions < 0.2
    assert impact(question(e=1.0, steps=8.0)).gained > 0.2  # contact is felt late: energy is gained


@pytest.mark.parametrize(
    "choices",
    [{}, {"status": "end"}, {"status": "located"}, {"integrator": CentralDifference()}, {"law": "hunt-crossley"}],
)
def test_the_forces_over_time_change_the_momentum_by_what_the_bodies_part_with(choices):
    asked = question(steps=7.0, **choices)
    found, courses = impact(asked), force_courses(asked)
    assert [*courses] == ["best", "worst", "exact"]
    off = {name: abs(course.restitution - 0.5) for name, course in courses.items()}
    assert off["worst"] == pytest.approx(np.nanmax(abs(found.restitutions - 0.5)))
    assert off["best"] == pytest.approx(np.nanmin(abs(found.restitutions - 0.5)))
    for name, course in courses.items():
        if name == "exact" or choices.get("status") != "located":  # that has forces between its samples
            impulse = np.trapezoid(course.force, course.time)
            assert impulse == pytest.approx(M * V * (1 + course.restitution), rel=1e-9 if name != "exact" else 2e-4)
        assert course.force.max() <= max(found.force, asked.without_step.force) * (1 + 1e-9)
    assert courses["worst"].time[0] == -courses["worst"].instant * asked.time_step
    assert courses["exact"].time[-1] == pytest.approx(asked.without_step.time)


def test_forces_of_contacts_that_blow_up_stay_or_have_many_steps():
    assert [*force_courses(question(steps=0.4))] == ["exact"]
    sticky = question().with_contact(damping=3 * math.sqrt(K * M)).with_steps_per_contact(20.0)
    for course in force_courses(sticky).values():
        assert course.time[-1] <= 2.1 * sticky.contact_time
    assert all(len(course.time) <= 1002 for course in force_courses(question(steps=5000.0)).values())


# --- backwards --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("integrator", [NewmarkBeta(), Bathe(), SemiImplicitEuler()])
def test_the_largest_step_keeps_to_the_tolerance_and_smaller_ones_do(integrator):
    asked = question(integrator=integrator)
    found = largest_step(asked, 0.1)
    ends = found.verified.restitution.least, found.verified.restitution.greatest
    assert max(abs(e - 0.5) for e in ends) <= 0.1
    n = found.steps_per_contact
    assert found.step == pytest.approx(asked.contact_time / n)
    for steps in np.linspace(1.003 * n, 3 * n, 40):
        e = impact(asked.with_steps_per_contact(steps)).restitution
        assert max(abs(e.least - 0.5), abs(e.greatest - 0.5)) <= 0.102
    larger = [impact(asked.with_steps_per_contact(part * n)).restitution for part in np.linspace(0.97, 0.9995, 6)]
    assert any(max(abs(e.least - 0.5), abs(e.greatest - 0.5)) > 0.1 for e in larger)


def test_k_for_a_permitted_penetration_or_force_gives_it():
    for law in ("kelvin-voigt", "hunt-crossley", "impact"):
        asked = question(law)
        for name, wanted in (("penetration", 1e-3), ("force", 5e3)):
            found = stiffness_for(asked, **{name: wanted})
            assert getattr(found.without_step, name) == pytest.approx(wanted, rel=1e-6)
            assert found.without_step.restitution == pytest.approx(0.5, abs=1e-6)


def test_bounds_hold_and_what_lies_beyond_does_not():
    asked = question(steps=10.0, integrator=CentralDifference())
    stable = stiffness_bounds(asked).stable[1]
    c, h = 2 * asked.method.damping, asked.time_step
    # ωh = 2(√(1 + ζ²) − ζ) of the damped oscillator with the damper at half steps
    omega = math.sqrt(stable / M)
    zeta = c / (2 * M * omega)
    assert omega * h == pytest.approx(2 * (math.sqrt(1 + zeta**2) - zeta), rel=1e-3)
    least, greatest = damping_bounds(asked).no_energy_gained
    assert impact(asked.with_contact(damping=1.01 * least)).gained == 0.0
    assert impact(asked.with_contact(damping=0.97 * least)).gained > 0.0  # by the touches at an end of a step
    assert least < asked.method.damping < greatest


def test_bands_go_over_steps_and_speeds():
    asked = question("impact", steps=10.0)
    by_steps = dict(over_steps(asked, np.array([5.0, 10.0])))
    assert by_steps[10.0].restitution == impact(asked).restitution
    by_speed = dict(over_speeds(asked, np.array([V, 2 * V])))
    assert by_speed[V].restitution == pytest.approx(impact(asked).restitution)
    assert by_speed[2 * V].penetration > by_speed[V].penetration


def test_hertz_stiffness_of_spheres():
    steel, rigid = Material(210e9, 0.3), Material(1e15, 0.0)
    assert hertz_stiffness(steel, rigid, 0.01) == pytest.approx(4 / 3 * 210e9 / 0.91 * 0.1, rel=1e-3)
    assert hertz_stiffness(steel, steel, 0.02, 0.02) == pytest.approx(hertz_stiffness(steel, steel, 0.01), rel=1e-12)
    with pytest.raises(ValueError, match="two planes touch in no point"):
        hertz_stiffness(steel, steel, math.inf)
    with pytest.raises(ValueError, match=r"nu = 0\.7 is outside"):
        hertz_stiffness(steel, Material(1e9, 0.7), 0.01)


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"speed": 0.0}, "closing_speed = 0"),
        ({"mass": -1.0}, "mass = -1"),
        ({"time_step": 0.0}, "with a method that has one"),
        ({"time_step": 1e-9}, "too short to follow: take at least"),
        ({"force": 1e9}, "take less than"),
    ],
)
def test_bad_numbers_are_named(numbers, message):
    with pytest.raises(ValueError, match=message):
        replace(question(), **numbers)


def test_a_question_without_a_step_has_no_answer_with_one():
    with pytest.raises(ValueError, match="no time step"):
        impact(Impact(ExactPenalty(K, 10.0), V, M))


def test_hht_feels_the_contact_after_it():
    found = impact(question(integrator=HHT(alpha=-0.3), steps=6.0))
    assert found.restitution.least < 0.5 < found.restitution.greatest
