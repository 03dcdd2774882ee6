"""One impact: closed forms without a step, a plain twin with it, all instants of touch, and what is chosen from it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    HHT,
    INTEGRATORS,
    TRBDF2,
    BackwardEuler,
    Bathe,
    CentralDifference,
    ExactPenalty,
    GeneralisedAlpha,
    HHTInterpolated,
    Impact,
    Material,
    MoreauJean,
    Newmark,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
    damping_bounds,
    force_courses,
    hertz_stiffness,
    impact,
    largest_step,
    over_motion,
    over_speeds,
    over_steps,
    simulate,
    stiffness_bounds,
    stiffness_for,
)
from vibroscope.engine.divergence.encounters import delivered_restitution, short_contacts
from vibroscope.engine.drivers import alone
from vibroscope.engine.drivers.alone import CODE, PARTED, SPEED, STUCK
from vibroscope.engine.one_impact.forward import instants_of
from vibroscope.engine.one_impact.instants import OUTLINE, ROUGH, over_instants
from vibroscope.engine.one_impact.of_system import contact_alone

from tests.naive_impact import ImpactTwin, ends_and_mean
from tests.share import every

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


def twin(asked):
    """The plain twin of a contact with a step."""
    method, h = asked.unit_method, asked.time_step / asked.units.time
    return ImpactTwin(method.law, 2 * method.damping, method.integrator, method.status, h)


INTEGRATORS_OF_TWIN = (
    *(NewmarkBeta(), NewmarkBeta(0.3025, 0.6), NewmarkBeta(1 / 6, 0.5), CentralDifference(), SemiImplicitEuler()),
    *(HHT(-0.05), HHT(-0.3), HHTInterpolated(-0.1), GeneralisedAlpha(0.8), GeneralisedAlpha(0.2), BackwardEuler()),
)
SCHEMES = [(kind, s) for kind in INTEGRATORS_OF_TWIN for s in CONTACT_STATUSES if s != "end" or not kind.explicit]
OF_LAWS = [(law, *s) for law in ("kelvin-voigt", "limited", "cut", "hunt-crossley") for s in SCHEMES]
NUMBERS = [(e, steps) for steps in (0.5, 1.3, 3.0, 5.0, 12.0, 40.0, 100.0) for e in (0.2, 0.5, 0.8, 1.0)]
# each law, integrator and status with two of the numbers, all of which occur; a twin's cuts at kinks take long
TABLE = [
    (*scheme, *NUMBERS[(11 * turn + 9 * k) % len(NUMBERS)])
    for turn, scheme in enumerate(OF_LAWS)
    for k in range(2)
    if scheme[2] != "located" or scheme[0] in ("kelvin-voigt", "hunt-crossley")
]


@pytest.mark.parametrize(("law", "integrator", "status", "e", "steps"), every(TABLE))
def test_what_a_step_gives_is_what_the_plain_formulas_give(law, integrator, status, e, steps):
    """Of each instant of touch, and least, mean, greatest and shares of all."""
    asked = question(law, e, steps, status, integrator)
    plain, found = twin(asked), impact(asked)
    (least, mean, greatest), shares = ends_and_mean(plain, 400 if status == "located" else 10_000)
    ends = found.restitution.least, found.restitution.greatest
    assert ends == pytest.approx((least, greatest), abs=1e-3, rel=1e-3, nan_ok=True)
    assert found.restitution.mean == pytest.approx(mean, abs=2e-3, nan_ok=True)
    assert {name: getattr(found, name) for name in shares} == pytest.approx(shares, abs=2e-3)
    instants = np.linspace(0.013, 0.987, 29)
    each, wanted = over_instants_at(asked, instants), plain.run(instants)[0]
    assert np.isnan(wanted).all() or np.nanmedian(np.abs(each - wanted)) < 1e-9  # beside an end rounding decides


def over_instants_at(asked, instants):
    """The restitution of these touches."""
    found = asked.touches.run(instants)
    return np.where(found[:, CODE] == PARTED, found[:, SPEED], np.where(found[:, CODE] == STUCK, 0.0, np.nan))


@pytest.mark.parametrize("law", ["kelvin-voigt", "limited", "compression", "jankowski"])
@pytest.mark.parametrize("status", ["start", "end"])
def test_extremes_and_shares_are_those_of_a_scan_whatever_the_law(law, status):
    """Kinks along a piece are found, and where a step begins to have two solutions, though the restitution goes on."""
    asked = question(law, steps=3.3, status=status)
    scan = asked.touches.run((np.arange(20_000) + 0.5) / 20_000)
    rate, _, depth, force = scan[scan[:, -1] == 0].T[:4]
    found = impact(asked)
    assert found.restitution == pytest.approx((rate.min(), rate.mean(), rate.max()), abs=1e-3)
    assert found.penetration == pytest.approx(depth.max() * asked.units.length, rel=1e-4)
    assert found.force == pytest.approx(force.max() * asked.units.force, rel=1e-4)
    assert found.two_solutions == pytest.approx((scan[:, 7] > 0).mean(), abs=2e-4)
    assert found.without_solution == pytest.approx((scan[:, 6] > 0).mean(), abs=2e-4)


def test_contacts_that_stay_are_one_course_however_long_they_are_followed():
    """With hardly any rebound most stay together; each step that was tried had another number of steps."""
    tried = []
    found = largest_step(question(e=0.01), cancelled=lambda: tried.append(None))
    assert found.verified.restitution.greatest < 0.06
    assert len(tried) < 200


@pytest.mark.parametrize("integrator", [NewmarkBeta(), HHTInterpolated()])
def test_no_restitution_is_negative_where_it_has_a_kink_at_zero(integrator):
    assert impact(question(e=1.0, steps=2.0, integrator=integrator)).restitution.least >= 0.0


def test_the_ends_of_pieces_are_found_and_what_a_linear_law_gives_is_linear_between_them():
    asked = question(steps=5.0)
    found = impact(asked)
    pieces = found.instant[:, -1] - found.instant[:, 0]
    jump = np.flatnonzero((pieces < 1e-11) & (np.ptp(found.restitutions, axis=1) > 0.1))
    assert len(jump) == 1  # from five steps to six
    at = found.instant[jump[0], 0]
    sides = twin(asked).run([at - 1e-9, at + 1e-9])[0]
    assert abs(sides[0] - sides[1]) > 0.3
    long = pieces > 1e-3
    bent = found.restitutions[long] @ [1.0, 0.0, -2.0, 0.0, 1.0]
    assert abs(bent).max() < 1e-9
    assert found.steps == (5, 6)


STEPS = [(kind, s) for kind in INTEGRATORS.values() for s in CONTACT_STATUSES if s != "end" or not kind.explicit]


@pytest.mark.parametrize(("law", "kind", "status"), every((law, *step) for law in CONTACT_LAWS for step in STEPS))
def test_small_steps_of_every_integrator_and_status_give_what_the_law_gives(law, kind, status):
    found = impact(question(law, steps=150.0, status=status, integrator=kind())).restitution
    assert found.least <= found.mean <= found.greatest
    assert found.mean == pytest.approx(0.5, abs=0.025)


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


@pytest.mark.parametrize(
    ("integrator", "status", "e", "tolerance"),
    every(
        [
            (NewmarkBeta(), "end", 0.5, 0.05),
            (NewmarkBeta(), "start", 0.5, 0.05),
            (HHT(), "end", 0.8, 0.03),
            (GeneralisedAlpha(), "end", 0.5, 0.05),
            (TRBDF2(), "start", 0.5, 0.05),
            (Bathe(), "start", 0.8, 0.03),  # whose stage ends within the step
            (BackwardEuler(), "start", 0.5, 0.05),
            (SemiImplicitEuler(), "start", 0.5, 0.05),
        ]
    ),
    ids=repr,
)
def test_no_window_of_steps_that_fail_lies_above_the_largest_step(integrator, status, e, tolerance):
    """By brute force: 400 numbers of steps in the next two, a two-hundredth apart."""
    method = TimeStepping(K, 0.0, 4, integrator, status, "keep")
    asked = Impact(method, 1.0, M, time_step=1e-4).with_restitution(e)
    n = largest_step(asked, tolerance).steps_per_contact
    for steps in np.arange(1.0002 * n, n + 2.0, 0.005):
        found = over_instants(asked.with_steps_per_contact(steps).touches, ROUGH).restitution
        assert np.nanmax(np.abs(found - e)) <= tolerance + 1e-4, steps


def test_none_lies_there_where_hundreds_of_steps_are_needed_under_a_force():
    method = TimeStepping(1e6, 200.0, 4, BackwardEuler())
    asked = Impact(method, 3.0, 2.0, time_step=1e-3, force=2000.0)
    e, found = asked.without_step.restitution, largest_step(asked)
    n = found.steps_per_contact
    assert n == pytest.approx(246.0, rel=1e-3)
    for steps in np.linspace(1.0002 * n, 1.5 * n, 199):
        off = np.abs(impact(asked.with_steps_per_contact(steps), OUTLINE).restitutions - e)
        assert np.nanmax(off) <= 0.05 + 1e-4, steps


def test_steps_within_which_the_force_makes_the_speed_do_not_keep_to_the_tolerance():
    asked = Impact(TimeStepping(1e6, 200.0, 4), 3.0, 2.0, time_step=1e-3, force=2000.0)
    assert largest_step(asked, 0.9).step < asked.mass * asked.speed / asked.force


def test_an_impact_law_under_a_force_that_keeps_the_bodies_together_is_soon_over():
    """Their gap stays closed, and rates of changing sign follow, ever smaller: it need not be followed to the end."""
    touches = MoreauJean(0.2, time_step=1e-3, speed=3.0, mass=2.0, force=2000.0).touches
    found = touches.run(np.linspace(0.0, 1.0, 21))
    assert (found[:, CODE] == STUCK).all()
    assert found[:, alone.STEPS].max() < 100


@pytest.mark.parametrize(
    "method",
    [
        Newmark(12_000, 16.1, 300),
        Newmark(12_000, 16.1, 300, every_step=True),
        TimeStepping(12_000, 16.1, 300, HHTInterpolated()),
        TimeStepping(12_000, 16.1, 300, GeneralisedAlpha()),
        TimeStepping(12_000, 16.1, 300, Bathe()),
        TimeStepping(12_000, 16.1, 300, BackwardEuler()),
        TimeStepping(12_000, 16.1, 300, SemiImplicitEuler()),
        TimeStepping(12_000, 16.1, 300, NewmarkBeta(), "end", "keep"),
    ],
    ids=repr,
)
def test_contacts_of_a_run_deliver_what_a_contact_alone_gives(method):
    """With 2.6 steps in a contact: the last force is felt in the step after the gap has opened."""
    system, eta = System(), 2.76
    alone = contact_alone(system, eta, method, 1.0).found.restitution
    run = simulate(system, eta, method)
    assert alone.least <= delivered_restitution(run) <= alone.greatest
    _, closing, parting = short_contacts(run)
    each = -parting / closing
    assert len(each) > 40
    assert np.mean((each > alone.least - 0.02) & (each < alone.greatest + 0.02)) > 0.9


def test_k_for_a_permitted_penetration_or_force_gives_it():
    wanted = {"penetration": 1e-3, "force": 5e3}
    cases = [(law, name) for law in ("kelvin-voigt", "hunt-crossley") for name in wanted] + [("impact", "penetration")]
    for law, name in cases:
        found = stiffness_for(question(law), **{name: wanted[name]})
        assert getattr(found.without_step, name) == pytest.approx(wanted[name], rel=1e-6)
        assert found.without_step.restitution == pytest.approx(0.5, abs=1e-6)


def test_k_for_a_permitted_penetration_under_a_weight_keeps_the_restitution_without_it():
    """With the first K the weight holds the bodies together: that was followed for minutes, and said e = 0."""
    asked = (
        replace(question("kelvin-voigt"), speed=1.0, mass=1.0, force=9.81).with_contact(1.0, 0.0).with_restitution(0.5)
    )
    assert asked.without_step.restitution == 0.0
    found = stiffness_for(asked, penetration=1e-3)
    assert found.without_step.penetration == pytest.approx(1e-3, rel=1e-6)
    assert found.method.stiffness == pytest.approx(563_600, rel=1e-3)
    assert replace(found, force=0.0).without_step.restitution == pytest.approx(0.5, abs=1e-6)


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
    assert stiffness_bounds(asked).stable[0] == 0.0  # as far as is looked


def test_touches_that_all_blow_up_have_no_restitution_and_gain_energy():
    for step in (2.9e-3, 3e-3):  # of the first, some instants between the others seem to stick
        asked = Impact(TimeStepping(1e6, 200.0, 4), 1.0, time_step=step)
        found = impact(asked)
        assert found.blown_up == pytest.approx(1.0)
        assert np.isnan(found.restitution).all()
        for bounds in (stiffness_bounds(asked), damping_bounds(asked)):
            assert bounds.no_energy_gained is None
            assert bounds.solution == (0.0, np.inf)


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


# --- the speeds of a motion -------------------------------------------------------------------------------------------


def test_over_a_motion_each_speed_counts_as_often_as_it_occurs():
    asked, speeds = question("impact", steps=4.0), np.array([1.0, 1.0, 1.0, 4.0])
    found = over_motion(asked, speeds)
    assert (found.speed.tolist(), found.count.tolist()) == ([1.0, 4.0], [3, 1])
    slow, fast = (impact(replace(asked, speed=v)) for v in (1.0, 4.0))
    ends = [(e.least, e.greatest) for e in (slow.restitution, fast.restitution)]
    assert found.restitution.least == min(least for least, _ in ends)
    assert found.restitution.greatest == max(greatest for _, greatest in ends)
    assert found.restitution.mean == pytest.approx((3 * slow.restitution.mean + fast.restitution.mean) / 4)
    assert (found.penetration.greatest, found.force.greatest) == (fast.penetration, fast.force)
    assert found.penetration.least < slow.penetration < found.penetration.mean < fast.penetration
    assert (found.steps.least, found.steps.greatest) == (min(slow.steps + fast.steps), max(slow.steps + fast.steps))


def test_the_speeds_of_a_chaotic_motion_are_a_histogram_whose_ends_are_solved_themselves():
    asked = question("hunt-crossley", steps=6.0)
    speeds = np.random.default_rng(1).uniform(0.5, 4.0, 300)
    found = over_motion(asked, speeds)
    assert found.count.sum() == 300
    assert found.speed @ found.count == pytest.approx(speeds.sum())
    assert found.penetration.greatest == impact(replace(asked, speed=speeds.max())).penetration
    means = [impact(replace(asked, speed=v)).restitution.mean for v in speeds[:60]]
    assert found.restitution.mean == pytest.approx(np.mean(means), abs=0.02)


def test_a_linear_law_is_solved_once_for_all_speeds(monkeypatch):
    asked, solved = question("limited"), []
    monkeypatch.setattr(
        "vibroscope.engine.one_impact.of_system.instants_of", lambda one: solved.append(one) or instants_of(one)
    )
    found = over_motion(asked, [0.5, 2.0, 3.0])
    assert len(solved) == 1
    assert found.restitution == pytest.approx(impact(asked).restitution)
    assert found.force.greatest == pytest.approx(impact(replace(asked, speed=3.0)).force)


def test_motions_without_impacts_have_no_answer():
    with pytest.raises(ValueError, match="there is no closing speed"):
        over_motion(question(), [])
    with pytest.raises(ValueError, match="closing_speed = 0"):
        over_motion(question(), [1.0, 0.0])


# --- a nonsmooth step -------------------------------------------------------------------------------------------------


def nonsmooth_twin(e, theta, weight, s):
    """Moreau and Jean's step as in the textbook, of mass, closing speed and step one; e, depth and impulse."""
    g, v, depth, largest = s - weight * s**2 / 2, -1.0 + weight * s, 0.0, 0.0
    for _ in range(400):
        impulse = 0.0
        if g + v / 2 <= 0:  # predicted to touch: 0 ≤ v₁ + e v₀ ⟂ P ≥ 0
            impulse = max(0.0, -(v - weight) - e * v)
        new = v - weight + impulse
        g, v = g + theta * new + (1 - theta) * v, new
        depth, largest = max(depth, -g), max(largest, impulse)
        if largest > 0 and impulse == 0 and v > 0 and g > 0:
            return math.sqrt(v * v + 2 * weight * g), depth, largest
    return 0.0, depth, largest


