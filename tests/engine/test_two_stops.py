"""Two stops on one gap: closed forms of the impact pair, plain twins, the mirror, studies, and what is refused."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vibroscope.app.explorer.presets import shelf
from vibroscope.engine import (
    BranchQuestion,
    Cells,
    ComparisonQuestion,
    EtaStudy,
    ExactPenalty,
    Excitation,
    Load,
    Newmark,
    Record,
    Reference,
    System,
    TimeStepping,
    Units,
    compare,
    lyapunov,
    motion,
    parse_system,
    peaks,
    physical_text,
    print_statement,
    repetition,
    run_cells,
    simulate,
    steady,
    sweep,
    system_text,
    transient,
    verdict,
    with_located_steps,
)
from vibroscope.engine.contact import equal_restitution_damping
from vibroscope.engine.divergence.conditions import unequal_stops_text
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.integrators import HHT, Bathe, CentralDifference
from vibroscope.engine.motions.lyapunov import follow_cells
from vibroscope.engine.motions.poincare_map import half_cycle_multipliers
from vibroscope.engine.motions.search import apart, random_states

from tests import naive, naive_stops

WALL = System(wall=True, d1=0.05, clearance=0.5, clearance2=0.8, restitution=0.6, restitution2=0.8)
PAIR = System(clearance=0.2, clearance2=0.5, d3=None, restitution=0.6, excitation=Excitation(constant1=0.1))
SYMMETRIC = System(clearance=0.4, clearance2=0.4, restitution=0.6)
STIFF = {"stiffness_factor2": 2.0, "damping_factor2": 0.5}
SYSTEMS = {"wall": (WALL, 1.3, (0.1, 0.9, 0.0, 0.0)), "bodies": (PAIR, 1.3, (0.1, 0.9, 0.0, 0.2))}
K, D = 4000.0, 5.0
METHODS = {
    "reference": Reference(),
    "reference, chatter summed": Reference(threshold=0.0),
    "exact": ExactPenalty(K, D),
    "cut": ExactPenalty(K, D, law="cut"),
    "hunt-crossley": ExactPenalty(K, D, law="hunt-crossley"),
    "flores": ExactPenalty(K, None, law="flores"),
    "newmark": Newmark(K, D, 2000),
    "located": Newmark(K, D, 400, located=True),
    "hht, end": TimeStepping(K, D, 2000, HHT(), status="end", without_solution="keep"),
    "bathe, start": TimeStepping(K, D, 2000, Bathe()),
    "central difference": TimeStepping(K, D, 4000, CentralDifference()),
    "hht, located": TimeStepping(K, D, 400, HHT(), status="located"),
    "steps of hunt-crossley": TimeStepping(K, D, 2000, law="hunt-crossley"),
}


def impact_pair(clearance, e):
    """ξ₁, ξ₁′ at τ = 0 of the symmetric orbit with one impact at each wall, τ of the first, and its closing speed.

    A free mass between two walls that move as cos τ: between impacts it flies at the constant speed V, and
    V = 2(c + cos φ)/π, sin φ = V(1 − e)/(1 + e) for the phase φ of an impact (Masri & Caughey 1966, Bapat 1983).
    """
    share = 2 / math.pi * (1 - e) / (1 + e)
    phase = math.asin(share * clearance / math.hypot(1, share)) + math.atan(share)
    speed = 2 * (clearance + math.cos(phase)) / math.pi
    start = clearance + math.cos(phase) - speed * phase - 1.0, speed, 0.0, 0.0
    return start, phase, speed + math.sin(phase)


def half_map(clearance, e, phase, speed):
    """Instant and speed of the next impact, mirrored, from those of one at the first wall: (φ, V before) → (φ, V)."""
    after = -e * speed - (1 + e) * math.sin(phase)  # V⁺ = b′ − e(V − b′), b = cos τ
    t = phase + math.pi
    for _ in range(50):  # Newton's method for the instant at the other wall
        there = clearance + math.cos(phase) + after * (t - phase) - (math.cos(t) - clearance)
        t -= there / (after + math.sin(t))
    return t - math.pi, -after


def half_jacobian(clearance, e, phase, speed, width=1e-5):
    """The derivative of :func:`half_map`, (2, 2), by central differences."""
    columns = [
        np.subtract(half_map(clearance, e, phase + dp, speed + dv), half_map(clearance, e, phase - dp, speed - dv))
        for dp, dv in ((width, 0.0), (0.0, width))
    ]
    return np.array(columns).T / (2 * width)


def off_squares(eta, method):
    """By how much multipliers of a symmetric motion differ from squares, as coefficients: pairs have no order."""
    found = motion(SYMMETRIC, eta, method)
    assert found.symmetric
    halves = half_cycle_multipliers(SYMMETRIC, eta, method, found.section[-1], found.period)
    return np.abs(np.poly(halves**2) - np.poly(found.multipliers)).max()


@pytest.mark.parametrize(("clearance", "e"), [(5.0, 0.6), (2.0, 0.8), (0.5, 0.3)])
def test_the_impact_pair_has_its_closed_form_orbit_and_multipliers(clearance, e):
    system = System(wall=True, spring1=0.0, d1=0.0, clearance=clearance, clearance2=clearance, restitution=e)
    start, phase, closing = impact_pair(clearance, e)
    run = simulate(system, 1.0, Reference(), periods=1, keep=1, initial=start, record=Record(1, 50))
    np.testing.assert_allclose(run.section[0], start, atol=1e-13)
    np.testing.assert_allclose(run.impacts.time, [phase, phase + math.pi], rtol=1e-13)
    np.testing.assert_allclose(run.impacts.closing_speed, closing, rtol=1e-13)
    np.testing.assert_allclose(run.impacts.impulse, [(1 + e) * closing, -(1 + e) * closing], rtol=1e-13)
    assert run.impacts.position.tolist() == [clearance, -clearance]
    assert not run.trajectory.force.any()

    found = steady(system, 1.0, Reference(), initial=start, stable_only=False)
    half = half_jacobian(clearance, e, phase, start[1])
    np.testing.assert_allclose(
        np.sort_complex(found.multipliers[:2]), np.sort_complex(np.linalg.eigvals(half @ half)), rtol=1e-6, atol=1e-8
    )
    assert np.prod(found.multipliers[:2]).real == pytest.approx(e**4, rel=1e-9)
    halves = half_cycle_multipliers(system, 1.0, Reference(), start, 1)
    np.testing.assert_allclose(
        np.sort_complex(halves[:2]), np.sort_complex(np.linalg.eigvals(half)), rtol=1e-6, atol=1e-8
    )


@pytest.mark.parametrize(
    ("method", "eta"), [(Reference("derived"), 1.3), (Reference("derived"), 2.76), (ExactPenalty(K, D), 2.2)]
)
def test_multipliers_of_a_symmetric_motion_are_squares_of_those_over_half_of_it(method, eta):
    assert off_squares(eta, method) < 1e-9


def test_with_located_steps_they_are_so_in_the_limit():
    coarse, fine = (off_squares(2.2, Newmark(K, D, steps, located=True)) for steps in (400, 800))
    assert fine < coarse / 3  # of second order


@pytest.mark.parametrize(("clearance", "name"), [(1.4, "symmetry breaking"), (6.3, "fold")])
def test_a_symmetric_motion_tells_a_fold_from_the_loss_of_its_symmetry(clearance, name):
    """A multiplier tends to +1 at both; that over half a cycle, by the closed form, to −1 or +1."""
    system = System(wall=True, spring1=0.0, d1=0.0, clearance=clearance, clearance2=clearance, restitution=0.6)
    start, phase, _ = impact_pair(clearance, 0.6)
    found = motion(system, 1.0, Reference(), initial=start)
    half = max(np.linalg.eigvals(half_jacobian(clearance, 0.6, phase, start[1])), key=abs)
    assert found.symmetric
    assert found.bifurcation == name == ("symmetry breaking" if half < 0 else "fold")
    assert found.margin == pytest.approx(1 - half**2, rel=1e-6)


@pytest.mark.parametrize("method", ["exact", "newmark"])
def test_a_symmetric_motion_of_a_penalty_loses_its_symmetry_to_two_that_mirror_each_other(method):
    """Newmark's are those of its limit, which its steps scatter."""

    def found(clearance, side):
        system = System(wall=True, spring1=0.0, d1=0.0, clearance=clearance, clearance2=clearance, restitution=0.6)
        damping = equal_restitution_damping(system, 1e4)
        chosen = ExactPenalty(1e4, damping) if method == "exact" else Newmark(1e4, damping, 4000)
        start = np.add(impact_pair(clearance, 0.6)[0], [side, 0.0, 0.0, 0.0])
        return motion(system, 1.0, chosen, initial=start)

    before = found(1.38, 0.05)
    assert before.bifurcation == "symmetry breaking"
    if method == "exact":
        beyond = [found(1.3, side) for side in (0.05, -0.05)]
        assert before.symmetric
        assert [each.symmetric for each in beyond] == [False, False]
        np.testing.assert_allclose(beyond[0].closing_speeds, beyond[1].closing_speeds[::-1], rtol=1e-9)
        np.testing.assert_allclose(beyond[0].multipliers, beyond[1].multipliers, atol=1e-9)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("threshold", [0.02, 0.2])
