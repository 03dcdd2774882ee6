"""Two bodies of which one or both have no spring: closed forms, exchange of the bodies, plain twins, refusals.

Their motions in closed form are held against 60-digit solutions in test_truth_systems.py.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    BackwardEuler,
    Bathe,
    BranchQuestion,
    CentralDifference,
    ExactPenalty,
    Excitation,
    Load,
    Newmark,
    NewmarkBeta,
    Record,
    Reference,
    System,
    TimeStepping,
    continue_branch,
    motion,
    physical_entry,
    simulate,
    steady,
    system_of_physical,
    transient,
)
from vibroscope.engine.energy.balance import balance_of_steps, energy_balance
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.system_file import brief_system_text, parse_system, system_text

from tests.naive_stepping import Twin

EXACT = 1e-12
MU, K, D = 0.5, 400.0, 3.0
DRIVE = Excitation(base=1.0, base_phase=0.3, force1=0.4, force1_phase=-1.0)
FREE_1 = System(mu=MU, spring1=0.0, kappa=1.25, d1=0.05, d2=0.08, d3=None, clearance=0.25, excitation=DRIVE)
FREE_2 = System(mu=MU, kappa=0.0, d1=0.03, d2=0.08, d3=None, clearance=0.25, excitation=DRIVE)
BOTH = System(mu=MU, spring1=0.0, kappa=0.0, d1=0.05, d2=0.08, clearance=0.25, excitation=DRIVE)
LOADED_1 = replace(FREE_1, excitation=replace(DRIVE, constant1=0.4, constant2=0.1))
LOADED_2 = replace(FREE_2, excitation=replace(DRIVE, constant1=0.2, constant2=-0.3))
LOADED = replace(BOTH, excitation=replace(DRIVE, constant1=0.15, constant2=-0.2))
PAIRS = {
    **{"free 1": FREE_1, "free 2": FREE_2, "both": BOTH},
    **{"loaded 1": LOADED_1, "loaded 2": LOADED_2, "loaded": LOADED},
}
METHODS = {
    "reference": Reference(),
    "exact": ExactPenalty(K, D),
    "bilinear": ExactPenalty(K, D, law="bilinear", penetration=0.02, stiffening=3.0),
    "limited": ExactPenalty(K, D, law="limited"),
    "hunt-crossley": ExactPenalty(K, D, law="hunt-crossley"),
    "newmark": Newmark(K, D, 2000),
    "newmark, every step": Newmark(K, D, 2000, every_step=True),
    "located": Newmark(K, D, 200, located=True),
    "hht": TimeStepping(K, D, 400, HHT(), status="end", without_solution="keep"),
    "bathe": TimeStepping(K, D, 400, Bathe()),
}


def exchanged(system):
    """The same two bodies, κ = 1 or 0, with the names of both exchanged, ξ₁ for −ξ₂, and the other one's mass."""
    drive, mu = system.excitation, system.mass_ratio
    excitation = Excitation(
        base=-drive.base,
        base_phase=drive.base_phase,
        force2=-drive.force1 / mu,
        force2_phase=drive.force1_phase,
        constant1=-drive.constant2 / mu,
        constant2=-drive.constant1 / mu,
    )
    return System(
        mu=1 / mu,
        spring1=float(system.kappa > 0),
        kappa=system.spring1,
        d1=system.damper2,
        d2=system.d1,
        d3=None,
        clearance=system.clearance,
        excitation=excitation,
    )


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize(
    "free",
    [replace(FREE_1, kappa=1.0), BOTH, replace(LOADED_1, kappa=1.0), LOADED],
    ids=["one", "both", "loaded one", "loaded both"],
)
def test_exchanged_bodies_move_alike(free, name):
    other = exchanged(free)
    method = METHODS[name]
    mirrored = method if method.rigid else replace(method, stiffness=method.stiffness / MU, damping=method.damping / MU)
    one, two = (simulate(each, 1.5, by, periods=4, keep=4) for each, by in ((free, method), (other, mirrored)))
    assert one.ok
    assert len(one.impacts.time) > 0
    np.testing.assert_allclose(one.section, -two.section[:, [2, 3, 0, 1]], atol=1e-9)


