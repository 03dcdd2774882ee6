"""A deck for OpenSeesPy: a script that runs, and writes its displacements as CSV."""

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, refuse
from vibroscope.engine.law_table import RATIO_LAWS, critical_damping, damper_of

NAME, SUFFIX, STATUS, COMMENT = "OpenSeesPy", "py", "end", ""
LAWS = (LINEAR, *RATIO_LAWS, "jankowski")  # Hertzdamp has those whose damper is a factor of the spring's force
INTEGRATORS = {  # ours: theirs; all take forces and contact at the interpolated displacement
    "newmark": lambda i: f'"Newmark", {i.gamma!r}, {i.beta!r}',
    "hht-interpolated": lambda i: f'"HHT", {1.0 + i.alpha!r}',
    "generalised-alpha": lambda i: f'"HHTGeneralized", {i.rho!r}',
    "tr-bdf2": lambda i: '"TRBDF2"',
}
_REMARKS = {
    "newmark": "Newmark's method: gamma, beta",
    "hht-interpolated": "HHT: 1 + alpha of Hilber; forces at the interpolated displacement",
    "generalised-alpha": "generalised-alpha (its GeneralizedAlpha takes the inertia at the end of the step): rho",
    "tr-bdf2": "each half of the method is a step here",
}
TOLERANCE = 1e-12  # of an iteration's displacement, in units of length; rounding stops smaller ones
_TOUCHING = 1e-300  # the material takes no gap of zero

TEMPLATE = '''"""{words}

Run it with Python (pip install openseespy; on Debian also libblas3 and liblapack3). It writes a CSV file; then

    {compare}

The contact status is iterated until it agrees with the end of the step. A step may have no solution, because the
damper's force jumps where the bodies touch; then the run ends with its number, and the file has what was before.
"""

import sys
from collections import deque
from math import pi
from pathlib import Path

import openseespy.opensees as ops

PERIOD, STEPS, PERIODS, KEEP = {p.period!r}, {p.method.steps}, {p.periods}, {p.keep}  # STEPS: per period
SUBSTEPS = {substeps}  # analysis steps of each
EVERY = {p.every}  # steps from one sample to the next
TOLERANCE = {tolerance!r}  # of the displacements in an iteration
ALGORITHMS = {algorithms}  # the tangent of the contact leaves out its damper, so that Newton's may cycle
SHIFT = {shift!r}  # of body 1, by which a preload becomes a gap of zero

ops.wipe()
ops.logFile(str(Path(__file__).with_suffix(".log")), "-noEcho")  # else it prints each impact
ops.model("basic", "-ndm", 1, "-ndf", 1)
for node in (0, 1, 2):
    ops.node(node, 0.0)
ops.fix(0, 1)
{bodies}

# Contact: stiffness, damper, gap (negative: where the distance of the nodes has shrunk by so much)
{contact}
ops.element("zeroLength", 3, 1, 2, "-mat", 3, "-dir", 1)
{second}
# cos Omega t, sin Omega t, and constant
ops.timeSeries("Trig", 1, 0.0, 1e300, PERIOD, "-shift", pi / 2)
ops.timeSeries("Trig", 2, 0.0, 1e300, PERIOD)
ops.timeSeries("Constant", 3)
{loads}

{start}

ops.constraints("Plain")
ops.numberer("Plain")
ops.system("FullGeneral")
ops.test("NormDispIncr", TOLERANCE, 100)
ops.algorithm(ALGORITHMS[0])
ops.integrator({integrator})  # {remark}
ops.analysis("Transient")

rows = deque(maxlen=KEEP * STEPS // EVERY + 1)


def sample(step):
    if step % EVERY == 0:
        rows.append((step * PERIOD / STEPS, ops.nodeDisp(1, 1) - SHIFT, ops.nodeDisp(2, 1)))


def advance(size):
    for algorithm in ALGORITHMS:
        if algorithm != ALGORITHMS[0]:
            ops.algorithm(algorithm)
        if ops.analyze(1, size) == 0:
            if algorithm != ALGORITHMS[0]:
                ops.algorithm(ALGORITHMS[0])
            return True
    return False


fault = None
for step in range(PERIODS * STEPS):
    sample(step)
    if not all(advance(PERIOD / STEPS / SUBSTEPS) for _ in range(SUBSTEPS)):
        fault = f"step {{step + 1}} (period {{step // STEPS + 1}}) has no solution: no iteration converges"
        break
else:
    sample(PERIODS * STEPS)

lines = ["{p.header}", *(", ".join(map(repr, row)) for row in rows)]
Path(__file__).with_suffix(".csv").write_text("\\n".join(lines) + "\\n")
sys.exit(fault)
'''


