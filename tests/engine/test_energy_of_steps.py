"""Energy balance of integrators, contact statuses and laws: terms integrated otherwise, and what the steps create."""

import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    INTEGRATORS,
    TRBDF2,
    Bathe,
    CentralDifference,
    ExactPenalty,
    Excitation,
    GeneralisedAlpha,
    Newmark,
    NewmarkBeta,
    Record,
    System,
    TimeStepping,
    motion,
    simulate,
)
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.law_table import LAWS

from tests.law_numbers import law_numbers
from tests.naive_stepping import Twin
from tests.share import every

SYSTEM, ETA = System(), 2.76
TERMS = "gain", "work", "dampers", "contact"


def method_of(law, steps, integrator=None, status="start"):
    damping = 18 if LAWS[law].exponent == 1.0 else 400
    more = {"law": law, "without_solution": "keep", **law_numbers(law, penetration=0.01)}
    return TimeStepping(12000, damping, steps, integrator or HHT(-0.1), status, **more)


def balance_of(method, periods=3, system=SYSTEM, eta=ETA, initial=None):
    record = Record(periods, method.steps)
    run = simulate(system, eta, method, periods=periods, keep=periods, initial=initial, record=record)
    assert run.ok
    return energy_balance(run), run


def off(method, exact):
    """How far each term is from that of the solution without a time step, summed over the periods."""
    found, _ = balance_of(method)
    return np.array([getattr(found, name).sum() - getattr(exact, name).sum() for name in TERMS])


@pytest.mark.parametrize("law", every(CONTACT_LAWS))
def test_the_terms_tend_to_those_integrated_along_the_motion_without_a_time_step(law):
    """These are closed forms, or Gauss' rule along the steps of high order; what the steps create tends to nothing."""
    exact = energy_balance(simulate(SYSTEM, ETA, method_of(law, 4).limit, periods=3, keep=3), SYSTEM.rest)
    coarse, fine = (off(method_of(law, n), exact) for n in (4000, 64_000))
    assert (np.abs(fine) < np.abs(coarse) / 4).all()
    assert np.abs(fine).max() < 0.03 * exact.lost.sum()
    made = [balance_of(method_of(law, n))[0].residual.sum() for n in (4000, 64_000)]
    assert abs(made[1]) < abs(made[0]) / 4


@pytest.mark.parametrize(
    ("integrator", "status"),
    [(kind(), status) for kind in INTEGRATORS.values() for status in ("start", "end")[: 1 if kind.explicit else 2]],
)
def test_work_and_dampers_are_the_integrals_of_their_powers_over_time(integrator, status):
    system = System(excitation=Excitation(base=0.7, force2=0.4, force2_phase=0.3, constant1=0.2), clearance=0.1)
    balance, run = balance_of(method_of("kelvin-voigt", 8000, integrator, status), system=system)
    tau, (v1, v2) = run.trajectory.time, run.trajectory.velocity
    mu = system.mass_ratio
    base = 0.7 * ETA**2 * np.cos(ETA * tau)
    force2 = 0.4 * np.cos(ETA * tau + 0.3)
    work = np.trapezoid(base * (v1 + mu * v2) + force2 * v2, tau)
    dampers = np.trapezoid(2 * system.d1 * v1**2 + 2 * mu * system.d2 * system.kappa * v2**2, tau)
    assert balance.work.sum() == pytest.approx(work, rel=2e-3)
    assert balance.dampers.sum() == pytest.approx(dampers, rel=2e-3)


@pytest.mark.parametrize(("law", "n"), [("kelvin-voigt", 1.0), ("hunt-crossley", 1.5)])
def test_a_contact_takes_what_its_force_does_beyond_that_of_its_spring(law, n):
    """Of a preloaded body whose contact stores other energies at the ends of periods."""
    system = System(clearance=-0.3, d1=0.05, d2=0.05)
    method = TimeStepping(100, 3, 8000, NewmarkBeta(), law=law)
    balance, run = balance_of(method, 1, system, 1.4, (0.3, 0.0, 0.1, 0.0))
    x, force = run.trajectory.displacement, run.trajectory.force
    depth = np.maximum(x[0] - x[1] - system.clearance, 0.0)
    damper = force - 100 * depth**n
    assert abs(depth[-1] - depth[0]) > 0.1
    assert balance.contact[0] == pytest.approx(np.trapezoid(damper, depth), rel=1e-3)


FREE = System(wall=True, d1=0.0, clearance=100.0, excitation=Excitation(base=0.0))


