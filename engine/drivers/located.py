"""Driver of one-step methods with their step cut at each contact change."""

import numpy as np

from ..facts import Ending
from ..integrators import Integrator, NewmarkBeta
from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers
from ..kernels.equations.contact_law import CONSTANT, KELVIN_VOIGT, LAWS
from ..kernels.equations.motion import coefficients
from ..kernels.parameters import Parameters
from ..kernels.status import PAUSED, STATUSES
from ..kernels.time_stepping import law_pieces, law_step, located_law
from ..kernels.time_stepping import located as kernel
from ..kernels.time_stepping.contact_location import SCHEME, Stages, forcing_with
from ..methods import Newmark, TimeStepping
from ..result import Checkpoint, Cost, Status
from .base import is_first_use
from .stepping import SteppingDriver
from .time_stepping import parameters_of_steps


def stages_of(integrator: Integrator, p: Parameters) -> Stages:
    """The stages of an integrator for compiled code, at most two."""
    c, numbers = uncompiled(coefficients)(p), []
    for stage in integrator.stages:
        pairs = (*stage.velocities, 0.0)[:2], (*stage.accelerations, 0.0)[:2], (*stage.rates, 0.0)[:2]
        d, e, f = pairs
        numbers.append((stage.end, *d, *e, stage.beta, *f, stage.gamma, stage.alpha_m, stage.alpha_f))
    numbers = tuple(tuple(map(float, row)) for row in (*numbers, numbers[0])[:2])
    kind = integrator.averaged, integrator.explicit
    return Stages(len(integrator.stages), *kind, float(c.react1), float(c.inverse_mass), numbers)


class LocatedDriver(SteppingDriver):
    """One run of a one-step method with located contact changes."""

    solves_per_call = 2_000_000

    def begin(self, start: Checkpoint) -> None:
        method, p = self._method, parameters_of_steps(*self.run)
        self._scheme, integrator = kernel.located_scheme(p), NewmarkBeta()
        if method.has_choices:
            integrator = method.integrator
            self.solution = f"the solution by {integrator.short_title()}"
            self._scheme = self._scheme._replace(stages=stages_of(integrator, p), shortest_step=self._scheme.h)
        self._prepare(p, integrator)
        if len(start.state) > len(self.run[0].rest):
            self._state = np.array(start.state)
        else:
            state = kernel.start_state(self._scheme, start.state, self.kept_from == 0)
            self._state = self._packed_start(state, method.initial_acceleration == "zero")
        self._started = self._now.solves
        if is_first_use(self._kernel):  # compile or load outside the measured seconds
            state, self._state = self._state, self._state.copy()
            self._call(0, 0, self._no_buffers)
            self._state = state

    def _prepare(self, p: Parameters, integrator: Integrator) -> None:
        """Make what the kernel needs beside the scheme."""
        self._packed, self._forces = SCHEME.pack(self._scheme), self.forces_of_steps()

    def _packed_start(self, state: kernel.LocatedState, at_rest: bool) -> np.ndarray:
        """The discrete solution at τ = 0; ``at_rest``: without acceleration."""
        return kernel.STATE.pack(state._replace(a=0.0, b=0.0) if at_rest else state)

    def forces_of_steps(self) -> np.ndarray:
        """f₁ and f at the beginning of each step of a period, and at the end of the last, (n + 1, 2)."""
        angle = self.angles_of_steps()
        return np.column_stack(uncompiled(forcing_with)(self._scheme, np.cos(angle), np.sin(angle)))

    @property
    def _now(self) -> kernel.LocatedState:
        return kernel.STATE.read(self._state)

    _kernel = staticmethod(kernel.integrate_located)

    def _call(self, last: int, most: int, buffers: PackedBuffers) -> int:
        arrays = self._forces, self._state, last, most, self._window, buffers.flat, buffers.sizes
        return self._kernel(self._packed, *arrays)

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code = self._call(stop * self._method.steps, self.solves_per_call, buffers)
        again = code == PAUSED
        return Status.OK if again else STATUSES[code], again

    def explain(self, status: Status) -> Ending:
        step, n = self._now.step, self._method.steps
        if status is Status.DIVERGED:
            return self.explain_divergence(step)
        return Ending(
            f"more than {kernel.SOLVES_PER_STEP:,} solves within step {step} (period {step / n:.2f})",
            "contacts follow each other far faster than the excitation",
            "take a smaller K, or a D that ends them",
        )

    def record_open_contact(self, buffers: Buffers) -> None:
        now = self._now
        if now.pressed and now.step > self._window[0]:
            time = now.step * self._scheme.h + now.offset
            kernel.end_contact(self._scheme, now.contact, time, uncompiled(kernel.motion_of)(now), buffers)

    def section_rows_done(self) -> int:
        return max(0, (self._now.step - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self._now.solves - self._started)


class LocatedLawDriver(LocatedDriver):
    """A run with located steps and another contact law than spring and damper."""

    def _prepare(self, p: Parameters, integrator: Integrator) -> None:
        m = self._scheme._replace(stages=stages_of(integrator, p))
        self._law = law_step.LawScheme(m, int(p.law), p.stiffness, p.exponent, p.penetration, p.gain, p.relative)

    def _packed_start(self, state: kernel.LocatedState, at_rest: bool) -> np.ndarray:
        m, pressed = self._law, state.pressed
        z = uncompiled(kernel.motion_of)(state)
        closing = max(-state.u, 0.0) if state.g == 0.0 else 0.0  # of a contact that was open before, nothing is known
        contact = state.contact._replace(speed2=state.contact.speed1 - closing)
        gain = uncompiled(law_step.gain_of)(m, contact)
        if at_rest:
            a, b = 0.0, 0.0
        else:
            forcing = uncompiled(forcing_with)(m.located, 1.0, 0.0)
            _, _, a, _, _, b = law_step.with_law_accelerations(m, gain, pressed, z, forcing)
        piece = law_pieces.piece_at(m, gain, z) if pressed else law_pieces.FREE
        return located_law.STATE.pack(located_law.LawState(state._replace(a=a, b=b, contact=contact), piece))

    @property
    def _now(self) -> kernel.LocatedState:
        return located_law.STATE.read(self._state).located

    _kernel = staticmethod(located_law.integrate_located_law)

    def _call(self, last: int, most: int, buffers: PackedBuffers) -> int:
        return self._kernel(self._law, self._state, last, most, self._window, buffers.views)


def located_driver(method: Newmark | TimeStepping) -> type[LocatedDriver]:
    """The driver of a method with located steps."""
    same = method.law == LAWS[CONSTANT] and method.spring_exponent == 1.0  # Eq. (20) with n = 1 is Eq. (5)
    return LocatedDriver if same or method.law == LAWS[KELVIN_VOIGT] else LocatedLawDriver
