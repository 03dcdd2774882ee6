"""One claim of the paper: a sentence, the figure it stands with, a way to check it, and what a check brings."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from vibroscope.app.explorer.scenes import Scene, scenes
from vibroscope.engine import Diagram, ExactPenalty, Method, Newmark, Record, Reference, Response, System, simulate

SYSTEM = System()
VERDICTS = ("agrees", "differs", "shown by example")
# What a printed phase plot can tell: points that scatter (standard deviation) by less than this share of the largest
# coordinate of the section look like one.
SEEN = 0.01
_RUN = 2000  # periods before those that are looked at: the paper's 2,050 less its last 50
_SAMPLED = Record(12, 500)
_LEAST = 1e-4  # share that is still printed


@dataclass(frozen=True, eq=False)
class Orbits:
    """Phase plots over each other: responses with samples, by name."""

    runs: dict[str, Response]


@dataclass(frozen=True, eq=False)
class Times:
    """Displacements and contact force over the last two periods of a response with samples."""

    run: Response


@dataclass(frozen=True, eq=False)
class Plane:
    """A K–D plane.

    Attributes
    ----------
    stiffness, damping : (m,), (n,) ndarray
        Centres of the cells, evenly spaced in their logarithms.
    kind : (n, m) ndarray of int
        Index into ``names``.
    names : tuple of str
        What a cell may be.
    at : tuple of float
        K and D of the set that the claim is about.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    kind: np.ndarray
    names: tuple[str, ...]
    at: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Finding:
    """What a check brings.

    Attributes
    ----------
    agrees : bool
        Whether the claim holds here.
    found : str
        What was found, with its numbers.
    why : str
        Where it differs, or agrees only in part: the reason.
    picture : Orbits, Times, Plane or Diagram
        The figure remade.
    """

    agrees: bool
    found: str
    picture: Orbits | Times | Plane | Diagram = field(repr=False)
    why: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "agrees", bool(self.agrees))  # NumPy's truth is no JSON


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
    tab : str
        Key of the tab that shows it best.
    holds : bool
        Whether the model is known to agree; a check that says otherwise is a fault of one of them.
    example : bool
        Whether the paper's own numbers are lost, so that ours can show the claim but not confirm it.
    """

    key: str
    place: str
    text: str
    scene: str
    check: Callable[[Scene], Finding]
    tab: str = "explore"
    holds: bool = True
    example: bool = False

    @property
    def figure(self) -> int:
        """Number of the figure."""
        return int(re.match(r"\d+", self.key)[0])

    @property
    def name(self) -> str:
        """As the paper prints it: "Figure 9 [A]"."""
        case = self.key.removeprefix(str(self.figure))
        return f"Figure {self.figure}" + (f" [{case}]" if case else "")

    def verdict(self, finding: Finding) -> str:
        """One of `VERDICTS`."""
        if not finding.agrees:
            return "differs"
        return "shown by example" if self.example else "agrees"

    def find(self) -> Finding:
        """Check it now: some milliseconds, or some seconds for a plane."""
        return self.check(scenes()[self.scene])


def tally(verdicts: Iterable[str]) -> str:
    """How many claims agree, differ and are shown by example."""
    counts = Counter(verdicts)
    return f"{counts['agrees']} agree, {counts['differs']} differ, {counts['shown by example']} shown by example"


def as_dict(claim: Claim, finding: Finding) -> dict:
    """The contract for scripts."""
    return {
        "figure": claim.name,
        "place": claim.place,
        "claim": claim.text,
        "verdict": claim.verdict(finding),
        "agrees": claim.verdict(finding) == "agrees",
        "known_to_agree": claim.holds and not claim.example,
        "found": finding.found,
        "why": finding.why,
    }


def reference(scene: Scene, record: Record = _SAMPLED) -> Response:
    """The reference from rest, the paper's 2,050 periods."""
    return run(scene, Reference(), record=record)


def newmark(scene: Scene, keep: int = 50, record: Record = _SAMPLED) -> Response:
    """The scene's penalty solution; more than the paper's 50 kept periods where a statistic is wanted."""
    return run(scene, Newmark(scene.K, scene.D, scene.steps), keep, record)


def exact(scene: Scene) -> Response:
    """The same without a time step."""
    return run(scene, ExactPenalty(scene.K, scene.D))


def run(scene: Scene, method: Method, keep: int = 50, record: Record = _SAMPLED) -> Response:
    """2,000 periods from rest, and ``keep`` more that are kept."""
    return simulate(SYSTEM, scene.eta, method, periods=_RUN + keep, keep=keep, record=record)


def reach(section: np.ndarray) -> np.ndarray:
    """Largest coordinate of each section, (..., sample, 4)."""
    return np.abs(section).max(axis=(-2, -1))


def periods(count: int) -> str:
    """A cycle in words."""
    return {0: "no cycle", 1: "one period", 2: "two periods"}.get(count, f"{count} periods")


def count(number: float, what: str) -> str:
    """So many of something."""
    return f"{number:g} {what}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """Two digits, three from 10 % on; never narrower than its sign."""
    return f"{100 * share:.{3 if share >= 0.1 else 2}g}\u00a0%" if share >= _LEAST else "less than 0.01\u00a0%"