def test_two_balls_in_flight_meet_where_a_closed_form_says():
    system = System(mu=MU, spring1=0.0, kappa=0.0, d1=0.0, d2=0.0, clearance=1.0, restitution=0.5,
                    excitation=Excitation(base=0.0))  # fmt: skip
    run = simulate(system, 1.0, Reference(), periods=1, keep=1, initial=(0, 1.0, 0, -0.5))
    np.testing.assert_allclose(run.impacts.time, [1 / 1.5], rtol=EXACT)
    common, relative = (1.0 - 0.5 * MU) / (1 + MU), 0.75
    after = common - relative * MU / (1 + MU)
    np.testing.assert_allclose(run.section[-1][1::2], [after, after + relative], rtol=EXACT)
    np.testing.assert_allclose(run.impacts.impulse, [1.5 * 1.5 * MU / (1 + MU)], rtol=EXACT)


def test_a_penalty_contact_of_two_free_bodies_lasts_half_a_cycle():
    system = System(mu=MU, spring1=0.0, kappa=0.0, d1=0.0, d2=0.0, excitation=Excitation(base=0.0))
    run = simulate(system, 1.0, ExactPenalty(K, 0.0), periods=1, keep=1, initial=(0, 1.0, 0, 0))
    np.testing.assert_allclose(run.contacts, [[0.0, math.pi / math.sqrt(K * (1 + 1 / MU))]], atol=EXACT)
    np.testing.assert_allclose(run.impacts.impulse, [2 * MU / (1 + MU)], rtol=EXACT)


def test_two_free_bodies_joined_stop_in_their_dampers():
    system = replace(BOTH, clearance=0.0, restitution=0.0, excitation=Excitation(base=0.0))
    run = simulate(system, 1.0, Reference(), periods=3, keep=3, initial=(0, 1.0, 0, -0.5), record=Record(3, 8))
    rate = 2 * (0.05 + MU * 0.08) / (1 + MU)  # the force that keeps them together presses: body 1 is damped less
    together = (1.0 - 0.5 * MU) / (1 + MU) * math.exp(-rate * run.window[1])
    np.testing.assert_allclose(run.contacts, [[0.0, run.window[1]]])
    np.testing.assert_allclose(run.section[-1][1::2], together, rtol=EXACT)
    assert energy_balance(run, (0, 1.0, 0, -0.5)).residual == pytest.approx(0, abs=EXACT)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("name", ["reference", "exact", "bilinear", "limited", "hunt-crossley"])
