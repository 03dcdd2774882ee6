"""A result of Explore: the columns and words that its figures need, and what is said of it.

The findings: whether both solutions agree, the parts of their difference, each motion, and the cost.
"""

from dataclasses import dataclass

import param
from vibroscope.app.explorer.compute import RunPair
from vibroscope.app.explorer.explanation import Description, Explanation, describe, paragraphs
from vibroscope.app.explorer.field_units import shown_content, words_of_change
from vibroscope.app.explorer.method_words import name_of_integrator
from vibroscope.app.explorer.motion_kind import Kinds, with_kinds
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.component import Component
from vibroscope.engine import PART_NAMES, percent

_EXPLANATION_FIELDS = ("headline", "agree", "measure", "note", "change", "details")
_MEANINGS = {
    "total": ("all of it", "penalty solution against reference"),
    "time_step": (PART_NAMES["time_step"], "its steps against the same spring and damper without a time step"),
    "regularisation": (
        PART_NAMES["regularisation"],
        "contact by spring K and damper D against impacts, both with the joint damping of d₁ and d₂",
    ),
    "joint_damping": (
        PART_NAMES["joint_damping"],
        "joint damping of d₁ and d₂ against the measured d₃, which the penalty model lacks",
    ),
}


class Findings(Component):
    """Plain text in live regions: screen readers read what changes, and no text can become markup."""

    content = param.Dict(default={}, doc="The fields of a description; those of its explanation, once it is known")

    script = "explore/findings"
    sheets = ("shared/scroll_cue",)

    def show(self, found: "Interpretation") -> None:
        """Show a result; until its explanation is known, the previous one stays, greyed.

        Kinds of motion that are not known yet are not shown.
        """
        result, explanation = found.result, found.shown_explanation
        new = result.description.lines(explanation) | {
            "cost": [list(chip) for chip in result.description.cost],  # lists, as the browser's side has them
            "shipped": result.shipped is not None,
            "solver": name_of_integrator(result.setting.integrator),
            "kinds": {name: list(map(str, kind)) for name, kind in (found.shown_kinds or {}).items()},
        }
        if explanation is None:
            new = self.content | new | {"pending": True}
        else:
            new |= {name: getattr(explanation, name) for name in _EXPLANATION_FIELDS}
            new["offer"] = words_of_change(explanation.change, result.setting)
            new["bars"] = [[name, *_MEANINGS[name], value, percent(value)] for name, value in explanation.parts.items()]
        if new != self.content:
            self.content = new


@dataclass(frozen=True, eq=False)
class Result:
    """The columns of both runs and their description. It may wait long, and the runs would hold 3 MB."""

    setting: Setting
    columns: dict[str, Columns]
    description: Description
    shipped: Explanation | None = None  # of a result that comes with the package


def prepare(runs: RunPair) -> Result:
    """The result of both runs."""
    return Result(runs.setting, present(runs), describe(runs))


@dataclass(frozen=True, eq=False)
class Interpretation:
    """A result with its explanation and the kinds of its motions, as far as they are known."""

    result: Result
    explanation: Explanation | None = None
    kinds: Kinds | None = None

    @property
    def shown_explanation(self) -> Explanation | None:
        """The explanation in the units of the setting."""
        return self.explanation and self.explanation.in_units(self.result.setting.scale)

    @property
    def shown_kinds(self) -> Kinds | None:
        """The kinds of the motions, their evidence in the units of the setting."""
        return shown_content(self.kinds, self.result.setting.scale)

    def paragraphs(self) -> dict[str, str]:
        """The text of the findings by headings."""
        return with_kinds(self._texts(), self.shown_kinds)

    def summary(self) -> str:
        """The text of the findings without the kinds of the motions, in one line."""
        return " ".join(f"{head}: {text}" for head, text in self._texts().items())

    def _texts(self) -> dict[str, str]:
        return paragraphs(self.result.description, self.shown_explanation)
