"""Driver of one-step methods with their step cut at each contact change."""

import numpy as np

from ..integrators import Integrator, NewmarkBeta
from ..kernels.accelerated import located_skip
from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers
from ..kernels.equations.motion import coefficients
from ..kernels.equations.rates import free_rate
from ..kernels.parameters import Parameters
from ..kernels.status import PAUSED, STATUSES
from ..kernels.time_stepping import located as kernel
from ..kernels.time_stepping.contact_location import Stages, forcing_with
from ..kernels.time_stepping.linear_step import COLUMNS
from ..methods import TimeStepping
from ..result import Checkpoint, Cost, Status
from .newmark import has_strides
from .parameters import parameters_of
from .skip_tables import LocatedTables
from .stepping import SteppingDriver

MANY_STEPS = 1000  # a period from which tables are worth their making, for Newmark's method, whose steps take no time


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
        method, p = self._method, parameters_of(*self.run)
        self._scheme, integrator = kernel.located_scheme(p), NewmarkBeta()
        if isinstance(method, TimeStepping):
            integrator = method.integrator
            self.solution = f"the solution by {integrator.name}"
            self._scheme = self._scheme._replace(stages=stages_of(integrator, p), shortest_step=self._scheme.h)
        self._forces, angle = self.forces_of_steps(), self.angles_of_steps()[:-1]
        self._tables = None
        if self._can_skip(p):
            angles = np.array([np.cos(angle), np.sin(angle)])
            self._tables = LocatedTables(self._scheme, p, integrator)
            work = np.zeros((5, COLUMNS))
            self._skips = located_skip.LocatedSkips(self._tables.arrays, p.free_position, angles, work)
        if len(start.state) == kernel.STATE.size:
            self._state = np.array(start.state)
        else:
            state = kernel.start_state(self._scheme, start.state, self.kept_from == 0)
            if getattr(method, "initial_acceleration", "") == "zero":
                state = state._replace(a=0.0, b=0.0)
            self._state = kernel.STATE.pack(state)
        self._started = self._now.solves
        if not getattr(self._kernel, "signatures", True):  # compile or load outside the measured seconds
            state, self._state = self._state, self._state.copy()
            self._call(0, 0, self._no_buffers)
            self._state = state

    def _can_skip(self, p: Parameters) -> bool:
        method = self._method
        enough = isinstance(method, TimeStepping) or method.steps >= MANY_STEPS
        return enough and not method.every_step and has_strides(p.eta, uncompiled(free_rate)(p), method.steps)

    def forces_of_steps(self) -> np.ndarray:
        """f₁ and f at the beginning of each step of a period, and at the end of the last, (n + 1, 2)."""
        angle = self.angles_of_steps()
        return np.column_stack(uncompiled(forcing_with)(self._scheme, np.cos(angle), np.sin(angle)))

    @property
    def _now(self) -> kernel.LocatedState:
        return kernel.STATE.read(self._state)

    @property
    def _kernel(self):
        return kernel.integrate_located if self._tables is None else located_skip.integrate_skipping

    def prepare(self) -> None:
        if self._tables is not None:
            self._tables.make_asked()

    def _call(self, last: int, most: int, buffers: PackedBuffers) -> int:
        if self._tables is None:
            return self._take_every_step(last, most, buffers)
        arrays = self._forces, self._state, last, most, self._window, buffers.views
        return located_skip.integrate_skipping(self._scheme, self._skips, *arrays)

    def _take_every_step(self, last: int, most: int, buffers: PackedBuffers) -> int:
        arrays = self._forces, self._state, last, most, self._window, buffers.views
        return kernel.integrate_located(self._scheme, *arrays)

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code = self._call(stop * self._method.steps, self.solves_per_call, buffers)
        again = code == PAUSED
        return Status.OK if again else STATUSES[code], again

    def explain(self, status: Status) -> str:
        step, n = self._now.step, self._method.steps
        if status is Status.DIVERGED:
            return self.explain_divergence(step)
        return (
            f"more than {kernel.SOLVES_PER_STEP:,} solves within step {step} (period {step / n:.2f}): contacts follow "
            "each other far faster than the excitation; take a smaller K, or a D that ends them"
        )

    def results(self) -> dict:
        last = self.periods * self._method.steps
        while self._now.step < last and self._take_every_step(last, self.solves_per_call, self._no_buffers) == PAUSED:
            pass  # a skip stops short of where a run is cut
        return super().results()

    def record_open_contact(self, buffers: Buffers) -> None:
        now = self._now
        if now.pressed and now.step > self._window[0]:
            time = now.step * self._scheme.h + now.offset
            kernel.end_contact(self._scheme, now.contact, time, uncompiled(kernel.motion_of)(now), buffers)

    def section_rows_done(self) -> int:
        return max(0, (self._now.step - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self._now.solves - self._started)
