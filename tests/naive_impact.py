"""Plain twin of one impact: each scheme in the form of its source, of all instants of touch at once, step by step.

Reduced mass, closing speed and the spring's force at a penetration of one are one; the gap opens with λ = g″. Columns
are instants of touch.
"""

import math

import numpy as np

LOOKS, BISECTIONS = 7, 50  # parts of a step that are looked at for a change, and halvings that locate it
WIDER, SECANTS = 60, 60
AT_ONCE = 1e-9  # of a step: a kink so close to its beginning was just passed
OVER, STUCK, BLOWN_UP, UNSOLVED = range(4)
HUGE, AT_REST = 1e12, 1e-9


class ImpactTwin:
    """Contacts with a step ``h``; ``damper``: c, or h of Hunt and Crossley's law."""

    def __init__(self, law, damper, integrator, status, h):
        self.law_name, self.c, self.method, self.name, self.status = law, damper, integrator, integrator.name, status
        self.h = h

    # --- the law and its pieces ---------------------------------------------------------------------------------------

    def law(self, g, v):
        """λ of a gap and its rate, with contact."""
        spring, damper = -g, -self.c * v
        if self.law_name == "kelvin-voigt":
            return spring + damper
        if self.law_name == "cut":
            return np.maximum(0.0, spring + damper)
        if self.law_name == "limited":
            return np.where(g < 0, spring + np.minimum(np.maximum(damper, -spring), spring), 0.0)
        assert self.law_name == "hunt-crossley"
        return np.where(g < 0, np.abs(g) ** 1.5 * (1 + damper), 0.0)

    def piece(self, g, v):
        """0 in flight; which formula of the law acts in contact."""
        spring, damper = -g, -self.c * v
        if self.law_name == "cut":
            inner = np.where(spring + damper >= 0, 1, 2)
        elif self.law_name == "limited":
            inner = np.where(damper > spring, 2, np.where(-damper > spring, 3, 1))
        else:
            inner = np.ones(np.shape(g), dtype=int)
        return np.where(g <= 0, inner, 0)

    def solve(self, force_with):
        """λ with which λ is the force of the law: by secants of a bracket, from zero to what λ = 0 gives, or wider."""
        low = np.zeros_like(force_with(0.0))
        high = below = force_with(low)
        above = force_with(high) - high
        for _ in range(WIDER):  # where a contact pulls, the force does not fall everywhere
            outside = (above > 0) == (below > 0)
            if not (outside & (above != 0)).any():
                break
            low, below = np.where(outside, high, low), np.where(outside, above, below)
            high = np.where(outside, 2 * high, high)
            above = force_with(high) - high
        for _ in range(SECANTS):
            over = np.where(below == above, 1.0, below - above)
            new = np.where(above == 0.0, high, high + above * (high - low) / over)
            value = force_with(new) - new
            if not (np.abs(value) > 1e-14 * np.abs(new)).any():
                break
            crosses = (value > 0) != (above > 0)
            low, below = np.where(crosses, high, low), np.where(crosses, above, 0.5 * below)
            high, above = new, value
        return new

    # --- one step -----------------------------------------------------------------------------------------------------

    def end(self, state, h, contact):
        """g, v, a, λ at the end of a step, and the gap that decides its contact status."""
        g, v, a, before = state
        if self.name in ("central-difference", "semi-implicit-euler"):
            felt = v + (h / 2 if self.name == "central-difference" else h) * a
            g = g + h * felt
            force = np.where(contact, self.law(g, felt), 0.0)
            return (g, felt + h / 2 * force if self.name == "central-difference" else felt, force, force), g
        if self.name == "backward-euler":
            force = self.solve(lambda x: np.where(contact, self.law(g + h * (v + h * x), v + h * x), 0.0))
            v = v + h * force
            return (g + h * v, v, force, force), g + h * v
        am = af = 0.0
        if self.name == "newmark":
            beta, gamma = self.method.beta, self.method.gamma
        elif self.name == "generalised-alpha":
            rho = self.method.rho
            am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
            beta, gamma = 0.25 * (1 - am + af) ** 2, 0.5 - am + af
        else:
            assert self.name in ("hht", "hht-interpolated")
            alpha = self.method.alpha
            beta, gamma, af = (1 - alpha) ** 2 / 4, 0.5 - alpha, -alpha

        def moved(x):
            """Acceleration, g, v at the end, and gap and rate that the law feels, with a contact force."""
            new = (1 - af) * x + af * before if self.name == "hht" else (x - am * a) / (1 - am)
            g1 = g + h * v + h * h * ((0.5 - beta) * a + beta * new)
            v1 = v + h * ((1 - gamma) * a + gamma * new)
            share = 0.0 if self.name == "hht" else af
            return new, g1, v1, (1 - share) * g1 + share * g, (1 - share) * v1 + share * v

        force = self.solve(lambda x: np.where(contact, self.law(*moved(x)[3:]), 0.0))
        new, g1, v1, felt, _ = moved(force)
        return (g1, v1, new, force), felt

    def wants(self, felt, force):
        return (felt <= 0) & ((self.law_name != "cut") | (force > 0))

    def constant_step(self, state, former):
        """The end of a step whose contact status is that of its start or of its end; that, and where it has none."""
        if self.name in ("central-difference", "semi-implicit-euler"):
            end, felt = self.end(state, self.h, True)
            contact = self.wants(felt, end[3])
            return self.end(state, self.h, contact)[0], contact, np.zeros(len(felt), bool)
        if self.status == "start":
            contact = state[0] <= 0
            end, felt = self.end(state, self.h, contact)
            return end, contact, np.zeros(len(felt), bool)
        ends = [self.end(state, self.h, np.full(former.shape, each)) for each in (False, True)]
        agrees = [self.wants(felt, end[3]) == (each == 1) for each, (end, felt) in enumerate(ends)]
        if self.law_name == "cut":  # without contact the force that would act decides
            agrees[0] = ~((ends[0][1] <= 0) & (self.law(*ends[0][0][:2]) > 0))
        contact = np.where(np.where(former, agrees[1], agrees[0]), former, ~former)
        chosen = tuple(np.where(contact, one, other) for one, other in zip(ends[1][0], ends[0][0], strict=True))
        return chosen, contact, ~(agrees[0] | agrees[1])

    # --- a contact ----------------------------------------------------------------------------------------------------

    def run(self, s):
        """e, how it ends, and a number that differs between courses, of instants of touch ``s``, (n,)."""
        return (self.run_located if self.status == "located" else self.run_constant)(np.asarray(s, dtype=float))

    @property
    def most(self):
        return int(200 + 5 * 2 * math.pi / self.h)

    def run_constant(self, s):
        n = len(s)
        state = s * self.h, -np.ones(n), np.zeros(n), np.zeros(n)
        e, code, course = np.full(n, np.nan), np.full(n, STUCK), np.zeros(n, dtype=np.int64)
        former, going = np.zeros(n, bool), np.ones(n, bool)
        for i in range(self.most):
            was = state[1]
            state, former, unsolved = self.constant_step(state, former)
            g, v = state[:2]
            course = np.where(going, (3 * course + former + 1) % 1_000_003, course)
            unsolved, huge = going & unsolved, going & ~(np.abs(g) < HUGE)
            over = going & (i > 0) & (g > 0) & (v > 0) & ~former & (np.abs(v - was) <= 1e-12)
            for which, name in ((unsolved, UNSOLVED), (huge, BLOWN_UP), (over & ~unsolved, OVER)):
                code[which] = name
            e[over] = v[over]
            going &= ~(unsolved | huge | over)
            state = tuple(np.where(going, each, 1.0) for each in state)
            if not going.any():
                break
        return self.found(state, going, e, code, course)

    def run_located(self, s):
        n = len(s)
        state = self.anew(np.zeros(n), -np.ones(n))
        piece, left = self.piece(*state[:2]), (1 - s) * self.h
        e, code, course, going = np.zeros(n), np.full(n, STUCK), np.zeros(n, dtype=np.int64), np.ones(n, bool)
        for _ in range(3 * self.most):
            beyond, before = np.full(n, np.nan), np.zeros(n)
            for j in range(1, LOOKS + 1):
                there = self.piece(*self.end(state, left * j / LOOKS, True)[0][:2])
                first = np.isnan(beyond) & (there != piece)
                beyond[first] = (left * j / LOOKS)[first]
                before = np.where(np.isnan(beyond), left * j / LOOKS, before)
            changed = ~np.isnan(beyond)
            low, high = before, np.where(changed, beyond, left)
            for _ in range(BISECTIONS if changed.any() else 0):
                middle = 0.5 * (low + high)
                same = self.piece(*self.end(state, middle, True)[0][:2]) == piece
                low, high = np.where(changed & same, middle, low), np.where(changed & ~same, middle, high)
            at_once = changed & (high <= AT_ONCE * left)
            end = self.end(state, high, True)[0]
            at_once &= end[0] <= 0
            if at_once.any():
                whole = self.end(state, left, True)[0]
                end = tuple(np.where(at_once, one, other) for one, other in zip(whole, end, strict=True))
                high = np.where(at_once, left, high)
            g, v = end[:2]
            over = going & changed & ~at_once & (g > 0)
            e[over], code[over] = v[over], OVER
            left = np.where(changed & ~at_once, left - high, self.h)
            fresh = self.anew(g, v)
            anew = changed & (self.piece(g, v) != piece)
            state = tuple(np.where(anew, one, other) for one, other in zip(fresh, end, strict=True))
            piece, going = self.piece(g, v), going & ~over
            course = np.where(going, (5 * course + piece + 1) % 1_000_003, course)
            if not going.any():
                break
            state = tuple(np.where(going, each, -1.0) for each in state)
        return self.found(state, going, e, code, course)

    def found(self, state, going, e, code, course):
        code[going & (np.abs(state[1]) > 1)] = BLOWN_UP
        code[(code == OVER) & (e < AT_REST)] = STUCK
        return np.where(code == OVER, e, np.where(code == STUCK, 0.0, np.nan)), code, course

    def anew(self, g, v):
        force = self.law(g, v)
        return g, v, force, force


