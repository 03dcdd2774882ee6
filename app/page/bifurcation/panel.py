"""What stands beside a bifurcation diagram: the numbers that can be swept, the choices, and the diagram in sentences.

The motion whose branch is searched for first: the search finds the others in its order, so a link holds it.

A bifurcation diagram and its branches as a Python script, and as commands.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.link import LINEAR, ViewChoice
from vibroscope.app.explorer.parameters import FIELDS, START_FIELDS, Field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import branch_command, initial_option, method_options, sweep_command, sweep_python
from vibroscope.app.studies.bifurcation import COUNT, SAMPLE, TRANSIENT, DiagramQuestion, PartialDiagram
from vibroscope.app.studies.branches import BranchesQuestion
from vibroscope.engine import COORDINATES
from vibroscope.engine.facts import Statement, equation, span, stated
from vibroscope.engine.motions.words import NOT_JUDGED
from vibroscope.engine.sweeps import CellKind


class Swept(NamedTuple):
    """A number that can be swept.

    Attributes
    ----------
    field : Field
        It; `app.explorer.state` has the range at first.
    parts : int
        Into how many parts a unit is divided where the line is dragged; 1 for whole numbers.
    solvers : tuple of str
        Solvers that have it, the preferred one first.
    """

    field: Field
    parts: int
    solvers: tuple[str, ...]

    @property
    def choice(self) -> str:
        """The label in the list of choices: its name, without its definition."""
        return self.field.hint.removesuffix(" Ω/ω₁")

    def rounded(self, value: float) -> float:
        """The nearest value that the line can be dragged to."""
        low, high = self.field.bounds
        return min(max(round(value * self.parts) / self.parts, low), high)


SWEPT = {
    "eta": Swept(FIELDS["eta"], 10_000, ("reference", "exact", "newmark")),
    "K": Swept(FIELDS["K"], 10, ("exact", "newmark")),
    "D": Swept(FIELDS["D"], 1000, ("exact", "newmark")),
    "steps": Swept(FIELDS["steps"], 1, ("newmark",)),
    "restitution": Swept(FIELDS["restitution"], 10_000, ("reference",)),
}


def statements(setting: Setting, result: PartialDiagram) -> list[list[str | Statement]]:
    """Head and text of what the diagram says."""
    symbol, nearest = FIELDS[result.question.over].label, nearest_cell(setting, result)
    lines = []
    if nearest is not None:
        at = float(result.question.axis[nearest])
        lines.append([stated("Near {}", equation(symbol, at, 5)), motion_at(result, nearest) + "."])
    return [*lines, [stated("From {}", span(symbol, *result.question.span)), f"{'; '.join(shares(result))}."]]


def nearest_cell(setting: Setting, result: PartialDiagram) -> int | None:
    """The known cell that is nearest to the number that is set; None if that lies outside of the diagram."""
    value, (low, high) = getattr(setting, result.question.over), result.question.span
    known = np.flatnonzero(result.known)
    return known[np.argmin(np.abs(result.question.axis[known] - value))] if low <= value <= high else None


_SHARES = {  # a kind of motion as the statement names it
    CellKind.ARTEFACT: "periodic but blurred by the time step",
    CellKind.QUASI_PERIODIC: "quasi-periodic",
    CellKind.CHAOTIC: "chaotic",
    CellKind.UNDECIDED: "kind not decided",
    CellKind.UNKNOWN: NOT_JUDGED,
    CellKind.ENDED_EARLY: "ended early",
}


def shares(result: PartialDiagram) -> list[str]:
    """The kinds of motion, and the share of the range that each takes."""
    known = np.flatnonzero(result.known)
    kind, period = result.kinds["kind"][known], result.kinds["kind_period"][known]
    periodic = kind == CellKind.PERIODIC
    parts = {f"period {n}": periodic & (period == n) for n in (1, 2)}
    parts["longer periods"] = periodic & (period > 2)
    parts |= {name: kind == code for code, name in _SHARES.items()}
    return [f"{name} {_percent(float(cells.mean()))}" for name, cells in parts.items() if cells.any()]


def motion_at(result: PartialDiagram, index: int) -> str | Statement:
    """The motion of a cell, and its impacts."""
    if result.ended[index]:
        return "the run ended early"
    return kind_text(result, index) + f", impacts per period {result.impacts[index]:.3g}"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.005 else "below 1 %"


def kind_text(result: PartialDiagram, index: int) -> str:
    """Kind of motion of a cell, with its evidence."""
    kind = CellKind(result.kinds["kind"][index])
    if kind is CellKind.UNKNOWN:
        return result.motion_words(index)
    exponent, error = result.kinds["lyapunov"][index], result.kinds["lyapunov_error"][index]
    is_aperiodic = np.isfinite(exponent) and kind is not CellKind.PERIODIC
    rate = f" (Lyapunov exponent {exponent:+.2g} ± {error:.1g} per period)" if is_aperiodic else ""
    return result.motion_words(index) + rate


_NAMES = ("followed", *(name.replace("start", "followed") for name in START_FIELDS))  # in a link: η and the state


class Followed(NamedTuple):
    """The motion at ``initial`` (ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0), or that a run from there settles to."""

    eta: float
    initial: tuple[float, ...]

    @classmethod
    def of(cls, setting: Setting) -> "Followed":
        """The motion from the start of a setting."""
        return cls(setting.eta, tuple(map(float, setting.initial)))

    def linked(self) -> dict[str, float]:
        """Numbers for a link, from which `linked_motion` reads the same; a state that is 0 is left out."""
        return {name: number for name, number in zip(_NAMES, (self.eta, *self.initial), strict=True) if number}


def linked_motion(choice: Mapping[str, float]) -> Followed | None:
    """The motion that the choices of a link name; None if they name none."""
    eta, *state = (choice.get(name) for name in _NAMES)
    return None if eta is None else Followed(eta, tuple(number or 0.0 for number in state))


def without_motion(choice: Mapping[str, str | float]) -> dict[str, str | float]:
    """The choices of a link that the panel has, too."""
    return {name: value for name, value in choice.items() if name not in _NAMES}


def diagram_python(question: DiagramQuestion, branches: Mapping[str, BranchesQuestion]) -> str:
    """`EtaStudy` and, for the branches by the name of their result, `find_branches`."""
    how = f"direction={question.direction!r}, coordinates={tuple(COORDINATES)}"
    how += "" if question.over == "eta" else f", over={question.over!r}, eta={question.eta!r}"
    how += "" if question.initial is None else f", initial={question.initial}"
    values = f"np.linspace({question.span[0]!r}, {question.span[1]!r}, {question.count})"
    values = f"np.unique(np.round({values}))" if question.over == "steps" else values
    calls = {name: _branch_call(each) for name, each in branches.items()}
    call = f"sweep(EtaStudy(\n    system, {question.method!r}, values={values},\n"
    call += f"    {how}, transient={question.transient}, sample={SAMPLE},\n))"
    return sweep_python({"diagram": call, **calls}, question.system)


def diagram_command(question: DiagramQuestion, branches: Mapping[str, BranchesQuestion]) -> str:
    """``vibroscope sweep eta`` and ``vibroscope branch``."""
    low, high = question.span
    options = f" --from {low!r} --to {high!r} --count {question.count}{method_options(question.method)}"
    options += "" if question.over == "eta" else f" --over {question.over} --eta {question.eta!r}"
    options += f" --direction {question.direction} --coordinates {','.join(COORDINATES)}"
    options += initial_option(question.initial)
    sweep = sweep_command("eta", question.system, f"{options} --transient {question.transient} --sample {SAMPLE}")
    if not branches:
        return sweep
    return sweep + branch_command(question.system, {name: _branch_options(each) for name, each in branches.items()})


def _branch_call(question: BranchesQuestion) -> str:
    asked = question.search
    names = ("over", "low", "high", "max_period", "most_orbits", *(("initial",) if asked.initial is not None else ()))
    numbers = ", ".join(f"{name}={getattr(asked, name)!r}" for name in names)
    return f"find_branches(\n    BranchQuestion(system, {asked.eta!r}, {asked.method!r}, {numbers}),\n)"


def _branch_options(question: BranchesQuestion) -> str:
    asked = question.search
    options = f" --over {asked.over} --from={asked.low!r} --to={asked.high!r} --max-period {asked.max_period}"
    options += f" --most-orbits {asked.most_orbits}{initial_option(asked.initial)}"
    given = "" if asked.over == "eta" and asked.initial is None else f" --eta {asked.eta!r}"
    return f"{options}{method_options(asked.method)}{given}"


DIRECTION_NAMES = {
    "rest": "from rest",
    "own": "from an own start",
    "up": "continued upwards",
    "down": "continued downwards",
}
_COORDINATES = {
    f"{letter}{number}": f"{words} {number}"
    for number in (1, 2)
    for letter, words in (("xi", "displacement"), ("v", "velocity"))
}
MOST_VALUES, MOST_TRANSIENT = 2000, 20_000  # that can be typed: with more, a diagram outlasts its time
_BRANCHES = {"off": "not shown", "on": "of the diagram", "both": "reference and penalty"}
_SOLVERS = {"reference": "reference", "exact": "exact penalty", "newmark": "penalty with a time step"}


_FOLLOWED = zip(_NAMES, (FIELDS["eta"].bounds, *[LINEAR] * len(START_FIELDS)), strict=True)
CHOICES = (
    ViewChoice("over", "Swept", "eta", {name: swept.choice for name, swept in SWEPT.items()}),
    ViewChoice("solver", "Solver", "reference", _SOLVERS),
    ViewChoice("direction", "Start", "rest", DIRECTION_NAMES),
    ViewChoice("coordinate", "Coordinate", "xi2", _COORDINATES, of_body_2=("xi2", "v2")),
    ViewChoice("branches", "Branches", "off", _BRANCHES),
    ViewChoice("from", "From", 0.0, bounds=LINEAR, linked=False),
    ViewChoice("to", "To", 0.0, bounds=LINEAR, linked=False),
    ViewChoice("count", "Values", COUNT, bounds=(2, MOST_VALUES)),
    ViewChoice("transient", "Transient (periods)", TRANSIENT, bounds=(0, MOST_TRANSIENT)),
    *(
        ViewChoice(
            *(name, FIELDS[name].label, 0.0),
            bounds=FIELDS[name].bounds,
            when={"direction": "own"},
            of_body_2=() if "wall" in FIELDS[name].bodies else (name,),
        )
        for name in START_FIELDS
    ),
    *(ViewChoice(name, "", None, bounds=bounds, shown=False) for name, bounds in _FOLLOWED),
)
HINT = (
    "Drag the line, click, or use the slider to set the swept number. A zoom is computed anew at its own range. Hollow "
    "points are a periodic motion that the time step blurs. In grey, once computed: the other direction (motions "
    "coexist where they differ), or the reference. Branches are solid where they are stable, dashed where they are "
    "not; a click on one opens that motion in Explore."
)
CURSOR = {  # the line that can be dragged
    "figure": "bifurcation",
    "span": "bifurcation_cursor",
    "label": "bifurcation_label",
    "by": "over",
    "swept": {
        name: {"name": name, "symbol": swept.field.label, "bounds": list(swept.field.bounds), "parts": swept.parts}
        for name, swept in SWEPT.items()
    },
}
