"""A deck for Abaqus/Standard: masses, springs and dashpots; a node that meets a rigid surface. Not run by this project.

Sources of the keywords: Abaqus Keywords Reference: *MASS, *SPRING, *DASHPOT, *CONTACT DAMPING, *SURFACE BEHAVIOR,
*DYNAMIC, *AMPLITUDE.
"""

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, check, refuse

NAME, SUFFIX, STATUS = "Abaqus/Standard", "inp", "end"
LAWS = (LINEAR,)
INTEGRATORS = ("newmark", "hht")

_DECK = """\
*HEADING
{title}
** {words}
** Not run by Vibroscope, which has no licence of this code: look at the first results before you trust them.
**
** Run it with: abaqus job={name}. This script, run by "abaqus python", makes a CSV file of its result:
**   from odbAccess import openOdb
**   step = openOdb("{name}.odb").steps["RUN"]
**   hist = [step.historyRegions["Node PART-1-1.%d" % i].historyOutputs["U1"].data for i in (2, 3)]
**   with open("{name}.csv", "w") as out:
**       out.write("{header}\\n")
**       for (t, a), (_, b) in zip(*hist):
**           if t >= {first!r}: out.write("%r, %r, %r\\n" % (t, a + {x1!r}, b + {x2!r}))
** then
**   {compare}
**
** The contact status is iterated until it agrees with the end of the step.
*NODE
1, {far_left}, 0., 0.
2, 0., 0., 0.
3, {gap}, 0., 0.
4, {far_right}, 0., 0.
*NSET, NSET=OUT
2, 3
{bodies}
** The face of body 2 is a rigid plane that its node carries; the node of body 1 has the area 1.
*SURFACE, TYPE=SEGMENTS, NAME=FACE2
START, {gap}, {low}
LINE, {gap}, {high}
*RIGID BODY, ANALYTICAL SURFACE=FACE2, REF NODE=3
*NSET, NSET=NODE1
2
*SURFACE, TYPE=NODE, NAME=FACE1
NODE1, 1.
*SURFACE INTERACTION, NAME=CONTACT
1.
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{stiffness}
{damper}*CONTACT PAIR, INTERACTION=CONTACT, TYPE=NODE TO SURFACE
FACE1, FACE2
*BOUNDARY
1, 1, 6
2, 2, 2
3, {free}, 2
3, 6, 6
4, 1, 6
{start}{amplitudes}
*STEP, NAME=RUN, NLGEOM=YES, INC={most}
*DYNAMIC, DIRECT, ALPHA={alpha}
{step}, {end}
{loads}*OUTPUT, HISTORY, FREQUENCY={every}
*NODE OUTPUT, NSET=OUT
U
*END STEP
"""


def write(problem: DeckProblem) -> str:
    """The deck; raises ValueError for what Abaqus has not."""
    check(problem, NAME, LAWS, INTEGRATORS, STATUS)
    integrator = problem.integrator
    if integrator.name == "newmark" and (integrator.beta, integrator.gamma) != (0.25, 0.5):
        raise refuse(NAME, "other numbers of Newmark's method", "leave out --beta and --gamma, or take hht")
    stiffness, damping = problem.contact
    far, gap = 1e3 * problem.length, problem.gap()
    x1, x2 = (problem.scale.physical("displacement", problem.start[place]) for place in (0, 2))
    words = problem.words(NAME, STATUS)
    return _DECK.format(
        title=words[0],
        words="\n** ".join(words[1:]),
        header=problem.header,
        first=problem.first * problem.step - 0.5 * problem.step,
        x1=x1,
        x2=x2,
        name=problem.name,
        compare="\n**   ".join(problem.compare(STATUS, SUFFIX)),
        far_left=-far,
        far_right=gap + far,
        gap=gap,
        high=problem.length,
        low=-problem.length,
        bodies="\n".join(_bodies(problem)),
        stiffness=repr(stiffness),
        damper=f"*CONTACT DAMPING, DEFINITION=DAMPING COEFFICIENT\n{damping!r}\n" if damping else "",
        free=1 if problem.system.wall else 2,
        start=_start(problem),
        amplitudes="\n".join(_amplitudes(problem)),
        most=problem.steps + 10,
        alpha=getattr(integrator, "alpha", 0.0),
        step=repr(problem.step),
        end=repr(problem.periods * problem.period),
        loads="".join(_loads(problem)),
        every=problem.every,
    )


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
        cosine, sine, constant = body.load
        rest = constant - body.stiffness * body.displacement
        lines += [f"*AMPLITUDE, NAME=LOAD{i}, DEFINITION=PERIODIC", f"1, {problem.angular_frequency!r}, 0., {rest!r}"]
        lines.append(f"{cosine!r}, {sine!r}")
    return lines


def _loads(problem: DeckProblem) -> list[str]:
    return [f"*CLOAD, AMPLITUDE=LOAD{i}\n{i + 1}, 1, 1.\n" for i in range(1, len(problem.bodies) + 1)]
