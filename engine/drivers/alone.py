"""A contact alone: two bodies of a reduced mass meet, and no force acts but that of the contact and a constant one.

To the kernels it is the contact of a body without spring and damper with a wall, κ = d₂κ = 0, and the constant force a
load of so long a period that its cosine is one.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.law_driven import set_up_law
from vibroscope.engine.drivers.located import scheme_of_run
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.time_stepping import linear_scheme
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import make_buffers, no_contact
from vibroscope.engine.kernels.equations.contact_law import HUNT_CROSSLEY, contact_law_of, gain_at, law_force
from vibroscope.engine.kernels.event_driven import law_integrate
from vibroscope.engine.kernels.event_driven.law_contact import LawSystem
from vibroscope.engine.kernels.event_driven.state import HybridState, start_state
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.status import DIVERGED, OK, WITHOUT_SOLUTION
from vibroscope.engine.kernels.time_stepping import linear_step, located, touches
from vibroscope.engine.kernels.time_stepping.contact_location import SCHEME
from vibroscope.engine.kernels.time_stepping.touches import FOUND, run_touches
from vibroscope.engine.law_table import deepest_penetration
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System

MOST_STEPS = 10_000  # of high order, in a contact
AT_REST = 1e-9  # speed, as a share of the closing speed, at which bodies do not part: rounding decides of less
CREPT_BACK = 1e-6  # of the deepest penetration without a damper: a slow contact that is as near to its end stays closed
LOOKS = 8  # at depth and force within a step of high order, to find the largest
SHARES = np.linspace(0.0, 1.0, LOOKS + 1)
DRAWN = 200  # instants of a contact that is drawn
NEARINGS = 32  # of a largest value: more would compare its rounding
MOST_SOLVES = 1_000_000  # of a located contact
MOST_CYCLES, FEWEST_STEPS = 5, 200  # of a contact with a step: cycles of its spring, and steps, after which it stays
# What is found of a touch (:func:`..kernels.time_stepping.touches.run_touches`): columns, and how it ended
SPEED, GAP, DEPTH, PUSH = touches.SPEED, touches.GAP, touches.DEPTH, touches.PUSH
STEPS, NONE, TWO, CODE = touches.STEPS, touches.NONE, touches.TWO, touches.CODE
PARTED, BLOWN_UP, UNSOLVED, STUCK = OK, DIVERGED, WITHOUT_SOLUTION, touches.STUCK
ALWAYS = 1e12  # steps in the period of a load that is constant
ONE = np.array([[1.0], [0.0]])  # cosine and sine of that load
_G, _U, _STEP = map(located.STATE.begin, ("g", "u", "step"))  # in a packed state of located steps
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def parameters_alone(method: Method, e: float = 1.0, step: float = 1.0, push: float = 0.0) -> Parameters:
    """The parameters of a contact alone, of a reduced mass of one.

    Parameters
    ----------
    method : ExactPenalty, Newmark or TimeStepping
        The number of its steps has no meaning here.
    e : float
        Restitution from which a law takes its damper where D is left out.
    step : float
        Δτ; any where the method has none.
    push : float
        The constant force, positive where it presses the bodies together.
    """
    p = parameters_of(System(wall=True, restitution=e, clearance=0.0), 1.0, method)
    free = {"kappa": 0.0, "d1": 0.0, "damper2": 0.0, "stiffness_share": 0.0, "free_gap": 0.0}
    loads = {"base_cosine": 0.0, "base_sine": 0.0, "force1_cosine": push, "force1_sine": 0.0}
    return _with_step(p._replace(steps=ALWAYS, **free, **loads), step)


def _with_step(p: Parameters, step: float) -> Parameters:
    return p._replace(eta=2.0 * math.pi / step / ALWAYS)


# --- without a step ---------------------------------------------------------------------------------------------------


class Course(NamedTuple):
    """What a contact gives without a time step."""

    restitution: float
    penetration: float  # the deepest
    force: float  # the largest
    time: float  # until the gap opens; inf if it stays closed


def restitution_alone(p: Parameters, closing: float = 1.0) -> float:
    """The restitution of a contact alone that begins with a closing speed; 0 if it does not end."""
    *_, (_, _, _, after, ends) = _steps_alone(p, closing)
    return after.rate / closing if ends else 0.0


def course_alone(p: Parameters) -> Course:
    """Follow a contact alone that begins with a closing speed of one."""
    begins, opens, after, depth_and_force = _motion_alone(p)
    times = np.unique(np.concatenate([begins[:-1] + share * np.diff(begins) for share in SHARES]))
    seen = np.array([depth_and_force(t) for t in times])
    largest = []
    for which, best in enumerate(np.argmax(seen, axis=0)):
        ends = times[max(best - 1, 0)], times[min(best + 1, len(times) - 1)]
        found = _largest_between(lambda t, which=which: depth_and_force(t)[which], *ends)
        largest.append(max(0.0, float(seen[best, which]), found))
    return Course(after.rate if opens else 0.0, *largest, float(begins[-1]) if opens else math.inf)


def force_alone(p: Parameters, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Instants after touch and the force then, (n,) each, of the same contact until it opens, or until a time."""
    begins, opens, _, depth_and_force = _motion_alone(p, until)
    until = min(until, begins[-1])
    times = np.linspace(0.0, until, DRAWN)
    force = np.array([depth_and_force(t)[1] for t in times])
    ends = [until] if opens and until == begins[-1] else []  # it jumps there, and at touch, where a damper acts
    return np.concatenate([[0.0], times, ends]), np.concatenate([[0.0], force, np.zeros(len(ends))])


