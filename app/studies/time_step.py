"""The time-step study while it grows: first few steps, which take little time, then many. No panel import."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import Newmark, System
from vibroscope.engine.sweeps import MISSING, SCHEMES, RunOptions, StepStudy, grow_cached

STEPS = (500, 1000, 2000, 4000, 6000, 8000, 16_000, 32_000)  # the paper's Figure 14 has 2,000 to 8,000
STEPS_AT_ONCE = 3  # from one partial result to the next
TRANSIENT, SAMPLE = 2000, 50


class StepQuestion(NamedTuple):
    """A time-step study to compute."""

    system: System
    eta: float
    K: float
    D: float

    def study(self) -> StepStudy:
        """The study that answers it."""
        method = Newmark(self.K, self.D, STEPS[0])
        return StepStudy(self.system, method, self.eta, TRANSIENT, SAMPLE, steps=STEPS)


@dataclass(frozen=True, eq=False)
class PartialStep:
    """A time-step study so far: of the first of `STEPS`, the variables as `engine.sweep_step` names them."""

    question: StepQuestion
    study: StepStudy
    values: dict[str, np.ndarray]

    @property
    def _count(self) -> int:
        """How many numbers of steps are known: they come in ascending order."""
        return int((self.values["status"][:, 0] != MISSING).sum())

    @property
    def steps(self) -> np.ndarray:
        """n, ascending."""
        return self.study.steps[: self._count]

    @property
    def share(self) -> float:
        """Of all steps of the study."""
        return float(self.steps.sum() / self.study.steps.sum())

    def of_scheme(self, name: str, scheme: str) -> np.ndarray:
        """A variable over n with the fixed or the located step, as ``spread``, ``error`` or ``status``."""
        return self.values[name][: self._count, SCHEMES[scheme]]

    def order(self, name: str, scheme: str) -> tuple[float, float]:
        """Observed order of ``spread`` or ``error_time_step``, and its standard error."""
        orders = self.study.conclusions(self.values)
        return tuple(float(orders[f"order_of_{name}{end}"].values[SCHEMES[scheme]]) for end in ("", "_error"))

    def data(self) -> dict[str, object]:
        """What is known, for a file: the variables as `engine.sweep_step` names them."""
        question = {"eta": self.question.eta, "K": self.question.K, "D": self.question.D, "steps": self.steps}
        of_study = {"error_joint_damping": self.study.arrays["error_joint_damping"]}
        of_study |= self.study.conclusions(self.values)
        return (
            question
            | {name: column[: self._count] for name, column in self.values.items()}
            | {name: np.asarray(item.values) for name, item in of_study.items()}
        )

    def nearest(self, steps: float) -> int:
        """Index of the n of the study that is nearest, by ratio."""
        return int(np.argmin(np.abs(np.log(self.steps / steps))))

    def orbit(self, index: int, scheme: str) -> dict[str, np.ndarray]:
        """ξ₂ and ξ₂′ over the periods that follow the sample."""
        return {name: self.of_scheme(name, scheme)[index] for name in ("xi2", "v2")}

    def section(self, index: int, scheme: str) -> dict[str, np.ndarray]:
        """ξ₂ and ξ₂′ at τ ≡ 0 mod T over the sample."""
        return {name: self.of_scheme(f"{name}_section", scheme)[index] for name in ("xi2", "v2")}


def grow_step(question: StepQuestion, last: PartialStep | None, cancelled: Callable[[], bool]) -> Iterator[PartialStep]:
    """Partial results of the study, which is kept on disk; of a complete one the same again. Raises `Cancelled`."""
    if last is not None and last.share == 1:
        yield last
        return
    study = question.study()
    options = RunOptions(threads=current_settings().threads, cells_per_chunk=STEPS_AT_ONCE, cancelled=cancelled)
    for values in grow_cached(study, options):
        yield PartialStep(question, study, values)
