"""Driver of Newmark's method with its step cut at each contact change."""

import math

import numpy as np

from ..kernels.compile.record import Folded
from ..kernels.compile.record import Record as Buffers
from ..kernels.time_stepping import located as kernel
from ..kernels.time_stepping.contact_location import Law, accelerations
from ..methods import Newmark
from ..model import System
from ..result import Checkpoint, Cost, Status
from .stepping import SteppedDriver

SOLVES_PER_CALL = 2_000_000


def pack(system: System, eta: float, method: Newmark) -> Law:
    """Coefficients of the equations (:mod:`engine.kernels.time_stepping.contact_location`)."""
    period = 2 * math.pi / eta
    both = 1 + 1 / system.mass_ratio
    # the relative motion in contact, e^{−rτ}: r² − 2D(1 + 1/μ) r + K(1 + 1/μ) = 0; modulus of the faster r
    decay, square = method.damping * both, method.stiffness * both
    rate = decay + math.sqrt(decay * decay - square) if decay * decay > square else math.sqrt(square)
    fastest, h = max(1.0, system.kappa, eta), period / method.steps
    return Law(
        load=eta * eta,
        damping1=2 * system.d1,
        stiffness1=1.0,
        damping2=2 * system.d2 * system.kappa,
        stiffness2=system.kappa**2,
        both=both,
        stiffness=method.stiffness,
        damper=method.damping,
        eta=eta,
        h=h,
        steps=method.steps,
        first=h * fastest / rate,
        growth=h * fastest / math.pi,
    )


class LocatedDriver(SteppedDriver):
    """One run of Newmark's method that lands on the contact changes."""

    def begin(self, start: Checkpoint) -> None:
        self._law = pack(*self.run)
        self._cosines = self._cosines_of_steps()
        self._state = _state(self._law, start, self.kept_from == 0)
        self._started = self._state[kernel.SOLVES]
        if not getattr(kernel.march, "signatures", True):  # compile or load outside the measured seconds
            kernel.march(self._law, self._cosines, self._state.copy(), 0, 0, self._window, self._nothing.views)

    def periods_per_call(self) -> int:
        return max(1, SOLVES_PER_CALL // self._method.steps)

    def march(self, stop: int, record: Folded) -> tuple[Status, bool]:
        last = stop * self._method.steps
        code = kernel.march(self._law, self._cosines, self._state, last, SOLVES_PER_CALL, self._window, record.views)
        ends = {kernel.DIVERGED: Status.DIVERGED, kernel.CROWDED: Status.UNRESOLVED}
        return ends.get(code, Status.OK), code == kernel.PAUSED

    def explain(self, status: Status) -> str:
        step, n = int(self._state[kernel.STEP]), self._method.steps
        where = f"step {step} (period {step / n:.2f})"
        if status is Status.DIVERGED:
            return self._blown_up(where, kernel.LIMIT)
        return (
            f"more than {kernel.SOLVES_PER_STEP:,} solves within {where}: contacts follow each other far faster than "
            "the excitation; take a smaller K, or a D that ends them"
        )

    def close_open_contact(self, record: Buffers) -> None:
        state = self._state
        now = state[kernel.STEP] * self._law.h + state[kernel.OFFSET]
        if state[kernel.CONTACT] > 0.0 and state[kernel.STEP] > self._window[0]:
            kernel.close_contact(state, now, kernel.motion_of(state), record)

    def section_rows_done(self) -> int:
        return max(0, (int(self._state[kernel.STEP]) - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=int(self._state[kernel.SOLVES] - self._started))


def _state(law: Law, start: Checkpoint, kept: bool) -> np.ndarray:
    state = np.zeros(kernel.SLOTS)
    if len(start.state) == kernel.SLOTS:
        state[:] = start.state
        return state
    x, v, x2, v2 = start.state
    motion = accelerations(law, False, (x, v, 0.0, x2 - x, v2 - v, 0.0), 1.0)
    *_, g, u, b = motion
    # at zero gap the first derivative of the free motion that is not zero decides; cos ητ has no part in the third
    *_, jerk = accelerations(law, False, (v, motion[2], 0.0, u, b, 0.0), 0.0)
    contact = next((value < 0 for value in (g, u, b, jerk) if value != 0), True)
    motion = accelerations(law, contact, motion, 1.0)
    state[[kernel.X, kernel.V, kernel.A, kernel.G, kernel.U, kernel.B]] = motion
    state[kernel.CONTACT] = float(contact)
    kernel.open_contact(state, 0.0, motion, kept and contact and g == 0)
    return state
