"""Which K, D and time step to set instead: a search in low-priority threads. No panel import."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from vibroscope.app.explorer.explanation import sentence
from vibroscope.app.explorer.state import Explorer, Setting, print_number
from vibroscope.app.explorer.typed import read_typed_number
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Job, lower_priority
from vibroscope.app.runtime.workers import Workers, pool
from vibroscope.engine import Recommendation, Reference, System, recommend

_THREADS = 2  # searches that run at the same time, of all sessions
_PERCENT = (0.01, 100.0)  # limits of a tolerance
_FRONT_POINTS = 10  # shown, at most
CACHE = Cache(32)  # results by their question


class Question(NamedTuple):
    """What a search depends on; it does not depend on K, D and Δτ, which it looks for."""

    system: System
    eta: float
    reference: Reference
    located: bool
    tolerance: float


def make_question(setting: Setting, percent: object) -> Question:
    """The question for a setting and a tolerance as typed, in per cent; raises `Refused` if that is no tolerance."""
    tolerance = float(read_typed_number("tolerance", percent, _PERCENT, units={"": 1.0, "%": 1.0}, shown="%")) / 100
    return Question(setting.system, setting.eta, setting.reference, setting.located == "yes", tolerance)


def search_threads() -> Workers:
    """The threads of all searches; threads that a search starts inherit their low priority."""
    return pool("suggestion", _THREADS, lower_priority)


class Search(Job):
    """One search; ``on_progress(search, share)``, then ``on_result(search, result)``, are called in a worker thread."""

    def __init__(
        self,
        question: Question,
        on_progress: Callable[[Search, float], None],
        on_result: Callable[[Search, Recommendation | Exception], None],
    ) -> None:
        super().__init__(question)
        self._on_progress = on_progress
        self._on_result = on_result
        self._begin(search_threads())

    def _answer(self) -> None:
        found = CACHE.get(self.question) or self._recommend()
        CACHE.put(self.question, found)
        if not self.cancelled:
            self._on_result(self, found)

    def _fail(self, error: Exception) -> None:
        self._on_result(self, error)

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
            progress=lambda share: self._on_progress(self, share),
            cancelled=lambda: self.cancelled,
        )


def trial_texts(trial) -> dict[str, str]:
    """K, D and n of a trial as texts for the controls."""
    return dict(zip(("K", "D", "steps"), map(print_number, trial.setting), strict=True))


def within_sliders(trial) -> bool:
    """Whether the sliders can be set to a trial's setting."""
    bounds = [Explorer.param[name].bounds for name in ("K", "D", "steps")]
    return all(low <= value <= high for value, (low, high) in zip(trial.setting, bounds, strict=True))


def suggestion_content(found: Recommendation) -> dict:
    """What the page shows of a result.

    Returns
    -------
    dict
        ``met`` (bool), ``head`` (str), ``lines`` (list of str), ``use`` (texts of the best setting found, empty if
        there is none or the sliders cannot be set to it), ``tolerance`` (share), and ``front``: lists of steps, error,
        and texts of a setting, at most ten.
    """
    best = found.best
    points = [trial for trial in _thin_front(found.front, best) if within_sliders(trial)]
    return {
        "met": found.met,
        "head": f"An error of {_percent(found.tolerance)} is {'met' if found.met else 'not met'}",
        "lines": _lines(found),
        "use": trial_texts(best) if best is not None and within_sliders(best) else {},
        "tolerance": found.tolerance,
        "front": [[trial.setting.steps, trial.error, trial_texts(trial)] for trial in points],
    }


def _lines(found: Recommendation) -> list[str]:
    if found.best is None:
        return [sentence(found.reason)]
    (stiffness, damping, steps), best = found.best.setting, found.best
    result = (
        f"K = {stiffness:g}, D = {damping:g}, T/Δτ = {steps}: error {_percent(best.error)}; "
        f"nine in ten neighbouring settings have at most {_percent(best.robust)}."
    )
    if found.located:
        result += f" It costs {best.cost:.0f} solves per period, since steps are cut where contact changes."
    lines = [result] if found.met else [f"Best found: {result}", sentence(found.reason)]
    if found.compensated:
        part = _percent(found.joint_damping)
        lines.append(f"Note: the joint damping alone causes {part}; errors cancel here, and may not at another η.")
    elif 1e-4 <= found.joint_damping <= found.tolerance:  # a larger one is the reason, nan means that there is none
        lines.append(f"The joint damping alone causes {_percent(found.joint_damping)} of it.")
    return lines


def _thin_front(front: tuple, best) -> list:
    """At most `_FRONT_POINTS` points, evenly spread, the best among them."""
    if len(front) <= _FRONT_POINTS:
        return list(front)
    wanted = {round(i * (len(front) - 1) / (_FRONT_POINTS - 2)) for i in range(_FRONT_POINTS - 1)}
    return [trial for i, trial in enumerate(front) if i in wanted or trial is best]


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"
