"""The equations of MODEL.md solved to as many digits as asked for, apart from the engine and by other means.

Motion. Between events each phase (flight, joined, penalty contact) is one linear system y′ = Ay with

    y = (ξ₁, ξ₁′, g, g′, η² cos ητ, η² sin ητ),        g = ξ₂ − ξ₁.

Its Taylor series yⱼ₊₁ = A yⱼ/(j + 1) is summed over steps h with ‖A‖h ≤ REACH. There is no formula for modes or steady
motion, so nothing degenerates at resonance, at ζ = 1, without damping or for κ → 1. Gap and gap rate are part of the
state, so the flights of a chatter keep all their digits. Steps end at every multiple of T, where the excitation is set
to (η², 0) anew.

Only for a contact so stiff that ‖A‖ is above STIFF are the same Taylor coefficients summed from the eigenvectors of A,
so that a mode that has died away no longer holds the step down; what is left out is added to the remainder.

Events. Each phase ends at the first zero of f = g (flight), −g (penalty contact) or λ (joined). On each step f is a
polynomial of known remainder R. Its Bernstein coefficients b on the step enclose it: all b > R, no zero; one change of
sign and none of them within R of zero, exactly one (Descartes). Otherwise the step is halved (de Casteljau), the left
half first. So no zero is passed, however shallow the dip, and an undecidable one raises. The coefficients are integers
in units of 2^-BITS; their rounding is part of R. Where a phase starts on the surface f ~ tᵐ, and f/tᵐ is searched.

All parameters are the exact values of the double-precision numbers that the engine is given.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import comb

import mpmath
from mpmath import mp, mpf

REACH = 6
STIFF = 100
NODES = 48
BITS = 560  # of the integers that decide on zeros: 1e-168
TABLE = {"kappa": 2.41, "d1": 0.0033, "d2": 0.0120, "kappa3": 1.80, "d3": 0.0330, "restitution": 0.5}
IMPACT, JOIN, PART = 0, 1, 2  # events of the reference
TOUCH, LEAVE = 0, 1  # events of the penalty


class Undecided(ArithmeticError):
    """More digits are needed to tell whether there is an event."""


def terms_needed() -> int:
    """N with REACHᴺ/N! below the working precision."""
    n, size = 0, mpf(1)
    while n < REACH or size > mpf(10) ** (-mp.dps - 3):
        n += 1
        size *= mpf(REACH) / n
    return n


def horner(coefficients, s):
    """Value of Σ cⱼ sʲ."""
    value = mpf(0)
    for c in reversed(coefficients):
        value = value * s + c
    return value


# ------------------------------------------------------------------------------------------------------ motion


class Taylor:
    """One phase in the coordinates of y: A and the row of f, with weights w of the norm max |wᵢ yᵢ|."""

    def __init__(self, matrix, row, weights):
        self.rows = [[(k, mpf(x)) for k, x in enumerate(line) if x != 0] for line in matrix]
        self.row = [(k, mpf(x)) for k, x in enumerate(row) if x != 0]
        self.weights = weights
        self.norm = max(sum(abs(x) * weights[i] / weights[k] for k, x in line) for i, line in enumerate(self.rows))
        self.count = terms_needed()

    def longest(self, y):
        """Longest step from y."""
        return REACH / self.norm

    def expand(self, y, h):
        """(coefficients of f in s = t/h, bound of their remainder on 0 ≤ s ≤ 1, y as a function of s)."""
        term = list(y)
        terms = [term]
        for j in range(1, self.count + 1):
            scale = h / j
            term = [sum((x * term[k] for k, x in line), mpf(0)) * scale for line in self.rows]
            terms.append(term)
        f = [sum((x * term[k] for k, x in self.row), mpf(0)) for term in terms[:-1]]
        last = max(w * abs(x) for w, x in zip(self.weights, terms[-1], strict=True))
        ratio = self.norm * h / (self.count + 1)
        remainder = sum(abs(x) / self.weights[k] for k, x in self.row) * last / (1 - ratio)
        return f, remainder, lambda s: [horner([term[i] for term in terms], s) for i in range(6)]


class Modal:
    """The same for a stiff contact: y = Re Σ aᵢ rᵢ, aᵢ′ = λᵢaᵢ, one mode of each pair of conjugates."""

    def __init__(self, matrix, row):
        with mp.workdps(3 * mp.dps):  # nearly equal eigenvalues (ζ ≈ 1) cost digits
            values, right = mp.eig(mp.matrix(matrix))
            left = right**-1
            tiny = mpf(10) ** -mp.dps * max(map(abs, values)) * mpf(10) ** 10
            self.modes = []
            for i, value in enumerate(values):
                real = abs(value.imag) < tiny
                if real or value.imag > 0:
                    column = [right[k, i] * (1 if real else 2) for k in range(6)]
                    value = mpmath.mpc(value.real, 0 if real else value.imag)
                    self.modes.append((value, column, [left[i, k] for k in range(6)], self._dot(row, column)))
        self.count = terms_needed()
        self.least = mpf(10) ** (15 - mp.dps)  # amplitudes below it are rounding
        self._powers = {}

    @staticmethod
    def _dot(row, column):
        return sum((x * z for x, z in zip(row, column, strict=True) if x != 0), mpmath.mpc(0))

    def _living(self, y):
        """[(mode, its part of f at the start)], and a bound of what is left out."""
        parts = [(i, f * self._dot(y, left)) for i, (_, _, left, f) in enumerate(self.modes)]
        dead = sum((abs(part) for _, part in parts if abs(part) <= self.least), mpf(0))
        return [(i, part) for i, part in parts if abs(part) > self.least], dead

    def longest(self, y):
        living, _ = self._living(y)
        return REACH / max(abs(self.modes[i][0]) for i, _ in living)

    def expand(self, y, h):
        living, dead = self._living(y)
        f = [mpf(0)] * self.count
        for i, part in living:
            u, v = part.real, part.imag
            f = [sofar + u * re - v * im for sofar, (re, im) in zip(f, self._table(i, h), strict=True)]
        remainder = dead + sum(abs(part) for _, part in living) * mpf(10) ** -mp.dps
        amplitudes = [self._dot(y, left) for _, _, left, _ in self.modes]

        def at(s):
            grown = [a * mp.exp(mode[0] * h * s) for a, mode in zip(amplitudes, self.modes, strict=True)]
            return [
                sum((b * mode[1][k] for b, mode in zip(grown, self.modes, strict=True)), mpmath.mpc(0)).real
                for k in range(6)
            ]

        return f, remainder, at

    def _table(self, i, h):
        """(λh)ʲ/j! as pairs."""
        if (i, h) not in self._powers:
            z, line = mpmath.mpc(1), []
            for j in range(self.count):
                line.append((z.real, z.imag))
                z *= self.modes[i][0] * h / (j + 1)
            if len(self._powers) > 64:
                self._powers.clear()
            self._powers[i, h] = line
        return self._powers[i, h]


# ------------------------------------------------------------------------------------------------------ zeros


def changes(b, slop):
    """Changes of sign of Bernstein coefficients; None if one of them may be zero."""
    if any(-slop <= x <= slop for x in b):
        return None
    return sum((x > 0) != (y > 0) for x, y in pairwise(b))


def halves(b):
    """Bernstein coefficients on both halves (de Casteljau), with 2^-BITS lost at each level."""
    left, right = [b[0]], [b[-1]]
    while len(b) > 1:
        b = [(x + y) >> 1 for x, y in pairwise(b)]
        left.append(b[0])
        right.append(b[-1])
    return left, right[::-1]


def bernstein(coefficients):
    """Σ cⱼ sʲ on [0, 1] in Bernstein form, integers in units of 2^-BITS; bᵢ = Σ C(i, j)/C(n, j) cⱼ."""
    n = len(coefficients) - 1
    line = [int(mp.ldexp(c, BITS)) // comb(n, j) for j, c in enumerate(coefficients)]
    b = []
    while line:  # Pascal's triangle: b₀ = c₀, and each line of sums loses its last
        b.append(line[0])
        line = [x + y for x, y in pairwise(line)]
    return b


def first_zero(coefficients, order, remainder):
    """First s in (0, 1] with f(s) = 0 for f = Σ cⱼ sʲ > 0 at first, c₀ … of lower order being zero; or None."""
    q = coefficients[order:]
    slop = int(mp.ldexp(remainder, BITS)) + (1 << (len(q) + 10))
    parts = [(bernstein(q), mpf(0), mpf(1))]
    if parts[0][0][0] <= slop:
        raise Undecided("f does not start positive")
    while parts:
        b, low, width = parts.pop()
        count = changes(b, slop)
        if count == 0:
            if b[0] < 0:
                raise Undecided("negative without a zero")
            continue
        if count == 1:
            return polish(q, low, low + width)
        if width < mpf(2) ** -300:
            raise Undecided("double zero")
        left, right = halves(b)
        parts += [(right, low + width / 2, width / 2), (left, low, width / 2)]
    return None


def polish(q, low, high):
    """The only zero in [low, high] of a polynomial positive at ``low``: Newton's method held in the bracket."""
    slopes = [j * c for j, c in enumerate(q)][1:]
    near = mpf(10) ** (-0.65 * mp.dps)  # the error after a step so short is about its square
    s = -q[0] / q[1] if q[1] < 0 else low  # the hops of a chatter are short: there it is near
    s = s if low < s < high else (low + high) / 2
    for _ in range(40 * mp.dps):
        value = horner(q, s)
        low, high = (s, high) if value > 0 else (low, s)
        slope = horner(slopes, s)
        nearer = s - value / slope if slope != 0 else low
        if abs(nearer - s) <= abs(s) * near:
            return nearer
        s = nearer if low < nearer < high else (low + high) / 2
    raise Undecided("no convergence")


