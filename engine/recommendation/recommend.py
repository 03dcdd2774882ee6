"""Recommend K, D and the time step: the setting that meets the tolerances at the least cost, at one η or at several.

The error is that of :class:`..divergence.error.Target`: the rms difference of the displacements from the reference,
relative to it, in phase with the excitation. A setting must also deliver the restitution of the system, and the peak
force that it would have without a time step (:mod:`.contacts`). :mod:`.step_search` searches the least number of steps
per period n, :mod:`.contact_search` the best K and D for each n. From the least n, :mod:`.middle` goes to the middle of
where the tolerances are met. No setting is recommended by a formula: every one that is returned was run from rest by
Newmark's method, and so were its neighbours, so that it does not meet the tolerances by chance (:mod:`.trials`). With
several η each setting is tried at all of them (:mod:`.range_trials`), and between them (:mod:`.search`).

The search sees the question with ten digits (`.question.round_numbers`), so that a further one does not change the
answer; the answer is verified for the question as it is.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from vibroscope.engine.drivers.threads import thread_count
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.recommendation.question import SettingQuestion
from vibroscope.engine.recommendation.recommendation import Recommendation
from vibroscope.engine.recommendation.search import Search
from vibroscope.engine.recommendation.trials import Trial


def recommend(
    question: SettingQuestion,
    *,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: Callable[[list[Trial], float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Recommendation:
    """Find K, D and steps per period that meet the tolerances at the least cost, at all η of the question and between.

    Parameters
    ----------
    question : SettingQuestion
    threads : int, optional
        To try settings side by side; by default one for each core.
    progress : callable, optional
        Called in the calling thread with the fraction that is done at least, 0 to 1.
    partial : callable, optional
        Called in the calling thread with the front of the settings found so far, whenever some were tried with another
        n, and the η to which their steps per period belong. Those that meet the tolerance are confirmed.
    cancelled : callable, optional
        Polled many times a second, by several threads; when it returns true the search is cancelled.

    Returns
    -------
    Recommendation
        The same for the same question, however many threads there are.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Limits, SettingQuestion, System, Tolerances, recommend
    >>> held = Limits(stiffness=12000, steps_max=4000)
    >>> found = recommend(SettingQuestion(System(), 2.76, Tolerances(0.2), held))
    >>> found.met, found.best.setting.stiffness, found.best.robust <= 0.2
    (True, 12000.0, True)
    """
    progress = progress or _ignore
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        found = Search(question, pool, cancelled).run(progress, partial or _ignore)
    progress(1.0)
    return found


def design_curve(
    question: SettingQuestion, etas: Sequence[float], *, progress: Callable[[float], None] | None = None, **how: object
) -> list[Recommendation]:
    """Return a recommendation for each of several η alone: how K, D and n change with η.

    Parameters
    ----------
    question : SettingQuestion
        Its own η have no effect.
    etas : sequence of float
        Excitation frequencies η = Ω/ω₁.
    progress : callable, optional
        Called with the fraction that is done at least, 0 to 1.
    **how
        Those of :func:`recommend`, whose exceptions are raised, too.
    """
    return _one_after_the_other([replace(question, etas=eta) for eta in etas], progress, how)


def recommend_schemes(
    question: SettingQuestion,
    schemes: Sequence[TimeStepping],
    *,
    progress: Callable[[float], None] | None = None,
    **how: object,
) -> list[Recommendation]:
    """Return a recommendation for each of several schemes, such as the integrators of a code, best first.

    First come those that meet the tolerance, by solves per period (:attr:`Recommendation.solves`), and where these are
    equal by the error that they keep to; then the others by that error.

    Parameters
    ----------
    question : SettingQuestion
        Its scheme has no effect.
    schemes : sequence of Newmark or TimeStepping
        Their K, D and n have no effect.
    **how
        Those of :func:`recommend`.

    Raises
    ------
    ValueError
        If there is no scheme.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not schemes:
        raise ValueError("schemes is empty: give the methods to search over")
    return sorted(_one_after_the_other([replace(question, scheme=each) for each in schemes], progress, how), key=_rank)


def _one_after_the_other(questions: list[SettingQuestion], progress, how: dict) -> list[Recommendation]:
    progress = progress or _ignore
    return [
        recommend(question, progress=lambda fraction, i=i: progress((i + fraction) / len(questions)), **how)
        for i, question in enumerate(questions)
    ]


def _rank(found: Recommendation) -> tuple[float, ...]:
    """The sort key of recommendations."""
    if found.best is None:
        return (2.0,)
    robust = found.best.robust
    return (0.0, found.solves, robust) if found.met else (1.0, robust)


def _ignore(*_: object) -> None:
    """Nobody wants the progress, or what is found so far."""