def test_the_reference_meets_both_stops_when_its_twin_does(name, threshold):
    system, eta, start = SYSTEMS[name]
    events, end = naive_stops.reference(system, eta, system.derived_joint_damping, threshold, 4, start)
    run = simulate(system, eta, Reference("derived", threshold), periods=4, keep=4, initial=start)
    assert {k for _, kind, k, _ in events if kind == 0} == {0, 1}
    assert any(kind == 2 for _, kind, _, _ in events) or threshold < 0.1
    met = np.array([(t, v) for t, kind, _, v in events if kind == 0])
    stop = [k for _, kind, k, _ in events if kind == 0]
    np.testing.assert_allclose(run.impacts.time, met[:, 0], rtol=1e-9)
    np.testing.assert_allclose(run.impacts.closing_speed, met[:, 1], rtol=1e-7, atol=1e-9)
    assert (run.impacts.impulse < 0).astype(int).tolist() == stop
    np.testing.assert_allclose(run.section[-1], end, atol=1e-9)


@pytest.mark.parametrize("name", SYSTEMS)
def test_an_exact_penalty_solution_is_that_of_its_twin(name):
    system, eta, start = SYSTEMS[name]
    system, method = replace(system, **STIFF), ExactPenalty(K, D)
    run = simulate(system, eta, method, periods=3, keep=3, initial=start, record=Record(3, 2000))
    np.testing.assert_allclose(run.section[-1], naive_stops.penalty(system, eta, method, 3, start), atol=1e-9)
    assert run.trajectory.force.min() < -1.0 < 1.0 < run.trajectory.force.max()


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("integrator", ["own loop", "stages"])
def test_newmarks_steps_are_those_of_their_twin(name, integrator):
    system, eta, start = SYSTEMS[name]
    system = replace(system, **STIFF)
    method = Newmark(K, D, 500) if integrator == "own loop" else TimeStepping(K, D, 500, HHT(alpha=0.0))
    run = simulate(system, eta, method, periods=1, keep=1, initial=start)
    assert len(set(np.sign(run.impacts.impulse))) == 2
    states, _ = naive.newmark(system, eta, K, D, 500, 500, start=start)
    np.testing.assert_allclose(run.section[-1], states[-1], atol=1e-8)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", [name for name in METHODS if METHODS[name].has_step])
