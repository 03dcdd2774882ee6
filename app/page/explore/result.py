"""A result of Explore: the columns and words that its figures need, and what is said of it."""

from __future__ import annotations

from dataclasses import dataclass

from vibroscope.app.explorer.compute import RunPair
from vibroscope.app.explorer.explanation import Description, Explanation, describe, paragraphs
from vibroscope.app.explorer.motion_kind import Kinds, with_kinds
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.statements import shown_text, words_of_change


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
        scale = self.result.setting.scale
        return self.kinds and {
            name: kind._replace(evidence=shown_text(kind.evidence, scale)) for name, kind in self.kinds.items()
        }

    @property
    def offer(self) -> str:
        """The words of the change that the explanation proposes; empty while it is not known."""
        explanation = self.shown_explanation
        return words_of_change(explanation.change, self.result.setting) if explanation else ""

    def paragraphs(self) -> dict[str, str]:
        """The text of the findings by headings."""
        return with_kinds(self._texts(), self.shown_kinds)

    def summary(self) -> str:
        """The text of the findings without the kinds of the motions, in one line."""
        return " ".join(f"{head}: {text}" for head, text in self._texts().items())

    def _texts(self) -> dict[str, str]:
        return paragraphs(self.result.description, self.shown_explanation)