@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.8, 1.0])
def test_a_nonsmooth_step_has_newtons_restitution_whatever_the_instant_and_overlaps_by_part_of_a_step(e, theta):
    asked = MoreauJean(e, 2e-3, V, M, theta=theta)
    found = impact(asked)
    assert found.restitution == pytest.approx((e, e, e), abs=1e-15)
    moved = V * 2e-3
    assert found.penetration == pytest.approx(moved * max(0.5, 1.5 - theta * (1 + e)), rel=1e-9)
    assert found.force * asked.time_step == pytest.approx(M * V * (1 + e))
    assert (found.steps, found.gained) == ((1, 1), 0.0)
    assert impact(replace(asked, time_step=1e-3)).penetration == pytest.approx(found.penetration / 2)


@pytest.mark.parametrize(("e", "theta"), [(0.6, 0.5), (0.9, 0.52), (0.5, 0.66)])
def test_nonsmooth_steps_under_a_weight_are_those_of_the_textbook_and_make_no_energy(e, theta):
    h = 1e-3
    asked = MoreauJean(e, h, V, M, 0.05 * M * V / h, theta)
    found = impact(asked)
    plain = [nonsmooth_twin(e, theta, 0.05, s) for s in (np.arange(1000) + 0.5) / 1000]
    rebound, depth, impulse = np.array(plain).T
    assert found.restitution == pytest.approx((rebound.min(), rebound.mean(), rebound.max()), abs=1e-3)
    assert found.penetration == pytest.approx(depth.max() * V * h, rel=3e-3)
    assert found.force * h == pytest.approx(impulse.max() * M * V, rel=3e-3)
    assert theta <= 1 / (1 + e)  # Acary's bound
    assert found.gained == 0.0