def test_steps_tend_to_the_exact_solution(name, method):
    system, eta, start = SYSTEMS[name]
    method = METHODS[method]
    exact = simulate(system, eta, method.limit, periods=1, keep=1, initial=start)
    run = simulate(system, eta, replace(method, steps=16 * method.steps), periods=1, keep=1, initial=start)
    assert np.sign(run.impacts.impulse).tolist() == np.sign(exact.impacts.impulse).tolist()
    assert {-1.0, 1.0} == set(np.sign(run.impacts.impulse))
    np.testing.assert_allclose(run.section, exact.section, atol=0.005 if method.located else 0.02)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", METHODS)
def test_in_a_mirror_every_motion_has_the_other_sign(name, method):
    system, eta, start = SYSTEMS[name]
    system, method = replace(system, **STIFF), METHODS[method]
    own = {} if method.rigid else {"stiffness": 2 * method.stiffness}
    own |= {} if method.rigid or method.damping is None else {"damping": 0.5 * method.damping}
    one = simulate(system, eta, method, periods=3, keep=3, initial=start, record=Record(1, 100))
    mirrored = tuple(-value for value in start)
    other = simulate(
        system.mirrored, eta, replace(method, **own), periods=3, keep=3, initial=mirrored, record=Record(1, 100)
    )
    assert {1.0, -1.0} == set(np.sign(one.impacts.impulse))
    np.testing.assert_allclose(other.section, -one.section, atol=1e-9)
    np.testing.assert_allclose(other.impacts.impulse, -one.impacts.impulse, atol=1e-7)
    np.testing.assert_allclose(other.contacts, one.contacts, atol=1e-8)
    np.testing.assert_allclose(other.trajectory.force, -one.trajectory.force, atol=1e-5)


