"""General systems: clearance and preload, walls, forces and constants on both bodies, free vibration, for systems.json.

Every generator yields (name, Problem). The method is in the name: "reference", or "exact" for the exact penalty.
"""

import random

from high_precision import Problem

from hard_cases.methods import exact, reference

SAMPLES = 2
LIMIT = 1e-24  # a threshold that cannot be distinguished from its limit 0 in double precision
SEEDS = 44
FREE = {"base": 0.0}
NO_BASE = {"base": 0.0, "force1": 1.0}


def _problem(name, eta, method, periods, system, excitation, start):
    law = method["name"]
    problem = Problem(eta, method, periods, system, start, excitation=excitation, samples=SAMPLES)
    return f"{name}|{law}", problem


def touching():
    """The paper's kind of system: no clearance, base motion alone."""
    other = {"kappa": 0.6, "kappa3": 0.8, "d1": 0.02, "d2": 0.05, "d3": 0.1, "restitution": 0.8}
    rest = (0.0, 0.0, 0.0, 0.0)
    for eta, penalty in ((1.08, exact(2500, 8)), (2.76, exact(12000, 18))):
        yield _problem(f"touching|paper|{eta}", eta, reference("table"), 3, {}, {}, rest)
        yield _problem(f"touching|paper|{eta}", eta, penalty, 3, {}, {}, rest)
    start = (0.5, -1.0, 0.75, 0.25)
    for eta in (0.7, 1.6):
        yield _problem(f"touching|softer body 2|{eta}", eta, reference("table"), 3, other, {}, start)
        yield _problem(f"touching|softer body 2|{eta}", eta, exact(400, 3), 3, other, {}, start)


def clearance():
    """Two bodies on a shaken base, apart at rest or pressed together."""
    for c in (0.25, 1.5, -0.5, -3.0):
        system = {"clearance": c, "restitution": 0.6}
        for eta in (1.08, 2.76):
            start = (0.0, 0.0, 0.0, 0.0) if c > 0 else (-0.75 * abs(c), 0.0, 0.25 * abs(c), 0.0)
            yield _problem(f"clearance|{c:g}|{eta}", eta, reference("derived"), 3, system, {}, start)
            yield _problem(f"clearance|{c:g}|{eta}", eta, exact(3000, 9), 3, system, {}, (0.0, 0.0, 0.0, 0.0))
    table = {"clearance": -1.0, "d3": 0.12}
    for eta in (0.6, 2.0):  # with a joint damping of its own
        yield _problem(f"clearance|-1, table|{eta}", eta, reference("table"), 3, table, {}, (-0.5, 0.0, 0.5, 0.0))


def wall():
    """One body against a wall: in front of it, at rest on it, pressed to it."""
    for c in (0.0, 0.5, 3.0, -0.5, -2.0):
        system = {"wall": True, "clearance": c, "d1": 0.03, "restitution": 0.7}
        for eta in (0.8, 2.6):
            start = (min(c, 0.0), 0.0, 0.0, 0.0)  # a body pressed to the wall begins there
            yield _problem(f"wall|{c:g}|{eta}", eta, reference("derived"), 3, system, {}, start)
            yield _problem(f"wall|{c:g}|{eta}", eta, exact(1500, 6), 3, system, {}, (0.0, 0.0, 0.0, 0.0))


def forces():
    """Forces instead of base motion, and both, with phases; a wall and two bodies."""
    kinds = {
        "force 1": {"base": 0.0, "force1": 2.0},
        "force 2": {"base": 0.0, "force2": 3.0, "force2_phase": 0.7},
        "opposed": {"base": 0.0, "force1": 1.5, "force2": 1.5, "force2_phase": 3.141592653589793},
        "all": {
            "base": 0.5,
            "base_phase": 1.0,
            "force1": 2.0,
            "force1_phase": -0.6,
            "force2": 1.0,
            "force2_phase": 2.5,
        },
        "base phase": {"base_phase": -1.3},
    }
    system = {"clearance": 0.75, "restitution": 0.65, "d1": 0.02, "d2": 0.02}
    for name, excitation in kinds.items():
        for eta, penalty in ((0.9, exact(800, 5)), (2.2, exact(20000, 25))):
            start = (0.25, 0.5, -0.125, -0.5)
            yield _problem(f"forces|{name}|{eta}", eta, reference("derived"), 3, system, excitation, start)
            yield _problem(f"forces|{name}|{eta}", eta, penalty, 3, system, excitation, start)
    of_wall = {"force": NO_BASE, "force and base": {"base": 0.5, "base_phase": 0.4, "force1": 2.0, "force1_phase": 2.0}}
    system = {"wall": True, "clearance": 0.5, "restitution": 0.8, "d1": 0.05}
    for name, excitation in of_wall.items():
        for eta in (0.9, 3.0):
            start = (0.0, 1.0, 0.0, 0.0)
            yield _problem(f"forces on a body by a wall|{name}|{eta}", eta, reference(), 3, system, excitation, start)
            yield _problem(
                f"forces on a body by a wall|{name}|{eta}", eta, exact(1e4, 30), 3, system, excitation, start
            )


