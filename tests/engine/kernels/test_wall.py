"""A wall is a body that does not move, by its coefficients alone: nothing else in the kernels depends on it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    Bathe,
    BranchQuestion,
    ExactPenalty,
    Excitation,
    Newmark,
    Reference,
    System,
    TimeStepping,
    continue_branch,
    simulate,
    with_located_steps,
)
from vibroscope.engine.kernels.accelerated import skip
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations import motion
from vibroscope.engine.kernels.event_driven import integrate, law_integrate, state
from vibroscope.engine.kernels.time_stepping import linear_step, located, newmark

FORCES = Excitation(base=0.8, base_phase=0.4, force1=1.1, force1_phase=0.7, constant1=0.3)
WALLS = System(wall=True), System(wall=True, clearance=0.2, d1=0.05, restitution=0.8, excitation=FORCES)
NEWMARK = Newmark(1200.0, 5.0, 400)
STEPS = TimeStepping(1200.0, 5.0, 400)
SOLVERS = {  # a method, the layout of its state, the numbers of body 1 in it, and its loop
    "reference": (Reference(), state.STATE, ("x1", "v1"), integrate.integrate),
    "summed chatter": (Reference(threshold=0.0), state.STATE, ("x1", "v1"), integrate.integrate),
    "exact": (ExactPenalty(1200.0, 5.0), state.STATE, ("x1", "v1"), integrate.integrate),
    "stiff": (ExactPenalty(1e8, 3e4), state.STATE, ("x1", "v1"), integrate.integrate),
    "pieces": (ExactPenalty(1200.0, 5.0, "limited"), state.STATE, ("x1", "v1"), law_integrate.integrate_law),
    "smooth": (ExactPenalty(1200.0, 0.1, "flores"), state.STATE, ("x1", "v1"), law_integrate.integrate_law),
    "skipping": (NEWMARK, newmark.STATE, ("p1", "q1", "a1"), skip.integrate_skipping),
    "every step": (replace(NEWMARK, every_step=True), newmark.STATE, ("p1", "q1", "a1"), newmark.integrate),
    "located": (with_located_steps(NEWMARK), located.STATE, ("x", "v", "a"), located.integrate_located),
}
STEPPED = {
    "start": replace(STEPS, integrator=HHT()),
    "end": replace(STEPS, integrator=HHT(), status="end", without_solution="keep"),
    "two stages": replace(STEPS, integrator=Bathe(), every_step=True),
    "law": replace(STEPS, law="hunt-crossley"),
    "located": replace(STEPS, integrator=HHT(), status="located"),
}


def ended(system, method):
    """The packed state at the end of a run in which the bodies meet."""
    run = simulate(system, 0.9, method, periods=6, keep=6)
    assert run.ok
    assert len(run.contacts) + len(run.impacts.time) > 3
    return np.array(run.checkpoint.state)


@pytest.mark.parametrize("system", WALLS, ids=["plain", "general"])
@pytest.mark.parametrize("solver", SOLVERS)
def test_body_1_does_not_move_by_a_single_bit(solver, system):
    method, layout, names, _ = SOLVERS[solver]
    found = layout.read(ended(system, method))
    assert [getattr(found, name) for name in names] == [0.0] * len(names)


@pytest.mark.parametrize("system", WALLS, ids=["plain", "general"])
@pytest.mark.parametrize("method", STEPPED.values(), ids=STEPPED)
def test_nor_does_it_with_other_integrators_and_laws(method, system):
    packed = ended(system, method)
    if method.located:
        found = located.STATE.read(packed)
        assert (found.x, found.v, found.a) == (0.0, 0.0, 0.0)
    else:
        np.testing.assert_array_equal(linear_step.STATE.read(packed).u[[0, 2, 4]], 0.0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_loop_is_compiled_once_for_both_kinds_of_system(solver):
    method, *_, loop = SOLVERS[solver]
    ended(System(), method)
    known = list(loop.signatures)
    ended(WALLS[1], method)
    assert list(loop.signatures) == known


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(1200.0, 5.0)], ids=repr)
def test_two_multipliers_of_a_branch_are_zero(method):
    branch = continue_branch(BranchQuestion(WALLS[1], 1.9, method, low=1.8, high=2.0))
    assert len(branch.values) > 3
    assert not branch.sections[..., 2:].any()
    assert not np.abs(branch.multipliers[:, 2:]).any()


def test_coordinates_of_a_wall_and_of_two_bodies():
    contact_coordinates, displacements = (
        uncompiled(motion.contact_coordinates),
        uncompiled(motion.displacements),
    )
    x, v, y, w = 0.3, -0.7, 0.45, 0.2
    for system in (System(clearance=0.1), System(mu=0.4, clearance=-0.3)):
        found = contact_coordinates(system, x, v, y, w)
        assert found == (x, v, system.clearance + (y - x), w - v)
        assert displacements(system, *found)[:2] == (x, v)
        assert displacements(system, *found)[2:] == pytest.approx((y, w), abs=1e-15)
    wall = WALLS[1]
    found = contact_coordinates(wall, x, v, 0.0, 0.0)
    assert found == (0.0, 0.0, wall.clearance - x, -v)
    assert found == contact_coordinates(wall, x, v, y, w)  # whatever is given for body 2
    assert displacements(wall, *found) == pytest.approx((x, v, 0.0, 0.0), abs=1e-16)
    assert math.copysign(1.0, displacements(wall, *found)[2]) == 1.0  # it is printed, without a sign


def test_a_wall_is_hit_at_the_same_steps():
    """Skipped and plain steps of 120 settings."""
    rng, contacts = np.random.default_rng(8), 0
    for _ in range(120):
        eta, n = rng.uniform(0.5, 4.0), int(np.exp(rng.uniform(math.log(200), math.log(32000))))
        method = Newmark(10 ** rng.uniform(1, 5), 10 ** rng.uniform(-1, 1), n)
        system = System(wall=True, d1=0.05, clearance=rng.uniform(-0.5, 1.0))
        plain, skipped = (
            simulate(system, eta, replace(method, every_step=every), periods=3, keep=3) for every in (True, False)
        )
        assert skipped.status == plain.status
        if not plain.ok:
            continue
        contacts += len(plain.contacts)
        np.testing.assert_allclose(skipped.contacts, plain.contacts, atol=1e-3 / n, err_msg=str((eta, method)))
        np.testing.assert_allclose(skipped.section, plain.section, atol=1e-7 * np.abs(plain.section).max())
    assert contacts > 400