def test_a_chatter_ends_at_the_second_stop_as_at_the_first():
    """Pressed to the second stop by a constant force it comes to rest at the instant of the geometric sum."""
    weight, e, height = 0.7, 0.5, 3.0
    system = System(
        wall=True,
        spring1=0.0,
        d1=0.0,
        clearance=1.0,
        clearance2=height,
        restitution=0.9,
        restitution2=e,
        excitation=Excitation(base=0.0, constant1=-weight),
    )
    assert system.rest == (-height, 0.0, 0.0, 0.0)
    run = simulate(system, 1.0, Reference(threshold=0.0), periods=4, keep=4, initial=(0, 0, 0, 0), record=Record())
    fall = math.sqrt(2 * height / weight)
    np.testing.assert_allclose(run.contacts, [[fall * (1 + e) / (1 - e), run.window[1]]], rtol=1e-12)
    assert run.trajectory.force[-1] == -weight  # it pushes body 1 back
    assert run.section[-1].tolist() == [-height, 0, 0, 0]


def test_far_stops_change_nothing():
    one = System(wall=True, d1=0.05, clearance=0.5)
    far = replace(one, clearance2=1e4)
    for method in (Reference(), ExactPenalty(K, D), Newmark(K, D, 2000, every_step=True)):
        first, second = (simulate(system, 1.3, method, periods=20, keep=20) for system in (one, far))
        np.testing.assert_allclose(first.section, second.section, atol=1e-9)


def test_the_exponent_of_the_impact_pair_is_that_of_its_multipliers():
    system = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0, restitution=0.6)
    for method in (Reference(), ExactPenalty(1e6, 200.0), ExactPenalty(1e4, 20.0, law="cut")):
        found = steady(system, 1.0, method, initial=impact_pair(5.0, 0.6)[0])
        exponent = lyapunov(system, 1.0, method, initial=found.state, periods=300).exponent
        assert exponent == pytest.approx(math.log(abs(found.multipliers[0])), abs=1e-4), method


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(100, 1), Newmark(100, 1, 200)])
def test_a_free_body_that_nothing_touches_repeats_itself_though_its_section_is_nothing_but_rounding(method):
    slot = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0, restitution=0.6)
    found = motion(slot, 1.0, method)
    assert (found.type, found.period, found.impacts_per_period) == ("periodic", 1, 0)
    assert 1e-16 < np.abs(found.section).max() < 1e-8


def test_a_motion_that_sticks_now_and_then_is_not_said_to_graze():
    """A free body between two walls: irregular until it sticks, which leaves nothing of a disturbance."""
    slot = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0, restitution=0.6)
    found = motion(slot, 1.0, Reference(), initial=(0.0, 0.5, 0.0, 0.0))
    assert found.lyapunov == -math.inf
    assert "grazes" not in found.reason


UNLIKE = System(wall=True, d1=0.02, clearance=1.0, clearance2=1.0, restitution=0.5, restitution2=0.7)
ONE_DAMPER = Newmark(5066.0, 15.33, 400)


def unlike_compared(system):
    return compare(ComparisonQuestion(system, 2.0, with_located_steps(ONE_DAMPER)))


