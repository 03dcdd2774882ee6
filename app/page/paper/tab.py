"""Paper: every figure of the paper remade from its claims, each with what is found and the way to see more."""

from __future__ import annotations

from functools import partial

import numpy as np
import panel as pn
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import PAPER_COMMAND, PAPER_PYTHON
from vibroscope.app.page.files import style
from vibroscope.app.page.paper.claims import ClaimCard, draw
from vibroscope.app.page.tab import Move, Tab, TabHost
from vibroscope.app.paper import CLAIMS, Claim, Finding, as_dict, tally
from vibroscope.app.paper.checks import CHECKS
from vibroscope.app.paper.tables import table_of

_INTRO = """
<article class="text above">
<h2>The paper, claim by claim</h2>
<p>“Penalty-regularization of a dissipative vibro-impacting system”: what it says of its figures, in our words, and
what the engine finds now, with the paper's run of 2,050 periods from rest. A claim is checked when it comes into
view. Figures 1, 2, 5, 7 and 8 are drawings of the model and of the experiment; Help shows the model.</p>
</article>
"""


_CLAIMS = Figure("claims", "Claims and findings", "", drawn=False)


class Paper(Tab):
    """Cards that ask for their check when they are seen."""

    key = "paper"
    title = "Paper"
    controls = False

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self._cards: dict[str, ClaimCard] = {}
        self._slots: dict[str, pn.Column] = {}
        self._asked: set[str] = set()  # seen, and nothing found yet
        self._findings: dict[str, Finding] = {}
        self._visible = False

    def build(self) -> pn.viewable.Viewable:
        """All cards, without figures."""
        for key, claim in CLAIMS.items():
            self._cards[key] = ClaimCard(_told(claim), partial(self._seen, key))
            self._slots[key] = pn.Column(
                self._cards[key], css_classes=["slot"], stylesheets=[style("paper/paper")], sizing_mode="stretch_width"
            )
        intro = pn.pane.HTML(
            _INTRO, stylesheets=[style("shared/text")], css_classes=["intro"], sizing_mode="stretch_width"
        )
        return pn.Column(
            intro,
            *self._slots.values(),
            css_classes=["claims"],
            stylesheets=[style("paper/paper")],
            sizing_mode="stretch_width",
        )

    def show(self, move: Move) -> None:
        """Go on with what was seen before another tab was opened."""
        self._visible = True
        for key in self._asked:
            CHECKS.ask(key, self._deliver)
        super().show(move)

    def summary(self, setting: Setting) -> str:
        """How many claims agree and differ; a claim is checked when it comes into view."""
        return self._tally()

    def hide(self) -> None:
        """Nothing is checked for a tab that nobody sees."""
        self._visible = False
        CHECKS.withdraw(self._deliver)

    # -- what can be taken away ----------------------------------------------

    def figures(self) -> list[Figure]:
        """The claims, and the figure of each that has been checked."""
        found = [
            Figure(f"paper{key}", claim.name, f"{claim.name}. {claim.text}")
            for key, claim in CLAIMS.items()
            if key in self._findings
        ]
        return [_CLAIMS, *found] if found else []

    def table(self, name: str) -> list[Series]:
        """What was found of each claim, or what a figure is drawn from."""
        if name != _CLAIMS.name:
            return table_of(self._findings[name.removeprefix("paper")].picture)
        return [Series(row.pop("figure"), {n: np.array([cell]) for n, cell in row.items()}) for row in self._rows()]

    def data(self) -> dict[str, object]:
        """What was found of each claim."""
        return {"claims": self._rows()}

    def words(self) -> dict[str, str]:
        """What was found, claim by claim."""
        return {
            f"{row['figure']} ({row['verdict']}): {row['claim']}": f"{row['found']} {row['why']}".strip()
            for row in self._rows()
        }

    def python(self, setting: Setting) -> str:
        """All claims."""
        return PAPER_PYTHON

    def command(self, setting: Setting) -> str:
        """All claims."""
        return PAPER_COMMAND

    def _tally(self) -> str:
        found = f"{len(self._findings)} of {len(CLAIMS)} claims checked"
        verdicts = [CLAIMS[key].verdict(finding) for key, finding in self._findings.items()]
        return f"{found}: {tally(verdicts)}." if verdicts else f"{found}."

    def _rows(self) -> list[dict]:
        return [as_dict(claim, self._findings[key]) for key, claim in CLAIMS.items() if key in self._findings]

    # -- checks --------------------------------------------------------------

    def _seen(self, key: str) -> None:
        """The browser has the card in view."""
        if key not in self._asked and key not in self._findings:
            self._asked.add(key)
            CHECKS.ask(key, self._deliver)

    def _deliver(self, key: str, result: Finding | Exception) -> None:
        """In a worker thread."""
        self.host.call_later(partial(self._checked, key, result))

    def _checked(self, key: str, result: Finding | Exception) -> None:
        if key in self._findings:  # asked for again while it was on its way
            return
        if isinstance(result, Exception):  # still asked for: `show` does so again
            self._cards[key].fail(
                f"This could not be checked ({error_text(result)}). Open another tab and come back to try again."
            )
            return
        self._asked.discard(key)
        self._findings[key] = result
        with pn.io.hold(self.host.doc):
            plot = draw(result.picture, f"paper{key}")
            self._slots[key].append(pn.pane.Bokeh(plot, css_classes=["picture"], sizing_mode="stretch_width"))
            self._cards[key].update(CLAIMS[key].verdict(result), result)
            self.host.update_offers()
            if self._visible and not self._asked:  # a screen reader is told once, when all that is in view is known
                self.host.summarise(self._tally())


def _told(claim: Claim) -> dict:
    """What a card says before anything is known."""
    from vibroscope.app.page.tabs import TABS  # which holds this tab

    tab = TABS.get(claim.tab) or TABS["explore"]
    told = {"name": claim.name, "place": claim.place, "text": claim.text, "scene": claim.scene}
    return told | {"tab": tab.key, "title": tab.title}
