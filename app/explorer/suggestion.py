"""Which K, D and time step to set instead: searched for behind every slider, in threads of their own. No panel."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from vibroscope.app.explorer.state import Explorer, Setting, print_number, read_number
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Job, lower_priority
from vibroscope.app.runtime.workers import Workers, pool
from vibroscope.engine import Recommendation, Reference, System, recommend

_THREADS = 2  # searches that run at the same time, of all sessions
_PERCENT = (0.01, 100.0)  # of a tolerance
_SHOWN = 10  # points of the front
_KEPT = Cache(32)


class Question(NamedTuple):
    """What a search depends on: not on K, D and Δτ, which it looks for."""

    system: System
    eta: float
    reference: Reference
    located: bool
    tolerance: float


def question_of(setting: Setting, percent: object) -> Question:
    """What is asked for a setting; raises `Refused` if the tolerance, as typed, is no share in per cent."""
    tolerance = read_number("tolerance", percent, _PERCENT, whole=False) / 100
    return Question(setting.system, setting.eta, setting.reference, setting.located == "yes", tolerance)


def _threads() -> Workers:
    """What a search starts inherits the low priority of its thread."""
    return pool("suggestion", _THREADS, lower_priority)


class Search(Job):
    """One search; ``told(search, share)``, then ``found(search, result)``, are called in a worker thread."""

    def __init__(
        self,
        question: Question,
        told: Callable[[Search, float], None],
        found: Callable[[Search, Recommendation | Exception], None],
    ) -> None:
        super().__init__(question)
        self._told = told
        self._found = found
        self._begin(_threads())

    def _answer(self) -> None:
        found = _KEPT.get(self.question) or self._recommend()
        _KEPT.put(self.question, found)
        if not self.cancelled:
            self._found(self, found)

    def _fail(self, error: Exception) -> None:
        self._found(self, error)

    def _recommend(self) -> Recommendation:
        system, eta, reference, located, tolerance = self.question
        limits = Explorer.param
        return recommend(
            system,
            eta,
            tolerance=tolerance,
            located=located,
            reference=reference,
            stiffness_max=limits.K.bounds[1],
            steps_max=limits.steps.bounds[1],
            progress=lambda share: self._told(self, share),
            cancelled=self._cancelled.is_set,
        )


def texts_of_trial(trial) -> dict[str, str]:
    """K, D and n of a trial as the controls take them."""
    return dict(zip(("K", "D", "steps"), map(print_number, trial.setting), strict=True))


def fits(trial) -> bool:
    """Whether the sliders reach a trial's setting."""
    bounds = [Explorer.param[name].bounds for name in ("K", "D", "steps")]
    return all(low <= value <= high for value, (low, high) in zip(trial.setting, bounds, strict=True))


def told_of(found: Recommendation) -> dict:
    """What the page is told of a result: head, lines, the front, and what the button would set.

    Returns
    -------
    dict
        ``met`` (bool), ``head`` (str), ``lines`` (list of str), ``use`` (texts of the best setting found, empty where
        there is none or the sliders do not reach it), ``tolerance`` (share), and ``front``: lists of steps, error,
        and texts of a setting, at most ten.
    """
    best = found.best
    return {
        "met": found.met,
        "head": f"An error of {_percent(found.tolerance)} is {'met' if found.met else 'not met'}",
        "lines": _lines(found),
        "use": texts_of_trial(best) if best is not None and fits(best) else {},
        "tolerance": found.tolerance,
        "front": [[t.setting.steps, t.error, texts_of_trial(t)] for t in _thinned(found.front, best) if fits(t)],
    }


def _lines(found: Recommendation) -> list[str]:
    if found.best is None:
        return [_sentence(found.reason)]
    (stiffness, damping, steps), best = found.best.setting, found.best
    numbers = f"K = {stiffness:g}, D = {damping:g}, T/Δτ = {steps}"
    kept = f"error {_percent(best.error)}; nine in ten of its neighbours keep to {_percent(best.robust)}."
    cost = (
        f"It costs {best.cost:.0f} solves a period, since steps are cut where contact changes." if found.located else ""
    )
    lines = [f"{numbers}: {kept} {cost}".strip() if found.met else f"Best found: {numbers}, {kept} {cost}".strip()]
    if not found.met:
        lines.append(_sentence(found.reason))
    if found.compensated:
        part = _percent(found.joint_damping)
        lines.append(f"Mind: the joint damping alone makes {part}; errors cancel here, and need not at another η.")
    elif 1e-4 <= found.joint_damping <= found.tolerance:  # one that is larger is the reason; nan where there is none
        lines.append(f"Of it the joint damping alone makes {_percent(found.joint_damping)}.")
    return lines


def _thinned(front: tuple, best) -> list:
    """At most ten points, evenly spread, the best among them."""
    if len(front) <= _SHOWN:
        return list(front)
    wanted = {round(i * (len(front) - 1) / (_SHOWN - 2)) for i in range(_SHOWN - 1)}
    return [trial for i, trial in enumerate(front) if i in wanted or trial is best]


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
