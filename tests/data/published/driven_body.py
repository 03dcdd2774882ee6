"""B2, Code_Aster SDND102: a body driven through spring and damper by its support, against a wall in space.

The support moves as −sin Ωt/Ω². The body starts at rest relative to it.
"""

from high_precision import Problem, solve
from mpmath import atan2, cos, mp, mpf, pi, sin, sqrt

DATA = "25", "98696", "0.07", "5.76e7", "20", "0.0005"


def data():
    """Mass, spring, damping ratio, stiffness of the wall, Ω/π and clearance, with the present number of digits."""
    return map(mpf, DATA)


def driven_body(periods, samples=1):
    """B2 as a problem in space: force on the body, lengths in support amplitudes; and its units of time and length."""
    mass, spring, zeta, wall, turns, clearance = data()
    omega1, drive = sqrt(spring / mass), turns * pi
    eta, length = drive / omega1, 1 / drive**2
    cosine, sine = -2 * zeta * eta, -mpf(1)  # of the force of damper and spring
    excitation = {"base": 0, "force1": sqrt(cosine**2 + sine**2), "force1_phase": atan2(-sine, cosine)}
    system = {"wall": True, "clearance": clearance / length, "d1": zeta}
    method = {"name": "exact", "stiffness": wall / spring, "damping": 0}
    problem = Problem(eta, method, periods, system, (0, -eta, 0, 0), excitation=excitation, samples=samples)
    return problem, 1 / omega1, length


def b2():
    problem, unit_of_time, length = driven_body(5)
    begins = [(t, rate) for t, kind, rate in solve(problem).events if kind == 0]
    force, instant = max(peak_of_contact(problem, *begin) for begin in begins)
    yield "greatest force", force * mpf(DATA[1]) * length
    yield "instant of it", instant * unit_of_time


def b2_step():
    yield "greatest force, steps of 1 ms", max(newmark_forces(mpf("0.001"), 500))
    forces = manuals_forces(mpf("0.001"), 500)  # two numbers of the notes in the file
    if abs(max(forces) - mpf("1014.24")) > 0.01 or abs(max(forces[1::2]) - mpf("629.333")) > 0.001:
        raise ArithmeticError(f"the manual's way gives {mp.nstr(max(forces), 8)} N")


def peak_of_contact(problem, begin, rate):
    """The greatest force of a contact that begins with g′ = rate, and its instant."""
    matrix = mp.matrix(problem.matrix(problem.method["stiffness"], 0))
    eta, stiffness = problem.omega, problem.method["stiffness"]
    start = mp.matrix([0, 0, 0, rate, cos(eta * begin), sin(eta * begin), 1])

    def at(t):
        return mp.expm(matrix * t) * start

    quarter = pi / 2 / sqrt(1 + stiffness)
    t = mp.findroot(lambda t: at(t)[3], (quarter / 2, 3 * quarter / 2), solver="anderson", tol=mpf(10) ** -60)
    return -stiffness * at(t)[2], begin + t


def newmark_forces(h, steps):
    """Contact forces of B2 after each step of Newmark's method, contact decided at the start of a step."""
    mass, spring, zeta, wall, turns, clearance = data()
    omega1, drive = sqrt(spring / mass), turns * pi
    damper = 2 * zeta * omega1 * mass

    def force(t):  # of the support through spring and damper
        return -spring * sin(drive * t) / drive**2 - damper * cos(drive * t) / drive

    x, v, touching, forces = mpf(0), -1 / drive, False, []
    a = (force(mpf(0)) - damper * v) / mass
    for n in range(1, steps + 1):
        ahead, faster = x + h * v + h * h / 4 * a, v + h / 2 * a
        stiffness = spring + (wall if touching else 0)
        load = force(n * h) + (wall * clearance if touching else 0)
        a = (load - damper * faster - stiffness * ahead) / (mass + h / 2 * damper + h * h / 4 * stiffness)
        x, v = ahead + h * h / 4 * a, faster + h / 2 * a
        touching = x >= clearance
        forces.append(max(mpf(0), wall * (x - clearance)))
    return forces


def manuals_forces(h, steps):
    """The same as the manual has it: displacements relative to the support, contact decided at the end of a step."""
    mass, spring, zeta, wall, turns, clearance = data()
    omega1, drive = sqrt(spring / mass), turns * pi
    damper = 2 * zeta * omega1 * mass
    x, v, a, forces = mpf(0), mpf(0), mpf(0), []
    for n in range(1, steps + 1):
        gap = clearance + sin(drive * n * h) / drive**2  # to the wall, which moves against the support
        ahead, faster = x + h * v + h * h / 4 * a, v + h / 2 * a
        for stiffness in (mpf(0), wall):  # without contact, and with it if the body would be through the wall
            load = -mass * sin(drive * n * h) + stiffness * gap - damper * faster - (spring + stiffness) * ahead
            a = load / (mass + h / 2 * damper + h * h / 4 * (spring + stiffness))
            if ahead + h * h / 4 * a < gap:
                break
        x, v = ahead + h * h / 4 * a, faster + h / 2 * a
        forces.append(max(mpf(0), wall * (x - gap)))
    return forces


def b2_twin():
    """Two such bodies meet in the middle; the penalty between them has half the stiffness: the same force."""
    return b2()


def b2_displacements():
    """At instants that are samples: a period is 0.1 s."""
    problem, _, length = driven_body(4, samples=50)
    states = solve(problem).states
    for t in ("0.05", "0.156", "0.25", "0.4"):
        yield f"displacement at {t} s", states[round(mpf(t) * 500)][0] * length
