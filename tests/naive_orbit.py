"""Plain twin of the points of branches: the paper's system in mpmath, derivatives by differences.

Bodies swing by the equations of motion in ξ₁, ξ₁′, ξ₂, ξ₂′, each phase by a matrix exponential. An orbit solves that
the watched quantity is zero at each event and that the state returns; a point, that a determinant is zero, or the
lowest gap of a flight.
"""

import itertools

import mpmath as mp

DIGITS = 30
WIDTH = mp.mpf(10) ** -9  # of central differences, which err by its square
GRID = 64  # points of a flight among which minima are seen
TOUCHING = ("stick", "touch")


class Twin:
    """Orbits of one sequence of events: ``events``, whether the bodies touch at τ = 0, and the period.

    ``over`` is the number that varies, the last of the unknowns: "eta", "K", "D" or "restitution".
    """

    def __init__(self, system, eta, method, events, first, period, over="eta"):
        self.system, self.method, self.over = system, method, over
        self.events, self.first, self.period = events, first, period
        self.kappa, self.mu = mp.mpf(system.kappa), mp.mpf(system.mass_ratio)
        self.numbers = {"eta": mp.mpf(eta), "restitution": mp.mpf(system.restitution)}
        if method.name == "exact":
            self.numbers |= {"K": mp.mpf(method.stiffness), "D": mp.mpf(method.damping)}
        self.slope = None  # ∂F/∂x at the first guess
        self.impacts = []  # of the orbit evaluated last: parting speed, and contact force if the bodies stayed joined
        self.propagators = {}  # by contact, number that varies, and length: differences change one phase or two

    def generator(self, eta, touching):
        """A of z′ = A z, z = (ξ₁, ξ₁′, ξ₂, ξ₂′, cos ητ, sin ητ)."""
        a = mp.zeros(6)
        a[0, 1] = a[2, 3] = mp.mpf(1)
        a[4, 5], a[5, 4] = -eta, eta
        d1, d2 = mp.mpf(self.system.d1), mp.mpf(self.system.d2)
        if touching and self.method.name == "reference":
            kappa3, d3 = mp.mpf(self.system.kappa3), mp.mpf(self.system.joint_damping(self.method.joint_damping))
            for row in (1, 3):
                a[row, row - 1], a[row, row], a[row, 4] = -(kappa3**2), -2 * d3 * kappa3, eta**2
            return a
        a[1, 0], a[1, 1], a[1, 4] = mp.mpf(-1), -2 * d1, eta**2
        a[3, 2], a[3, 3], a[3, 4] = -(self.kappa**2), -2 * d2 * self.kappa, eta**2
        if touching:
            for column, factor in ((0, self.numbers["K"]), (1, 2 * self.numbers["D"])):
                a[1, column] -= factor
                a[1, column + 2] += factor
                a[3, column] += factor / self.mu
                a[3, column + 2] -= factor / self.mu
        return a

    def propagator(self, touching, generator, length):
        """exp(A·length), each computed once."""
        key = touching, self.numbers[self.over], length
        if key not in self.propagators:
            self.propagators[key] = mp.expm(generator * length)
        return self.propagators[key]

    def force(self, z, eta):
        """Contact force of the joined bodies, in a unit of its own: what body 1 would gain on body 2 apart (Eq. 8)."""
        free = self.generator(eta, False) * z
        return free[1] - free[3]

    def residual(self, x):
        """F at x = (ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, instants in periods, α₁), and the phases: A, z at the start, length."""
        self.numbers[self.over], self.impacts = x[-1], []
        eta, e, instants, y = self.numbers["eta"], self.numbers["restitution"], list(x[4:-1]), list(x[:4])
        matrices = {touching: self.generator(eta, touching) for touching in (False, True)}
        found, phases, turn, touching = [], [], mp.mpf(0), self.first
        for k, end in enumerate([*instants, mp.mpf(self.period)]):
            z = mp.matrix([*y, mp.cos(2 * mp.pi * turn), mp.sin(2 * mp.pi * turn)])
            length = (end - turn) * 2 * mp.pi / eta
            if not touching:
                phases.append((matrices[touching], z, length))
            z = self.propagator(touching, matrices[touching], length) * z
            y, turn = list(z[:4]), end
            if k == len(instants):
                break
            rate, event = y[3] - y[1], self.events[k]
            found.append(self.force(z, eta) if event == "release" else y[2] - y[0])
            left = {"impact": -e * rate, "stick": mp.mpf(0)}.get(event, rate)
            if event == "impact" and self.method.name == "reference":
                common = y[1] + self.mu / (1 + self.mu) * rate
                joined = mp.matrix([y[0], common, y[2], common, z[4], z[5]])
                self.impacts.append((left, self.force(joined, eta)))
            y[1] += self.mu / (1 + self.mu) * (rate - left)
            y[3] = y[1] + left
            touching = event in TOUCHING
        return mp.matrix([*(a - b for a, b in zip(y, x[:4], strict=True)), *found]), phases

    def jacobian(self, x):
        """∂F/∂x, by central differences."""
        columns = []
        for k in range(len(x)):
            ends = []
            for way in (1, -1):
                there = x.copy()
                there[k] += way * WIDTH
                ends.append(self.residual(there)[0])
            columns.append((ends[0] - ends[1]) / (2 * WIDTH))
        found = mp.zeros(len(columns[0]), len(columns))
        for k, column in enumerate(columns):
            for i in range(len(column)):
                found[i, k] = column[i]
        return found

    def solved(self, x, fixed):
        """The orbit at which one of the unknowns keeps its value.

        By Newton's method with the derivative at the first guess, which is good to ten digits or so: each step then
        gains as many.
        """
        free = [k for k in range(len(x)) if k != fixed]
        if self.slope is None:
            self.slope = self.jacobian(x)
        for _ in range(8):
            values = self.residual(x)[0]
            matrix = mp.matrix([[self.slope[i, k] for k in free] for i in range(len(values))])
            step = mp.lu_solve(matrix, -values)
            for k, change in zip(free, step, strict=True):
                x[k] += change
            if mp.norm(step, mp.inf) < mp.mpf(10) ** -20:
                return x
        raise AssertionError("the twin finds no orbit")

    def monodromy(self, x):
        """Jacobian of the Poincaré map."""
        jacobian, n = self.jacobian(x), len(x) - 1
        first = jacobian[:4, :4] + mp.eye(4)
        if n == 4:
            return first
        return first - jacobian[:4, 4:n] * mp.inverse(jacobian[4:n, 4:n]) * jacobian[4:n, :4]

    def lowest_gap(self, x):
        """The lowest minimum of the gap within a flight, from a grid by Newton's method on its rate."""
        found = []
        for a, start, length in self.residual(x)[1]:
            step, z, rates = mp.expm(a * (length / GRID)), start, []
            for k in range(GRID + 1):
                rates.append((z[3] - z[1], k))
                z = step * z
            for (before, k), (after, _) in itertools.pairwise(rates):
                if before < 0 < after:
                    t = (k + before / (before - after)) * length / GRID
                    for _ in range(6):
                        z = mp.expm(a * t) * start
                        slope = a * z
                        t -= (z[3] - z[1]) / (slope[3] - slope[1])
                    z = mp.expm(a * t) * start
                    found.append(z[2] - z[0])
        return min(found)

    def at_point(self, kind, x):
        """What is zero at a point of this kind."""
        if kind == "grazing":
            return self.lowest_gap(x)
        if kind == "sticking begins":
            self.residual(x)
            threshold = mp.mpf(self.method.threshold)
            return min((max(parting - threshold, -force) for parting, force in self.impacts), key=abs)
        if kind == "fold":
            n = len(x) - 1
            return mp.det(self.jacobian(x)[:, :n])
        monodromy = self.monodromy(x)
        if kind == "period doubling":
            return mp.det(monodromy + mp.eye(4))
        pair = max((each for each in mp.eig(monodromy)[0] if mp.im(each) > 0), key=abs)  # Neimark–Sacker
        return abs(pair) - 1

    def located(self, kind, x):
        """α₁ of the point near a guess, by the secant method along the curve."""
        fixed = 4 if kind == "fold" else len(x) - 1
        low = self.solved(x.copy(), fixed)
        high = low.copy()
        high[fixed] += mp.mpf(10) ** -9 * max(1, abs(high[fixed]))
        high = self.solved(high, fixed)
        below, above = self.at_point(kind, low), self.at_point(kind, high)
        for _ in range(6):
            following = high.copy()
            following[fixed] -= above * (high[fixed] - low[fixed]) / (above - below)
            low, below, high = high, above, self.solved(following, fixed)
            above = self.at_point(kind, high)
            if abs(high[fixed] - low[fixed]) < mp.mpf(10) ** -16 * max(1, abs(high[fixed])):
                return high[-1]
        raise AssertionError("the twin finds no point")