def test_stops_that_ask_for_different_restitutions_need_dampers_of_their_own():
    found = unlike_compared(UNLIKE)
    words = print_statement(unequal_stops_text(UNLIKE, with_located_steps(ONE_DAMPER), found.closing_speed))
    factor = float(words.partition("damping_factor2 = ")[2].split()[0])
    own = [equal_restitution_damping(replace(UNLIKE, restitution=e), 5066.0) for e in (0.5, 0.7)]
    assert factor == pytest.approx(own[1] / own[0], rel=1e-3)
    better = replace(UNLIKE, damping_factor2=factor)
    assert unlike_compared(better).difference.total < found.difference.total / 5
    assert unequal_stops_text(better, ONE_DAMPER, 1.0) == ""
    without_loss = replace(UNLIKE, restitution=1.0)  # for which no damper times a factor gives the second its own
    assert unequal_stops_text(without_loss, ONE_DAMPER, 1.0) == ""


@pytest.mark.release  # a third of a minute: between walls every step is taken
def test_a_verdict_on_stops_that_ask_for_different_restitutions_says_so():
    words = print_statement(verdict(unlike_compared(UNLIKE)).headline)
    assert "The stops ask for restitutions of 0.5 and 0.7: with the D that gives 0.5 at the first, the second" in words


@pytest.mark.parametrize("method", ["reference", "exact", "newmark", "located"])
def test_a_cell_of_a_study_is_a_run(method):
    method, etas = METHODS[method], np.array([1.1, 1.3])
    cells = run_cells(Cells(WALL, etas, method), transient=30, sample=10)
    for i, eta in enumerate(etas):
        run = simulate(WALL, eta, method, periods=40, keep=10)
        np.testing.assert_array_equal(cells.section[i], run.section)
        np.testing.assert_array_equal(cells.end[i], run.section[-1])


@pytest.mark.parametrize("method", [ExactPenalty(1.0, 1.0), Newmark(1.0, 1.0, 2000)], ids=["exact", "newmark"])
def test_cells_with_one_stop_and_with_two_run_side_by_side(method):
    """In one call of the kernel, each with its own K and D at either stop; the disturbance of each is its own, too."""
    systems = [WALL, replace(WALL, **STIFF), WALL.with_first_stop, replace(WALL, clearance2=0.6)]
    stiffness, damping = np.array([4000.0, 3000.0, 4000.0, 2000.0]), np.array([5.0, 4.0, 5.0, 6.0])
    cells = Cells(systems, np.full(4, 1.3), method, stiffness=stiffness, damping=damping)
    found, exponents = run_cells(cells, transient=30, sample=10), {}
    if not method.has_step:
        follow_cells(cells, np.arange(4), found.end, 256, exponents.__setitem__)
    for i, system in enumerate(systems):
        method = replace(method, stiffness=stiffness[i], damping=damping[i])
        run = simulate(system, 1.3, method, periods=40, keep=10)
        np.testing.assert_array_equal(found.section[i], run.section)
        if method.has_step:
            continue
        alone = lyapunov(system, 1.3, method, initial=found.section[i, -1], periods=256)
        assert (exponents[i].exponent, exponents[i].section.tobytes()) == (alone.exponent, alone.section.tobytes())


def test_peaks_take_both_stops():
    system, eta, start = SYSTEMS["wall"]
    run = simulate(
        replace(system, **STIFF), eta, ExactPenalty(K, D), periods=3, keep=3, initial=start, record=Record(3, 4000)
    )
    found = peaks(run)
    assert found["contact_force"] == pytest.approx(np.abs(run.trajectory.force).max(), rel=0.3)
    assert found["contact_force"] >= np.abs(run.trajectory.force).max()
    assert found["impulse"] == np.abs(run.impacts.impulse).max()
    beyond = np.maximum(run.trajectory.displacement[0] - 0.5, -run.trajectory.displacement[0] - 0.8).max()
    assert found["penetration"] == pytest.approx(beyond, rel=1e-12)


def test_what_is_no_second_stop():
    with pytest.raises(ValueError, match=r"clearance \+ clearance2 = -0.5 leaves no play between the two stops"):
        System(clearance=0.5, clearance2=-1.0)
    with pytest.raises(ValueError, match="restitution2 without clearance2: there is no second stop"):
        System(restitution2=0.5)
    with pytest.raises(ValueError, match=r"a stop is penetrated by 0\.2 at the start"):
        simulate(WALL, 1.3, Reference(), initial=(-1.0, 0, 0, 0))


