"""The motions that coexist at one setting, while they are searched for. No panel import.

Both solvers are run from many starts, in turn, and each motion that starts end in is listed once
(:mod:`engine.motions.search`).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from vibroscope.app.explorer.field_units import shown_field, shown_text
from vibroscope.app.explorer.method_words import brief_name, plain_motion
from vibroscope.app.explorer.motion_kind import describe_kind
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import (
    Attractor,
    Method,
    Motion,
    Reference,
    System,
    TimeStepping,
    Units,
    counted,
    percent,
    search_attractors,
    written,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.motions.search import STARTS


class CoexistingQuestion(NamedTuple):
    """Everything that the motions depend on; the start of the setting is no part of it."""

    system: System
    eta: float
    reference: Reference
    penalty: TimeStepping

    @classmethod
    def of(cls, setting: Setting) -> "CoexistingQuestion":
        """The question for a setting."""
        return cls(setting.system, setting.eta, setting.reference, setting.penalty)

    @property
    def methods(self) -> dict[str, Method]:
        """The solvers by their names."""
        return {name: getattr(self, name) for name in SOLVERS}


@dataclass(frozen=True, eq=False)
class Coexisting:
    """The motions of each solver that were found so far, after ``done`` starts; the largest share first."""

    question: CoexistingQuestion
    done: int
    found: dict[str, tuple[Attractor, ...]]

    @property
    def share(self) -> float:
        """The share of the starts that are done."""
        return self.done / STARTS

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        return {
            name: [{"share": each.share, "start": each.start, **plain_motion(each.motion)} for each in motions]
            for name, motions in self.found.items()
        }


def search_coexisting(question: CoexistingQuestion, last: Coexisting | None, cancelled: Poll) -> Iterator[Coexisting]:
    """The motions so far, after each start. Raises `Cancelled`."""
    methods, problem = question.methods, (question.system, question.eta)
    searches = (search_attractors(*problem, method, cancelled=cancelled) for method in methods.values())
    for done, found in enumerate(zip(*searches, strict=True), start=1):
        yield Coexisting(question, done, dict(zip(methods, found, strict=True)))


def coexisting_content(result: Coexisting, setting: Setting) -> dict:
    """The content of the page for a result, in the units of the setting.

    Returns
    -------
    dict
        ``head`` (str), and ``solvers``: title and motions of each. A motion has ``name``, ``share`` and ``text``, the
        evidence for its kind ``why``, its start in words ``starts`` and as texts ``use``, and ``shown``: whether the
        setting starts there.
    """
    titles = {"reference": "Reference", "penalty": f"Penalty ({brief_name(result.question.penalty)})"}
    solvers = [
        [title, [_motion(each, setting, "impact" if name == "reference" else "contact") for each in result.found[name]]]
        for name, title in titles.items()
    ]
    counts = (counted(len(result.found[name]), "motion") for name in SOLVERS)
    words = [f"{count} of the {name}" for name, count in zip(("reference", "penalty model"), counts, strict=True)]
    return {"head": f"From {counted(result.done, 'start')}: {' and '.join(words)}", "solvers": solvers}


def _motion(each: Attractor, setting: Setting, event: str) -> dict:
    kind = describe_kind(each.motion)
    return {
        "name": kind.name,
        "share": percent(each.share),
        "text": _strength(each.motion, setting.scale, event),
        "why": shown_text(kind.evidence, setting.scale),
        "starts": _start_words(each, setting),
        "use": {"zero_start": "zero", **dict(zip(START_FIELDS, map(print_number, each.start.tolist()), strict=True))},
        "shown": tuple(each.start.tolist()) == setting.initial,
    }


def _start_words(each: Attractor, setting: Setting) -> str:
    """The start with the symbols and units of the page."""
    fields = zip(START_FIELDS, each.start.tolist(), strict=True)
    return ", ".join(shown_field(name, setting).words(value) for name, value in fields)


def _strength(found: Motion, scale: Units | None, event: str) -> str:
    """How often and how hard the pendulums meet; empty if the run ended early."""
    if not found.impacts_per_period >= 0:
        return ""

    def text(quantity: str, value: float) -> str:
        return written(value) if scale is None else scale.text(quantity, value)

    peak = f", peak force {text('force', found.peak_force)}" if found.peak_force > 0 else ""
    impulse = f", impulse {text('impulse', found.impulse)}" if found.impulse > 0 else ""
    return f"{counted(found.impacts_per_period, event)}{impulse} per period{peak}"