def constants():
    """Weights: they press the bodies together or pull them apart, with and without a clearance."""
    for c in (0.0, 0.5):
        for one, two in ((2.0, 0.0), (-1.0, 0.5), (1.5, -4.0)):
            system = {"clearance": c, "restitution": 0.5, "d1": 0.03, "d2": 0.03, "d3": 0.05}
            excitation = {"base": 0.6, "constant1": one, "constant2": two}
            start = (0.0, 0.0, 1.5, 0.0)
            name = f"constants|{c:g}|{one:g},{two:g}"
            yield _problem(name, 1.3, reference("derived"), 3, system, excitation, start)
            yield _problem(name, 1.3, exact(1000, 10), 3, system, excitation, (0.0, 0.0, 0.0, 0.0))
    for c, weight in ((0.0, 3.0), (1.0, -2.0), (1.0, 2.5)):
        system = {"wall": True, "clearance": c, "restitution": 0.5, "d1": 0.05}
        excitation = {"base": 0.0, "force1": 2.0, "force1_phase": 0.3, "constant1": weight}
        start = (c - 1.0, 0.0, 0.0, 0.0)
        yield _problem(f"constants|wall {c:g}|{weight:g}", 1.7, reference(), 3, system, excitation, start)
        yield _problem(f"constants|wall {c:g}|{weight:g}", 1.7, exact(1000, 10), 3, system, excitation, start)


def free():
    """Free vibration from a start; η only sets the length of a "period"."""
    start = (1.0, 2.0, 1.5, -3.0)
    for c in (0.0, 0.5, -0.25):
        system = {"clearance": c, "restitution": 0.8}
        yield _problem(f"free|{c:g}", 1.0, reference("derived"), 3, system, FREE, start)
        yield _problem(f"free|{c:g}", 1.0, exact(5000, 12), 3, system, FREE, start)
        system = {"wall": True, "clearance": c, "restitution": 0.8, "d1": 0.0}
        yield _problem(f"free|wall {c:g}", 1.0, reference(), 3, system, FREE, (-1.0, 2.0, 0.0, 0.0))
        yield _problem(f"free|wall {c:g}", 1.0, exact(5000, 12), 3, system, FREE, (-1.0, 2.0, 0.0, 0.0))


def sticking():
    """Chatter that ends in permanent contact, by the paper's threshold and in its limit; contact that never ends."""
    for threshold in (0.002, LIMIT):
        method, which = reference("derived", threshold), "limit" if threshold == LIMIT else "threshold"
        pressed = {"clearance": -2.0, "restitution": 0.5}
        yield _problem(f"sticking|preload, {which}", 1.2, method, 2, pressed, {"base": 1.5}, (-2.0, 0.0, 2.0, 1.0))
        weights = {"base": 0.3, "constant1": 3.0, "constant2": -3.0}
        yield _problem(f"sticking|weights, {which}", 1.2, method, 2, {"clearance": 1.0}, weights, (0.0, 0.0, 0.0, 0.0))
        system = {"wall": True, "clearance": 0.25, "restitution": 0.6, "d1": 0.02}
        excitation = {"base": 0.0, "force1": 2.0, "constant1": 1.0}
        yield _problem(f"sticking|wall, {which}", 0.8, method, 2, system, excitation, (0.0, 0.0, 0.0, 0.0))
    never_opens = {"clearance": -8.0}
    yield _problem("sticking|never opens", 0.9, reference("derived"), 3, never_opens, {}, (-6.5, 0.0, 1.5, 0.0))
    yield _problem("sticking|never opens", 0.9, exact(3000, 50), 3, never_opens, {}, (-6.5, 0.0, 1.5, 0.0))
    on_wall = {"wall": True, "clearance": -4.0}
    yield _problem("sticking|never leaves the wall", 1.5, reference(), 2, on_wall, {}, (-4.0, 0.0, 0.0, 0.0))
    yield _problem("sticking|never leaves the wall", 1.5, exact(3000, 50), 2, on_wall, {}, (-4.0, 0.0, 0.0, 0.0))