def test_only_stops_that_are_alike_are_symmetric():
    alike = System(clearance=0.5, clearance2=0.5)
    assert alike.is_symmetric
    assert not replace(alike, restitution2=0.7).is_symmetric
    assert not replace(alike, excitation=Excitation(constant1=0.1)).is_symmetric
    assert not System().is_symmetric


# -- motions, files and what knows one stop ----------------------------------------------------------------------------


def test_a_symmetric_orbit_is_named_so():
    pair = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0, restitution=0.6)
    start = impact_pair(5.0, 0.6)[0]
    for method in (Reference(), ExactPenalty(1e6, 200.0)):
        found = motion(pair, 1.0, method, initial=start)
        assert (found.symmetric, found.impacts_per_period) == (True, 2)
        assert repetition(found).startswith("repeats every period")
        assert repetition(found).endswith(", symmetric between the stops")
    below = replace(pair, excitation=Excitation(constant1=0.05))
    assert motion(below, 1.0, Reference(), initial=start).symmetric is None
    one_sided = System(wall=True, d1=0.05, clearance=0.9, clearance2=0.9, restitution=0.6)
    found = motion(one_sided, 1.3, Reference(), initial=(0.5, 0.9, 0, 0))
    assert found.symmetric in ((True, False) if found.period else (None,))


@pytest.mark.parametrize("system", [replace(WALL, **STIFF), PAIR, replace(WALL, restitution2=None)])
def test_a_system_file_brings_both_stops_back(system):
    assert parse_system(system_text(system).encode()).system == system
    found = parse_system(physical_text(system, Units()).encode()).system
    for name in ("clearance2", "restitution2", "stiffness_factor2", "damping_factor2"):
        given = getattr(system, name)
        assert getattr(found, name) == (given and pytest.approx(given, rel=1e-13)), name
    assert "clearance2" not in system_text(System(wall=True))


@pytest.mark.parametrize("system", [WALL, PAIR])
def test_random_starts_lie_between_the_stops(system):
    states = apart(system, random_states(np.random.default_rng(1), 200, np.array([5.0, 2.0])))
    assert system.overlaps_of(states).max() == 0.0
    assert np.ptp(system.gap(states[:, 0], states[:, 2])) > 0.9 * system.play
    assert not system.wall or not states[:, 2:].any()


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", ["reference", "reference, chatter summed", "exact"])
def test_the_energy_of_both_stops_is_balanced(name, method):
    system, eta, start = SYSTEMS[name]
    system = replace(system, **STIFF)
    run = simulate(system, eta, METHODS[method], periods=6, keep=6, initial=start)
    assert {1.0, -1.0} == set(np.sign(run.impacts.impulse))
    found = energy_balance(run, start=start)
    assert np.abs(found.residual).max() < 1e-12 * found.size
    assert (found.impacts if method != "exact" else found.contact).sum() > 0.01 * found.size


def test_the_energy_of_steps_is_that_of_the_exact_solution():
    system, eta, start = SYSTEMS["wall"]
    system = replace(system, **STIFF)
    exact = energy_balance(simulate(system, eta, METHODS["exact"], periods=2, keep=2, initial=start), start=start)
    method = Newmark(K, D, 20_000, every_step=True)
    run = simulate(system, eta, method, periods=2, keep=2, initial=start, record=Record(2, 20_000))
    found = energy_balance(run)
    for name in ("work", "dampers", "contact"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact, name), atol=0.01 * exact.size)
    assert np.abs(found.residual).max() < 0.01 * found.size


@pytest.mark.parametrize("method", ["reference", "exact"])
def test_the_energy_of_both_stops_is_balanced_under_a_sweep(method):
    run = transient(replace(WALL, **STIFF), Load.sweep(3.0, 1.0, 1.3, 20.0), METHODS[method], free=6.0)
    assert {1.0, -1.0} == set(np.sign(run.response.impacts.impulse))
    assert np.abs(run.energy.residual).max() < 1e-12 * run.energy.size


