"""Plain twin of located steps with any contact law: looks through each step for the first change, and bisects it."""

import numpy as np

from tests.naive_law_stepping import LawTwin
from tests.naive_stepping import Twin

LOOKS = 7  # parts of a step that are looked at
AT_ONCE = 1e-9  # of a step: a kink so close to its beginning was just passed


class LocatedLawTwin(LawTwin):
    """One run that begins apart; steps are not shortened otherwise."""

    def damper(self):
        """c v of the law is this times v."""
        return 2.0 * self.method.damping

    def piece(self, x, v):
        """0 in flight; which formula of the law acts in contact."""
        depth, speed, k = -self.gap(x), v[0] - v[1], self.method.stiffness
        if depth < 0:
            return 0
        if self.method.law == "cut":
            return 1 if k * depth + self.damper() * speed >= 0 else 2
        if self.method.law == "limited":
            return 2 if self.damper() * speed > k * depth else 3 if -self.damper() * speed > k * depth else 1
        if self.method.law == "bilinear":
            return 1 if depth <= self.method.penetration else 2
        if self.method.law in ("compression", "jankowski"):
            return 1 if speed >= 0 else 2
        if self.method.law == "impact" and depth > 0:
            x = min(depth / self.method.penetration, 1.0)
            inner = k * depth**self.method.exponent + self.damper() * (3 * x**2 - 2 * x**3) * speed
            return 1 if inner >= 0 else 2
        return 1

    def law(self, x, v):
        return max(0.0, self.spring_and_damper_alone(x, v)) if self.method.law == "cut" else super().law(x, v)

    def spring_and_damper_alone(self, x, v):
        return -self.method.stiffness * self.gap(x) + self.damper() * (v[0] - v[1])

    def step(self, state, tau, length, contact):
        """The end of a step of any length: x, v, a, λ."""
        self.h = length
        if self.method.integrator.name in ("central-difference", "semi-implicit-euler"):
            x, v, a, _ = state
            felt = v + (length if self.method.integrator.name == "semi-implicit-euler" else length / 2) * a
            x, _, new, force = self.anew(x + length * felt, felt, tau + length, contact)
            last = felt if self.method.integrator.name == "semi-implicit-euler" else felt + length / 2 * new
            return x, last, new, force

        def chosen(end):
            x, v, a, _, force = self.solved(end, contact)
            return x, v, a, force if contact else 0.0

        *_, last = Twin.stages(self, state, tau, chosen)
        return last

    def anew(self, x, v, tau, contact):
        """The state from which the next step begins: its acceleration and force by the equations."""
        force = self.law(x, v) if contact else 0.0
        a = np.zeros(2)
        a[self.free] = -(np.linalg.inv(self.mass) @ (self.push(force) + self.own(x, v, tau)))[self.free]
        return x, v, a, force

    def changes(self, periods, start=None):
        """Changes of contact [(τ, begins)], and states at the ends of periods, (periods, 4), from ``start``, apart."""
        whole, n, rows, found = self.h, self.method.steps, [], []
        x1, v1, x2, v2 = start or self.system.rest
        state, piece, end = self.anew(np.array([x1, x2]), np.array([v1, v2]), 0.0, False), 0, None
        for i in range(periods * n):
            done = 0.0
            while done < whole:
                tau, length = i * whole + done, whole - done

                def same(theta, state=state, tau=tau, piece=piece):
                    nonlocal end
                    end = self.step(state, tau, theta, piece > 0)
                    return self.piece(*end[:2]) == piece

                looked = [length * j / LOOKS for j in range(1, LOOKS + 1)]
                beyond = next((theta for theta in looked if not same(theta)), None)
                if beyond is None:
                    state, done = end, whole
                    continue
                before = beyond - length / LOOKS
                for _ in range(55):
                    middle = (before + beyond) / 2
                    before, beyond = (middle, beyond) if same(middle) else (before, middle)
                x, v, *_ = self.step(state, tau, beyond, piece > 0)
                if beyond <= AT_ONCE * length and piece > 0 and self.piece(x, v) > 0:
                    beyond = length
                    x, v, *_ = self.step(state, tau, length, True)
                now, after, done = tau + beyond, self.piece(x, v), done + beyond
                if (piece > 0) != (after > 0):
                    found.append((now, after > 0))
                    x = x.copy()
                    x[1] -= self.gap(x) if not self.system.wall else 0.0
                    x[0] += self.gap(x)
                if piece == 0:
                    self.closing = v[0] - v[1]
                piece = self.piece(x, v) if piece == 0 else after
                state = self.anew(x, v, now, piece > 0)
            if (i + 1) % n == 0:
                rows.append([state[0][0], state[1][0], state[0][1], state[1][1]])
        return found, np.array(rows)
