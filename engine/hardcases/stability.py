"""How the engine does in the hard cases.

Each case (:mod:`.cases`) is run, compared with its true solution where there is one (assets/truth/hard.json), and its
energy is balanced (:mod:`.judgement`). ``vibroscope stability`` prints the outcomes; the tests run the same list.
"""

from collections.abc import Callable, Iterable

from .cases import HardCase, hard_cases
from .judgement import HardCaseOutcome, outcome


def stability(
    cases: Iterable[HardCase] | None = None, progress: Callable[[HardCaseOutcome], None] | None = None
) -> list[HardCaseOutcome]:
    """Run the hard cases and return their outcomes.

    Parameters
    ----------
    cases : iterable of HardCase, optional
        By default all of :func:`hard_cases`.
    progress : callable, optional
        Called with each outcome in turn.

    Returns
    -------
    list of HardCaseOutcome
    """
    outcomes = []
    for case in hard_cases() if cases is None else cases:
        outcomes.append(outcome(case))
        if progress is not None:
            progress(outcomes[-1])
    return outcomes
