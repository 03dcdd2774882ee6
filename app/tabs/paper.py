"""Paper: every figure of the paper remade from its claims, each with what is found and the way to see more."""

from __future__ import annotations

import json
import logging
from functools import partial

import panel as pn

from app.files import style
from app.paper import CLAIMS, Claim, Finding, as_dict
from app.paper.checks import CHECKS
from app.tabs.base import Desk, Move, Tab
from app.views.claims import ClaimCard, draw

log = logging.getLogger("vibroscope")

_INTRO = """
<article class="text">
<h2>The paper, claim by claim</h2>
<p>“Penalty-regularization of a dissipative vibro-impacting system”: what it says of its figures, in our words, and
what the engine finds now, with the paper's run of 2,050 periods from rest. A claim is checked when it comes into
view. Figures 1, 2, 5, 7 and 8 are drawings of the model and of the experiment; Help shows the model.</p>
</article>
"""


class Paper(Tab):
    """Cards that ask for their check when they are seen."""

    key = "paper"
    title = "Paper"
    controls = False

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self._cards: dict[str, ClaimCard] = {}
        self._slots: dict[str, pn.Column] = {}
        self._asked: set[str] = set()  # seen, and nothing found yet
        self._findings: dict[str, Finding] = {}

    def build(self) -> pn.viewable.Viewable:
        """All cards, without figures."""
        for key, claim in CLAIMS.items():
            self._cards[key] = ClaimCard(_told(claim), partial(self._seen, key))
            self._slots[key] = pn.Column(
                self._cards[key], css_classes=["slot"], stylesheets=[style("paper")], sizing_mode="stretch_width"
            )
        intro = pn.pane.HTML(_INTRO, stylesheets=[style("text")], css_classes=["intro"], sizing_mode="stretch_width")
        return pn.Column(
            intro,
            *self._slots.values(),
            css_classes=["claims"],
            stylesheets=[style("paper")],
            sizing_mode="stretch_width",
        )

    def show(self, move: Move) -> None:
        """Go on with what was seen before another tab was opened."""
        for key in self._asked:
            CHECKS.ask(key, self._deliver)
        super().show(move)

    def hide(self) -> None:
        """Nothing is checked for a tab that nobody sees."""
        CHECKS.withdraw(self._deliver)

    def take(self, what: str) -> dict | None:
        """What has been found so far."""
        if what != "json" or not self._findings:
            return None
        rows = [as_dict(CLAIMS[key], self._findings[key]) for key in CLAIMS if key in self._findings]
        text = json.dumps(rows, ensure_ascii=False, indent=1)
        return {"name": "vibroscope-paper.json", "type": "application/json", "text": text}

    def _seen(self, key: str) -> None:
        """The browser has the card in view."""
        if key not in self._asked and key not in self._findings:
            self._asked.add(key)
            CHECKS.ask(key, self._deliver)

    def _deliver(self, key: str, result: Finding | Exception) -> None:
        """In a worker thread."""
        self.desk.later(partial(self._checked, key, result))

    def _checked(self, key: str, result: Finding | Exception) -> None:
        if key in self._findings:  # asked for again while it was on its way
            return
        self._asked.discard(key)
        if isinstance(result, Exception):
            log.error("checking %s failed", key, exc_info=result)
            self._cards[key].fail(f"This could not be checked ({result}).")
            return
        self._findings[key] = result
        with pn.io.hold(self.desk.doc):
            plot = draw(result.picture, f"paper{key}")
            self._slots[key].append(pn.pane.Bokeh(plot, css_classes=["picture"], sizing_mode="stretch_width"))
            self._cards[key].update(result)


def _told(claim: Claim) -> dict:
    """What a card says before anything is known."""
    from app.tabs import TABS  # which holds this tab

    tab = TABS.get(claim.tab) or TABS["explore"]
    told = {"name": claim.name, "place": claim.place, "text": claim.text, "scene": claim.scene}
    return told | {"tab": tab.key, "title": tab.title}
