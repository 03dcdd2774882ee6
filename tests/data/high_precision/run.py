"""Integration from event to event, and the energy budget along the way."""

from dataclasses import dataclass

from mpmath import mp, mpf

from high_precision.zeros import Undecided, first_zero

NODES_PER_DIGIT = 0.8
IMPACT, JOIN, PART = 0, 1, 2  # events of the reference
TOUCH, LEAVE = 0, 1  # events of the penalty


@dataclass
class Budget:
    """Energy in units of m₁ω₁² times the base amplitude squared, from the start on.

    ``work`` is that of the excitation on both masses, ``damped`` the energy dissipated by all dampers, ``lost`` that
    dissipated by impacts; ``residual`` is gain + damped + lost − work.
    """

    work: mpf
    damped: mpf
    lost: mpf
    residual: mpf


@dataclass
class Solution:
    """Outcome of a run.

    ``states`` (ξ₁, ξ₁′, ξ₂, ξ₂′) and contact ``forces`` λ (without impulses) at 0, T/samples, 2T/samples, …; ``events``
    [(τ, kind, g′ before)]; the energy budget if requested.
    """

    states: list
    forces: list
    events: list
    budget: Budget | None = None


def solve(problem, energy=False):
    """Solve the motion over all periods.

    ``energy`` requests the budget: on each step the powers are integrated by Gauss quadrature, with so many points that
    it is exact to the working precision for sums of exponentials of which none exceeds e^(2 REACH). The quadrature is
    independent of how the motion is computed, so that its residual checks the motion.

    Raises
    ------
    Undecided
        If the working precision cannot decide whether there is an event.
    """
    run = _Run(problem, gauss_rule(round(NODES_PER_DIGIT * mp.dps)) if energy else ())
    while len(run.states) <= problem.periods * problem.samples:
        run.step()
    budget = None
    if energy:
        residual = run.stored() - run.stored_at_start + run.damped + run.lost - run.work
        budget = Budget(run.work, run.damped, run.lost, residual)
    return Solution(run.states, run.forces, run.events, budget)