def _motion_alone(
    p: Parameters, until: float = 0.0
) -> tuple[np.ndarray, bool, HybridState, Callable[[float], tuple[float, float]]]:
    """Where steps of high order begin and the last ends; whether and how the gap opens; depth and force over time."""
    law, steps = uncompiled(contact_law_of)(p), list(_steps_alone(p, 1.0, until))
    gain = uncompiled(gain_at)(law, 1.0)
    begins = np.cumsum([0.0] + [step[2] for step in steps])

    def depth_and_force(t: float) -> tuple[float, float]:
        k = min(int(np.searchsorted(begins, t, "right")), len(steps)) - 1
        system, a, *_ = steps[k]
        _, _, gap, rate = law_integrate.law_motion(system, a, (0.0,) * 6, t - begins[k])
        return -gap, law_force(law, gain, -gap, -rate)

    *_, after, opens = steps[-1]
    return begins, opens, after, depth_and_force


def _steps_alone(
    p: Parameters, closing: float, until: float = 0.0
) -> Iterator[tuple[LawSystem, HybridState, float, HybridState, bool]]:
    """The steps of high order of a contact: its system, state, length, the state after it, whether the gap opens.

    They end with the contact or, after a time, where it is known not to end. A body that turns back before the gap
    opens lacks the energy to open it, and a contact only takes energy: depth and force have been the largest, too.
    """
    system = set_up_law(p._replace(law=float(HUNT_CROSSLEY)))  # one without tables for pieces, which are not used
    spacing = deepest_penetration(p.stiffness, p.mu, closing, p.exponent) / closing
    system = system._replace(law=uncompiled(contact_law_of)(p), flight=system.flight._replace(spacing=spacing))
    opened = uncompiled(no_contact)()._replace(closing=closing)
    a = uncompiled(start_state)(system, (0.0, 0.0, 0.0, -closing))._replace(mode=law_integrate.SMOOTH, contact=opened)
    time, turns_back = 0.0, False
    for _ in range(MOST_STEPS):
        s, after, ends, _ = law_integrate.follow_smooth(system, a, math.inf)
        time += max(s, 0.0)
        turns_back |= a.rate > 0.0 >= after.rate
        if s < 0.0:
            ends = False
        yield system, a, max(s, 0.0), after, ends
        rests = abs(after.rate) < AT_REST * closing and -after.gap < CREPT_BACK * spacing * closing
        if ends or s < 0.0 or rests or (turns_back and time > until):
            return
        a = after