# ------------------------------------------------------------------------------------------------------ the model


@dataclass
class Problem:
    """One run: system, η, method, start.

    Attributes
    ----------
    eta : float
    method : dict
        {"name": "reference", "joint_damping": "table" or "derived", "threshold": ε} or
        {"name": "exact", "stiffness": K, "damping": D}.
    periods : int
    system : dict
        What differs from Table 1.
    initial : tuple of 4 float
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    """

    eta: float
    method: dict
    periods: int
    system: dict = field(default_factory=dict)
    initial: tuple = (0.0, 0.0, 0.0, 0.0)
    stiff: float = STIFF

    def __post_init__(self):
        s = {name: mpf(value) for name, value in (TABLE | self.system).items()}
        self.kappa, self.e = s["kappa"], s["restitution"]
        self.mu = (s["kappa3"] ** 2 - 1) / (s["kappa"] ** 2 - s["kappa3"] ** 2)
        self.share = self.mu / (1 + self.mu)
        self.c1, self.c2 = 2 * s["d1"], 2 * s["d2"] * s["kappa"]  # ξᵢ″ + cᵢξᵢ′ + …
        self.k3 = s["kappa3"]
        derived = (s["d1"] + self.mu * s["d2"] * s["kappa"]) / ((1 + self.mu) * s["kappa3"])
        self.c3 = 2 * self.k3 * (s["d3"] if self.method.get("joint_damping") == "table" else derived)
        self.rate = mpf(self.eta)
        self.period = 2 * mp.pi / self.rate

    def start(self):
        x1, v1, x2, v2 = map(mpf, self.initial)
        return [x1, v1, x2 - x1, v2 - v1, self.rate**2, mpf(0)]

    def free_acceleration(self):
        """g″ of the motion without contact, as a row; λ of permanent contact is −share times it, at g = g′ = 0."""
        return [1 - self.kappa**2, self.c1 - self.c2, -(self.kappa**2), -self.c2, 0, 0]

    def matrix(self, stiffness=0, damping=0):
        """A of flight, or of penalty contact with λ = −Kg − 2Dg′."""
        k, d, more = mpf(stiffness), 2 * mpf(damping), 1 + 1 / self.mu
        gap = self.free_acceleration()
        gap[2] -= k * more
        gap[3] -= d * more
        return [
            [0, 1, 0, 0, 0, 0],
            [-1, -self.c1, k, d, 1, 0],
            [0, 0, 0, 1, 0, 0],
            gap,
            [0, 0, 0, 0, 0, -self.rate],
            [0, 0, 0, 0, self.rate, 0],
        ]

    def joined_matrix(self):
        zero = [0] * 6
        return [
            [0, 1, 0, 0, 0, 0],
            [-(self.k3**2), -self.c3, 0, 0, 1, 0],
            zero,
            zero,
            [0, 0, 0, 0, 0, -self.rate],
            [0, 0, 0, 0, self.rate, 0],
        ]

    def phase(self, name):
        """Flight (f = g), joined (f = λ) or contact (f = −g)."""
        if name == "joined":
            row = [-self.share * x for x in self.free_acceleration()]
            return Taylor(self.joined_matrix(), row[:2] + [0] * 4, [mpf(1)] * 6)
        if name == "flight":
            return Taylor(self.matrix(), [0, 0, 1, 0, 0, 0], [mpf(1)] * 6)
        matrix = self.matrix(self.method["stiffness"], self.method["damping"])
        row = [0, 0, -1, 0, 0, 0]
        fast = max(mpf(1), mp.sqrt(mpf(self.method["stiffness"]) * (1 + 1 / self.mu)))
        taylor = Taylor(matrix, row, [mpf(1), mpf(1), fast, mpf(1), mpf(1), mpf(1)])
        return taylor if taylor.norm <= self.stiff else Modal(matrix, row)


