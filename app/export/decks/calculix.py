"""A deck for CalculiX: two blocks that move along x alone, springs and dampers, and a contact pair.

Each block is one element whose nodes follow one node, so that it is rigid along x and its density gives the mass. The
contact is of the type surface to surface, whose law is exactly bilinear (node to surface has a smooth one). Without a
damper a nonlinear spring takes its place, SPRINGA: CalculiX then does not check the energy of an impact.
"""

from math import cos, pi, sin

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, alpha_of, refuse

NAME, SUFFIX, STATUS, COMMENT = "CalculiX", "inp", "end", "** "
LAWS = (LINEAR,)
INTEGRATORS = ("newmark", "hht")  # Newmark's method with alpha = 0
MOST_STEPS = 100_000  # a table has a row for each, since its amplitudes do not repeat
_FAR = 1e3  # between ends of springs, in units of length
_DEEP = 1e2  # depth of a block, in units of length; deeper ones leave fewer digits for the gap behind body 1
_NARROW = 0.9  # side of the slave face
_LIGHT = 1e-13  # density of the block of the second stop over that of body 2, which has all of its mass

TEMPLATE = """\
** {words}
**
** Run it with: ccx {p.name}. It writes displacements with seven digits to {p.name}.dat; this makes a CSV file of them:
** {convert}
** then
**   {compare}
**
** The contact status is iterated until it agrees with the end of the step. CalculiX checks the energy of a
** step with contact, too, and may stop ("solution seems to diverge") where the iterations converged.
*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=BODY1
101, 11, 12, 13, 14, 15, 16, 17, 18
*ELEMENT, TYPE=C3D8, ELSET=BODY2
102, 21, 22, 23, 24, 25, 26, 27, 28
{third}*NSET, NSET=NODES1, GENERATE
11, 18
*NSET, NSET=NODES2, GENERATE
21, 28
{behind}*NSET, NSET=OUT
2, 3
{bodies}
*EQUATION
{ties}
*BOUNDARY
1, 1, 3
2, 2, 3
3, {free}, 3
4, 1, 3
NODES1, 2, 3
NODES2, 2, 3
{contact}
{start}{amplitudes}
*STEP, INC={most}
*CONTROLS, PARAMETERS=FIELD
1.E-8, 1.E-8
*DYNAMIC, DIRECT, ALPHA={alpha}
{step}, {end}
*CLOAD, AMPLITUDE=LOAD1
2, 1, 1.
{load2}*NODE PRINT, NSET=OUT, FREQUENCY={p.every}
U
*END STEP
"""

_PAIR = """\
*SURFACE, NAME=SLAVE{stop}, TYPE=ELEMENT
101, {slave}
*SURFACE, NAME=MASTER{stop}, TYPE=ELEMENT
{master}
*SURFACE INTERACTION, NAME=CONTACT{stop}
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{stiffness}
*CONTACT DAMPING
{damping}
*CONTACT PAIR, INTERACTION=CONTACT{stop}, TYPE=SURFACE TO SURFACE
SLAVE{stop}, MASTER{stop}"""
_SPRING = """\
*ELEMENT, TYPE=SPRINGA, ELSET=TOUCH
7, 2, 3
*SPRING, ELSET=TOUCH, NONLINEAR
{push}, {deep}
0., {touch}
0., {apart}{pull}"""


def parts(problem: DeckProblem) -> dict[str, object]:
    """The rest of the template; raises ValueError for what CalculiX has not."""
    alpha, wall = alpha_of(problem, NAME), problem.system.wall
    if problem.steps > MOST_STEPS:
        fewer = f"give at most {MOST_STEPS // problem.method.steps} --periods"
        raise refuse(NAME, f"{problem.steps} steps in a table of at most {MOST_STEPS} rows", fewer)
    third = problem.system.two_stops and _has_damper(problem)
    followed = ((2, 11), (3, 21), (3, 31))[: 3 if third else 2]
    return {
        "third": "*ELEMENT, TYPE=C3D8, ELSET=BODY3\n103, 31, 32, 33, 34, 35, 36, 37, 38\n" if third else "",
        "behind": "31, 38\n" if third else "",
        "step": number(problem.step),
        "end": number(problem.end),
        "convert": _convert(problem),
        "nodes": "\n".join(_nodes(problem)),
        "bodies": "\n".join(_bodies(problem)),
        "ties": "\n".join(f"2\n{first + i}, 1, 1., {node}, 1, -1." for node, first in followed for i in range(8)),
        "free": 1 if wall else 2,
        "contact": _contact(problem),
        "start": _start(problem),
        "amplitudes": "\n".join(_amplitudes(problem)),
        "most": problem.steps + 10,
        "alpha": number(alpha),
        "load2": "" if wall else "*CLOAD, AMPLITUDE=LOAD2\n3, 1, 1.\n",
    }


def number(value: float) -> str:
    """With as many digits as a field of 20 characters holds."""
    return f"{value:.13E}"


def _convert(problem: DeckProblem) -> str:
    """A command that writes the samples to be kept."""
    name, (x1, x2) = problem.name, problem.displacements
    return (
        f"""awk 'BEGIN {{print "{problem.header}"}} / time /{{t=$NF}} NF==4 && $1=="2" {{a=$2}} """
        f"""NF==4 && $1=="3" && t>{problem.first:.9g} {{printf "%s, %.10g, %.10g\\n", t, a+{x1!r}, $2+{x2!r}}}' """
        f"{name}.dat > {name}.csv"
    ).replace("+-", "-")