def limits():
    """Nothing touches; restitution 0 and 1; contacts that are stiff, overdamped or critically damped."""
    rest = (0.0, 0.0, 0.0, 0.0)
    for system in ({"clearance": 50.0}, {"clearance": 50.0, "wall": True}):
        name = f"limits|nothing touches{', wall' if 'wall' in system else ''}"
        excitation = {"force1": 1.0, "force1_phase": 0.5, "constant1": 0.25}
        yield _problem(name, 1.9, reference(), 3, system, excitation, rest)
        yield _problem(name, 1.9, exact(1e4, 10), 3, system, excitation, rest)
    for e in (0.0, 1.0):
        system = {"clearance": 0.5, "restitution": e}
        yield _problem(f"limits|e = {e:g}", 1.6, reference("derived"), 3, system, {}, rest)
        yield _problem(f"limits|e = {e:g}, wall", 1.6, reference(), 3, system | {"wall": True}, {}, rest)
    for k, d in ((1e6, 100), (1e8, 0), (100, 10), (100, 50), (4, 100)):
        system = {"wall": True, "clearance": 0.5, "d1": 0.01}
        yield _problem(f"limits|wall, K = {k:g}, D = {d}", 1.6, exact(k, d), 2, system, {}, rest)
    for k, d in ((1e6, 100), (100, 50)):
        yield _problem(f"limits|K = {k:g}, D = {d}", 1.6, exact(k, d), 2, {"clearance": 0.5}, {}, rest)


def mass_ratios():
    """Bodies of equal frequency, whose mass ratio does not follow from κ₃; a light and a heavy body 2."""
    twins = {"kappa": 1.0, "mass_ratio": 1.0, "d1": 0.05, "d2": 0.05, "clearance": 0.5, "restitution": 0.7}
    apart = {"base": 0.0, "force1": 1.5, "force1_phase": 0.4, "force2": -1.5, "force2_phase": 0.4}
    rest = (0.0, 0.0, 0.0, 0.0)
    yield _problem("mass ratio|twins driven apart", 0.9, reference("derived"), 3, twins, apart, rest)
    yield _problem("mass ratio|twins driven apart", 0.9, exact(2000, 10), 3, twins, apart, rest)
    for mu in (0.05, 20.0):
        system = {"kappa": 1.7, "mass_ratio": mu, "clearance": -0.25, "restitution": 0.6}
        start = (-0.25, 0.5, 0.5, -0.5)
        yield _problem(f"mass ratio|{mu:g}", 1.4, reference("derived"), 3, system, {"force2": mu}, start)
        yield _problem(f"mass ratio|{mu:g}", 1.4, exact(800, 3), 3, system, {"force2": mu}, start)


def drawn():
    """Systems, excitations and starts drawn at random, all with numbers of two digits."""
    for seed in range(SEEDS):
        draw = random.Random(seed)

        def number(low, high, draw=draw):
            return round(draw.uniform(low, high), 2)

        with_wall = seed % 3 == 0
        system = {"clearance": number(-1.5, 1.5), "d1": number(0, 0.1), "restitution": number(0.2, 0.95)}
        if with_wall:
            system["wall"] = True
        else:
            kappa = draw.choice((number(0.3, 0.8), number(1.3, 3.0)))
            system |= {"kappa": kappa, "kappa3": round(1 + (kappa - 1) * draw.uniform(0.2, 0.8), 3)}
            system |= {"d2": number(0, 0.1), "d3": number(0, 0.2)}
        excitation = {"base": number(0, 1.5), "force1": number(-2, 2), "constant1": number(-1, 1)}
        excitation |= {"base_phase": number(-3, 3), "force1_phase": number(-3, 3)}
        if not with_wall:
            excitation |= {"force2": number(-2, 2), "force2_phase": number(-3, 3), "constant2": number(-1, 1)}
        x = number(-1, 0)
        apart = number(0.1, 1.0)  # at the start
        start = (x, number(-1, 1), 0.0, 0.0) if with_wall else (x, number(-1, 1), x + apart, number(-1, 1))
        if with_wall and x > system["clearance"]:
            start = (round(system["clearance"] - apart, 2), *start[1:])
        elif not with_wall:
            start = (*start[:2], round(x + apart - system["clearance"], 2), start[3])
        damping = draw.choice((number(0, 2), number(2, 20)))
        method = reference("derived") if seed % 2 else exact(round(10 ** draw.uniform(1.5, 4.5)), damping)
        yield _problem(f"drawn|{seed}", number(0.6, 3.0), method, 3, system, excitation, start)


SYSTEM_GROUPS = (touching, clearance, wall, forces, constants, free, sticking, limits, mass_ratios, drawn)