def test_beyond_the_bound_of_theta_a_weight_gains_energy():
    bounced = impact(MoreauJean(1.0, 1e-3, V, M, 0.05 * M * V / 1e-3, theta=1.0))
    assert bounced.gained == 1.0
    assert impact(MoreauJean(1.0, 1e-3, V, M, 0.05 * M * V / 1e-3)).restitution == pytest.approx((1.0, 1.0, 1.0))


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asked", "numbers", "message"),
    [
        (question(), {"time_step": 0.0}, "with a method that has one"),
        (question(), {"force": 1e9}, "take less than"),
        (MoreauJean(0.5, 1e-3, V, M), {"time_step": 0.0}, "time_step = 0"),
        (MoreauJean(0.5, 1e-3, V, M), {"restitution": 1.2}, r"restitution = 1\.2"),
        (MoreauJean(0.5, 1e-3, V, M), {"force": 1.0, "time_step": M * V}, "take less than"),
    ],
)
def test_bad_numbers_are_named(asked, numbers, message):
    with pytest.raises(ValueError, match=message):
        replace(asked, **numbers)


def test_a_question_without_a_step_has_no_answer_with_one():
    with pytest.raises(ValueError, match="no time step"):
        impact(Impact(ExactPenalty(K, 10.0), V, M))


def test_hht_feels_the_contact_after_it():
    found = impact(question(integrator=HHT(alpha=-0.3), steps=6.0))
    assert found.restitution.least < 0.5 < found.restitution.greatest


@pytest.mark.release  # a quarter of a minute: contacts that stay are followed for long
def test_a_step_below_a_window_of_steps_that_fail_is_found():
    """With a tolerance as large as what is asked, contacts that stay are within it, but not those of 3 steps."""
    asked = Impact(TimeStepping(1.0, 0.0, 4), 1.0, time_step=0.01).with_restitution(0.4)
    found = largest_step(asked, 0.4)
    assert found.steps_per_contact < 2
    assert found.verified.restitution.greatest <= 0.8
    for steps in np.linspace(found.steps_per_contact, 20, 50):
        assert impact(asked.with_steps_per_contact(steps)).restitution.greatest <= 0.8
