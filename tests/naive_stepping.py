"""Plain twins of the one-step methods: each in the form of its source, every step solved with both contact statuses."""

import functools
import math

import numpy as np

from tests.naive import drive, matrices_of


class NoSolution(Exception):
    """Neither status of a step that is to be halved agrees with its own end."""


class Twin:
    """One run; a wall is body 2 with its rows and columns struck out."""

    def __init__(self, system, eta, method):
        self.mu = 1.0 if system.wall else system.mass_ratio
        self.system, self.eta, self.method = system, eta, method
        self.h = 2 * math.pi / eta / method.steps
        self.mass, self.dampers, self.springs = matrices_of(system)
        self.load = functools.lru_cache(4)(self.load_of(*drive(system, eta)))  # a stage asks for the same load often
        self.free = slice(0, 1) if system.wall else slice(0, 2)
        self.contacts = self.none = self.two = 0
        self.at_end = method.status == "end"

    def load_of(self, first, second):
        """The load at τ, from what drives each body."""
        (one, constant1), (two, constant2) = first, second

        def load(tau):
            c, s = math.cos(self.eta * tau), math.sin(self.eta * tau)
            forces = [one[0] * c + one[1] * s + constant1, self.mu * (two[0] * c + two[1] * s + constant2)]
            return np.array(forces)

        return load

    def gap(self, x):
        return self.system.clearance + x[1] - x[0]

    def spring_and_damper(self, x, v):
        return -self.method.stiffness * self.gap(x) - 2 * self.method.damping * (v[1] - v[0])

    def own(self, x, v, tau):
        """What acts on the bodies but for contact and inertia, to the left of the equation."""
        return self.dampers @ v + self.springs @ x - self.load(tau)

    def push(self, force):
        return force * np.array([1.0, -1.0])

    def solve(self, residual):
        """Zero of an affine function."""
        zero, found = residual(np.zeros(2)), np.zeros(2)
        slope = np.column_stack([residual(unit) - zero for unit in np.eye(2)])
        found[self.free] = np.linalg.solve(slope[self.free, self.free], -zero[self.free])
        return found

    def stages(self, state, tau, status_of):
        """Yield the end of each stage: x, v, a, λ; ``status_of(end)`` chooses a status and returns its end."""
        name, i, h = self.method.integrator.name, self.method.integrator, self.h
        x, v, a, former = state
        if name in ("newmark", "hht", "hht-interpolated", "generalised-alpha"):
            yield status_of(lambda s: self.one_stage(x, v, a, former, tau, s))
        elif name in ("tr-bdf2", "bathe"):
            rho = 0.0 if name == "tr-bdf2" else i.rho
            g = 0.5 if name == "tr-bdf2" or rho == 1 else (2 - math.sqrt(2 + 2 * rho)) / (1 - rho)
            middle = status_of(lambda s: self.trapezoid(x, v, a, tau, g * h, s))
            yield middle
            last = self.backward if name == "tr-bdf2" else self.bathe
            yield status_of(lambda s: last((x, v, a), middle, tau, s, g, rho))
        elif name == "backward-euler":
            yield status_of(lambda s: self.implicit(lambda new: (x + h * (v + h * new), v + h * new), tau + h, s))
        elif name == "euler-implicit-damper":
            yield status_of(lambda s: self.implicit_damper(x, v, tau, s))
        else:
            felt = v + (h if name == "semi-implicit-euler" else h / 2) * a
            new = x + h * felt
            status = self.gap(new) <= 0 and (self.method.law != "cut" or self.spring_and_damper(new, felt) > 0)
            force = self.spring_and_damper(new, felt) if status else 0.0
            right = self.push(force) + self.own(new, felt, tau + h)
            found = np.zeros(2)
            found[self.free] = -(np.linalg.inv(self.mass) @ right)[self.free]
            yield new, (felt if name == "semi-implicit-euler" else felt + h / 2 * found), found, force

    def one_stage(self, x, v, a, former, tau, status):
        """Newmark's relations with the equation of motion of each method."""
        i, h, name = self.method.integrator, self.h, self.method.integrator.name
        am = af = 0.0
        if name == "newmark":
            beta, gamma = i.beta, i.gamma
        elif name == "generalised-alpha":
            am, af = (2 * i.rho - 1) / (i.rho + 1), i.rho / (i.rho + 1)
            beta, gamma = 0.25 * (1 - am + af) ** 2, 0.5 - am + af
        else:
            beta, gamma, af = (1 - i.alpha) ** 2 / 4, 0.5 - i.alpha, -i.alpha

        def end(new):
            return x + h * v + h * h * ((0.5 - beta) * a + beta * new), v + h * ((1 - gamma) * a + gamma * new)

        def law(new):
            x1, v1 = end(new)
            if name != "hht":
                x1, v1 = (1 - af) * x1 + af * x, (1 - af) * v1 + af * v
            return self.gap(x1), self.spring_and_damper(x1, v1)

        def residual(new):
            x1, v1 = end(new)
            force = law(new)[1] if status else 0.0
            if name == "hht":
                now = self.own(x1, v1, tau + h) + self.push(force)
                return self.mass @ new + (1 - af) * now + af * (self.own(x, v, tau) + self.push(former))
            between = self.own((1 - af) * x1 + af * x, (1 - af) * v1 + af * v, tau + (1 - af) * h)
            return self.mass @ ((1 - am) * new + am * a) + between + self.push(force)

        new = self.solve(residual)
        gap, force = law(new)
        return *end(new), new, gap, force

    def trapezoid(self, x, v, a, tau, h, status):
        def end(new):
            v1 = v + h / 2 * (a + new)
            return x + h / 2 * (v + v1), v1

        return self.implicit(end, tau + h, status)

    def backward(self, begun, middle, tau, status, share, rho):
        """The three-point backward formula of Bathe (2007), a = (v₀ − 4v_m + 3v)/Δt, and v likewise of ξ.

        Solved for v and ξ: the quotients themselves would lose all digits in a step that is cut to a sliver.
        """
        (x, v, _), (xm, vm, *_), h = begun, middle, self.h

        def end(new):
            v1 = (4 * vm - v + h * new) / 3
            return (4 * xm - x + h * v1) / 3, v1

        return self.implicit(end, tau + h, status)

    def bathe(self, begun, middle, tau, status, share, rho):
        (x, v, a), (_, vm, am, *_), h = begun, middle, self.h
        q1 = (rho + 1) / (2 * share * (rho - 1) + 4)
        q0, q2 = (share - 1) * q1 + 0.5, 0.5 - share * q1

        def end(new):
            v1 = v + h * (q0 * a + q1 * am + q2 * new)
            return x + h * (q0 * v + q1 * vm + q2 * v1), v1

        return self.implicit(end, tau + h, status)

    def implicit(self, end, tau, status):
        def residual(new):
            x, v = end(new)
            return self.mass @ new + self.own(x, v, tau) + self.push(status and self.spring_and_damper(x, v))

        new = self.solve(residual)
        x, v = end(new)
        return x, v, new, self.gap(x), self.spring_and_damper(x, v)

    def implicit_damper(self, x, v, tau, status):
        """(M + Δτ C)(v₁ − v) = Δτ(l − Kx − Cv + λ): the contact's damper stands in C, too."""

        def balance(v1):
            inner = self.own(x, v1, tau) + self.push(status and self.spring_and_damper(x, v1))
            return self.mass @ (v1 - v) / self.h + inner

        v1 = self.solve(balance)
        return x + self.h * v1, v1, (v1 - v) / self.h, self.gap(x), self.spring_and_damper(x, v1)

    def run(self, periods):
        """States at the ends of periods, (periods, 4)."""
        x1, v1, x2, v2 = self.system.rest
        x, v = np.array([x1, x2]), np.array([v1, v2])
        status = bool(self.gap(x) <= 0)
        force = self.spring_and_damper(x, v) if status else 0.0
        right = self.push(force) + self.own(x, v, 0.0)
        a = np.zeros(2)
        a[self.free] = -(np.linalg.inv(self.mass) @ right)[self.free]
        rows, solutions, cut = [], [], self.method.law == "cut"

        def choose(end):
            nonlocal status
            if not self.at_end:
                found = end(status)
                if status and cut and found[4] < 0:
                    found = (*end(False)[:4], 0.0)
                elif not status:
                    found = (*found[:4], 0.0)
                status = bool(found[3] <= 0)  # the gap there is that of the next stage's start
                return (*found[:3], found[4])
            ends = {s: end(s) for s in (status, not status)}
            agree = [s for s in ends if (ends[s][3] <= 0 and (not cut or ends[s][4] > 0)) == s]
            if not agree and self.method.without_solution == "halve":
                raise NoSolution
            solutions.append(len(agree))
            status = agree[0] if agree else status
            return (*ends[status][:3], ends[status][4] if status else 0.0)

        overlap, whole = self.gap(x) <= 0, self.h

        def advance(state, k):
            """A step, in parts of half the size wherever one has no solution."""
            nonlocal status
            level, done = 0, 0
            while done < 1024:
                former, self.h = status, whole / 2**level
                solutions.clear()
                try:
                    *_, last = self.stages(state, (k + done / 1024) * whole, choose)
                    state, done = last, done + (1024 >> level)
                except NoSolution:
                    status, level = former, level + 1
            failed = level > 0 or 0 in solutions
            self.none, self.two, self.h = self.none + failed, self.two + (not failed and 2 in solutions), whole
            return state

        for k in range(periods * self.method.steps):
            x, v, a, force = advance((x, v, a, force), k)
            if not self.at_end:
                status = bool(self.gap(x) <= 0)
            self.contacts += bool(self.gap(x) <= 0) and not overlap
            overlap = self.gap(x) <= 0
            if (k + 1) % self.method.steps == 0:
                rows.append([x[0], v[0], x[1], v[1]])
        return np.array(rows)
