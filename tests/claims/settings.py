"""Settings drawn at random: the paper's system and others, contact laws, statuses and integrators."""

import random
from typing import NamedTuple

from vibroscope.engine import (
    HHT,
    TRBDF2,
    Bathe,
    CentralDifference,
    Excitation,
    GeneralisedAlpha,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
)

IMPLICIT = (NewmarkBeta(0.3025, 0.6), HHT(), HHTInterpolated(), GeneralisedAlpha(), TRBDF2(), Bathe())
EXPLICIT = (CentralDifference(), SemiImplicitEuler())
LAWS = ("cut", "limited", "compression", "hunt-crossley", "flores", "jankowski")
RATIO_LAWS = ("hunt-crossley", "flores")
MOST_STEPS = 2000  # of a method whose steps cannot be skipped


class Setting(NamedTuple):
    """What is compared."""

    system: System
    eta: float
    method: TimeStepping


def draw(seed):
    """The setting of a seed, an int: its numbers have three digits."""
    chance = random.Random(f"verdict {seed}")
    system = System() if chance.random() < 0.4 else _system(chance)
    eta = _rounded(chance.uniform(0.5, 4.0))
    stiffness, damping = (_rounded(10 ** chance.uniform(*ends)) for ends in ((1, 5), (-1, 2)))
    steps = round(_rounded(10 ** chance.uniform(2.3, 4.3)))
    kind = chance.random()
    if kind < 0.5:
        return Setting(system, eta, Newmark(stiffness, damping, steps, located=chance.random() < 0.25))
    status = chance.choice(("start", "end", "end", "located"))
    integrator = chance.choice((*IMPLICIT, *EXPLICIT)) if chance.random() < 0.5 else NewmarkBeta()
    if integrator.explicit and status == "end":
        status = "start"
    law = chance.choice(LAWS) if chance.random() < 0.5 else "kelvin-voigt"
    how = {"integrator": integrator, "status": status, "law": law}
    if status == "end":
        how["without_solution"] = chance.choice(("keep", "halve"))
    if law in RATIO_LAWS and chance.random() < 0.5:
        damping = None
    return Setting(system, eta, TimeStepping(stiffness, damping, min(steps, MOST_STEPS), **how))


def _system(chance):
    """Two bodies or a wall, apart, touching or pressed together; with a force, a weight, joint damping or without."""
    numbers = {
        "d1": _rounded(10 ** chance.uniform(-2.5, -1.3)),
        "restitution": _rounded(chance.uniform(0.1, 0.9)),
        "clearance": chance.choice((0.0, _rounded(chance.uniform(-1, 1)), _rounded(chance.uniform(0, 2)))),
    }
    if chance.random() < 0.25:
        numbers["wall"] = True
    else:
        numbers |= {
            "kappa": _rounded(chance.uniform(0.6, 4.0)),
            "mu": _rounded(10 ** chance.uniform(-0.7, 0.6)),
            "d2": _rounded(10 ** chance.uniform(-2.5, -1.3)),
            "d3": chance.choice((None, _rounded(chance.uniform(0.02, 0.06)))),
        }
    drive = {}
    if chance.random() < 0.3:
        drive = {"force1": _rounded(chance.uniform(-2, 2)), "constant1": _rounded(chance.uniform(-0.5, 0.5))}
        if "wall" not in numbers:
            drive |= {"force2": _rounded(chance.uniform(-2, 2)), "force2_phase": _rounded(chance.uniform(0, 6))}
    return System(**numbers, excitation=Excitation(**drive))


def _rounded(value):
    return float(f"{value:.3g}")


def command(setting):
    """The command line of a setting; a system other than the paper's as it is in Python."""
    system, eta, method = setting
    damping = "" if method.damping is None else f" --D {method.damping:g}"
    text = f"compare --eta {eta:g} --K {method.stiffness:g}{damping} --steps {method.steps}"
    if not method.has_choices:
        text += " --located" if method.located else ""
    else:
        text += f" --status {method.status} --integrator {method.integrator} --law {method.law}"
        text += f" --without-solution {method.without_solution}" if method.status == "end" else ""
    return text if system == System() else f"{text}  # {system}"
