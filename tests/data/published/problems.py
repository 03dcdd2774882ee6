"""The other published problems: half cycles, orbits with one impact, grazing, bounces, restitution."""

from high_precision import Problem, solve
from mpmath import acos, asin, atan, atan2, cos, exp, mp, mpf, pi, sin, sqrt


def b1():
    """SDND101: half a cycle of the mass on both springs, and half a cycle away from the wall."""
    m, k, wall, speed = mpf(100), mpf(10) ** 4, mpf(10) ** 6, mpf(1)
    free, pressed = sqrt(k / m), sqrt((k + wall) / m)
    half = pi / pressed
    yield "greatest force", wall * speed / pressed
    yield "instant of it", half / 2
    yield "duration of contact", half
    yield "impulse", 2 * wall * speed / pressed**2
    yield "instant of the second peak", half + pi / free + half / 2
    yield "speed of the second impact", speed


def one_n_orbit(omega, r, sigma, n):
    """Impact speed and phase of the (1, n) orbit of Budd and Dux, upper branch."""
    omega, r, sigma = map(mpf, (omega, r, sigma))
    angle = 2 * pi * n / omega
    c, gamma, rho = sin(angle) * (1 + r) / (1 - cos(angle)), 1 / (1 - omega**2), (1 - r) / omega
    root = sqrt(4 * (gamma**2 * c**2 - (sigma**2 - gamma**2) * rho**2))
    speed = (-2 * c * sigma + root) / (c**2 + rho**2)
    return speed, atan2(-speed * rho / 2 / gamma, (sigma + speed * c / 2) / gamma)


def orbit(omega, r, sigma, n):
    speed, phase = one_n_orbit(omega, r, sigma, n)
    check_orbit(mpf(omega), mpf(r), mpf(sigma), n, speed, phase)
    yield "impact speed", speed
    yield "time between impacts", 2 * pi * n / mpf(omega)


def check_orbit(omega, r, sigma, n, speed, phase):
    """Raise unless the motion from just after the impact is the orbit: no other impact, and the same speed again."""
    system = {"wall": True, "clearance": sigma, "d1": 0, "restitution": r}
    method = {"name": "reference", "threshold": 0}
    excitation = {"base": 0, "force1": 1, "force1_phase": phase}
    start = (sigma, -r * speed, 0, 0)
    found = [e for e in solve(Problem(omega, method, n + 1, system, start, excitation=excitation)).events if e[1] == 0]
    again = abs(found[0][0] - 2 * pi * n / omega) + abs(found[0][2] + speed)
    if again > mpf(10) ** -25:
        raise ArithmeticError(f"no (1, {n}) orbit at ω = {omega}: an impact at {mp.nstr(found[0][0], 5)}")


def b3():
    """From any start: the orbit attracts (the bodies' motion is resonant)."""
    yield "impact speed", one_n_orbit("2", "0.8", "0", 1)[0]


def grazing(omega, sigma, c):
    omega, sigma, c = map(mpf, (omega, sigma, c))
    return sigma * sqrt((1 - omega**2) ** 2 + (c * omega) ** 2)


def b5():
    yield "instant of impact 1", pi
    yield "instant of impact 5", 5 * pi
    yield "speed of impact 1", mpf(1)
    yield "speed of impact 5", mpf("0.7") ** 4


def b5_two():
    """Equal frequencies: the gap is an oscillator of its own."""
    yield "instant of impact 4", 4 * pi
    yield "speed of impact 4", mpf("0.6") ** 3


def sdnd122():
    m, k, wall, e, energy = map(mpf, ("1", "10", "50", "0.01", "0.00650108331626"))
    free = 2 * sqrt(m / k) * acos(-e * sqrt(k / 2 / energy))
    middle = e * k / (k + wall)  # from where the wall is touched to the equilibrium with it
    swing = sqrt(middle**2 + (2 * energy - k * e**2) / (k + wall))
    pressed = 2 * sqrt(m / (wall + k)) * acos(middle / swing)
    yield "frequency by harmonic balance", 1 / (free + pressed)
    yield "frequency by the formula of the manual", 1 / (free + pressed)


def sdnd105():
    """The force K x reaches 1; the spring of 1e-7 N/m acts beside the wall."""
    omega = sqrt(1 + mpf("1e-7"))
    yield "instant at which the force is 1 N", asin(omega / 2) / omega