def ends_and_mean(twin, count=400):
    """Least, mean and greatest restitution over the instants of touch, and the shares that end otherwise."""
    s = (np.arange(count) + 0.5) / count
    e, code, course = twin.run(s)
    mean = e[np.isfinite(e)].mean() if np.isfinite(e).any() else math.nan
    shares = {"without_solution": UNSOLVED, "blown_up": BLOWN_UP, "stuck": STUCK}
    shares = {name: np.mean(code == each) for name, each in shares.items()}
    # between two instants with different courses there is an end of both
    jumps = np.flatnonzero((course[1:] != course[:-1]) | (code[1:] != code[:-1]))
    low, high = s[jumps].copy(), s[jumps + 1].copy()
    left = course[jumps], code[jumps]
    for _ in range(20 if len(jumps) else 0):
        middle = 0.5 * (low + high)
        _, kind, way = twin.run(middle)
        same = (way == left[0]) & (kind == left[1])
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    beside = twin.run(np.concatenate([low, high]))[0] if len(low) else np.empty(0)
    if np.isfinite(e).any():  # the least and the greatest may stand at a kink, or where only the cuts of a step change
        for which in (np.nanargmin, np.nanargmax):
            at = s[which(e)]
            for width in (1.0, 0.02, 4e-4):
                near = np.clip(at + width * np.linspace(-1, 1, 101) / count, 1e-9, 1 - 1e-9)
                found = twin.run(near)[0]
                at, beside = near[which(found)], np.append(beside, found)
    every = np.concatenate([e, beside, twin.run([1e-9, 1 - 1e-9])[0]])
    every = every[np.isfinite(every)]
    ends = (every.min(), every.max()) if len(every) else (math.nan, math.nan)
    return (ends[0], mean, ends[1]), shares