@dataclass
class Budget:
    """Energy in units of m₁ω₁² times the base amplitude squared, from the start on.

    ``work`` is what the excitation η² cos ητ does on both masses, ``damped`` what the dampers take (those of the joint
    and of the contact too), ``lost`` what the impacts take; ``residual`` is gain + damped + lost − work.
    """

    work: mpf
    damped: mpf
    lost: mpf
    residual: mpf


@dataclass
class Solution:
    """States (ξ₁, ξ₁′, ξ₂, ξ₂′) at 0, T, 2T, …, events [(τ, kind, g′ before)], and the energy if it was asked for."""

    states: list
    events: list
    budget: Budget | None = None


def solve(problem, energy=False):
    """The motion over all periods.

    ``energy`` asks for the budget: on each step the powers are integrated by Gauss's rule of NODES points, exact to
    some sixty digits for sums of exponentials of which none exceeds e^(2 REACH). It sees nothing of how the motion is
    stepped, so that its residual checks the motion.

    Raises
    ------
    Undecided
        If the working precision cannot tell whether there is an event.
    """
    run = _Run(problem, gauss(NODES) if energy else ())
    while len(run.states) <= problem.periods:
        run.step()
    budget = None
    if energy:
        residual = run.stored() - run.begin + run.damped + run.lost - run.work
        budget = Budget(run.work, run.damped, run.lost, residual)
    return Solution(run.states, run.events, budget)


