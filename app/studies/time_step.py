"""The time-step study while it grows: first few steps, which take little time, then many. No panel import.

At the end the motions whose sections do not show what they are, are judged (:mod:`engine.sweeps.motion_kinds`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.method_words import scheme_as_dict
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import System, TimeStepping, stiffness_of_step
from vibroscope.engine.arguments import Poll
from vibroscope.engine.sweeps import (
    MISSING,
    SCHEMES,
    CellKind,
    RunOptions,
    StepStudy,
    grow_cached,
    judge_runs,
    kind_words,
)

STEPS = (500, 1000, 2000, 4000, 6000, 8000, 16_000, 32_000)  # the paper's Figure 14 has 2,000 to 8,000
STEPS_AT_ONCE = 4  # from one partial result to the next; the last has half its cost in one run
# Largest n of a motion that is judged although no step can be skipped: more would take long, and scatter is small.
MOST_TAKEN = 4000
TRANSIENT, SAMPLE = 2000, 50


class StepQuestion(NamedTuple):
    """A time-step study to compute."""

    system: System
    eta: float
    method: TimeStepping  # with steps that are not located; how many has no effect
    initial: tuple[float, float, float, float] | None = None  # rest
    stiffness_of_step: float | None = None  # s, where K follows the step: that of the method has no effect then

    def study(self) -> StepStudy:
        """The study that answers it."""
        method = replace(self.method, steps=STEPS[0])
        if self.stiffness_of_step is not None:
            first = stiffness_of_step(self.system, self.eta, STEPS[0], self.stiffness_of_step)
            method = replace(method, stiffness=first)
        own = {"initial": self.initial, "stiffness_of_step": self.stiffness_of_step}
        return StepStudy(self.system, method, self.eta, transient=TRANSIENT, sample=SAMPLE, steps=STEPS, **own)


@dataclass(frozen=True, eq=False)
class PartialStep:
    """A time-step study so far: of the first of `STEPS`, the variables as `engine.StepStudy` names them."""

    question: StepQuestion
    study: StepStudy
    values: dict[str, np.ndarray]
    judged: dict[str, dict[int, tuple[CellKind, int]]] | None = None  # of each scheme: kind and period of motions

    @property
    def _count(self) -> int:
        """How many numbers of steps are known: they come in ascending order."""
        return int((self.values["status"][:, 0] != MISSING).sum())

    @property
    def steps(self) -> np.ndarray:
        """n, ascending."""
        return self.study.steps[: self._count]

    @property
    def stiffness(self) -> np.ndarray | float:
        """K: one for all runs, or, where it follows the step, that of each n."""
        if self.question.stiffness_of_step is None:
            return self.question.method.stiffness
        return self.study.arrays["K"].values[: self._count]

    @property
    def schemes(self) -> tuple[str, ...]:
        """The names in `engine.sweeps.SCHEMES` that apply."""
        return tuple(self.study.schemes)

    @property
    def share(self) -> float:
        """The share of the study that is done, including the judgement of the motions."""
        return float(self.steps.sum() / self.study.steps.sum()) * (1.0 if self.judged is not None else 0.99)

    def of_scheme(self, name: str, scheme: str) -> np.ndarray:
        """A variable over n with the fixed or the located step, as ``spread``, ``error`` or ``status``."""
        return self.values[name][: self._count, SCHEMES[scheme]]

    def words(self, index: int, scheme: str) -> str:
        """The motion in words; until it is judged, by its section."""
        period, near = (int(self.of_scheme(name, scheme)[index]) for name in ("period", "near_period"))
        if period == 1:
            return kind_words(CellKind.PERIODIC, 1)
        kind = (self.judged or {}).get(scheme, {}).get(index)
        return kind_words(*(kind or (CellKind.UNKNOWN, period)), near)

    def order(self, name: str, scheme: str) -> tuple[float, float]:
        """Observed order of ``scatter`` or ``error_time_step``, and its standard error."""
        orders = self.study.conclusions(self.values)
        return tuple(float(orders[f"order_of_{name}{end}"].values[SCHEMES[scheme]]) for end in ("", "_error"))

    def why_none(self, name: str, *schemes: str) -> str:
        """Why ``scatter`` or ``error_time_step`` has no number at any n with these schemes, or all; else empty."""
        schemes = schemes or self.schemes
        if any(np.isfinite(self.of_scheme(name, scheme)).any() for scheme in schemes):
            return ""
        complete = any((self.of_scheme("status", scheme) == 0).any() for scheme in schemes)
        return "the motions do not keep step" if complete else "no run came to its end"

    def data(self) -> dict[str, object]:
        """The results so far, for a file: the variables as `engine.StepStudy` names them."""
        question = question_as_dict(self.question) | {"K": self.stiffness, "steps": self.steps}
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
        """Displacement and velocity of the observed body over the periods that follow the sample."""
        return {name: self.of_scheme(name, scheme)[index] for name in self.study.shown}

    def section(self, index: int, scheme: str) -> dict[str, np.ndarray]:
        """Displacement and velocity at τ ≡ 0 mod T over the sample."""
        return {name: self.of_scheme(f"{name}_section", scheme)[index] for name in self.study.shown}


def question_as_dict(question) -> dict[str, object]:
    """What a study of several steps asks, for a file."""
    method, scale = question.method, question.stiffness_of_step
    found = {"eta": question.eta, "K": method.stiffness, "D": method.damping, "steps": method.steps}
    found |= {"method": scheme_as_dict(method)}
    return found if scale is None else found | {"stiffness_of_step": scale}


def grow_step(question: StepQuestion, last: PartialStep | None, cancelled: Poll) -> Iterator[PartialStep]:
    """Partial results of the study, which is kept on disk. Raises `Cancelled`."""
    study = question.study()
    options = RunOptions(threads=current_settings().threads, cells_per_chunk=STEPS_AT_ONCE, cancelled=cancelled)
    for values in grow_cached(study, options):
        result = PartialStep(question, study, values)
        yield result
    yield replace(result, judged={scheme: _judge(result, scheme, options) for scheme in result.schemes})


def _judge(result: PartialStep, scheme: str, options: RunOptions) -> dict[int, tuple[CellKind, int]]:
    """Kind and period of the motions that a section of another period than one leaves open, by their place."""
    status, period = (result.of_scheme(name, scheme) for name in ("status", "period"))
    method = result.study.schemes[scheme]
    skipped = scheme == "fixed"
    chosen = np.flatnonzero((status == 0) & (period != 1) & (skipped | (result.steps <= MOST_TAKEN)))
    if not len(chosen):
        return {}
    cells = replace(result.study.cells_at({"steps": result.steps[chosen]}), method=method)
    how = {"transient": TRANSIENT, "sample": SAMPLE, "threads": options.threads, "cancelled": options.cancelled}
    kinds = judge_runs(cells, **how)
    pairs = zip(map(CellKind, kinds["kind"].tolist()), kinds["kind_period"].tolist(), strict=True)
    return dict(zip(chosen.tolist(), pairs, strict=True))