def test_the_energy_balances(pair, name):
    run = simulate(PAIRS[pair], 1.5, METHODS[name], periods=4, keep=4, record=Record(4, 400))
    balance = energy_balance(run, PAIRS[pair].rest)
    assert np.abs(balance.residual).max() < 1e-9 * balance.stored


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize(
    "integrator", [NewmarkBeta(), HHT(-0.1), Bathe(0.3), BackwardEuler(), CentralDifference()], ids=repr
)
def test_every_step_is_that_of_the_twin(pair, integrator):
    method = TimeStepping(100.0, 2.0, 100, integrator, "start" if integrator.explicit else "end", "keep")
    run, twin = simulate(PAIRS[pair], 1.5, method, periods=6, keep=6), Twin(PAIRS[pair], 1.5, method)
    expected = twin.run(6)
    assert twin.contacts > 0
    np.testing.assert_allclose(run.section, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def balance_with(pair, steps):
    """The balance of Newmark's steps over four periods."""
    method = Newmark(100.0, 2.0, steps)
    return balance_of_steps(simulate(PAIRS[pair], 1.5, method, periods=4, keep=4, record=Record(4, steps)))


@pytest.mark.parametrize("pair", ["loaded 1", "loaded 2"])
def test_what_newmarks_steps_create_at_contacts_falls_with_the_step(pair):
    """Under a weight there are contacts in each period, whose instants a step misses by its length."""
    coarse, fine = (np.abs(balance_with(pair, steps).residual).sum() for steps in (400, 4000))
    assert 8.0 < coarse / fine < 12.5


@pytest.mark.parametrize("pair", PAIRS)
def test_skipped_steps_lead_where_every_step_leads(pair):
    one, two = (simulate(PAIRS[pair], 1.5, Newmark(K, D, 5000, every_step=each), periods=6, keep=6) for each in (0, 1))
    assert len(one.impacts.time) == len(two.impacts.time) > 0
    np.testing.assert_allclose(one.section, two.section, atol=1e-8)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("name", ["reference", "exact"])
def test_the_jacobian_of_the_poincare_map_is_that_of_differences(pair, name):
    poincare, h = PoincareMap(PAIRS[pair], 1.5, METHODS[name], None), 1e-6
    start = poincare.coordinates((PAIRS[pair].rest[0], 0.0) * 2)  # apart by the clearance
    found = poincare(start, 4)
    columns = [
        (poincare(start + h * unit, 4).state - poincare(start - h * unit, 4).state) / (2 * h) for unit in np.eye(4)
    ]
    np.testing.assert_allclose(found.jacobian, np.column_stack(columns), atol=1e-6 * np.abs(found.jacobian).max())


def test_a_weight_holds_a_body_whose_motions_form_a_branch():
    weighted = Excitation(base=3.0, constant2=-0.15)
    system = System(mu=0.25, kappa=0.0, d1=0.05, d2=0.0, d3=None, clearance=0.0, excitation=weighted)
    branch = continue_branch(BranchQuestion(system, 1.5, ExactPenalty(K, D), low=1.49, high=1.51))
    assert len(branch.values) > 5
    for k in (0, len(branch.values) // 2, -1):
        start, period = tuple(branch.sections[k][0]), branch.period
        run = simulate(system, branch.values[k], ExactPenalty(K, D), periods=period, keep=1, initial=start)
        np.testing.assert_allclose(run.section[-1], start, rtol=0, atol=1e-9 * np.abs(start).max())
        jacobian = PoincareMap(system, branch.values[k], ExactPenalty(K, D), None)
        found = np.linalg.eigvals(jacobian(jacobian.coordinates(start), period).jacobian)
        size = np.abs(found).max()
        np.testing.assert_allclose(np.sort(np.abs(found)), np.sort(np.abs(branch.multipliers[k])), atol=1e-6 * size)


def test_nothing_holds_a_body_without_a_spring():
    found = steady(FREE_1, 1.5, Reference())
    assert found.period == 0
    assert "disturbances neither grow nor die away" in str(found)


@pytest.mark.parametrize("law", ["kelvin-voigt", "cut", "hunt-crossley"])
def test_a_weight_is_a_load_that_lasts_and_the_gap_that_of_the_reduced_mass(law):
    """A ball is thrown at a free body; the common centre falls with half of L/(1 + μ) τ²."""
    end, force, share, numbers = 12.0, -0.3, MU / (1 + MU), {"mu": MU, "spring1": 0.0, "kappa": 0.0, "d2": 0.0}
    pair = System(d1=0.0, d3=None, clearance=1.0, **numbers)
    wall = System(wall=True, spring1=0.0, d1=0.0, clearance=1.0, excitation=Excitation(base=0.0, constant1=-force / MU))
    of_pair, of_wall = ExactPenalty(K, D, law=law), ExactPenalty(K / share, D / share, law=law)
    found = transient(pair, Load.trapezoid(force, end, 0.0, on="force2"), of_pair, free=0.0).response
    alone = transient(wall, Load.trapezoid(0.0, end, 0.0), of_wall, free=0.0, initial=(0, 0, 0, 0)).response
    (x1, v1, x2, v2), (y, w, _, _) = found.section[-1], alone.section[-1]
    assert len(found.impacts) == len(alone.impacts) > 2
    assert found.impacts.time == pytest.approx(alone.impacts.time, abs=EXACT)
    assert (x2 - x1, v2 - v1) == pytest.approx((-y, -w), abs=1e-11)
    assert (x1 + MU * x2) / (1 + MU) == pytest.approx(0.5 * force * end**2 / (1 + MU), abs=1e-11)


@pytest.mark.parametrize("name", METHODS)
def test_under_weights_the_gap_is_that_of_the_reduced_mass_and_the_centre_falls(name):
    """The reduced mass lies beside a wall that the weights pull it to."""
    first, second, share = 0.5, -0.125, MU / (1 + MU)
    weights = Excitation(base=0.0, constant1=first, constant2=second)
    pair = System(mu=MU, spring1=0.0, kappa=0.0, d1=0.0, d2=0.0, clearance=1.0, excitation=weights)
    pull = Excitation(base=0.0, constant1=first - second / MU)
    wall = System(wall=True, spring1=0.0, d1=0.0, clearance=1.0, excitation=pull)
    method = METHODS[name]
    reduced = method if method.rigid else replace(method, stiffness=K / share, damping=D / share)
    found = simulate(pair, 1.0, method, periods=2, keep=2)
    alone = simulate(wall, 1.0, reduced, periods=2, keep=2, initial=(0, 0, 0, 0))
    x1, v1, x2, v2 = found.section.T
    assert len(found.impacts) == len(alone.impacts) > 2
    np.testing.assert_allclose(found.impacts.impulse, share * alone.impacts.impulse, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose((x1 - x2, v1 - v2), alone.section[:, :2].T, atol=1e-9)
    times = 2 * math.pi * np.arange(1, 3)
    falls = 0.5 * (first + second) / (1 + MU) * times**2
    np.testing.assert_allclose((x1 + MU * x2) / (1 + MU), falls, rtol=1e-9 if method.has_step else EXACT)


@pytest.mark.parametrize("mu", [0.1, 0.7, 2.8])
def test_weights_alike_do_not_part_by_rounding(mu):
    """Of the weights 0.1 and μ 0.1 the quotient is not 0.1 again."""
    weights = Excitation(base=0.0, constant1=-0.1, constant2=-0.1 * mu)
    system = System(mu=mu, spring1=0.0, kappa=0.0, d1=0.0, d2=0.0, clearance=0.0, excitation=weights)
    assert weights.constant2 / mu != -0.1
    assert system.free_pull == 0.0
    run = simulate(system, 1.0, Reference(), periods=3, keep=3)
    assert (run.section[:, 0] == run.section[:, 2]).all()


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(K, D)], ids=["reference", "exact"])
@pytest.mark.parametrize("clearance", [1.0, 0.0])
def test_two_free_bodies_that_nothing_drives_stay_where_they_are(method, clearance):
    """The words said that a run of 2,050 periods did not find it."""
    found = motion(replace(BOTH, clearance=clearance, excitation=Excitation(base=0.0)), 1.0, method)
    assert found.type == "periodic"
    assert found.reason.endswith("has come to rest, and disturbances neither grow nor die away")


def test_where_a_free_body_begins():
    assert replace(BOTH, clearance=2.0).rest == (0.0, 0.0, 0.0, 0.0)
    assert replace(BOTH, clearance=-2.0).rest == (-2.0, 0.0, 0.0, 0.0)
    assert replace(FREE_2, clearance=-2.0).rest == (0.0, 0.0, 2.0, 0.0)
    assert LOADED_2.rest == pytest.approx((-0.1, 0.0, -0.35, 0.0))  # on the sprung body, which bears both forces
    assert LOADED_1.rest == pytest.approx((0.5 / (MU * 1.25**2) + 0.25, 0.0, 0.5 / (MU * 1.25**2), 0.0))


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"spring1": 0.5, "mu": 1.0}, "spring1 = 0.5 without wall = true: of two bodies give 1"),
        ({"spring1": 0.0}, "spring1 = 0 leaves the mass ratio open, which kappa3 does not give: give mass_ratio"),
        ({"kappa": 1e-4, "mu": 1.0}, "kappa"),
    ],
)
def test_what_two_bodies_cannot_be(numbers, words):
    with pytest.raises(ValueError, match=words):
        System(**numbers)


