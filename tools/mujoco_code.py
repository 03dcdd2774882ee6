"""MuJoCo's contact beside ours: a law of accelerations, which its documentation gives and its steps are checked by.

With solref = (−k, −b), both times the impedance d, and a constant solimp = d, the contact's reference acceleration is
−kg − bg′, and its force

    λ = max(0, (−kg − bg′ − a₀) / (A + (1 − d)/d · A)),    A = 1/m₁ + 1/m₂,

a₀ being the acceleration that the gap has without contact, all at the beginning of a step of semi-implicit Euler
(MuJoCo documentation, Computation: "Constraint model"; Modeling: "Solver parameters"). With k = KA and b = 2DA, spring
and damper cut at zero give the same but for a₀, as long as d is near 1: it may be 0.9999 at most.
"""

import math
from importlib.metadata import version
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from vibroscope.engine import SemiImplicitEuler, System, TimeStepping, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.motion import coefficients

CASES = ((1.08, 2500.0, 8.0), (2.76, 12000.0, 18.0))  # eta, K, D
STEPS = (2000, 20000)
PERIODS = 3
IMPEDANCE = 0.9999

# Body 1 ends where body 2, a sphere, begins; both slide along one line.
_MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" tolerance="0"/>
  <default><geom mass="0" condim="1" solref="{k!r} {b!r}" solimp="{d!r} {d!r} 1 0.5 1"/></default>
  <worldbody>
    <body>
      <joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="{m1!r}" diaginertia="1 1 1"/>
      <geom type="box" size="1 1 1" pos="-1 0 0"/>
    </body>
    <body>
      <joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="{m2!r}" diaginertia="1 1 1"/>
      <geom type="sphere" size="1" pos="{centre!r} 0 0"/>
    </body>
  </worldbody>
</mujoco>"""


def mujoco_version() -> str | None:
    """Its version, None where it cannot be imported."""
    return version("mujoco-core") if find_spec("mujoco") else None


class Found(NamedTuple):
    """A run of MuJoCo."""

    contact: int  # steps in contact
    own: float  # largest difference of displacements and velocities of a step from the law above
    apart: float  # difference from ours, spring and damper cut at zero, at the end
    missing: float  # largest |a₀| in contact, as a share of the largest acceleration by spring and damper


def compare_mujoco(eta: float, stiffness: float, damping: float, steps: int) -> Found:
    """The paper's pendulums; springs, dampers and loads are applied forces, so that only the contact is MuJoCo's."""
    import mujoco

    method = TimeStepping(stiffness, damping, steps, SemiImplicitEuler(), "start", law="cut")
    c = uncompiled(coefficients)(parameters_of(System(), eta, method))
    mass, reaction, h = np.array([1.0, c.mu]), np.array([-1.0, 1.0]), 2.0 * math.pi / eta / steps
    dampers, springs, loads = mass * (c.c1, c.c2), mass * (c.k1, c.k2), mass[:, None] * np.array([c.load1, c.load1])
    flexible = float(reaction @ (reaction / mass))  # A
    share = IMPEDANCE * flexible
    numbers = {"m1": float(mass[0]), "m2": float(mass[1]), "k": -stiffness * share, "b": -2.0 * damping * share}
    text = _MODEL.format(step=h, d=IMPEDANCE, centre=1.0, **numbers)
    model = mujoco.MjModel.from_xml_string(text)
    data, contact, own, free, largest = mujoco.MjData(model), 0, 0.0, 0.0, 0.0
    for i in range(PERIODS * steps):
        q, v, angle = data.qpos.copy(), data.qvel.copy(), 2.0 * math.pi * i / steps
        applied = loads @ (math.cos(angle), math.sin(angle)) - dampers * v - springs * q
        data.qfrc_applied[:] = applied
        mujoco.mj_step(model, data)
        gap, rate, force = q[1] - q[0], v[1] - v[0], 0.0
        if gap < 0.0:
            reference, without = -flexible * (stiffness * gap + 2.0 * damping * rate), reaction @ (applied / mass)
            force = max(0.0, (reference - without) / flexible * IMPEDANCE)
            contact, free, largest = contact + 1, max(free, abs(without)), max(largest, abs(reference))
        v = v + h * (applied + reaction * force) / mass
        own = max(own, np.abs(data.qvel - v).max(), np.abs(data.qpos - (q + h * v)).max())
    ours = simulate(System(), eta, method, periods=PERIODS, keep=1).section[-1]
    apart = np.abs(ours[[0, 2, 1, 3]] - [*data.qpos, *data.qvel]).max()
    return Found(contact, float(own), float(apart), float(free / largest))
