"""A claim of the paper: a sentence, the figure it belongs to, a check, and the check's finding."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass, field

from vibroscope.app.explorer.scenes import Scene, scenes
from vibroscope.app.paper.pictures import Picture

# Whether the check that runs is cancelled; those that take many seconds poll it.
is_cancelled: ContextVar[Callable[[], bool] | None] = ContextVar("is_cancelled", default=None)

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
        Key of the scene that holds its η, K, D and steps (`app.explorer.scenes`).
    check : callable
        Takes the scene, returns a `Finding`.
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
    check: Callable[[Scene], Finding]
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
        return self.check(scenes()[self.scene])


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