# -- in physical units and files ---------------------------------------------------------------------------------------

HAMMER = {  # a free hammer of 1 kg meets a sprung anvil
    "mass1_kg": 1.0,
    "stiffness1_N_per_m": 0.0,
    "mass2_kg": 4.0,
    "stiffness2_N_per_m": 1600.0,
    "damping1_Ns_per_m": 0.5,
    "clearance_mm": 2.0,
}


@pytest.mark.parametrize(
    ("more", "omega1"),
    [({}, 20.0), ({"time_s": 0.1}, 10.0), ({"frequency_Hz": 5.0}, 10 * math.pi)],
)
def test_without_a_spring_time_is_counted_by_what_is_given_or_by_body_2(more, omega1):
    system, units, *_ = system_of_physical(HAMMER | more)
    assert (system.spring1, units.omega1) == (0.0, pytest.approx(omega1))
    assert (system.kappa, system.d1) == (pytest.approx(20 / omega1), pytest.approx(0.25 / omega1))


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"stiffness2_N_per_m": 0.0, "damping2_Ns_per_m": 3.0, "time_s": 0.05},
        {"stiffness1_N_per_m": 900.0, "damping1_Ns_per_m": 2.0, "stiffness2_N_per_m": 0.0},
    ],
)
def test_an_entry_of_free_bodies_comes_back(more):
    found = system_of_physical(HAMMER | more)
    again = system_of_physical(physical_entry(found.system, found.units, found.eta))
    assert again.units.omega1 == pytest.approx(found.units.omega1, rel=1e-14)
    for name, value in found.system.as_dict().items():
        assert again.system.as_dict()[name] == (value and pytest.approx(value, rel=1e-14)), name


