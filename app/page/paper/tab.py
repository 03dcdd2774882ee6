"""The tab Paper: every claim of the paper with its verdict, its figure, and a button that opens its setting.

A claim of the paper as a card: the sentence, the verdict, what was found, why, and a button to its setting.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import panel as pn
import param
from bokeh.plotting import figure
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.drawing import Drawing
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import PAPER_COMMAND, PAPER_PYTHON
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.files import style
from vibroscope.app.page.paper.figures import draw
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.declared import declared
from vibroscope.app.page.shared.figure import THEME
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.tab import Look, Move, TabHost, TabView, on_loop
from vibroscope.app.paper import CLAIMS, Claim, Finding, as_dict, count_verdicts
from vibroscope.app.paper.checks import CHECKED, Checked, begin_check
from vibroscope.app.paper.pictures import table_of
from vibroscope.app.studies.study_job import StudyJob
from vibroscope.engine import counted


class ClaimCard(Component):
    """The card.

    Parameters
    ----------
    claim : dict
        What the card shows at once: ``name``, ``place``, ``text``, ``scene``, and the view that its button opens as
        ``view`` and ``title``.
    on_view : callable
        Called whenever the card comes into view, or the user asks for the check.
    on_cancel : callable
        Called when the user cancels the check.
    """

    claim = param.Dict(default={}, doc="name, place, text, scene; view that the button opens and its title")
    found = param.Dict(default={}, doc="verdict, found, why; or error; or cancelled; empty until it is known")

    script = "paper/card"

    def __init__(self, claim: dict, on_view: Callable[[], None], on_cancel: Callable[[], None]) -> None:
        super().__init__(claim=claim, css_classes=["card"], sizing_mode="stretch_width")
        self.listen(seen=(bool, lambda seen: on_view()), cancel=(bool, lambda cancel: on_cancel()))


_INTRO = """
<article class="text above">
<h2>The paper, claim by claim</h2>
<p>“Penalty-regularization of a dissipative vibro-impacting system”: what it says of its figures, in our words, and
what the engine finds now, with the paper's run of 2,050 periods from rest. A claim is checked when it comes into
view, or when “Take away” needs it. Figures 1, 2, 5, 7 and 8 are drawings of the model and of the experiment; Help
shows the model.</p>
</article>
"""

# In a link an entry of a legend is named by its place: what a legend holds is known once its claim is checked.
ENTRIES = ("entry1", "entry2", "entry3", "entry4")
_GATHERED = 600  # ms: figures that come within are drawn together, since the browser lays out the page for each drawing
_TABLE = Figure("claims", "Claims and findings", "", drawn=False)


class Paper(TabView):
    """Cards whose claims are checked when they come into view.

    Attributes
    ----------
    cards : dict of ClaimCard
        The card of each claim, by key.
    slots : dict of pn.Column
        A column for each claim: its card and, once it is checked, its figure.
    """

    key = "paper"
    title = "The paper’s claims"
    controls = False
    legends = {f"paper{key}": ENTRIES for key in CLAIMS}  # noqa: RUF012 - read only

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self.muting = Muting(self.legends, {})
        self.cards: dict[str, ClaimCard] = {}
        self.slots: dict[str, pn.Column] = {}
        self._requested: set[str] = set()  # came into view, and not checked yet
        self._askers = {key: Asker(host) for key in CLAIMS}
        self._findings: dict[str, Finding] = {}
        self._visible = self._hidden = False
        self._undrawn: list[str] = []  # claims with a finding that is not drawn yet
        self._draw_is_due = False
        self._drop_file()

    def build(self) -> pn.viewable.Viewable:
        """All cards, without figures."""
        for key, claim in CLAIMS.items():
            self.cards[key] = ClaimCard(
                self._card_content(claim), partial(self._request, key), partial(self._cancel, key)
            )
            self.slots[key] = pn.Column(
                self.cards[key], css_classes=["slot"], stylesheets=[style("paper/paper")], sizing_mode="stretch_width"
            )
        intro = pn.pane.HTML(
            _INTRO, stylesheets=[style("shared/text")], css_classes=["intro"], sizing_mode="stretch_width"
        )
        return pn.Column(
            intro,
            *self.slots.values(),
            css_classes=["claims"],
            stylesheets=[style("paper/paper")],
            sizing_mode="stretch_width",
        )

    def _card_content(self, claim: Claim) -> dict:
        """The content of a card before its claim is checked."""
        words = {"name": claim.name, "place": claim.place, "text": claim.text, "scene": claim.scene}
        return words | {"view": claim.view, "title": self.host.view_titles[claim.view]}

    def show(self, move: Move) -> None:
        """Request again what came into view before another tab was opened."""
        self._visible, self._hidden = True, False
        self._draw_soon()
        for key in tuple(self._requested):
            self._ask(key)
        super().show(move)

    def summary(self, setting: Setting) -> str:
        """How many claims agree and differ; a claim is checked when it comes into view."""
        return self._tally()

    def hide(self) -> None:
        """Withdraw what is not checked yet: a hidden tab checks nothing, and draws nothing."""
        self._visible, self._hidden = False, True
        self._drop_file()
        for asker in self._askers.values():
            asker.drop()

    # -- export --------------------------------------------------------------

    def prepare(self, what: str, take: Callable[[], None]) -> None:
        """Check the claims that the file holds, also those that never came into view; the last file counts."""
        figure = what.partition(":")[2]
        every = what in ("json", "report") or figure == _TABLE.name
        self._take, self._needed = take, {key for key in CLAIMS if every or figure == f"paper{key}"}
        for key in self._needed:
            self._request(key)
        self._take_if_ready()

    def awaited(self) -> str:
        """The number of claims that a requested file waits for, in words."""
        count = len(self._needed - self._findings.keys())
        return f"Checking {counted(count, 'claim')} for this file …" if count else ""

    def _take_if_ready(self) -> None:
        if self._take is not None and self._needed <= self._findings.keys() - set(self._undrawn):
            take = self._take
            self._drop_file()
            take()

    def _drop_file(self) -> None:
        self._take, self._needed = None, set()

    def _miss(self, key: str, why: str) -> None:
        """A claim will not be checked: the file that waits for it does not come."""
        if key in self._needed:
            self._drop_file()
            self.host.report_error(f"The file was not made: the check of {CLAIMS[key].name} {why}.")

    def figures(self) -> list[Figure]:
        """The table of claims, and the figure of each claim."""
        found = (Figure(f"paper{key}", claim.name, f"{claim.name}. {claim.text}") for key, claim in CLAIMS.items())
        return [_TABLE, *found]

    def drawing(self, name: str, look: Look) -> Callable[[], Drawing]:
        """The figure of a claim, which has none on the page before it has come into view."""
        if self.host.doc.get_model_by_name(name):
            return super().drawing(name, look)
        return lambda: declared(self._plot(name.removeprefix("paper")), dark=look.dark)

    def table(self, name: str) -> list[Series]:
        """The findings, or what a figure is drawn from."""
        if name != _TABLE.name:
            return table_of(self._findings[name.removeprefix("paper")].picture)
        return [Series(row.pop("figure"), {n: np.array([cell]) for n, cell in row.items()}) for row in self._rows()]

    def data(self) -> dict[str, object]:
        """The findings."""
        return {"claims": self._rows()}

    def words(self) -> dict[str, str]:
        """The findings in words, by claim."""
        return {
            f"{row['figure']} ({row['verdict']}): {row['claim']}": f"{row['found']} {row['why']}".strip()
            for row in self._rows()
        }

    def python(self, setting: Setting) -> str:
        """A script that checks all claims."""
        return PAPER_PYTHON

    def command(self, setting: Setting) -> str:
        """The command that checks all claims."""
        return PAPER_COMMAND

    def _tally(self) -> str:
        found = f"{len(self._findings)} of {len(CLAIMS)} claims checked"
        verdicts = [CLAIMS[key].verdict(finding) for key, finding in self._findings.items()]
        return f"{found}: {count_verdicts(verdicts)}." if verdicts else f"{found}."

    def _rows(self) -> list[dict]:
        return [as_dict(claim, self._findings[key]) for key, claim in CLAIMS.items() if key in self._findings]

    # -- checks --------------------------------------------------------------

    def _request(self, key: str) -> None:
        """Have a claim checked, once."""
        if key not in self._requested and key not in self._findings:
            self._requested.add(key)
            self.cards[key].found = {}
            self._ask(key)

    def _ask(self, key: str) -> None:
        checked = CHECKED.get(key)
        if checked is not None:
            self._found(key, checked.finding)
        else:
            self._askers[key].ask(partial(begin_check, key, on_loop(self.host, self._show_result)))

    def _cancel(self, key: str) -> None:
        """Let a check be; its card offers to begin anew."""
        if key in self._requested:
            self._requested.discard(key)
            self._askers[key].drop()
            self.cards[key].found = {"cancelled": True}
            self._miss(key, "was cancelled")

    def _show_result(self, job: StudyJob, result: Checked | Exception) -> None:
        """Show a finding on its card, with its figure, or why the claim could not be checked."""
        if isinstance(result, Checked):
            self._found(job.question, result.finding)
            return
        again = "Open another tab and come back to try again."  # it stays requested
        self.cards[job.question].found = {"error": f"This could not be checked ({error_text(result)}). {again}"}
        self._miss(job.question, "failed")

    def _found(self, key: str, finding: Finding) -> None:
        self._requested.discard(key)
        self._findings[key] = finding
        self._undrawn.append(key)
        self._draw_soon()
        self.host.update_offers()
        if self._visible and not self._requested:  # for screen readers: once, when all in view is known
            self.host.summarise(self._tally())

    def _draw_soon(self) -> None:
        if self._undrawn and not self._draw_is_due:
            self._draw_is_due = True
            self.host.doc.add_timeout_callback(self._draw, _GATHERED)

    def _draw(self) -> None:
        """Draw the findings that have come; none while the tab is hidden, or the browser would be busy with them."""
        self._draw_is_due = False
        if self._hidden:
            return
        keys, self._undrawn = self._undrawn, []
        self.host.add_models(partial(self._add_pictures, keys), partial(self._show_findings, keys))

    def _add_pictures(self, keys: Sequence[str]) -> None:
        for key in keys:
            plot = self._plot(key)
            for name, item in zip(ENTRIES, plot.legend[0].items if plot.legend else (), strict=False):
                self.muting.watch(plot.name, name, item)
            # without a theme of its own Panel gives it the dark one of its own for a link with "theme=dark"
            picture = pn.pane.Bokeh(plot, theme=THEME, css_classes=["picture"], sizing_mode="stretch_width")
            self.slots[key].append(picture)

    def _plot(self, key: str) -> figure:
        plot = draw(self._findings[key].picture, f"paper{key}")
        say(plot, CLAIMS[key].name, self._findings[key].result)
        plot.title.visible = False  # for screen readers: the card has it beside the picture
        return plot

    def _show_findings(self, keys: Sequence[str]) -> None:
        for key in keys:  # after its figure, to which the browser then gives the theme
            found = self._findings[key]
            verdict = CLAIMS[key].verdict(found)
            self.cards[key].found = {"verdict": verdict, "found": found.result, "why": found.reason}
        self._take_if_ready()
