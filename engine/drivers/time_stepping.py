"""Driver of one-step methods whose step is a matrix for each contact status."""

from collections.abc import Callable

import numpy as np
from vibroscope.engine.drivers.base import CAPACITY, SteppingDriver
from vibroscope.engine.drivers.newmark import has_strides
from vibroscope.engine.drivers.skip_tables import skip_tables
from vibroscope.engine.drivers.step_maps import bodies_of, felt_late, is_stable, stage_maps
from vibroscope.engine.facts import Choice, Ending, equation, stated
from vibroscope.engine.kernels.accelerated import matrix_skip
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import Buffers, PackedBuffers, make_buffers, no_contact
from vibroscope.engine.kernels.equations.contact_law import CONSTANT, CUT, KELVIN_VOIGT, gain_at, law_force
from vibroscope.engine.kernels.equations.motion import (
    accelerations,
    coefficients,
    contact_coordinates,
    displacements,
    free_rate,
)
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.status import FULL
from vibroscope.engine.kernels.time_stepping import linear_step as kernel
from vibroscope.engine.kernels.time_stepping.newmark import FAR_FROM_STOP, LIMIT, begin_contact, end_contact, scheme_of
from vibroscope.engine.methods import WITHOUT_SOLUTION, TimeStepping
from vibroscope.engine.result import Checkpoint, Status


def as_steps_see(p: Parameters) -> Parameters:
    """The parameters with the law that steps solve for: Eq. (20) with n = 1 is Eq. (5), with which a step is linear."""
    same = p.law == CONSTANT and p.exponent == 1.0
    return p._replace(law=float(KELVIN_VOIGT), damping=0.5 * p.gain) if same else p


def linear_scheme(p: Parameters, method: TimeStepping) -> kernel.LinearScheme:
    """The matrices of a method, and of its parts of steps if it may cut them."""
    bodies, system = bodies_of(p), uncompiled(scheme_of)(p)
    system = system._replace(late=felt_late(method.integrator), reach=min(FAR_FROM_STOP * p.play, LIMIT))
    levels = range(kernel.HALVINGS + 1 if method.without_solution == "halve" else 1)
    maps = np.array([stage_maps(bodies, method.integrator, system.h / 2**level) for level in levels])
    weights = [stage.weight for stage in method.integrator.stages]
    return kernel.LinearScheme(
        maps,
        (weights[0], float(sum(weights[1:]))),
        method.status == "end" or method.integrator.explicit,
        WITHOUT_SOLUTION.index(method.without_solution),
        bodies.load_rate * system.h,
        system,
    )


