"""Runs of a setting through `simulate` alone, and measures of their own: nothing here is of `engine.divergence`."""

import math
from dataclasses import replace
from functools import cached_property

import numpy as np
from vibroscope.engine import Checkpoint, Record, Reference, simulate

PER_PERIOD = 200  # samples
SECTION = 1000  # periods of a section that is compared as a distribution
LONG = 40_000  # periods after which a motion is what it stays
SAME_POINT = 1e-5  # of the section's size, as docs/theory/motions.md says
SLOW = 0.03  # s: a run that takes longer is made short in a scan
SHORT = 250  # periods of a short run before those that are kept


class Runs:
    """The reference and penalty solutions of a setting.

    Parameters
    ----------
    setting : Setting
    periods, keep : int
        That a comparison says it is of.
    sections : bool
        Whether it compares sections, since a motion does not repeat itself.
    """

    def __init__(self, setting, periods, keep, sections=False):
        self.system, self.eta, self.method = setting
        self.periods, self.keep, self.sections = periods, keep, sections
        self._cycles, self._errors = {}, {}

    def run(self, method, periods=None, keep=None, **how):
        """A run from rest."""
        return simulate(self.system, self.eta, method, periods=periods or self.periods, keep=keep or self.keep, **how)

    @cached_property
    def reference(self):
        return self.run(Reference())

    @cached_property
    def penalty(self):
        return self.run(self.method)

    @cached_property
    def late(self):
        """The reference after LONG periods."""
        return self.run(Reference(), max(LONG, self.periods), SECTION)

    @cached_property
    def period(self):
        """Periods after which the reference repeats itself; 0 if it does not in the kept ones."""
        return 0 if self.sections else period_of(self.reference.section, self.keep // 2)

    @cached_property
    def is_slow(self):
        return self.run(self.method, keep=1).cost.seconds > SLOW

    @property
    def rest(self):
        return np.array(self.system.rest)[[0, 2]]

    def cycle(self, joint_damping, steps):
        """ξ of a cycle of the reference at every sampled instant of so many steps, (2, period, m), and its rms."""
        key = joint_damping, steps
        if key not in self._cycles:
            first = self.run(Reference(joint_damping))
            period = period_of(first.section, self.keep // 2)
            if not period:
                return None
            record = Record(period, PER_PERIOD, steps)
            again = self.run(Reference(joint_damping), keep=period, record=record)
            cycle = by_period(again, period)
            self._cycles[key] = cycle, rms(cycle - self.rest[:, None, None])
        return self._cycles[key]

    def error(self, method, *, further=0, joint_damping="table", short=False):
        """The difference of a penalty solution from the reference, relative to it; inf if it ends early.

        ``further``: so many kept lengths later than the comparison is. ``short``: begun on the reference's motion.
        """
        key = method, further, joint_damping, short
        if key not in self._errors:
            measure = self._of_displacements if self.period else self._of_sections
            self._errors[key] = measure(method, self._how(method, further, short), joint_damping)
        return self._errors[key]

    def _how(self, method, further, short):
        keep = self.keep if self.period else SECTION
        if short:
            state = tuple(self.reference.section[-1])
            return {"periods": SHORT + keep, "initial": Checkpoint(self.system, self.eta, method, 0, state)}
        return {"periods": max(self.periods, keep) + further * keep}

    def _of_displacements(self, method, how, joint_damping):
        steps = method.steps or None
        run = simulate(
            self.system, self.eta, method, keep=self.keep, record=Record(self.keep, PER_PERIOD, steps), **how
        )
        cycle = self.cycle(joint_damping, steps)
        if not run.ok or cycle is None:
            return math.inf
        (wanted, size), found = cycle, by_period(run, self.keep)
        period = wanted.shape[1]
        shifted = (wanted[:, (np.arange(self.keep) + shift) % period] for shift in range(period))
        return min(rms(found - each) for each in shifted) / size

    def _of_sections(self, method, how, joint_damping):
        run = simulate(self.system, self.eta, method, keep=SECTION, **how)
        return self.distance(run.section, joint_damping) if run.ok else math.inf

    def distance(self, section, joint_damping="table"):
        """Distance of a section, (SECTION, 4), from the reference's, relative to that."""
        wanted = self._section(joint_damping)
        return float(apart(section, wanted) / rms(wanted[:, [0, 2]] - self.rest))

    def _section(self, joint_damping):
        key = "section", joint_damping
        if key not in self._cycles:
            periods = max(self.periods, SECTION)
            self._cycles[key] = self.run(Reference(joint_damping), periods, SECTION).section
        return self._cycles[key]

    def chance(self):
        """Distance of sections that chance explains: the largest of those of four later lengths of each solution."""
        found = []
        for method in (Reference(), self.method):
            run = self.run(method, max(self.periods, SECTION) + 3 * SECTION, 4 * SECTION)
            parts = np.split(run.section, 4) if run.ok else []
            found += [self._apart(one, other) for i, one in enumerate(parts) for other in parts[:i]]
        return max(found, default=0.0)

    def _apart(self, one, other):
        return float(apart(one, other) / rms(self._section("table")[:, [0, 2]] - self.rest))


def apart(one, other):
    """Mean distance of the sorted displacements of two sections."""
    return np.mean(np.abs(np.sort(one[:, [0, 2]], axis=0) - np.sort(other[:, [0, 2]], axis=0)))


def by_period(run, periods):
    """Sampled ξ₁ and ξ₂ as (2, periods, m); the last instant is left out."""
    return run.trajectory.displacement[:, :-1].reshape(2, periods, -1)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def period_of(section, most):
    """Least period, ``most`` at most, after which a section, (n, 4), repeats itself; 0 if there is none."""
    size = max(np.abs(section).max(), 1e-300)
    for period in range(1, most + 1):
        if np.abs(section[period:] - section[:-period]).max() <= SAME_POINT * size:
            return period
    return 0


def energy_lost(system, eta, run, lengths=1):
    """Energy that the excitation gives per period, in each of so many lengths of a sampled run: ∫F dξ by parts.

    Displacements are continuous where velocities jump, so that samples do.
    """
    drive, mu = system.excitation, 0.0 if system.wall else system.mass_ratio
    bodies = (1.0, drive.force1, drive.force1_phase), (mu, drive.force2, drive.force2_phase)
    each, found = (len(run.trajectory.time) - 1) // lengths, []
    for part in range(lengths):
        taken = slice(part * each, (part + 1) * each + 1)
        time, given = run.trajectory.time[taken], 0.0
        for place, (mass, force, phase) in zip(run.trajectory.displacement[:, taken], bodies, strict=True):
            base, own = drive.base * eta**2 * mass, eta * time + drive.base_phase
            total = base * np.cos(own) + force * np.cos(eta * time + phase)
            rate = -eta * (base * np.sin(own) + force * np.sin(eta * time + phase))
            given += total[-1] * place[-1] - total[0] * place[0] - np.trapezoid(rate * place, time)
        found.append(float(given) * run.period / (time[-1] - time[0]))
    return found


def rebound_alone(system, method):
    """Restitution of a contact of a spring and a damper between free bodies, the textbook's."""
    ratio = method.damping / math.sqrt(method.stiffness * system.mass_share)
    return math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)) if ratio < 1 else 0.0


def undamped_duration(system, method, speed):
    """How long a contact of the spring Kδⁿ alone lasts between free bodies that close with a speed."""
    power = method.spring_exponent + 1
    depth = (power * system.mass_share * speed**2 / (2 * method.stiffness)) ** (1 / power)
    # ∫ dx/√(1 − x^power) from 0 to 1
    whole = math.sqrt(math.pi) * math.gamma(1 + 1 / power) / math.gamma(0.5 + 1 / power)
    return 2 * depth / speed * whole


def changed(method, **numbers):
    """A method with other numbers."""
    return replace(method, **numbers)
