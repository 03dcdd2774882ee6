"""One drop in each code that runs here: a body meets the ground, with a contact in that code's own words.

    found = drop("mujoco", {"solref": "-1000000 -194"}, mass=1.0, speed=1.0, step=1e-4)

The words are those of :mod:`vibroscope.app.codes.translation`. No gravity: the body moves towards the ground with one
speed and is followed until it leaves. MuJoCo and OpenSees are in the group `codes` of pyproject.toml; Bullet (`pip
install pybullet`), Drake (`pip install drake`) and ODE (Debian: python3-pyode) are run where they can be imported.
"""

from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.codes.contact_words import Around
from vibroscope.app.codes.translation import PHYSICAL, Written, translate
from vibroscope.engine import BackwardEuler, Impact, SemiImplicitEuler, TimeStepping
from vibroscope.engine.integrators import Integrator

from tools.mujoco_code import IMPEDANCE

STIFFNESS, DAMPING = 1e5, 80.0  # N/m and N·s/m, of 1 kg at 1 m/s
STEPS = 1e-3, 1e-4  # s: ten and a hundred in a contact
WORDS = {"K": f"{STIFFNESS:g} N/m", "c": f"{DAMPING:g} N s/m"}
# Codes whose touch is one of ours: which of their ways to say a contact is taken, and the integrator.
SCHEMES = {"mujoco": (0, SemiImplicitEuler()), "gazebo": (1, BackwardEuler()), "drake": (1, BackwardEuler())}

_LONGEST = 10_000_000  # steps
_RADIUS = 1.0  # m, of a sphere


class Drop(NamedTuple):
    """What a contact gave: rebound speed over closing speed, deepest penetration in m, largest force in N."""

    restitution: float
    penetration: float
    peak_force: float


class _Asked(NamedTuple):
    """A drop, in SI units; ``gap`` at the start."""

    words: Mapping[str, str]
    mass: float
    speed: float
    step: float
    gap: float

    def number(self, word: str) -> float:
        return float(self.words[word])


States = Iterator[tuple[float, float]]  # gap and speed away from the ground, after each step


def drop(code: str, words: Mapping[str, str], *, mass: float, speed: float, step: float, start: float = 0.5) -> Drop:
    """Run one drop.

    Parameters
    ----------
    code : str
        A key of `CODES`.
    words : mapping of str to str
        Of one of its forms, in SI units, as `Written.words`.
    mass, speed, step : float
        In kg, m/s and s.
    start : float
        Where in a step the body would touch: the gap at the start is this part of what it moves in a step.
    """
    asked = _Asked(words, mass, speed, step, start * speed * step)
    before, deepest, largest = -speed, 0.0, 0.0
    for done, (gap, rate) in enumerate(CODES[code].run(asked)):
        deepest, largest = max(deepest, -gap), max(largest, mass * (rate - before) / step)
        before = rate
        if (gap > 0.0 and rate > 0.0) or done > _LONGEST:
            break
    return Drop(before / speed, deepest, largest)


def translated(code: str, way: int, words: Mapping[str, str] = WORDS, step: float = STEPS[0]) -> Written:
    """The contact of 1 kg at 1 m/s in one of the ways in which a code says it."""
    return translate(PHYSICAL, words, codes()[code], Around(mass=1.0, speed=1.0, step=step)).written[way]


def touch(integrator: Integrator, step: float, start: float = 0.5) -> Drop:
    """The same by the engine: one touch, with the contact status from the start of the step."""
    method = TimeStepping(STIFFNESS, DAMPING / 2, 4, integrator, "start", law="cut")
    question = Impact(method, speed=1.0, mass=1.0, time_step=step)
    rate, _, depth, force, *_ = question.touches.run(np.array([start]))[0]
    return Drop(rate, depth * question.units.length, force * question.units.force)


def runs_here(code: str) -> bool:
    """Whether it can be imported."""
    return find_spec(CODES[code].module) is not None


def _mujoco(asked: _Asked) -> States:
    import mujoco

    model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{asked.step!r}" gravity="0 0 0" tolerance="0"/>
  <default>
    <geom mass="0" condim="1" solref="{asked.words["solref"]}" solimp="{IMPEDANCE} {IMPEDANCE} 1 0.5 1"/>
  </default>
  <worldbody>
    <geom type="plane" size="9 9 1"/>
    <body pos="0 0 {_RADIUS + asked.gap!r}">
      <joint type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="{asked.mass!r}" diaginertia="1 1 1"/>
      <geom type="sphere" size="{_RADIUS}"/>
    </body>
  </worldbody>
