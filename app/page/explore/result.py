"""The columns and words that the figures of Explore need, from both runs of a setting."""

from __future__ import annotations

from dataclasses import dataclass

from vibroscope.app.explorer.compute import RunPair
from vibroscope.app.explorer.explanation import Description, Explanation, describe
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.state import Setting


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
