"""The findings: whether both solutions agree, the parts of their difference, each motion, and the cost."""

from __future__ import annotations

import param
from vibroscope.app.explorer.explanation import Description, Explanation
from vibroscope.app.explorer.motion_kind import Kinds
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

    def update(
        self,
        description: Description,
        explanation: Explanation | None,
        kinds: Kinds | None,
        *,
        shipped: bool = False,
        offer: str = "",
        solver: str = "Newmark",
    ) -> None:
        """Show a new description; until its explanation is known, the previous one stays, greyed.

        Kinds of motion that are not known yet are not shown. ``shipped``: all this comes with the package and was not
        computed on this machine. ``offer``: the change to try, in words. ``solver``: the name of
        the penalty solution's integrator.
        """
        # lists, as the browser's side has them
        cost = [list(chip) for chip in description.cost]
        new = description.lines(explanation) | {"cost": cost, "shipped": shipped, "solver": solver}
        new["kinds"] = {name: list(map(str, kind)) for name, kind in (kinds or {}).items()}
        if explanation is None:
            new = self.content | new | {"pending": True}
        else:
            new |= {name: getattr(explanation, name) for name in _EXPLANATION_FIELDS} | {"offer": offer}
            new["bars"] = [[name, *_MEANINGS[name], value, percent(value)] for name, value in explanation.parts.items()]
        if new != self.content:
            self.content = new
