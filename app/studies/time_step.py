"""The time-step study, growing: first with few steps, which takes little time, then with many. No panel import."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from vibroscope.engine import System, sweep_step

if TYPE_CHECKING:
    import xarray

STEPS = (500, 1000, 2000, 4000, 6000, 8000, 16_000, 32_000)  # the paper's Figure 14 has 2,000 to 8,000
_STAGES = (3, 6, len(STEPS))  # so many of them
TRANSIENT, SAMPLE = 2000, 50
SCHEMES = ("fixed", "located")


class TimeStep(NamedTuple):
    """What is asked."""

    system: System
    eta: float
    K: float
    D: float


@dataclass(frozen=True, eq=False)
class TimeStepStage:
    """The study of the first of `STEPS`, as `engine.sweep_step` returns it."""

    question: TimeStep
    found: xarray.Dataset

    @property
    def steps(self) -> np.ndarray:
        """n, ascending."""
        return self.found["steps"].values

    @property
    def share(self) -> float:
        """Of all steps of the study."""
        return float(self.steps.sum() / sum(STEPS))

    def sizes(self, name: str, scheme: str) -> np.ndarray:
        """``spread``, ``error`` or ``error_time_step`` over n."""
        return self.found[name].values[:, SCHEMES.index(scheme)]

    def order(self, name: str, scheme: str) -> tuple[float, float]:
        """Observed order of ``spread`` or ``error_time_step``, and its standard error."""
        place = SCHEMES.index(scheme)
        return tuple(float(self.found[f"order_of_{name}{end}"].values[place]) for end in ("", "_error"))

    def data(self) -> dict[str, object]:
        """What is known, for a file: the variables as `engine.sweep_step` names them."""
        asked = {"eta": self.question.eta, "K": self.question.K, "D": self.question.D, "steps": self.steps}
        return asked | {name: column.values for name, column in self.found.data_vars.items()}

    def nearest(self, steps: float) -> int:
        """Index of the n of the study that is nearest, by ratio."""
        return int(np.argmin(np.abs(np.log(self.steps / steps))))

    def orbit(self, index: int, scheme: str) -> dict[str, np.ndarray]:
        """ξ₂ and ξ₂′ over the periods that follow the sample."""
        return {name: self.found[name].values[index, SCHEMES.index(scheme)] for name in ("xi2", "v2")}

    def section(self, index: int, scheme: str) -> dict[str, np.ndarray]:
        """ξ₂ and ξ₂′ at τ ≡ 0 mod T over the sample."""
        return {name: self.found[f"{name}_section"].values[index, SCHEMES.index(scheme)] for name in ("xi2", "v2")}


def refine_step(
    question: TimeStep, last: TimeStepStage | None, cancelled: Callable[[], bool]
) -> Iterator[TimeStepStage]:
    """Stages of the study, from ``last`` on; each is kept on disk too. Raises `Cancelled`."""
    if last is not None:
        yield last
    done = 0 if last is None else len(last.steps)
    for count in _STAGES:
        if count > done:
            how = {"transient": TRANSIENT, "sample": SAMPLE, "keep": True, "cancelled": cancelled}
            found = sweep_step(question.system, question.eta, question.K, question.D, STEPS[:count], **how)
            yield TimeStepStage(question, found)