def _nodes(problem: DeckProblem) -> list[str]:
    """The blocks as they are at the start; the nodes that they follow, and where the dampers hold, lie in a row."""
    side, far, gap = problem.length / 2.0, _FAR * problem.length, problem.gap
    deep = _DEEP * problem.length
    rows = [(1 + i, (2 * i - 2) * far, 0.0, 0.0) for i in range(4)]
    blocks = [(11, (-deep, 0.0), _NARROW * side), (21, (gap, gap + deep), side)]
    if problem.system.two_stops and _has_damper(problem):
        behind = -deep - problem.second_gap
        blocks.append((31, (behind - deep, behind), side))
    for first, ends, half in blocks:
        corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
        rows += [(first + i, ends[i // 4], *corners[i % 4]) for i in range(8)]
    return [", ".join([str(node), *map(number, place)]) for node, *place in rows]


def _contact(problem: DeckProblem) -> str:
    """A contact pair; without a damper a spring, whose table goes as far as its nodes are apart."""
    (stiffness, _), far, gap = problem.contact, _FAR * problem.length, problem.gap
    two = problem.system.two_stops
    if _has_damper(problem):
        pairs = [_pair(problem, "", problem.contact)]
        pairs += [_pair(problem, "2", problem.second_contact)] if two else []
        return "\n".join(pairs)
    apart, pull = -gap + far, ""
    if two:
        apart = problem.second_gap
        pull = f"\n{number(problem.second_contact[0] * far)}, {number(apart + far)}"
    push, deep, touch = -stiffness * far, -gap - far, -gap
    return _SPRING.format(push=number(push), deep=number(deep), touch=number(touch), apart=number(apart), pull=pull)


def _has_damper(problem: DeckProblem) -> bool:
    """Whether a contact has one, which a spring's table has no place for."""
    return bool(problem.contact[1])


def _pair(problem: DeckProblem, stop: str, contact: tuple[float, float]) -> str:
    """Two faces that meet: those of the second stop are behind body 1, on a block that moves with body 2."""
    stiffness, damping = (number(value / (_NARROW * problem.length) ** 2) for value in contact)
    slave, master = ("S1", "103, S2") if stop else ("S2", "102, S1")
    return _PAIR.format(stiffness=stiffness, damping=damping, slave=slave, master=master, stop=stop)


def _bodies(problem: DeckProblem) -> list[str]:
    """Material, spring and damper of each body; the wall's material does not matter."""
    lines, bodies = [], problem.bodies
    for i in (1, 2):
        side = problem.length * (_NARROW if i == 1 else 1.0)
        mass = bodies[i - 1].mass if i <= len(bodies) else bodies[0].mass
        density = number(mass / (_DEEP * problem.length * side**2))
        lines += [f"*MATERIAL, NAME=BODY{i}", "*ELASTIC", "1., 0.", "*DENSITY", density]
        lines += [f"*SOLID SECTION, ELSET=BODY{i}, MATERIAL=BODY{i}"]
    if problem.system.two_stops and _has_damper(problem):
        lines += ["*MATERIAL, NAME=BODY3", "*ELASTIC", "1., 0.", "*DENSITY", number(_LIGHT * float(density))]
        lines.append("*SOLID SECTION, ELSET=BODY3, MATERIAL=BODY3")
    for i, body in enumerate(bodies, 1):
        ends = "1, 2" if i == 1 else "3, 4"
        lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=SPRING{i}", f"{i}, {i + 1}", f"*SPRING, ELSET=SPRING{i}"]
        lines += ["1", number(body.stiffness)]
        if body.damping:
            lines += [f"*ELEMENT, TYPE=DASHPOTA, ELSET=DAMPER{i}", f"{i + 2}, {ends}", f"*DASHPOT, ELSET=DAMPER{i}"]
            lines += ["", number(body.damping)]
    return lines


def _start(problem: DeckProblem) -> str:
    """Velocities; displacements are counted from the start."""
    sets = (("2", "NODES1"), ("3", "NODES2"))
    moving = [(name, body.velocity) for names, body in zip(sets, problem.bodies, strict=False) for name in names]
    rows = [f"{name}, 1, {number(velocity)}" for name, velocity in moving if velocity]
    return "\n".join(["*INITIAL CONDITIONS, TYPE=VELOCITY", *rows, ""]) if rows else ""


def _amplitudes(problem: DeckProblem) -> list[str]:
    """The force on each body at the end of every step, its spring's at the start taken off."""
    lines, n = [], problem.method.steps
    for i, body in enumerate(problem.bodies, 1):
        lines.append(f"*AMPLITUDE, NAME=LOAD{i}")
        cosine, sine, rest = body.load_from_start
        angles = [2.0 * pi * k / n for k in range(n)]
        cycle = [number(cosine * cos(angle) + sine * sin(angle) + rest) for angle in angles]
        lines += [f"{number(k * problem.step)}, {cycle[k % n]}" for k in range(problem.steps + 1)]
    return lines
