"""A claim of the paper: a sentence, the figure it belongs to, a check, and the check's finding.

The runs that the paper's figures rest on: 2,050 periods from rest, of which the last 50 are shown.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass, field

import numpy as np
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.paper.pictures import Picture
from vibroscope.engine import Method, Record, Response, System, simulate
from vibroscope.engine.arguments import Poll

SYSTEM = System()
# What a printed phase plot can resolve: points that scatter (standard deviation) by less than this share of the
# section's largest coordinate look like one.
VISIBLE_SCATTER = 0.01
_SAMPLED = Record(12, 500)
TWO_PERIODS = Record(2, 1000)


def run_reference(scene: Setting, record: Record = _SAMPLED) -> Response:
    """The reference."""
    return run_method(scene, scene.reference, record=record)


def run_newmark(scene: Setting, record: Record = _SAMPLED) -> Response:
    """The scene's penalty solution by Newmark's method; statistics need more than 50 kept periods."""
    return run_method(scene, scene.penalty, record=record)


def run_exact(scene: Setting) -> Response:
    """The scene's penalty solution without a time step."""
    return run_method(scene, scene.penalty.limit)


def run_method(scene: Setting, method: Method, keep: int = 50, record: Record = _SAMPLED) -> Response:
    """2,000 periods from rest, and ``keep`` more that are kept."""
    return simulate(SYSTEM, scene.eta, method, periods=2000 + keep, keep=keep, record=record)


def section_size(section: np.ndarray) -> np.ndarray:
    """Largest coordinate of each section, (..., sample, 4)."""
    return np.abs(section).max(axis=(-2, -1))


_LEAST = 1e-4  # the smallest share that is printed


def cycle_text(periods: int) -> str:
    """A cycle of so many periods; 0 is no cycle."""
    return {0: "no cycle", 1: "one period", 2: "two periods"}.get(periods, f"{periods} periods")


def count_text(number: float, noun: str) -> str:
    """A number and its noun, which takes a plural s unless the number is 1."""
    return f"{number:g} {noun}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """Two digits, three from 10 % on; the space before the sign does not break."""
    return f"{100 * share:.{3 if share >= 0.1 else 2}g}\u00a0%" if share >= _LEAST else "less than 0.01\u00a0%"


# Whether the check that runs is cancelled; those that take many seconds poll it, and raise `Cancelled`.
is_cancelled: ContextVar[Poll | None] = ContextVar("is_cancelled", default=None)

VERDICTS = ("agrees", "differs", "shown by example")


@dataclass(frozen=True, eq=False)
class Finding:
    """The result of a check.

    Attributes
    ----------
    agrees : bool
        Whether the engine confirms the claim.
    result : str
        What was found, with its numbers.
    picture : Picture
        The figure, computed anew.
    reason : str
        Why the result differs, or agrees only in part; else empty.
    """

    agrees: bool
    result: str
    picture: Picture = field(repr=False)
    reason: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "agrees", bool(self.agrees))  # JSON does not take NumPy's bool


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, in our words.

    Attributes
    ----------
    key : str
        Figure and case, "9A".
    place : str
        Section of the paper.
    text : str
    scene : str
        Key of the scene that holds its η, K, D and steps (`app.explorer.presets`).
    check : callable
        Takes the setting of the scene, returns a `Finding`.
    view : str
        Key of the view that shows it best.
    holds : bool
        Whether the model is known to agree. A check that finds otherwise reveals a fault in the check or the engine.
    example : bool
        Whether the paper's own numbers are lost, so that ours can show the claim but not confirm it.
    """

    key: str
    place: str
    text: str
    scene: str
    check: Callable[[Setting], Finding]
    view: str = "explore"
    holds: bool = True
    example: bool = False

    @property
    def figure(self) -> int:
        """Number of the figure."""
        return int(re.match(r"\d+", self.key)[0])

    @property
    def name(self) -> str:
        """The figure as the paper prints it: "Figure 9 [A]"."""
        case = self.key.removeprefix(str(self.figure))
        return f"Figure {self.figure}" + (f" [{case}]" if case else "")

    def verdict(self, finding: Finding) -> str:
        """One of `VERDICTS`."""
        if not finding.agrees:
            return "differs"
        return "shown by example" if self.example else "agrees"

    def find(self) -> Finding:
        """Check the claim now: some milliseconds, or some seconds for a plane."""
        return self.check(scenes()[self.scene].setting)


def count_verdicts(verdicts: Iterable[str]) -> str:
    """How many claims agree, differ and are shown by example."""
    counts = Counter(verdicts)
    return f"{counts['agrees']} agree, {counts['differs']} differ, {counts['shown by example']} shown by example"


def as_dict(claim: Claim, finding: Finding) -> dict:
    """A claim and its finding as JSON for scripts."""
    verdict = claim.verdict(finding)
    return {
        "figure": claim.name,
        "place": claim.place,
        "claim": claim.text,
        "verdict": verdict,
        "agrees": verdict == "agrees",
        "known_to_agree": claim.holds and not claim.example,
        "found": finding.result,
        "why": finding.reason,
    }