@pytest.mark.parametrize("integrator", [HHT(-0.3), GeneralisedAlpha(0.5), TRBDF2(), Bathe(0.0)])
def test_numerical_damping_is_energy_that_the_steps_remove(integrator):
    """Of an undamped body that swings freely: what its energy loses, by the plain twin."""
    method = TimeStepping(100, 1, 20, integrator)
    balance, _ = balance_of(method, 5, FREE, 1.0, (1.0, 0.0, 0.0, 0.0))

    class Swinging(Twin):
        def __init__(self, *of):
            super().__init__(*of)
            self.system = FREE

    twin = Swinging(FREE, 1.0, method)
    twin.gap = lambda x: 100.0
    state, energies = (np.array([1.0, 0.0]), np.zeros(2), np.array([-1.0, 0.0]), 0.0), [0.5]
    for k in range(5 * 20):
        *_, state = twin.stages(state, k * twin.h, lambda end: (*end(0)[:3], 0.0))
        energies.append(0.5 * (state[0][0] ** 2 + state[1][0] ** 2))
    np.testing.assert_allclose(balance.residual, np.diff(energies[::20]), rtol=1e-9)
    assert (balance.residual < -1e-4).all()
    assert not np.abs(balance.lost).any()


def test_average_acceleration_creates_nothing_in_free_motion_and_central_differences_nothing_lasting():
    start = 1.0, 0.0, 0.0, 0.0
    balance, _ = balance_of(TimeStepping(100, 1, 20, NewmarkBeta()), 5, FREE, 1.0, start)
    assert np.abs(balance.residual).max() < 1e-13
    balance, _ = balance_of(TimeStepping(100, 1, 20, CentralDifference()), 40, FREE, 1.0, start)
    assert abs(balance.residual.sum()) < 0.02 * 0.5


def test_newmarks_method_by_both_loops_has_the_same_energies():
    methods = Newmark(12000, 18, 2000), TimeStepping(12000, 18, 2000, HHT(0.0))
    one, other = (balance_of(method)[0] for method in methods)
    for name in (*TERMS, "residual"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-7, atol=1e-9)


def test_located_steps_of_an_integrator_balance_to_second_order():
    made = []
    for n in (800, 3200):
        run = simulate(SYSTEM, ETA, TimeStepping(12000, 18, n, HHT(-0.1), "located"), periods=20, keep=20)
        made.append(np.abs(energy_balance(run).residual).mean())
    assert np.log(made[0] / made[1]) / np.log(4) == pytest.approx(2, abs=0.5)


@pytest.mark.parametrize("status", ["start", "end", "located"])
def test_a_motion_has_the_energies_of_its_integrator(status):
    found = motion(SYSTEM, 1.08, TimeStepping(100, 50, 1000, GeneralisedAlpha(0.5), status, "keep"))
    exact = motion(SYSTEM, 1.08, ExactPenalty(100, 50))
    assert found.energy_lost - found.energy_created == pytest.approx(exact.energy_lost, rel=0.03)
    small = abs(found.energy_created) < 1e-3 * exact.energy_lost
    assert small == (status == "located")  # whole steps miss the damper's jump at touch
    assert np.isnan(exact.energy_created)


def test_of_a_cycle_what_is_lost_is_put_in_or_created():
    found = motion(SYSTEM, 1.08, TimeStepping(100, 50, 200, HHT(-0.3)))
    run = simulate(SYSTEM, 1.08, TimeStepping(100, 50, 200, HHT(-0.3)), periods=900, keep=50, record=Record(50, 200))
    assert found.period == 1
    work = energy_balance(run).work.mean()
    assert found.energy_lost - found.energy_created == pytest.approx(work, rel=5e-3)


def test_commands_give_what_the_time_step_creates(capsys):
    numbers = "--eta 1.08 --K 100 --D 50 --steps 800 --units"
    common = [*numbers.split(), "--integrator", "central-difference"]
    main(["motion", "--solver", "newmark", *numbers.split(), "--integrator", "hht"])
    assert ", created by the time step " in capsys.readouterr().out
    main(["motion", "--solver", "newmark", *common])
    assert ", removed by the time step " in capsys.readouterr().out
    main(["motion", "--solver", "newmark", *common, "--json"])
    found = json.loads(capsys.readouterr().out)
    assert found["energy_created"] < 0 < found["energy_lost"]
    share = found["physical"]["energy_created"] / found["physical"]["energy_lost"]
    assert share == pytest.approx(found["energy_created"] / found["energy_lost"])
    main(["compare", *common, "--json"])
    compared = json.loads(capsys.readouterr().out)["physical"]
    # of later periods, since the comparison waits until both motions are settled; the step scatters what it creates
    created = compared["penalty"]["energy_created"]
    assert created == pytest.approx(found["physical"]["energy_created"], rel=0.3)
    assert compared["reference"]["energy_created"] is None