def gauss_rule(n):
    """[(point, weight)] of Gauss quadrature on [0, 1], by Newton's method on the Legendre polynomial."""
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
    """The state y of a run at the time t since the last sample; len(states) − 1 of them are complete."""

    def __init__(self, problem, rule):
        self.problem, self.t, self.y = problem, mpf(0), problem.start()
        self.rule, self.work, self.damped, self.lost = rule, mpf(0), mpf(0), mpf(0)
        self.reference = problem.method["name"] == "reference"
        self.phases = {name: problem.phase(name) for name in ("flight", "joined" if self.reference else "contact")}
        self.stored_at_start = self.stored()
        self.states, self.forces, self.events = [], [], []
        self.interval = problem.period / problem.samples
        self.begin()
        self.note_state()

    def begin(self):
        """Enter the first phase."""
        if self.y[2] == 0:
            self.meet(self.y[3])
        elif self.y[2] > 0:
            self.enter("flight", 0)
        elif self.reference:
            raise ValueError("the reference cannot start with g < 0")
        else:
            self.note(TOUCH, self.y[3])
            self.enter("contact", 0)

    def enter(self, name, order):
        """Enter a phase whose f starts as t^order."""
        self.name, self.order = name, order

    def note(self, kind, rate):
        self.events.append((max(len(self.states) - 1, 0) * self.interval + self.t, kind, rate))

    def note_state(self):
        self.states.append(self.problem.state(self.y))
        self.forces.append(self.force())

    def force(self):
        """The contact force λ."""
        if self.name == "joined":
            return sum((x * z for x, z in zip(self.problem.force_row(), self.y, strict=True)), mpf(0))
        if self.name == "contact":
            method = self.problem.method
            return -mpf(method["stiffness"]) * self.y[2] - 2 * mpf(method["damping"]) * self.y[3]
        return mpf(0)

    def stored(self):
        """Kinetic and elastic energy; the contact spring stores none while the pendulums are apart."""
        p, (x1, v1, x2, v2) = self.problem, self.problem.state(self.y)
        contact = mpf(p.method.get("stiffness", 0)) * min(self.y[2], 0) ** 2
        return (v1**2 + x1**2 + p.mu * (v2**2 + (p.kappa * x2) ** 2) + contact) / 2

    def add_energies(self, at, h, fraction):
        """Add the work and the damping losses of the first ``fraction`` of a step h to the budget."""
        p = self.problem
        for s, weight in self.rule:
            y = at(s * fraction)
            _, v1, _, v2 = p.state(y)
            u, dt = y[3], weight * h * fraction
            for mass, velocity, loads in ((mpf(1), v1, p.loads1), (p.mu, v2, p.loads2)):
                self.work += dt * mass * velocity * sum(x * z for x, z in zip(loads, y[4:], strict=True))
            if self.name == "joined":
                self.damped += dt * p.c3 * (1 + p.mu) * v1**2
            else:
                self.damped += dt * (p.c1 * v1**2 + p.mu * p.c2 * v2**2)
            if self.name == "contact":
                self.damped += dt * 2 * mpf(p.method["damping"]) * u**2

    def step(self):
        """Make one step of the series: to its end, the next sample or the next event."""
        series, left = self.phases[self.name], self.interval - self.t
        h = min(left, series.longest(self.y))
        f, remainder, at = series.expand(self.y, h)
        s = first_zero(f, self.order, remainder)
        self.order = 0
        self.add_energies(at, h, mpf(1) if s is None else s)
        if s is None:
            self.y, self.t = at(mpf(1)), self.t + h
            if h == left:
                self.t, self.y[4:6] = mpf(0), self.clock(len(self.states))
                self.note_state()
            return
        self.y, self.t = at(s), self.t + s * h
        self.y[2] = mpf(0)
        if self.name == "joined":
            self.note(PART, mpf(0))
            self.meet(mpf(0), parting=True)
        elif self.name == "contact":
            self.note(LEAVE, self.y[3])
            self.enter("flight", 1)
        else:
            self.meet(self.y[3])

    def meet(self, rate, parting=False):
        """Continue from g = 0: by an impact or a contact if the gap closes, else by its first nonzero derivative."""
        if rate < 0:
            return self.close(rate)
        derivatives = self.flight_derivatives()
        if parting:  # λ = 0 is g″ = 0
            derivatives[:3] = [mpf(0)] * 3
        size = max(abs(x) for x in self.y) + 1
        order = next((k for k, d in enumerate(derivatives) if abs(d) > size * mpf(10) ** (10 - mp.dps)), None)
        if order is None:
            raise Undecided("all derivatives of the gap vanish")
        if derivatives[order] > 0:
            if parting and order != 3:
                raise Undecided("the contact force vanishes without changing its sign")
            return self.enter("flight", order)
        if parting:
            raise Undecided("the pendulums would part into each other")
        self.note(JOIN if self.reference else TOUCH, mpf(0))
        # λ is proportional to −g″: its order is two less
        return self.enter("joined", order - 2) if self.reference else self.enter("contact", order)

    def clock(self, sample):
        """cos ητ and sin ητ at a sample."""
        if sample % self.problem.samples == 0:
            return [mpf(1), mpf(0)]
        angle = 2 * mp.pi * sample / self.problem.samples
        return [mp.cos(angle), mp.sin(angle)]

    def flight_derivatives(self):
        """g, g′, … of the motion without contact from here."""
        f, _, _ = self.phases["flight"].expand(self.y, mpf(1) / 8)
        return [f[k] * mp.factorial(k) * mpf(8) ** k for k in range(6)]

    def close(self, rate):
        """Begin an impact (reference) or a contact (penalty)."""
        if not self.reference:
            self.note(TOUCH, rate)
            return self.enter("contact", 1)
        self.note(IMPACT, rate)
        p, parting = self.problem, -self.problem.restitution * rate
        share = mpf(0) if p.wall else p.mass_share  # of the change of g′ that body 1 takes in y
        together = [*self.y]
        together[1], together[3] = self.y[1] + share * rate, mpf(0)
        force = sum((x * z for x, z in zip(p.force_row(), together, strict=True)), mpf(0))
        if parting <= mpf(p.method["threshold"]) and force > 0:
            self.lost += p.mass_share * rate**2 / 2
            self.y = together
            self.note(JOIN, mpf(0))
            return self.enter("joined", 0)
        self.lost += p.mass_share * (rate**2 - parting**2) / 2
        self.y[1], self.y[3] = together[1] - share * parting, parting
        if parting == 0:  # e = 0 and no pressure
            return self.meet(parting)
        return self.enter("flight", 1)
