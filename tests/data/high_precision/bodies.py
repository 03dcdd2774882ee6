"""The equations of motion of bodies with or without springs, between one stop or two, under loads in pieces.

A *case* is a dictionary of numbers in any consistent units:

    mass, spring, damper, constant   lists of one number (a body beside a wall, which stays at x₂ = 0) or of two
    clearance                        g₀ of the gap g = g₀ + x₂ − x₁, which the first stop keeps at g ≥ 0
    play                             of a second stop, g ≤ play; without it there is none
    stops                            of each stop {"restitution": e} (reference) or {"stiffness": K, "damper": C}: the
                                     force Kδ + Cδ′ of a penetration δ, which may pull
    threshold                        closing speed below which bodies stay together (reference)
    loads                            list of {"on": "base", "body 1" or "body 2", "form": …, numbers}
    start                            x₁, v₁, x₂, v₂ at t = 0; relative to the base, as all displacements
    end or periods and frequency     how long the motion lasts: a time, or periods 2π/frequency
    samples                          how many states are noted over all of it

A load on a body is a force towards larger x. One on the base is its acceleration a, so that −a acts on each unit of
mass; where it is harmonic, its displacement is given. Before a pulse or a record, and after it, a load is zero:

    "harmonic"    amplitude cos(frequency t + phase)
    "half-sine"   peak sin(πt/duration)
    "sawtooth"    rises linearly from 0 to the peak at the end, then drops to 0 at once
    "trapezoid"   rises linearly to the peak, stays, falls linearly; rise, hold, fall: their durations
    "record"      linear between the samples, lists time and value

Of the load the numbers C and C′ are part of the state, C″ = −w²C with w = frequency, π/duration or 0: so each piece
has the closed form of a linear system. The state is

    y = (x₁, v₁, g, g′, 1, C, C′, …)        with one C and C′ for each load.
"""

from itertools import accumulate, pairwise

from mpmath import mp, mpf

from high_precision.series import Taylor

UNIT, LOADS = 4, 5  # columns of 1 and of the first load
SLOWEST = mpf(1) / 8  # of the norms that limit a step: at rest on a wall nothing changes
FORMS = ("harmonic", "half-sine", "sawtooth", "trapezoid", "record")