def parts(problem: DeckProblem) -> dict[str, object]:
    """The rest of the template; raises ValueError for what OpenSees has not."""
    name, shift = problem.integrator.name, max(0.0, -problem.clearance)
    if problem.system.two_stops and not problem.method.linear:
        raise refuse(NAME, f"law = {problem.method.law!r} at two stops", f"this deck has {LINEAR} there")
    if problem.system.two_stops:
        shift = shift or min(0.0, problem.second_clearance)
    return {
        "substeps": 2 if name == "tr-bdf2" else 1,
        "tolerance": TOLERANCE * problem.length,
        "shift": shift,
        "algorithms": '("Newton",)' if name == "tr-bdf2" else '("Newton", "KrylovNewton")',  # a half cannot be repeated
        "bodies": "\n".join(_bodies(problem)),
        "contact": _contact(problem, shift),
        "second": _second_stop(problem, shift),
        "loads": "\n".join(_loads(problem, shift)),
        "start": "\n".join(_start(problem, shift)),
        "integrator": INTEGRATORS[name](problem.integrator),
        "remark": _REMARKS[name],
    }


def _bodies(problem: DeckProblem) -> list[str]:
    lines = ["ops.fix(2, 1)  # the wall"] if problem.system.wall else []
    for i, body in enumerate(problem.bodies, 1):
        lines += [
            f"\n# Body {i}: mass; spring and damper to the base",
            f"ops.mass({i}, {body.mass!r})",
            f'ops.uniaxialMaterial("Elastic", {i}, {body.stiffness!r}, {body.damping!r})',
            f'ops.element("zeroLength", {i}, 0, {i}, "-mat", {i}, "-dir", 1)',
        ]
    return lines


def _contact(problem: DeckProblem, shift: float) -> str:
    """The material; those of Hertz have a force K δⁿ, and so a stiffness in units of force per lengthⁿ."""
    method, system = problem.method, problem.system
    gap = min(-problem.clearance - shift, -_TOUCHING)
    if method.linear:
        stiffness, damping = problem.contact
        return f'ops.uniaxialMaterial("ViscoelasticGap", 3, {stiffness!r}, {damping!r}, {gap!r})'
    if problem.gap < 0.0:
        raise refuse(NAME, "a start with overlap for this law", "give a start at which the bodies are apart")
    damper, by_speed = damper_of(system, method)
    power = method.spring_exponent
    stiffness, _ = problem.contact
    if method.law == "jankowski":
        ratio = 0.5 * damper / critical_damping(method.stiffness, system.mass_share)
        mass = problem.scale.physical("mass", system.mass_share)
        return f'ops.uniaxialMaterial("JankowskiImpact", 3, {stiffness!r}, {ratio!r}, {mass!r}, {gap!r})'
    if not by_speed:
        raise refuse(NAME, f"law = {method.law!r} with a damper of its own", "leave out D: restitution gives it")
    return f'ops.uniaxialMaterial("Hertzdamp", 3, {stiffness!r}, {damper!r}, {gap!r}, {power!r})'


def _second_stop(problem: DeckProblem, shift: float) -> str:
    """The same material between exchanged nodes, whose distance shrinks where the bodies move apart."""
    if not problem.system.two_stops:
        return ""
    stiffness, damping = problem.second_contact
    gap = min(shift - problem.second_clearance, -_TOUCHING)
    return f"""ops.uniaxialMaterial("ViscoelasticGap", 4, {stiffness!r}, {damping!r}, {gap!r})
ops.element("zeroLength", 4, 2, 1, "-mat", 4, "-dir", 1)
"""


def _loads(problem: DeckProblem, shift: float) -> list[str]:
    """A pattern for each time series that anything needs; the spring of body 1 is relaxed at ``shift``."""
    lines = []
    for series in (1, 2, 3):
        forces = [body.load[series - 1] for body in problem.bodies]
        if series == 3:
            forces[0] += problem.bodies[0].stiffness * shift
        if any(forces):
            lines.append(f'ops.pattern("Plain", {series}, {series})')
            lines += [f"ops.load({i}, {force!r})" for i, force in enumerate(forces, 1) if force]
    return lines


def _start(problem: DeckProblem, shift: float) -> list[str]:
    """The initial state; accelerations are zero unless they are given."""
    lines = ["# The start: displacement, velocity, acceleration"]
    for i, (body, acceleration) in enumerate(zip(problem.bodies, problem.accelerations(), strict=True), 1):
        state = {"Disp": body.displacement + (shift if i == 1 else 0.0), "Vel": body.velocity, "Accel": acceleration}
        lines += [f'ops.setNode{kind}({i}, 1, {value!r}, "-commit")' for kind, value in state.items() if value]
    return lines