def gauss(n):
    """[(point, weight)] of Gauss's rule on [0, 1], by Newton's method on the Legendre polynomial."""
    rule = []
    for i in range(n):
        x = mp.cos(mp.pi * (i + mpf("0.75")) / (n + mpf("0.5")))
        for _ in range(10):
            before, now = mpf(1), x
            for k in range(2, n + 1):
                before, now = now, ((2 * k - 1) * x * now - (k - 1) * before) / k
            slope = n * (x * now - before) / (x * x - 1)
            x -= now / slope
        rule.append(((1 + x) / 2, 1 / ((1 - x * x) * slope**2)))
    return rule


class _Run:
    """The state of a run: whole periods are len(states) − 1, t counts from there."""

    def __init__(self, problem, rule):
        self.p, self.t, self.y = problem, mpf(0), problem.start()
        self.rule, self.work, self.damped, self.lost = rule, mpf(0), mpf(0), mpf(0)
        self.reference = problem.method["name"] == "reference"
        self.phases = {name: problem.phase(name) for name in ("flight", "joined" if self.reference else "contact")}
        self.begin = self.stored()
        self.states, self.events = [], []
        self.note_state()
        if self.y[2] == 0:
            self.surface(self.y[3])
        elif self.y[2] > 0:
            self.enter("flight", 0)
        elif self.reference:
            raise ValueError("the reference cannot start with g < 0")
        else:
            self.note(TOUCH, self.y[3])
            self.enter("contact", 0)

    def enter(self, name, order):
        self.name, self.order = name, order

    def note(self, kind, rate):
        self.events.append(((len(self.states) - 1) * self.p.period + self.t, kind, rate))

    def note_state(self):
        x1, v1, g, u = self.y[:4]
        self.states.append((x1, v1, x1 + g, v1 + u))

    def stored(self):
        """Kinetic and elastic energy; a spring of the contact holds none where it does not press."""
        p, (x1, v1, g, u) = self.p, self.y[:4]
        x2, v2 = x1 + g, v1 + u
        contact = mpf(self.p.method.get("stiffness", 0)) * min(g, 0) ** 2
        return (v1**2 + x1**2 + p.mu * (v2**2 + (p.kappa * x2) ** 2) + contact) / 2

    def spend(self, at, h, share):
        """Add work and damping of the first ``share`` of a step h to the budget."""
        p = self.p
        for s, weight in self.rule:
            _, v1, _, u, force, _ = at(s * share)
            v2, dt = v1 + u, weight * h * share
            self.work += dt * force * (v1 + p.mu * v2)
            if self.name == "joined":
                self.damped += dt * p.c3 * (1 + p.mu) * v1**2
            else:
                self.damped += dt * (p.c1 * v1**2 + p.mu * p.c2 * v2**2)
            if self.name == "contact":
                self.damped += dt * 2 * mpf(p.method["damping"]) * u**2

    def step(self):
        """One step of the series, to its end, the end of the period or the next event."""
        series, left = self.phases[self.name], self.p.period - self.t
        h = min(left, series.longest(self.y))
        f, remainder, at = series.expand(self.y, h)
        s = first_zero(f, self.order, remainder)
        self.order = 0
        self.spend(at, h, mpf(1) if s is None else s)
        if s is None:
            self.y, self.t = at(mpf(1)), self.t + h
            if h == left:
                self.t, self.y[4:] = mpf(0), [self.p.rate**2, mpf(0)]
                self.note_state()
            return
        self.y, self.t = at(s), self.t + s * h
        self.y[2] = mpf(0)
        if self.name == "joined":
            self.note(PART, mpf(0))
            self.surface(mpf(0), parting=True)
        elif self.name == "contact":
            self.note(LEAVE, self.y[3])
            self.enter("flight", 1)
        else:
            self.surface(self.y[3])

    def surface(self, rate, parting=False):
        """What follows g = 0: impact or touch if it closes, else the first derivative of g that is not zero decides."""
        if rate < 0:
            return self.close(rate)
        derivatives = self.flight_derivatives()
        if parting:  # λ = 0 is g″ = 0
            derivatives[:3] = [mpf(0)] * 3
        size = max(abs(x) for x in self.y) + 1
        order = next((k for k, d in enumerate(derivatives) if abs(d) > size * mpf(10) ** (10 - mp.dps)), None)
        if order is None:
            raise Undecided("nothing moves")
        if derivatives[order] > 0:
            if parting and order != 3:
                raise Undecided("a release without g‴")
            return self.enter("flight", order)
        if parting:
            raise Undecided("a release into each other")
        self.note(JOIN if self.reference else TOUCH, mpf(0))
        # λ goes as −g″: two orders less
        return self.enter("joined", order - 2) if self.reference else self.enter("contact", order)

    def flight_derivatives(self):
        """g, g′, … of the free motion from here."""
        f, _, _ = self.phases["flight"].expand(self.y, mpf(1) / 8)
        return [f[k] * mp.factorial(k) * mpf(8) ** k for k in range(6)]

    def close(self, rate):
        """Impact (reference) or the beginning of a contact (penalty)."""
        if not self.reference:
            self.note(TOUCH, rate)
            return self.enter("contact", 1)
        self.note(IMPACT, rate)
        p, parting = self.p, -self.p.e * rate
        common = self.y[1] + p.share * rate
        row = p.free_acceleration()
        force = -p.share * (row[0] * self.y[0] + row[1] * common)
        if parting <= mpf(p.method["threshold"]) and force > 0:
            self.lost += p.share * rate**2 / 2
            self.y[1], self.y[3] = common, mpf(0)
            self.note(JOIN, mpf(0))
            return self.enter("joined", 0)
        self.lost += p.share * (rate**2 - parting**2) / 2
        self.y[1], self.y[3] = common - p.share * parting, parting
        if parting == 0:  # e = 0 and no pressure
            return self.surface(parting)
        return self.enter("flight", 1)
