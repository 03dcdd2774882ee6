"""Driver of the reference solution."""

import math

import numpy as np

from ..kernels import reference as kernel
from ..kernels.modes import make_ladder
from ..kernels.pendulums import Pendulums
from ..kernels.record import Record as Buffers
from ..methods import Reference
from ..model import System
from ..result import Checkpoint, Cost, Record, Status
from .base import Driver

PERIODS_PER_CALL = 2000
_STATUS = {kernel.PILED_UP: Status.PILED_UP, kernel.UNRESOLVED: Status.UNRESOLVED}


def pack(system: System, eta: float, method: Reference) -> Pendulums:
    """Poles, steady amplitudes and contact law as the kernels want them."""
    frequencies = 1.0, system.kappa, system.kappa3
    ratios = system.d1, system.d2, system.joint_damping(method.joint_damping)
    poles = [complex(-d * k, k * math.sqrt(1 - d * d)) for k, d in zip(frequencies, ratios, strict=True)]
    steady = [eta**2 / complex(k * k - eta**2, 2 * d * k * eta) for k, d in zip(frequencies, ratios, strict=True)]
    share = system.mass_share
    return Pendulums(
        2 * math.pi / eta,
        complex(0.0, eta),
        *poles,
        *steady,
        mass_share=share,
        force_position=share * (system.kappa**2 - 1),
        force_velocity=share * 2 * (system.d2 * system.kappa - system.d1),
        restitution=system.restitution,
        threshold=method.threshold,
    )


class ReferenceDriver(Driver):
    """One run of the reference."""

    def __init__(
        self,
        system: System,
        eta: float,
        method: Reference,
        start: Checkpoint,
        keep: int,
        kept_from: int,
        record: Record | None,
    ):
        phases = record.phases(record.steps or record.per_period) if record else np.zeros(1)
        self.run = system, eta, method
        super().__init__(eta, start.periods, keep, kept_from, phases, record.periods if record else 0)
        self._packed = p = pack(system, eta, method)
        self._ladder = make_ladder((p.pole1, p.pole2, p.forcing_pole), (p.pole3, p.pole3, p.forcing_pole))
        self._events = self._evaluations = 0
        self._window = (float(kept_from), float(self.sampled_from))
        self._anchor = _anchor(self._packed, start)
        if not getattr(kernel.march, "signatures", True):  # compile, or load, outside the measured seconds
            self._march(start.periods - 1, self._nothing)

    def periods_per_call(self) -> int:
        return PERIODS_PER_CALL

    def march(self, stop: int, record: Buffers) -> tuple[Status, bool]:
        self._anchor, code, events, evaluations = self._march(stop, record)
        self._events += events
        self._evaluations += evaluations
        return _STATUS.get(code, Status.OK), code == kernel.FULL

    def _march(self, stop: int, record: Buffers) -> tuple[kernel.Anchor, int, int, int]:
        return kernel.march(self._packed, self._ladder, self._anchor, float(stop), self._window, record)

    def explain(self, status: Status) -> str:
        period = int(self._anchor.period) + 1
        if status is Status.UNRESOLVED:
            return (
                f"the next event in period {period} cannot be told from rounding: this is the resonance of an almost "
                "undamped pendulum; move eta away from it or give more damping"
            )
        return (
            f"over {kernel.MOST_EVENTS} impacts and contacts in period {period}: the chatter does not end; "
            "take a larger threshold or a smaller restitution"
        )

    def close_open_contact(self, record: Buffers) -> None:
        if self._anchor.mode == kernel.JOINED and self.periods > self.kept_from:
            begin = kernel.clock(self._packed, self._anchor)
            record.contacts[0] = begin, self.periods * self.period
            record.used[1] = 1

    def section_rows_done(self) -> int:
        return max(0, self.periods - self.kept_from)

    def cost(self) -> Cost:
        return Cost(self.seconds, events=self._events, evaluations=self._evaluations)

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._anchor))


def _anchor(packed: Pendulums, start: Checkpoint) -> kernel.Anchor:
    if len(start.state) == len(kernel.Anchor._fields):
        return kernel.Anchor(*start.state)
    x1, v1, x2, v2 = start.state
    if x2 < x1:
        raise ValueError(
            f"initial gap ξ₂ − ξ₁ = {x2 - x1:g} is negative: the reference knows no penetration, start with ξ₂ ≥ ξ₁"
        )
    return kernel.Anchor(*kernel.prepare(packed, x1, v1, x2 - x1, v2 - v1))
