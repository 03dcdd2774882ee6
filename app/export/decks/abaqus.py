"""A deck for Abaqus/Standard: masses, springs and dashpots; a node that meets a rigid surface. Not run by this project.

Sources of the keywords: Abaqus Keywords Reference: *MASS, *SPRING, *DASHPOT, *CONTACT DAMPING, *SURFACE BEHAVIOR,
*DYNAMIC, *AMPLITUDE.
"""

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, alpha_of

NAME, SUFFIX, STATUS, COMMENT = "Abaqus/Standard", "inp", "end", "** "
LAWS = (LINEAR,)
INTEGRATORS = ("newmark", "hht")

TEMPLATE = """\
*HEADING
{words}
** Not run by Vibroscope, which has no licence of this code: look at the first results before you trust them.
**
** Run it with: abaqus job={p.name}. This script, run by "abaqus python", makes a CSV file of its result:
**   from odbAccess import openOdb
**   step = openOdb("{p.name}.odb").steps["RUN"]
**   hist = [step.historyRegions["Node PART-1-1.%d" % i].historyOutputs["U1"].data for i in (2, 3)]
**   with open("{p.name}.csv", "w") as out:
**       out.write("{p.header}\\n")
**       for (t, a), (_, b) in zip(*hist):
**           if t >= {p.first!r}: out.write("%r, %r, %r\\n" % (t, a + {x1!r}, b + {x2!r}))
** then
**   {compare}
**
** The contact status is iterated until it agrees with the end of the step.
*NODE
1, {far_left}, 0., 0.
2, 0., 0., 0.
3, {p.gap}, 0., 0.
4, {far_right}, 0., 0.
*NSET, NSET=OUT
2, 3
{bodies}
** The face of body 2 is a rigid plane that its node carries; the node of body 1 has the area 1.
*SURFACE, TYPE=SEGMENTS, NAME=FACE2
START, {p.gap}, {low}
LINE, {p.gap}, {p.length}
*RIGID BODY, ANALYTICAL SURFACE=FACE2, REF NODE=3
*NSET, NSET=NODE1
2
*SURFACE, TYPE=NODE, NAME=FACE1
NODE1, 1.
*SURFACE INTERACTION, NAME=CONTACT
1.
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{p.contact[0]}
{damper}*CONTACT PAIR, INTERACTION=CONTACT, TYPE=NODE TO SURFACE
FACE1, FACE2
{second}*BOUNDARY
1, 1, 6
2, 2, 2
3, {free}, 2
3, 6, 6
4, 1, 6
{start}{amplitudes}
*STEP, NAME=RUN, NLGEOM=YES, INC={most}
*DYNAMIC, DIRECT, ALPHA={alpha}
{p.step}, {p.end}
{loads}*OUTPUT, HISTORY, FREQUENCY={p.every}
*NODE OUTPUT, NSET=OUT
U
*END STEP
"""


def parts(problem: DeckProblem) -> dict[str, object]:
    """The rest of the template; raises ValueError for what Abaqus has not."""
    far = 1e3 * problem.length
    return {
        "alpha": alpha_of(problem, NAME),
        "far_left": -far,
        "far_right": problem.gap + far,
        "low": -problem.length,
        "bodies": "\n".join(_bodies(problem)),
        "damper": _damper(problem.contact[1]),
        "second": _second_stop(problem),
        "free": 1 if problem.system.wall else 2,
        "start": _start(problem),
        "amplitudes": "\n".join(_amplitudes(problem)),
        "most": problem.steps + 10,
        "loads": "".join(_loads(problem)),
    }


_SECOND = """\
** The second stop: a plane on the other side of body 1, whose node moves with that of body 2.
*NODE
5, {place}, 0., 0.
*EQUATION
2
5, 1, 1., 3, 1, -1.
*SURFACE, TYPE=SEGMENTS, NAME=FACE3
START, {place}, {p.length}
LINE, {place}, {low}
*RIGID BODY, ANALYTICAL SURFACE=FACE3, REF NODE=5
*SURFACE INTERACTION, NAME=CONTACT2
1.
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{p.second_contact[0]}
{damper}*CONTACT PAIR, INTERACTION=CONTACT2, TYPE=NODE TO SURFACE
FACE1, FACE3
*BOUNDARY
5, 2, 2
5, 6, 6
"""


def _damper(damping: float) -> str:
    return f"*CONTACT DAMPING, DEFINITION=DAMPING COEFFICIENT\n{damping!r}\n" if damping else ""


def _second_stop(problem: DeckProblem) -> str:
    if not problem.system.two_stops:
        return ""
    damper = _damper(problem.second_contact[1])
    return _SECOND.format(p=problem, place=-problem.second_gap, low=-problem.length, damper=damper)


def _bodies(problem: DeckProblem) -> list[str]:
    lines = []
    for i, body in enumerate(problem.bodies, 1):
        ends = "1, 2" if i == 1 else "3, 4"
        lines += [f"*ELEMENT, TYPE=MASS, ELSET=MASS{i}", f"{i}, {i + 1}", f"*MASS, ELSET=MASS{i}", repr(body.mass)]
        lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=SPRING{i}", f"{i + 2}, {i + 1}"]
        lines += [f"*SPRING, ELSET=SPRING{i}", "1", repr(body.stiffness)]
        if body.damping:
            lines += [f"*ELEMENT, TYPE=DASHPOTA, ELSET=DAMPER{i}", f"{i + 4}, {ends}"]
            lines += [f"*DASHPOT, ELSET=DAMPER{i}", "", repr(body.damping)]
    return lines


def _start(problem: DeckProblem) -> str:
    """Velocities; displacements are counted from the start."""
    rows = [f"{node}, 1, {body.velocity!r}" for node, body in enumerate(problem.bodies, 2) if body.velocity]
    return "\n".join(["*INITIAL CONDITIONS, TYPE=VELOCITY", *rows, ""]) if rows else ""


def _amplitudes(problem: DeckProblem) -> list[str]:
    """A Fourier series for each body: one term; its spring's force at the start is taken off the constant."""
    lines = []
    for i, body in enumerate(problem.bodies, 1):
        cosine, sine, rest = body.load_from_start
        lines += [f"*AMPLITUDE, NAME=LOAD{i}, DEFINITION=PERIODIC", f"1, {problem.angular_frequency!r}, 0., {rest!r}"]
        lines.append(f"{cosine!r}, {sine!r}")
    return lines


def _loads(problem: DeckProblem) -> list[str]:
    return [f"*CLOAD, AMPLITUDE=LOAD{i}\n{i + 1}, 1, 1.\n" for i in range(1, len(problem.bodies) + 1)]