class Bodies:
    """The constants of a case, computed with the present number of digits, and the generators of its phases."""

    def __init__(self, case):
        self.case = case
        self.wall = len(case["mass"]) == 1
        self.mass, self.spring, self.damper, self.constant = (
            [mpf(x) for x in case[name]] for name in ("mass", "spring", "damper", "constant")
        )
        self.clearance = mpf(case["clearance"])
        self.inverse_mass = sum(1 / m for m in self.mass)  # of the gap
        self.share = mpf(0) if self.wall else self.mass[1] / sum(self.mass)  # of a change of g′ that body 1 takes
        self.surfaces = [(mpf(1), mpf(0))] + ([(mpf(-1), mpf(case["play"]))] if "play" in case else [])
        self.end = 2 * mp.pi * case["periods"] / mpf(case["frequency"]) if "periods" in case else mpf(case["end"])
        self.loads = [pieces(load) for load in case["loads"]]
        self.size = LOADS + 2 * len(self.loads)
        self._phases = {}

    def changes(self):
        """Instants within the motion at which a load goes over to another piece."""
        return sorted({begin for load in self.loads for begin, *_ in load if 0 < begin < self.end})

    def loads_from(self, t):
        """(C, C′, w) of each load from an instant on, at which a piece may begin."""
        found = []
        for load in self.loads:
            begin, w, c, s = max((piece for piece in load if piece[0] <= t), key=lambda piece: piece[0])
            d = t - begin
            if w == 0:
                found.append((c + s * d, s, w))
            else:
                cosine, sine = mp.cos(w * d), mp.sin(w * d)
                found.append((c * cosine + s * sine / w, s * cosine - c * w * sine, w))
        return found

    def start(self):
        """The initial y, its loads left open."""
        x1, v1, x2, v2 = map(mpf, self.case["start"])
        own = [mpf(0), mpf(0)] if self.wall else [x1, v1]
        return [*own, self.clearance + x2 - x1, v2 - v1, mpf(1)] + [mpf(0)] * (self.size - LOADS)

    def state(self, y):
        """x₁, v₁, x₂, v₂ of y."""
        x1, v1, g, u = y[:4]
        return (self.clearance - g, -u, mpf(0), mpf(0)) if self.wall else (x1, v1, x1 + g - self.clearance, v1 + u)

    def accelerations(self):
        """x₁″ and g″ of the motion without contact, as rows."""
        driven = [[mpf(0)] * self.size for _ in range(2)]
        for i, mass in enumerate(self.mass):
            driven[i][UNIT] = self.constant[i] / mass
            for k, load in enumerate(self.case["loads"]):
                if load["on"] == "base":
                    driven[i][LOADS + 2 * k] -= 1
                elif load["on"] == f"body {i + 1}":
                    driven[i][LOADS + 2 * k] += 1 / mass
        one, two = driven
        k1, c1 = self.spring[0] / self.mass[0], self.damper[0] / self.mass[0]
        if self.wall:  # g = g₀ − x₁
            gap = [-x for x in one]
            gap[2], gap[3], gap[UNIT] = -k1, -c1, gap[UNIT] + k1 * self.clearance
            return [mpf(0)] * self.size, gap
        k2, c2 = self.spring[1] / self.mass[1], self.damper[1] / self.mass[1]
        one[0], one[1] = -k1, -c1
        two[0], two[1], two[2], two[3] = -k2, -c2, -k2, -c2  # x₂ = x₁ + g − g₀
        two[UNIT] += k2 * self.clearance
        return one, [b - a for a, b in zip(one, two, strict=True)]

    def gap_row(self, surface):
        """How far the bodies are from a stop."""
        sign, at = self.surfaces[surface]
        return [mpf(0), mpf(0), sign, mpf(0), -sign * at] + [mpf(0)] * (self.size - LOADS)

    def force_row(self, surface):
        """The force of a stop that the bodies stay at: minus the reduced mass times g″ of the motion without it."""
        row = [-self.surfaces[surface][0] / self.inverse_mass * x for x in self.accelerations()[1]]
        row[3] = mpf(0)
        return row

    def penalty_row(self, surface):
        """The force of a stop that is penetrated."""
        stop, sign = self.case["stops"][surface], self.surfaces[surface][0]
        row = [-mpf(stop["stiffness"]) * x for x in self.gap_row(surface)]
        row[3] = -sign * mpf(stop["damper"])
        return row

    def phase(self, name, surface, rates):
        """Flight, "joined" at a stop (reference) or "pressed" to it, while the loads have these w: its series."""
        key = name, surface, tuple(rates)
        if key not in self._phases:
            self._phases[key] = self._series(name, surface, rates)
        return self._phases[key]

    def _series(self, name, surface, rates):
        one, gap = self.accelerations()
        weights = [mpf(1)] * self.size
        if name == "joined":
            one = [a + self.share * b for a, b in zip(one, gap, strict=True)]
            row, still = self.force_row(surface), True
        elif name == "pressed":
            sign, row, still = self.surfaces[surface][0], self.penalty_row(surface), False
            first = mpf(0) if self.wall else 1 / self.mass[0]
            one = [a - sign * first * x for a, x in zip(one, row, strict=True)]
            gap = [b + sign * self.inverse_mass * x for b, x in zip(gap, row, strict=True)]
            weights[2] = max(mpf(1), mp.sqrt(mpf(self.case["stops"][surface]["stiffness"]) * self.inverse_mass))
            row = [-x for x in self.gap_row(surface)]
        else:
            row, still = self.gap_row(surface or 0), False
        for column in range(UNIT, self.size):  # large loads shall not shorten the steps
            weights[column] = max(mpf(1), abs(one[column]), abs(gap[column]))
        nothing = [mpf(0)] * self.size
        matrix = [nothing if self.wall else self._unit(1), one, nothing if still else self._unit(3)]
        matrix += [nothing if still else gap, nothing]
        for k, w in enumerate(rates):
            slope = [-(w**2) * x for x in self._unit(LOADS + 2 * k)]
            matrix += [self._unit(LOADS + 2 * k + 1), slope]
            weights[LOADS + 2 * k + 1] = weights[LOADS + 2 * k] * max(mpf(1), w)
        if self.wall:
            matrix[1] = nothing
        series = Taylor(matrix, row, weights)
        series.norm = max(series.norm, SLOWEST)
        return series

    def _unit(self, column):
        return [mpf(1) if k == column else mpf(0) for k in range(self.size)]


def pieces(load):
    """[(begin, w, C, C′ at the begin)] of a load, the first of them from t = 0 on."""
    numbers = {name: mpf(x) for name, x in load.items() if isinstance(x, int | float | mpf)}
    form = load["form"]
    if form == "harmonic":
        w, size, phase = numbers["frequency"], numbers["amplitude"], numbers.get("phase", mpf(0))
        size *= -(w**2) if load["on"] == "base" else 1
        return [(mpf(0), w, size * mp.cos(phase), -size * w * mp.sin(phase) if phase else mpf(0))]
    if form == "half-sine":
        w = mp.pi / numbers["duration"]
        return [(mpf(0), w, mpf(0), numbers["peak"] * w), (numbers["duration"], mpf(0), mpf(0), mpf(0))]
    peak = numbers.get("peak")
    if form == "sawtooth":
        times, values = [0, numbers["duration"]], [0, peak]
    elif form == "trapezoid":
        times = [0, *accumulate(numbers[name] for name in ("rise", "hold", "fall"))]
        values = [0, peak, peak, 0]
    else:
        times, values = load["time"], load["value"]
    points = [(mpf(t), mpf(value)) for t, value in zip(times, values, strict=True)]
    found = [(mpf(0), mpf(0), mpf(0), mpf(0))] if points[0][0] > 0 else []
    found += [(t, mpf(0), a, (b - a) / (later - t)) for (t, a), (later, b) in pairwise(points)]
    return [*found, (points[-1][0], mpf(0), mpf(0), mpf(0))]