@pytest.mark.parametrize("method", ["reference", "exact", "newmark"])
def test_peaks_under_a_pulse_are_those_of_the_mirrored_system(method):
    """Only the second stop is met, or in the mirror only the first one."""
    system = replace(WALL, clearance2=WALL.clearance, restitution2=WALL.restitution)
    pulse, other = (transient(system, Load.half_sine(peak, 2.0), METHODS[method], free=1.0) for peak in (4.0, -4.0))
    assert [set(np.sign(run.response.impacts.impulse)) for run in (pulse, other)] == [{-1.0}, {1.0}]
    assert pulse.peaks == pytest.approx(other.peaks, rel=1e-9, nan_ok=True)
    assert method == "reference" or pulse.peaks["penetration"] > 1e-3


def test_places_of_impacts_are_those_of_their_stop():
    system, eta, start = SYSTEMS["bodies"]
    run = simulate(system, eta, Reference(), periods=6, keep=6, initial=start)
    gaps = system.gap(run.impacts.position, run.impacts.position2(system))
    np.testing.assert_allclose(gaps, np.where(run.impacts.impulse < 0, system.play, 0.0), atol=1e-12)


def test_what_knows_one_stop_says_so():
    run = simulate(WALL, 1.3, METHODS["cut"], periods=4, keep=4)
    with pytest.raises(ValueError, match=r"clearance2 = 0\.8: between two stops .* knows the law kelvin-voigt alone"):
        energy_balance(run)
    with pytest.raises(ValueError, match=r"clearance2 = 0\.8: the parameters of one stop are asked for"):
        parameters_of(WALL, 1.3, Reference())
    with pytest.raises(ValueError, match="clearance2: there is no second stop; give its clearance, too"):
        BranchQuestion(System(), 1.3, Reference(), over="clearance2", low=0.2, high=0.4)


@pytest.mark.parametrize(
    ("system", "method", "over", "words"),
    [
        (System(), Reference(), "restitution2", "there is no second stop; give its clearance, too"),
        (WALL, ExactPenalty(K, D), "restitution2", "no impact law and so no restitution2: give D in its place"),
        (WALL, Reference(), "stiffness_factor2", "no K and D, and so no stiffness_factor2: give another solver"),
    ],
)
def test_a_range_of_what_has_no_effect_is_refused(system, method, over, words):
    with pytest.raises(ValueError, match=words):
        BranchQuestion(system, 1.3, method, over=over, low=0.2, high=0.4)
    with pytest.raises(ValueError, match=words):
        EtaStudy(system, method, 1.3, over=over, values=[0.2, 0.4])


@pytest.mark.parametrize(("method", "name"), [(Reference(), "restitution2"), (ExactPenalty(K, D), "damping_factor2")])
def test_cells_of_a_sweep_over_a_number_of_the_second_stop_are_runs_with_it(method, name):
    values = [0.3, 0.5, 0.9]
    found = sweep(EtaStudy(WALL, method, 1.3, over=name, values=values, transient=100, sample=3))
    for value, row in zip(values, found["xi1"].values, strict=True):
        run = simulate(replace(WALL, **{name: value}), 1.3, method, periods=103, keep=3)
        assert row.tolist() == run.section[:, 0].tolist()


def test_a_mass_between_two_elastic_stops_moves_as_the_equations_of_the_modelica_library_say():
    stiffness, damper, half = 10.0, 1.5, 0.5  # N/m, N·s/m, m: Modelica.Mechanics.Translational.Examples.ElastoGap

    def force(s, v):  # Components.ElastoGap: the damper's part is at most as large as the spring's
        depth = abs(s) - half
        if depth <= 0.0:
            return 0.0
        spring, rate = stiffness * depth, damper * v * math.copysign(1.0, s)
        return math.copysign(spring + min(max(rate, -spring), spring), s)

    end = 12.0
    twin = solve_ivp(
        lambda t, y: (y[1], -force(*y)), (0.0, end), (2.0, 0.0), "DOP853", rtol=1e-12, atol=1e-13, max_step=1e-3
    )
    still = Excitation(base=0.0)
    system = System(wall=True, spring1=0.0, d1=0.0, clearance=half, clearance2=half, excitation=still)
    method = ExactPenalty(stiffness, 0.5 * damper, law="limited")
    released = {"periods": 1, "keep": 1, "initial": (2.0, 0.0, 0.0, 0.0), "record": Record(1, 4000)}
    run = simulate(system, 2.0 * math.pi / end, method, **released)
    assert (run.impacts.impulse < 0).sum() >= 1 <= (run.impacts.impulse > 0).sum()
    np.testing.assert_allclose(run.section[-1][:2], twin.y[:, -1], atol=1e-8)
    inside = np.abs(run.trajectory.displacement[0]) < half
    begins = shelf()["gap"].setting
    speed = begins.scale.physical("velocity", begins.initial[1])
    assert run.trajectory.velocity[0][inside][0] == pytest.approx(speed, rel=1e-9)