def sdnd108():
    """A fall of 2 m from 1 m/s, half a cycle of a spring under weight, and a throw back at the same speed."""
    g, wall, height, speed = mpf(10), mpf(100), mpf(2), mpf(1)
    omega, touching = sqrt(wall), sqrt(speed**2 + 2 * g * height)
    touch = (touching - speed) / g
    leaves = touch + 2 * (pi - atan2(touching * omega, g)) / omega
    yield "instant of touch", touch
    yield "instant at which it leaves the ground", leaves
    for name, time in (("1", mpf(1)), ("1.1", mpf("1.1"))):
        later = time - leaves
        yield f"fall after {name} s", height - touching * later + g * later**2 / 2


def oscillation(inertia, stiffness, damper, x, v):
    """x(t) and x′(t) of inertia x″ + damper x′ + stiffness x = 0, and when damper x′ + stiffness x is zero next."""
    rate = damper / (2 * inertia)
    omega = sqrt(stiffness / inertia - rate**2)
    sine = (v + rate * x) / omega

    def at(t):
        c, s = cos(omega * t), sin(omega * t)
        place = exp(-rate * t) * (x * c + sine * s)
        return place, exp(-rate * t) * omega * (sine * c - x * s) - rate * place

    more = stiffness / damper - rate
    return at, atan2(omega * sine + more * x, omega * x - more * sine) % pi / omega


def backlash():
    """ElastoBacklash: of a penetration x the torque is c x + min(d x′, c x), and none where that would be negative.

    A contact begins with the torque 2 c x, until d x′ = c x; then both act until they cancel, at −d x′ = c x.
    """
    inertia, spring, damper, half = mpf(5), mpf(20000), mpf(50), pi / 8
    time, side, x, v = mpf(0), 1, pi / 2 - half, mpf(0)
    ratio, free, flights, contacts = spring / damper, sqrt(2 * spring / inertia), [], []
    while len(flights) < 4:
        if not x:
            start, x = v, mpf(0)
            eased = atan(free / ratio) / free  # x = start sin(free t)/free and x′ = ratio x
            x, v, time = start * sin(free * eased) / free, start * cos(free * eased), time + eased
        at, end = oscillation(inertia, spring, damper, x, v)
        contacts.append((time, side, at))
        (x, v), time = at(end), time + end
        flights.append((time, side * (half + x), side * v))
        time, side, x, v = time + (2 * half + x) / -v, -side, mpf(0), -v
    for number, (left, place, speed) in enumerate(flights, 1):
        yield f"speed of flight {number}", abs(speed)
        yield f"end of flight {number}", left + (half + abs(place)) / abs(speed)
    for text, number in (("0.02", 0), ("0.06", 1), ("0.13", 2), ("0.2", 3)):
        begun, side, at = contacts[number]
        yield f"angle after {text} s", side * (half + at(mpf(text) - begun)[0])


def bounces():
    """The ball of Kirchner's demonstration: the sum of its flights."""
    fall, e = sqrt(2 * mpf("1.5") / mpf("9.8")), mpf("0.7")
    yield "instant of bounce 13", bounce(fall, e, 13)
    yield "end of bouncing", fall * (1 + e) / (1 - e)


def bounce(fall, e, n):
    """Instant of an impact of a ball that first falls for so long."""
    return fall * (1 + 2 * sum(e**k for k in range(1, n)))


def reference_fmu():
    """The ball of the FMU rests at the first rebound below 0.1 m/s."""
    g, e = mpf("9.81"), mpf("0.7")
    fall = sqrt(2 / g)
    last = next(n for n in range(1, 99) if g * fall * e**n < mpf("0.1"))
    yield "instant of the last impact", bounce(fall, e, last)
    yield "impacts until it rests", mpf(last)


def sticking(sigma):
    yield "release", acos(mpf(sigma)) / mpf("2.8")


def contraction():
    yield "product of the multipliers", mpf("0.8") ** 2 * exp(-2 * mpf("0.05") * 2 * pi / 2)


def restitution():
    """Two equal free bodies of 0.25 kg; the damper for e = 0.55 is that of the file."""
    kn, m, damper = mpf(10000), mpf("0.25"), mpf("13.218840989053941")
    ratio = damper / (2 * sqrt(m / 2 * kn))
    yield "restitution", exp(-pi * ratio / sqrt(1 - ratio**2))
