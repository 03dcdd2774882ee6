"""A deck in Modelica: the equations of motion with the contact law, whose events the tool locates itself.

Not run by this project. It needs no library.
"""

import re

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, refuse
from vibroscope.engine import NewmarkBeta, integrators

NAME, SUFFIX, STATUS, COMMENT = "Modelica", "mo", "located", "// "
INTEGRATORS = integrators.INTEGRATORS  # `parts` refuses all but one in words of its own
LAWS = {  # force while the bodies overlap, with the penetration and its rate
    LINEAR: "stiffness*depth + damping*der(depth)",
    "cut": "max(0, stiffness*depth + damping*der(depth))",
    "limited": "stiffness*depth + min(max(damping*der(depth), -stiffness*depth), stiffness*depth)",
    "compression": "stiffness*depth + damping*max(der(depth), 0)",
    "bilinear": "stiffness*(depth + {more!r}*max(depth - {knee!r}, 0)) + damping*der(depth)",
}

TEMPLATE = """\
// {words}
// Not run by Vibroscope, which has no tool for this language: look at the first results before you trust them.
//
// The tool locates each contact change, as --located does. With OpenModelica:
//   omc {p.name}.mos, where {p.name}.mos holds
//     loadFile("{p.name}.mo"); simulate(TwoBodies, outputFormat="csv", variableFilter="xi1|xi2");
// and this makes a CSV file of its result:
//   awk -F, 'NR==1 {{print "{p.header}"}} NR>1 && $1>{p.first!r} && $1>t {{print $1", "$2", "$3; t=$1}}' \\
//     TwoBodies_res.csv > {p.name}.csv
// then
//   {compare}
model TwoBodies "Displacements relative to the base"
  parameter Real stiffness = {p.contact[0]!r} "of the contact";
  parameter Real damping = {p.contact[1]!r} "of the contact, force per speed";
  parameter Real clearance = {p.clearance!r} "gap where both springs are relaxed";
  parameter Real Omega = {p.angular_frequency!r} "angular frequency of the excitation";
  Real xi1(start = {x1!r}, fixed = true);
  Real v1(start = {p.bodies[0].velocity!r}, fixed = true);
  {second}
  Real depth "penetration";{second_depth}
  Real force "of the contact, pushing where it is positive";
equation
  depth = xi1 - xi2 - clearance;
  force = (if depth >= 0 then {law} else 0){second_force};
  v1 = der(xi1);
  {motion1}
  {motion2}
  annotation(experiment(StartTime = 0, StopTime = {p.end!r}, Interval = {interval!r}, Tolerance = 1e-10));
end TwoBodies;
"""


def parts(problem: DeckProblem) -> dict[str, object]:
    """The rest of the template; raises ValueError for what it has not."""
    if problem.integrator != NewmarkBeta():
        raise refuse(NAME, "the integrator", "its tools choose their own; leave Newmark's with beta 1/4, gamma 1/2")
    one, *others = problem.bodies
    second, motion2 = 'parameter Real xi2 = 0 "the wall";', ""
    if others:
        (two,) = others
        second = (
            f"Real xi2(start = {two.displacement!r}, fixed = true);\n  Real v2(start = {two.velocity!r}, fixed = true);"
        )
        motion2 = f"v2 = der(xi2);\n  {_motion(2, two, '+ force')}"
    law, second_depth, second_force = LAWS[problem.method.law].format(**_numbers(problem)), "", ""
    if problem.system.two_stops:
        second_depth = '\n  Real depth2 = xi2 - xi1 - clearance2 "penetration at the second stop";'
        for name, value in zip(("stiffness2", "damping2"), problem.second_contact, strict=True):
            second_depth += f'\n  parameter Real {name} = {value!r} "of the second stop";'
        second_depth += f'\n  parameter Real clearance2 = {problem.second_clearance!r} "of the second stop";'
        law2 = re.sub("stiffness|damping|depth", r"\g<0>2", law)
        second_force = f" - (if depth2 >= 0 then {law2} else 0)"
    return {
        "second": second,
        "law": law,
        "second_depth": second_depth,
        "second_force": second_force,
        "motion1": _motion(1, one, "- force"),
        "motion2": motion2,
        "interval": problem.every * problem.step,
    }


def _numbers(problem: DeckProblem) -> dict[str, float]:
    """The numbers that the force of a law has beside those of spring and damper."""
    method = problem.method
    if method.stiffening is None:
        return {}
    return {"knee": method.penetration * problem.length, "more": method.stiffening - 1.0}


def _motion(i: int, body, push: str) -> str:
    """The equation of motion of a body."""
    cosine, sine, constant = body.load
    load = f"({cosine!r})*cos(Omega*time) + ({sine!r})*sin(Omega*time) + ({constant!r})"
    return f"{body.mass!r}*der(v{i}) + {body.damping!r}*v{i} + {body.stiffness!r}*xi{i} = {load} {push};"