def gear_pair(omega, mean=0.1, error=0.05, damping=0.05):
    """x″ + 2ζx′ + f(x) = F + eω² cos ωτ with f of a dead zone ±1, and its penalty: the damper acts in flight, too.

    A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49: a spur gear pair with backlash, its transmission error.
    """
    drive = Excitation(base=0.0, constant1=mean, force1=error * omega**2)
    system = System(
        wall=True, spring1=0.0, d1=damping, clearance=1.0, clearance2=1.0, restitution=1.0, excitation=drive
    )
    return system, ExactPenalty(1.0, 0.0)


def test_a_gear_pair_that_does_not_part_is_an_oscillator_about_its_mean_load():
    system, method = gear_pair(0.5)
    found = motion(system, 0.5, method, initial=(1.1, 0.0, 0.0, 0.0))
    response = 0.05 * 0.25 / (1 - 0.25 + 2j * 0.05 * 0.5)
    assert (found.type, found.period, found.contact_share) == ("periodic", 1, 1.0)
    np.testing.assert_allclose(found.section[0, :2], [1.1 + response.real, -0.5 * response.imag], atol=1e-12)


@pytest.mark.parametrize(("omega", "sides"), [(0.7, {1.0}), (0.6, {1.0, -1.0})])
def test_a_gear_pair_that_rattles_moves_as_its_equation_says(omega, sides):
    system, method = gear_pair(omega, error=0.3)

    def rate(t, y):
        torque = math.copysign(max(abs(y[0]) - 1.0, 0.0), y[0])
        return y[1], 0.1 + 0.3 * omega**2 * math.cos(omega * t) - 2 * 0.05 * y[1] - torque

    start = (1.1, 0.4, 0.0, 0.0) if sides == {1.0} else (0.0, -1.0, 0.0, 0.0)
    end = 2 * math.pi / omega
    twin = solve_ivp(rate, (0.0, 4 * end), start[:2], "DOP853", rtol=1e-12, atol=1e-13, max_step=1e-3)
    run = simulate(system, omega, method, periods=4, keep=4, initial=start)
    assert set(np.sign(run.impacts.impulse)) == sides
    np.testing.assert_allclose(run.section[-1][:2], twin.y[:, -1], atol=1e-8)


def test_a_verdict_tries_no_contact_between_two_stops_that_is_shorter_than_a_few_steps():
    scene = shelf()["pair"].setting
    found = verdict(compare(ComparisonQuestion(scene.system, scene.eta, scene.penalty)))
    stiffness = found.alone.curves["K"].values
    in_contact = math.pi / np.sqrt(stiffness) / (2.0 * math.pi / scene.steps)  # steps
    assert stiffness[0] < 10.0 < 10.0 * scene.K < stiffness[-1]
    assert in_contact.min() > 3.5
    # K, D and the step together leave 10.7 of 18.6 % once the motion has settled
    assert not found.together
    assert "No number alone halves it: at best no time step leaves 16 %" in str(found.headline)


def test_the_step_that_is_stable_is_so_in_contact_with_the_stiffer_stop():
    """A run is seen from either stop when it blows up; its advice does not depend on which."""
    system, alone = replace(WALL, stiffness_factor2=4.0), replace(WALL, clearance2=None, restitution2=None)
    method = TimeStepping(2000.0, 0.5, 60, CentralDifference())
    stiffer = simulate(alone, 1.0, replace(method, stiffness=8000.0), periods=20, keep=1)
    advice = re.search(r"unstable in contact with fewer than \d+ steps", stiffer.message)[0]
    for steps in range(20, 81, 4):
        run = simulate(system, 1.0, replace(method, steps=steps), periods=20, keep=1)
        assert run.status == "diverged"
        assert advice in run.message