class TimeSteppingDriver(SteppingDriver):
    """One run of :class:`engine.TimeStepping`."""

    layout = kernel.STATE
    solves_per_call = 1_000_000

    def tables_of(self, p: Parameters) -> dict:
        method, p = self.method, as_steps_see(p)
        scheme = linear_scheme(p, method)
        skips = p.pulse < 0.0 and not method.every_step
        skips = skips and has_strides(p.eta, uncompiled(free_rate)(p), method.steps)
        return {
            "_parameters": p,
            "_bodies": bodies_of(p),
            "_scheme": scheme,
            "_linear": p.law <= CUT,
            "_angles": np.ascontiguousarray(self.load[:, :-1]),
            "_work": np.zeros((matrix_skip.WORK_ROWS, kernel.WORK)),
            "_tables": skip_tables(scheme, p) if skips else None,
        }

    def turned(self, other: dict, begins: bool) -> np.ndarray:
        n, (u, at) = other["_scheme"].system, kernel.STATE.read(self._state)
        u = -u
        u[1] += self._parameters.play
        pressed, contact = bool(u[1] <= 0.0), at.contact
        if pressed:  # within one step across the play: the speed at its end stands for the mean over the step
            motion = uncompiled(displacements)(n, u[0], u[2], u[1], u[3])
            contact = begin_contact(n, at.step, motion, -u[3] if begins else 0.0)
        at = at._replace(status=int(pressed), pressed=pressed, contact=contact)
        return kernel.STATE.pack(kernel.LinearState(u, at))

    def start_state(self, start: Checkpoint) -> np.ndarray:
        m, p = self._scheme.system, self._parameters
        x1, v1, gap, rate = uncompiled(contact_coordinates)(m, *start.state)
        pressed = gap <= 0.0
        closing = max(-rate, 0.0) if gap == 0.0 else 0.0
        gain = uncompiled(gain_at)(m.law, closing)
        push = uncompiled(law_force)(m.law, gain, -gap, -rate) if pressed else 0.0
        x, v2 = x1 - m.rest1, v1 + rate
        x2 = m.touch + gap + x
        a1, a2 = uncompiled(accelerations)(uncompiled(coefficients)(p), x, v1, x2, v2, push, *self.load[:, 0])
        if self.method.initial_acceleration == "zero":
            a1 = a2 = 0.0
        u = np.array([x1, gap, v1, rate, a1, a2 - a1, push])
        contact = uncompiled(no_contact)()._replace(speed1=m.sign * closing)  # only the difference of speeds is used
        progress = kernel.StepProgress(int(pressed), pressed, 0, 0, 0, contact)
        return kernel.STATE.pack(kernel.LinearState(u, progress))

    @property
    def _now(self) -> kernel.StepProgress:
        return kernel.STATE.read(self._state).progress

    @property
    def loop(self) -> Callable:
        return kernel.integrate_linear if self._tables is None else matrix_skip.integrate_skipping

    def call(self, last: int, buffers: PackedBuffers) -> int:
        arrays = self._angles, self._state, self._work, last, self._window, buffers.views
        if self._tables is None:
            return kernel.integrate_linear(self._scheme, *arrays)
        return matrix_skip.integrate_skipping(self._scheme, self._tables, *arrays)

    def explain(self, status: Status) -> Ending:
        if status is Status.WITHOUT_SOLUTION:
            return self._explain_no_solution()
        return self.explain_divergence(self._now.step, self._explain_instability())

    def _explain_no_solution(self) -> Ending:
        method, step, damping = self.method, self._now.step, self._scheme.system.law.gain / 2
        cut = f", even in {kernel.PARTS} parts," if method.without_solution == "halve" else ""
        others = tuple(name for name in WITHOUT_SOLUTION[1:] if name != method.without_solution)
        advice = stated(
            "take a smaller {}, other steps per period than {}, or {}",
            equation("D", damping, relation=" than "),
            str(method.steps),
            Choice("without_solution", others, f"without_solution = {' or '.join(map(repr, others))}"),
        )
        return Ending(
            f"step {step + 1} (period {step // method.steps + 1}){cut} has no solution",
            "with contact it ends open, without contact it ends closed, because the damper's force jumps where the "
            "bodies touch",
            advice,
        )

    def _explain_instability(self) -> str:
        """The step that the method needs to be stable, in words; "" if it is stable."""
        method, period, stops = self.method, self.period, [stop["_bodies"] for stop in self._stops]
        if method.integrator.always_unstable:
            return "the method amplifies with every step, since gamma is below 1/2"
        where = {0: "without contact", 1: "in contact"}

        def unstable(n):
            known = where if self._linear else (0,)  # in contact by another law it depends on the penetration
            return [s for s in known if not all(is_stable(b, method.integrator, period / n, s) for b in stops)]

        found = unstable(method.steps)
        if not found:
            return ""
        low, high = method.steps, 2 * method.steps
        while unstable(high):
            low, high = high, 2 * high
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if unstable(middle) else (low, middle)
        return f"the method is unstable {where[found[-1]]} with fewer than {high} steps per period"

    def record_open_contact(self, buffers: Buffers) -> None:
        now, last, kept_from = self._now, self._steps_done(), int(self._window[0])
        if last <= kept_from or not (now.pressed or now.step < last):
            return
        spare = make_buffers(len(buffers.section), buffers.phases, 0, CAPACITY)  # the rows are written already
        for stop, views in ((kept_from, self._no_buffers.views), (last, spare.views)):  # what a skip has left
            arrays = self._angles, self._state, self._work, stop, self._window, views
            while kernel.integrate_linear(self._scheme, *arrays) == FULL:
                self._collect(views)
        u, now = kernel.STATE.read(self._state)
        if now.pressed:
            motion = uncompiled(displacements)(self._scheme.system, u[0], u[2], u[1], u[3])
            end_contact(self._scheme.system, now.contact, now.step, motion, 0.0, spare.views)
        self._collect(spare.views)

    def results(self) -> dict:
        now = self._now
        return super().results() | {"steps_without_solution": now.none, "steps_with_two": now.two}