</mujoco>""")
    data = mujoco.MjData(model)
    data.qvel[0] = -asked.speed
    while True:
        mujoco.mj_step(model, data)
        yield asked.gap + float(data.qpos[0]), float(data.qvel[0])


def _bullet(asked: _Asked) -> States:
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    try:
        options = {"useMaximalCoordinates": True, "physicsClientId": client}
        ground = pybullet.createMultiBody(
            0.0, pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client), **options
        )
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=_RADIUS, physicsClientId=client)
        body = pybullet.createMultiBody(asked.mass, sphere, basePosition=[0, 0, _RADIUS + asked.gap], **options)
        engine = {"fixedTimeStep": asked.step, "numSolverIterations": 500, "physicsClientId": client}
        if "globalCFM" in asked.words:
            engine |= {"contactERP": asked.number("contactERP"), "globalCFM": asked.number("globalCFM")}
        pybullet.setPhysicsEngineParameter(**engine)
        plain = {"restitution": 0, "lateralFriction": 0, "linearDamping": 0, "angularDamping": 0}
        pybullet.changeDynamics(ground, -1, physicsClientId=client, **plain)
        pybullet.changeDynamics(body, -1, physicsClientId=client, **plain)
        if "contactStiffness" in asked.words:  # the default of the ground would add 0.1 N·s/m
            own = {"contactStiffness": asked.number("contactStiffness"), "physicsClientId": client}
            pybullet.changeDynamics(body, -1, contactDamping=asked.number("contactDamping"), **own)
            pybullet.changeDynamics(ground, -1, contactDamping=0, **own | {"contactStiffness": 1e18})
        pybullet.resetBaseVelocity(body, [0, 0, -asked.speed], physicsClientId=client)
        while True:
            pybullet.stepSimulation(physicsClientId=client)
            place, _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            rate, _ = pybullet.getBaseVelocity(body, physicsClientId=client)
            yield place[2] - _RADIUS, rate[2]
    finally:
        pybullet.disconnect(client)


def _ode(asked: _Asked) -> States:
    import ode

    world = ode.World()
    world.setGravity((0, 0, 0))
    body, mass = ode.Body(world), ode.Mass()
    mass.setSphere(1.0, _RADIUS)
    mass.adjust(asked.mass)
    body.setMass(mass)
    body.setPosition((0, 0, _RADIUS + asked.gap))
    body.setLinearVel((0, 0, -asked.speed))
    group, contact = ode.JointGroup(), ode.Contact()
    contact.setMode(ode.ContactSoftERP | ode.ContactSoftCFM)
    contact.setSoftERP(asked.number("soft_erp"))
    contact.setSoftCFM(asked.number("soft_cfm"))
    contact.setMu(0.0)
    while True:
        gap = body.getPosition()[2] - _RADIUS
        if gap < 0.0:
            contact.setContactGeomParams((0, 0, gap), (0, 0, 1), -gap)
            ode.ContactJoint(world, group, contact).attach(body, None)
        world.step(asked.step)
        group.empty()
        yield body.getPosition()[2] - _RADIUS, body.getLinearVel()[2]


def _drake(asked: _Asked) -> States:
    from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
    from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    relaxed = "relaxation_time" in asked.words
    properties = ProximityProperties()
    dissipation = None if relaxed else asked.number("hunt_crossley_dissipation")
    # Two alike are in series.
    AddContactMaterial(dissipation, 2.0 * asked.number("point_contact_stiffness"), CoulombFriction(0, 0), properties)
    if relaxed:
        properties.AddProperty("material", "relaxation_time", 0.5 * asked.number("relaxation_time"))
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=asked.step)
    kinds = DiscreteContactApproximation
    plant.set_discrete_contact_approximation(kinds.kSap if relaxed else kinds.kLagged)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    inertia = SpatialInertia(asked.mass, [0, 0, 0], UnitInertia.SolidSphere(_RADIUS))
    body = plant.AddRigidBody("body", inertia)
    joint = plant.AddJoint(PrismaticJoint("up", plant.world_frame(), body.body_frame(), [0, 0, 1]))
    plant.RegisterCollisionGeometry(body, RigidTransform(), Sphere(_RADIUS), "sphere", properties)
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", properties)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    joint.set_translation(context, _RADIUS + asked.gap)
    joint.set_translation_rate(context, -asked.speed)
    done = 0
    while True:
        done += 1
        simulator.AdvanceTo(done * asked.step)
        yield joint.get_translation(context) - _RADIUS, joint.get_translation_rate(context)


def _opensees(asked: _Asked) -> States:
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, asked.mass)
    if "K1" in asked.words:
        numbers = (asked.number("K1"), asked.number("K2"), -asked.number("dy"), -asked.gap)
        ops.uniaxialMaterial("ImpactMaterial", 1, *numbers)
    else:
        ops.uniaxialMaterial("ViscoelasticGap", 1, asked.number("K"), asked.number("C"), -asked.gap)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.setNodeVel(2, 1, -asked.speed, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-14, 100)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    while ops.analyze(1, asked.step) == 0:
        yield asked.gap + ops.nodeDisp(2, 1), ops.nodeVel(2, 1)


class _Code(NamedTuple):
    module: str
    run: Callable[[_Asked], States]


CODES = {
    "mujoco": _Code("mujoco", _mujoco),
    "bullet": _Code("pybullet", _bullet),
    "gazebo": _Code("ode", _ode),
    "drake": _Code("pydrake", _drake),
    "opensees": _Code("openseespy", _opensees),
}
