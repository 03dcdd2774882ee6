"""Driver of one-step methods with their step cut at each contact change."""

from collections.abc import Callable

import numpy as np
from vibroscope.engine.drivers.base import SteppingDriver
from vibroscope.engine.drivers.parameters import at_start
from vibroscope.engine.drivers.step_maps import bodies_of, stages_of
from vibroscope.engine.drivers.time_stepping import as_steps_see
from vibroscope.engine.facts import Ending
from vibroscope.engine.integrators import NewmarkBeta
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import Buffers, PackedBuffers
from vibroscope.engine.kernels.equations.contact_law import KELVIN_VOIGT
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.time_stepping import located as kernel
from vibroscope.engine.kernels.time_stepping.contact_location import SCHEME, LocatedScheme
from vibroscope.engine.kernels.time_stepping.stage import forcing_with
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.result import Checkpoint, Status


def scheme_of_run(p: Parameters, method: TimeStepping) -> LocatedScheme:
    """The scheme of a method."""
    stages = stages_of(method.integrator, bodies_of(p).reaction)
    if method.integrator == NewmarkBeta() and p.law == KELVIN_VOIGT:
        stages = stages._replace(count=0)
    return kernel.located_scheme(p, stages, method.resolves_contacts)


class LocatedDriver(SteppingDriver):
    """One run of a one-step method with located contact changes."""

    layout = kernel.STATE
    solves_per_call = 2_000_000

    def tables_of(self, p: Parameters) -> dict:
        p = as_steps_see(p)
        scheme = scheme_of_run(p, self.method)
        return {
            "_parameters": p,
            "_scheme": scheme,
            "_packed": SCHEME.pack(scheme),
            "_forces": self.forces_of_steps(scheme),
            "_play": p.play,
        }

    def turned(self, other: dict, begins: bool) -> np.ndarray:
        s = self._now
        return self.layout.pack(s._replace(x=-s.x, v=-s.v, a=-s.a, g=self._play - s.g, u=-s.u, b=-s.b))

    def start_state(self, start: Checkpoint) -> np.ndarray:
        at_rest = self.method.initial_acceleration == "zero"
        scheme = scheme_of_run(at_start(self._parameters, self.load[0, 0]), self.method)
        return self.layout.pack(kernel.start_state(scheme, tuple(start.state), self.kept_from == 0, at_rest))

    def forces_of_steps(self, scheme: LocatedScheme) -> np.ndarray:
        """f₁ and f at the beginning of each step of a period, and at the end of the last, (n + 1, 2)."""
        return np.column_stack(uncompiled(forcing_with)(scheme.forcing, *self.load))

    @property
    def loop(self) -> Callable:
        return kernel.integrate_located

    def call(self, last: int, buffers: PackedBuffers) -> int:
        arrays = self._forces, self._state, last, self.solves_per_call, self._window, buffers.flat, buffers.sizes
        return kernel.integrate_located(self._packed, *arrays)

    def explain(self, status: Status) -> Ending:
        if status is Status.DIVERGED:
            return super().explain(status)
        step, n = self._now.step, self.method.steps
        return Ending(
            f"more than {kernel.SOLVES_PER_STEP:,} solves within step {step} (period {step / n:.2f})",
            "contacts follow each other far faster than the excitation",
            "take a smaller K, or a D that ends them",
        )

    def record_open_contact(self, buffers: Buffers) -> None:
        now = self._now
        if now.piece != kernel.FREE and now.step > self._window[0]:
            time = now.step * self._scheme.h + now.offset
            kernel.end_contact(self._scheme, now.contact, time, uncompiled(kernel.motion_of)(now), buffers)

    def steps_taken(self) -> int:
        return self._now.solves
