"""The motion of a case of :mod:`.bodies` from event to event, and the energies along the way."""

from mpmath import mp, mpf

from high_precision.bodies import LOADS, Bodies
from high_precision.run import IMPACT, JOIN, LEAVE, PART, TOUCH, Solution
from high_precision.zeros import Undecided, first_zero


def solve_case(case):
    """The motion of a case: states and contact forces (minus at the second stop), events [(t, kind, g′ before, stop)].

    Kinds as in :mod:`.run`; stops are counted from 1.

    Raises
    ------
    Undecided
        If the working precision cannot decide whether there is an event.
    """
    run = _Run(Bodies(case))
    while len(run.states) <= case["samples"]:
        run.step()
    return Solution(run.states, run.forces, run.events)


class _Run:
    """The state y of a run at the time t; len(states) − 1 samples are complete."""

    def __init__(self, bodies):
        self.bodies, self.t, self.y = bodies, mpf(0), bodies.start()
        self.reference = "restitution" in bodies.case["stops"][0]
        self.changes = bodies.changes()
        self.states, self.forces, self.events = [], [], []
        self.renew_loads()
        self.begin()
        self.note_state()

    def begin(self):
        """Enter the first phase."""
        for surface in range(len(self.bodies.surfaces)):
            distance = self.distance(surface)
            if distance == 0:
                return self.meet(surface)
            if distance < 0:
                if self.reference:
                    raise ValueError("the reference cannot start beyond a stop")
                self.note(TOUCH, surface)
                return self.enter("pressed", surface, 0)
        return self.enter("flight", None, 0)

    def enter(self, name, surface, order):
        """Enter a phase; what is watched at this stop starts as t^order."""
        self.name, self.surface, self.order = name, surface, order

    def distance(self, surface):
        sign, at = self.bodies.surfaces[surface]
        return sign * (self.y[2] - at)

    def note(self, kind, surface, rate=None):
        self.events.append((self.t, kind, self.y[3] if rate is None else rate, surface + 1))

    def note_state(self):
        self.states.append(self.bodies.state(self.y))
        self.forces.append(self.force())

    def force(self):
        """The contact force, negative at the second stop."""
        if self.name == "flight":
            return mpf(0)
        row = getattr(self.bodies, "force_row" if self.name == "joined" else "penalty_row")(self.surface)
        return self.bodies.surfaces[self.surface][0] * self.value(row)

    def value(self, row):
        return sum((x * z for x, z in zip(row, self.y, strict=True)), mpf(0))

    def renew_loads(self):
        """Set C and C′ of all loads, whose pieces may begin here."""
        loads = self.bodies.loads_from(self.t)
        self.rates = [w for *_, w in loads]
        self.y[LOADS:] = [x for c, s, _ in loads for x in (c, s)]

    def watched(self, series, h):
        """[(stop, coefficients, remainder, order)] of what may end the phase, and y over the step."""
        f, remainder, at = series.expand(self.y, h)
        found = [(self.surface, f, remainder, self.order)]
        if self.name == "flight":
            found = []
            for surface in range(len(self.bodies.surfaces)):
                f, remainder, _ = self.bodies.phase("flight", surface, self.rates).expand(self.y, h)
                found.append((surface, f, remainder, self.order if surface == self.surface else 0))
        return found, at

    def step(self):
        """Make one step of the series: to its end, the next sample, the next piece of a load, or the next event."""
        series = self.bodies.phase(self.name, self.surface, self.rates)
        sample = self.bodies.end * len(self.states) / self.bodies.case["samples"]
        until = min([sample, *self.changes[:1]])
        h = min(until - self.t, series.longest(self.y))
        last = h == until - self.t
        watched, at = self.watched(series, h)
        zeros = [(first_zero(f, order, remainder), surface) for surface, f, remainder, order in watched]
        zeros = [(s, surface) for s, surface in zeros if s is not None]
        self.order = 0
        if zeros:
            s, surface = min(zeros)
            self.y, self.t = at(s), self.t + s * h
            return self.end_phase(surface)
        self.y, self.t = at(mpf(1)), until if last else self.t + h
        if last and until == sample:
            self.renew_loads() if until not in self.changes else None
            self.note_state()
        if last and self.changes and until == self.changes[0]:
            del self.changes[0]
            self.renew_loads()
            if self.name == "joined" and self.value(self.bodies.force_row(self.surface)) <= self.rounding():
                self.meet(self.surface, joined=True)
        return None

    def rounding(self):
        return (max(abs(x) for x in self.y) + 1) * mpf(10) ** (10 - mp.dps)

    def end_phase(self, surface):
        """What follows the zero of what was watched at a stop."""
        self.y[2] = self.bodies.surfaces[surface][1]
        if self.name == "joined":
            self.note(PART, surface, mpf(0))
            return self.meet(surface, parting=True)
        if self.name == "pressed":
            self.note(LEAVE, surface)
            return self.enter("flight", surface, 1)
        return self.meet(surface)

    def meet(self, surface, parting=False, joined=False):
        """Continue at a stop: by an impact or a contact if the bodies close, else by the first nonzero derivative."""
        if self.bodies.surfaces[surface][0] * self.y[3] < 0:
            return self.close(surface)
        derivatives = self.flight_derivatives(surface)
        if parting:  # the force is zero, hence g″
            derivatives[:3] = [mpf(0)] * 3
        order = next((k for k, d in enumerate(derivatives) if abs(d) > self.rounding()), None)
        if order is None:
            raise Undecided("all derivatives of the gap vanish")
        if derivatives[order] > 0:
            if parting and order != 3:
                raise Undecided("the contact force vanishes without changing its sign")
            if joined:
                self.note(PART, surface, mpf(0))
            return self.enter("flight", surface, order)
        if parting:
            raise Undecided("the bodies would part into each other")
        if not joined:
            self.note(JOIN if self.reference else TOUCH, surface, mpf(0))
        # the force is proportional to −g″: its order is two less
        return self.enter("joined", surface, order - 2) if self.reference else self.enter("pressed", surface, order)

    def flight_derivatives(self, surface):
        """The distance from a stop and its derivatives, of the motion without contact from here."""
        f, _, _ = self.bodies.phase("flight", surface, self.rates).expand(self.y, mpf(1) / 8)
        return [f[k] * mp.factorial(k) * mpf(8) ** k for k in range(6)]

    def close(self, surface):
        """Begin an impact (reference) or a contact (penalty)."""
        if not self.reference:
            self.note(TOUCH, surface)
            return self.enter("pressed", surface, 1)
        self.note(IMPACT, surface)
        case, bodies, rate = self.bodies.case, self.bodies, self.y[3]
        parting = -mpf(case["stops"][surface]["restitution"]) * rate
        common = self.y[1] + bodies.share * rate
        self.y[1], self.y[3] = common, mpf(0)
        if abs(parting) <= mpf(case["threshold"]) and self.value(bodies.force_row(surface)) > 0:
            self.note(JOIN, surface, mpf(0))
            return self.enter("joined", surface, 0)
        self.y[1], self.y[3] = common - bodies.share * parting, parting
        return self.meet(surface) if parting == 0 else self.enter("flight", surface, 1)