def test_damping_of_a_body_without_a_spring_is_no_ratio():
    with pytest.raises(ValueError, match="damping2_ratio of a body without a spring: give stiffness2_N_per_m"):
        system_of_physical(HAMMER | {"stiffness2_N_per_m": 0.0, "damping2_ratio": 0.1, "time_s": 1.0})


@pytest.mark.parametrize("pair", PAIRS)
def test_a_file_of_free_bodies_comes_back(pair):
    text = system_text(PAIRS[pair])
    assert parse_system(text.encode()).system == PAIRS[pair]
    assert parse_system(brief_system_text(PAIRS[pair]).encode()).system == PAIRS[pair]


def test_branches_of_a_body_that_nothing_holds_are_refused():
    with pytest.raises(ValueError, match="one of the bodies has no spring: nothing holds it"):
        BranchQuestion(System(spring1=0.0, mu=1.0, d3=None), 1.0, Reference(), low=0.9, high=1.1)
    with pytest.raises(ValueError, match="neither body has a spring: nothing holds them"):
        BranchQuestion(LOADED, 1.0, Reference(), low=0.9, high=1.1)


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(K, D)], ids=["reference", "exact"])
def test_a_branch_over_a_weight_ends_where_there_is_none(method):
    """The impulse of a period is the weight times the period: the other body bears it."""
    eta, hammer = 1.5, replace(FREE_1, d1=0.0, excitation=Excitation(base=0.0, force1=2.5, constant1=0.05))
    question = BranchQuestion(hammer, eta, method, over="constant1", low=-0.1, high=0.1, max_period=4)
    branch = continue_branch(question)
    assert branch.values.min() == pytest.approx(0.0, abs=1e-8)
    k = np.argmin(np.abs(branch.values - 0.05))
    start, period = tuple(branch.sections[k][0]), branch.period
    run = simulate(*question.at(branch.values[k]), periods=2 * period, keep=2 * period, initial=start)
    assert run.impacts.impulse.sum() / (2 * period) == pytest.approx(branch.values[k] * run.period, rel=1e-6)


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(K, D)], ids=["reference", "exact"])
def test_between_two_stops_a_branch_goes_on_through_a_weight_of_zero(method):
    """A ball in a sprung cage: beyond zero the motions are those of the mirrored weight, at the other stop."""
    drive = Excitation(base=1.0, constant2=-0.1)
    cage = System(mu=0.25, kappa=0.0, d1=0.05, d2=0.02, d3=None, clearance=0.4, clearance2=0.4, excitation=drive)
    branch = continue_branch(BranchQuestion(cage, 0.8, method, over="constant2", low=-0.2, high=0.2, max_period=1))
    assert (branch.values.min(), branch.values.max()) == pytest.approx((-0.2, 0.2))
    for value in (-0.11, 0.0, 0.13):
        k = np.argmin(np.abs(branch.values - value))
        start, weight = branch.sections[k][0], branch.values[k]
        for sign in (1, -1):
            system = replace(cage, excitation=Excitation(base=sign * 1.0, constant2=sign * weight))
            run = simulate(system, 0.8, method, periods=1, keep=1, initial=tuple(sign * start))
            np.testing.assert_allclose(run.section[-1], sign * start, atol=1e-9)


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(K, D), Newmark(K, D, 2000, located=True)], ids=repr)
@pytest.mark.parametrize(
    ("constant1", "damper", "moves"),
    [(0.0, 0.05, False), (0.02, 0.05, True), (0.02, 0.0, True)],
)
def test_two_bodies_that_move_on_may_have_a_gap_that_repeats_itself(method, constant1, damper, moves):
    """Two weights on the pair that is pressed together: the gap does not feel them, nor do they hold the centre."""
    numbers = {"spring1": 0.0, "kappa": 0.0, "mu": MU, "d1": damper, "d2": damper, "clearance": 0.5}
    weights = Excitation(base=0.0, force1=0.5, constant1=0.3 + constant1, constant2=-0.3 + MU * constant1)
    found = motion(System(**numbers, excitation=weights), 1.0, method)
    words = "no spring holds the bodies: both move on, while their gap repeats itself after 1 period"
    assert (found.reason == words) == moves
    assert found.type == ("undecided" if moves else "periodic")