def _largest_between(value: Callable[[float], float], low: float, high: float) -> float:
    """The largest value between two times, of one that turns once: by the golden section."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = value(left), value(right)
    for _ in range(NEARINGS):
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = value(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = value(right)
    return max(at_left, at_right)


# --- with a step ------------------------------------------------------------------------------------------------------


class Touches:
    """Contacts alone with a step, which begin with a closing speed of one at any instant of touch within a step.

    Parameters
    ----------
    p : Parameters
    method : Newmark or TimeStepping
    step : float
        Δτ.
    """

    def __init__(self, p: Parameters, method: Method, step: float):
        self.flight, self.step = -p.force1_cosine, step
        self._most = int(FEWEST_STEPS + MOST_CYCLES * 2.0 * math.pi / math.sqrt(p.stiffness) / step)
        if method.located:
            self._located = SCHEME.pack(scheme_of_run(p, method))
            self._forces = np.tile([0.0, self.flight], (self._most + 2, 1))
            self._begun, self._buffers = located_start(self.flight), make_buffers(0, np.zeros(1), self._most, 1)
        else:
            self._located = None
            self._scheme = linear_scheme(p, method)
            self._work, self._nothing = np.zeros((4, linear_step.WORK)), make_buffers(0, np.zeros(1), 0, 0).views

    def run(self, instants: np.ndarray) -> np.ndarray:
        """What :func:`..kernels.time_stepping.touches.run_touches` finds, (n, FOUND).

        ``instants``: (n,), of touch, in steps after one, from 0 to 1.
        """
        starts = self._starts(instants)
        found = np.zeros((len(starts), FOUND))
        if self._located is None:
            run_touches(self._scheme, ONE, starts, self.flight, self._most, self._work, self._nothing, found)
        else:
            for start, row in zip(starts, found, strict=True):
                self._run_located(start, row)
        return found

    def force(self, instant: float, most: int, every: int = 1) -> np.ndarray:
        """The force after each step, or each so many, until the bodies part, from that before touch on, (n,).

        ``most``: steps that are followed. The forces are those of whose greatest `run` tells.
        """
        start = self._starts(np.array([instant]))[0]
        if self._located is not None:
            return self._follow_located(start)[1][: most + 1 : every, 4].copy()
        u = np.zeros(linear_step.STATE_ROWS)
        u[1], u[3], u[5] = *start, self.flight
        progress = linear_step.StepProgress(0, False, 0, 0, 0, uncompiled(no_contact)())
        state = linear_step.STATE.pack(linear_step.LinearState(u, progress))
        window, forces = (1, 1, 1), [0.0]
        for stop in range(every, min(most, self._most) + 1, every):
            code = linear_step.integrate_linear(self._scheme, ONE, state, self._work, stop, window, self._nothing)
            u, at = linear_step.STATE.read(state)
            forces.append(float(u[linear_step.FORCE]))
            if code != OK or (at.step > 1 and at.status == 0 and not at.pressed and u[3] > 0.0):
                break
        return np.array(forces)

    def _starts(self, instants: np.ndarray) -> np.ndarray:
        """Gap and its rate at the last step before each touch, (n, 2)."""
        t = instants * self.step
        starts = np.empty((len(t), 2))
        starts[:, 0], starts[:, 1] = t + 0.5 * self.flight * t * t, -(1.0 + self.flight * t)
        return starts

    def _run_located(self, start: np.ndarray, row: np.ndarray) -> None:
        """One contact whose steps are cut where it changes: over when the gap opens."""
        now, samples, over, code = self._follow_located(start)
        row[SPEED], row[GAP], row[STEPS] = now[[_U, _G, _STEP]]
        row[DEPTH] = max(0.0, (samples[:, 0] - samples[:, 2]).max())
        row[PUSH], row[touches.PULL] = max(0.0, samples[:, 4].max()), min(0.0, samples[:, 4].min())
        row[CODE] = PARTED if over else BLOWN_UP if code == DIVERGED else STUCK

    def _follow_located(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, int]:
        """The packed state after the contact, a sample of each step, (n, 5), whether it is over, and how it ended."""
        state, buffers, window = self._begun.copy(), self._buffers, (0, 0, 1)
        state[[_G, _U]], buffers.views.used[:] = start, 0
        run = self._located, self._forces, state, self._most, MOST_SOLVES, window
        code = located.integrate_located(*run, buffers.flat, buffers.sizes)
        samples = buffers.views.samples[: int(state[_STEP]) + 1]
        return state, samples, buffers.views.used[1] > 0, code


def touches_alone(method: Method, e: float, push: float) -> Callable[[float], Touches]:
    """Makes the contacts alone with a step Δτ; arguments as those of :func:`parameters_alone`."""
    return partial(_touches_with, parameters_alone(method, e, push=push), method)


def _touches_with(p: Parameters, method: Method, step: float) -> Touches:
    return Touches(_with_step(p, step), method, step)


def located_start(flight: float) -> np.ndarray:
    """The packed state of located steps without contact, but for gap and rate."""
    nothing = located.STATE.read(located.STATE.zeros())
    free = {"b": flight, "piece": located.FREE, "contact": uncompiled(no_contact)()}
    return located.STATE.pack(nothing._replace(**free))
