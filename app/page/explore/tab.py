"""Explore: both solvers for the present setting, drawn over each other, and what their difference means."""

from collections.abc import Callable
from functools import partial

import panel as pn
from vibroscope.app.explorer.closed_orbit import FARTHEST, LONGEST, SOLVERS, ClosedOrbit
from vibroscope.app.explorer.compute import JobQueue, cached_runs, compute_runs, shown_periods
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.explanation import AloneFacts, Explanation
from vibroscope.app.explorer.link import LINEAR, View, ViewChoice
from vibroscope.app.explorer.measured import Placed
from vibroscope.app.explorer.motion_kind import Kinds
from vibroscope.app.explorer.presets import Preset, preset_of
from vibroscope.app.explorer.shipped import shipped_result
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.drawing import Drawing
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import as_command
from vibroscope.app.export.tables import DIFFERENCE, FIGURES, columns_in_units, difference_table, figure_table
from vibroscope.app.page.explore.alone import NUMBERS, AloneView
from vibroscope.app.page.explore.column_sender import ColumnSender
from vibroscope.app.page.explore.comparison import PinComparison, PinnedResults
from vibroscope.app.page.explore.drawn import body_drawing, front_drawing
from vibroscope.app.page.explore.eta_map import EtaMapView, MapPoints, MapSource
from vibroscope.app.page.explore.explainer import Explainer, MotionJudge
from vibroscope.app.page.explore.figures import MotionView
from vibroscope.app.page.explore.measurement import Overlay
from vibroscope.app.page.explore.mechanism import Mechanism
from vibroscope.app.page.explore.other_motions import CoexistingMotions, OpenedMotion
from vibroscope.app.page.explore.result import Findings, Interpretation, Result, prepare
from vibroscope.app.page.explore.suggest import Suggester
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.declared import declared
from vibroscope.app.page.shared.figure import PIN_NAMES
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.tab import COMPUTING, Look, Move, TabHost, TabView
from vibroscope.engine import Units
from vibroscope.engine.arguments import Poll
from vibroscope.engine.simulate import LONGEST_FLIGHT

_GRID = "explore-grid"  # a class of `explore.css`
_SINGLE = {"diagram": "reference", "front": "found", "comparison": "compared"}  # figures with one series: its label
_ALONE = "alone_"  # begins the names of the figures over each number alone
# Entries of legends that come after those of pins.
_LATER = dict.fromkeys(("phase1", "phase2"), ("measured", "branch")) | {"displacement": ("measured",), "force": ()}


class Explore(TabView):
    """The figures of one setting."""

    key = "explore"
    title = "Explore"
    starts = motions = True
    axes = MotionView.spans() | dict.fromkeys(("eta", "section"), LINEAR)
    legends = {name: (*entries, *PIN_NAMES, *_LATER[name]) for name, entries in MotionView.legends().items()}  # noqa: RUF012

    choices = (  # at what phase a link may hold the motion, and the motion that was opened from a branch
        ViewChoice("phase", "", 0.0, {}, (0, LONGEST_FLIGHT)),
        *(ViewChoice(name, "", 1, {}, (1, LONGEST)) for name in SOLVERS),
        ViewChoice("orbit_xi1", "", 0.0, {}, (-FARTHEST, FARTHEST)),
    )

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self._queue = JobQueue(lambda *found: host.call_later(partial(self._take, *found)), solve=self._solve)
        self._explainer = Explainer(host, lambda: self._visible, self._show_explanation, self._show_alone)
        self._judge = MotionJudge(host, self._show_kinds)
        self._kinds: Kinds | None = None
        self._pinned = PinnedResults(host, self._redraw)
        self._measured = Overlay(host, self._redraw)
        self._map = MapSource(host, self._redraw_map)
        self._explanation: Explanation | None = None
        self._visible = False
        self._fresh = False  # the next update fits all axes to the data
        self._scene: Preset | None = None
        self._result: Result | None = None
        self._scale: Units | None = None  # the units of the axes

    def build(self) -> pn.viewable.Viewable:
        """Make mechanism, figures and findings; `explore.css` arranges them in a grid."""
        self.motion = MotionView()
        self.eta_map = EtaMapView(self.motion.sources)
        self.eta_map.set_texts = self.host.set
        self._sender = ColumnSender()
        self._alone = AloneView()
        self._alone.set_texts = self.host.set
        self.mechanism = Mechanism()
        self.findings = Findings()
        self.findings.listen(further=(bool, lambda _: self._add_alone()))
        self._suggester = Suggester(self.host)
        self._coexisting = CoexistingMotions(self.host)
        self._opened = OpenedMotion()
        self._opened.on_close = self._redraw
        self._followers = (self._suggester, self._coexisting, self._opened)
        self.ranges = self.motion.ranges | self.eta_map.ranges
        figures = [self.motion.figures[name] for name in ("phase1", "phase2", "displacement", "strip", "force")]
        figures.append(self.eta_map.figure)
        self.muting = Muting(self.legends, self.motion.items)
        self.motion.on_legend = self.muting.watch
        self._measured.button.css_classes = [*self._measured.button.css_classes, "measurement-choice"]
        self.comparison = PinComparison()
        grid = style("explore/explore")
        cards = self._opened, self._measured.panel, self.comparison
        for card in cards:
            card.css_classes = [*card.css_classes, "card"]
        cells = [
            self._sender,
            _cell(pn.Column(*cards, stylesheets=[grid]), "above"),
            _cell(self.mechanism, "mechanism"),
            *(_cell(pn.pane.Bokeh(plot, sizing_mode="stretch_both"), plot.name) for plot in figures),
            _cell(self.findings, "findings"),
            _cell(self._alone.view, "alone"),
            _cell(self._coexisting.view, "coexisting"),
            _cell(self._suggester.view, "suggest"),
            self._measured.button,
        ]
        self._grid = pn.Column(*cells, css_classes=[_GRID], stylesheets=[grid], sizing_mode="stretch_both")
        return self._grid

    # -- the view ----------------------------------------------------------------------

    def restore(self, view: View) -> None:
        """See `TabView.restore`."""
        super().restore(view)
        self.mechanism.held = view.choice.get("phase")
        self._opened.restore({name: number for name, number in view.choice.items() if name != "phase"})

    def choice(self) -> dict[str, float]:
        """The phase, if the user holds the motion, and what was opened from a branch."""
        held = {} if self.mechanism.held is None else {"phase": self.mechanism.held}
        return held | self._opened.choice()

    def watch_view(self, on_change: Callable[[], None]) -> None:
        """See `TabView.watch_view`."""
        super().watch_view(on_change)
        self.mechanism.on_hold = on_change

        def closed() -> None:
            self._redraw()
            on_change()

        self._opened.on_close = closed

    # -- the open tab ------------------------------------------------------------------

    def show_if_ready(self, move: Move) -> bool:
        """Send a cached result with the page itself, which saves a round trip."""
        self._visible = True
        runs = cached_runs(move.setting)
        if runs is not None:
            self._follow(move.setting)
            self._push(move.number, prepare(runs))
            return True
        ready = self._push_shipped(move)
        if ready:
            self._follow(move.setting)
            self._queue.submit(move.number, move.setting)
        return ready

    def show(self, move: Move) -> None:
        """Compute and draw."""
        self._visible = True
        self._fresh |= move.fresh
        self._explainer.drop()
        self._judge.drop()
        self._measured.cancel()
        self._follow(move.setting)
        self._push_shipped(move)
        self._queue.submit(move.number, move.setting)

    def announce(self, texts: dict[str, str], words: str, orbit: ClosedOrbit) -> None:
        """Say what is to be known of the motion that ``texts`` set, and draw it."""
        self._opened.announce(texts, words, orbit)

    def _follow(self, setting: Setting) -> None:
        for part in self._followers:
            part.follow(setting)

    def summary(self, setting: Setting) -> str:
        """The text of the findings, once it is complete."""
        known = setting == self.shown_setting() and self._explanation is not None
        return self._interpretation.summary() if known else COMPUTING

    def hide(self) -> None:
        """Another tab was opened: what is still computed will not be drawn."""
        self._visible = False
        self._judge.drop()
        self._suggester.cancel()
        self._coexisting.hide()
        self._map.drop()

    def close(self) -> None:
        """The session has ended."""
        for part in (self._map, self._explainer, self._judge, self._pinned):
            part.drop()
        for part in (self._queue, self._measured, *self._followers):
            part.close()

    # -- files to take away ------------------------------------------------------------

    def figures(self) -> list[Figure]:
        """All figures once there is a result; the map, a suggestion and curves over numbers once they are found."""
        if self._result is None:
            return []
        figures = FIGURES | ({"displacement": DIFFERENCE} if self._draws_difference else {})
        ready = {"diagram": self.eta_map.ready, "front": bool(self._suggester.front)}
        ready |= {f"{_ALONE}{number}": number in self._alone.numbers for number in NUMBERS}
        ready |= {"comparison": bool(self.comparison.rows), "phase2": self._result.setting.bodies != "wall"}
        return [figure for figure in figures.values() if ready.get(figure.name, True)]

    def table(self, name: str) -> list[Series]:
        """The columns that are drawn, in the units of the setting."""
        setting, columns = self._result.setting, self.data()
        if name.startswith(_ALONE):
            return self._alone.table(name.removeprefix(_ALONE))
        if name in _SINGLE:
            return [Series(_SINGLE[name], columns[name])]
        if name == "displacement" and self._draws_difference:
            return difference_table(columns["difference"], setting.coordinate, setting.scale)
        located, wall = setting.located == "yes", setting.bodies == "wall"
        return figure_table(name, columns, setting.scale, located=located, wall=wall)

    def drawing(self, name: str, look: Look) -> Callable[[], Drawing]:
        """A function that gives one of the figures."""
        if name == "mechanism":
            return lambda: body_drawing(look.bodies, dark=look.dark)
        if name.startswith(_ALONE):  # folded at first, and not on the page then
            alone = declared(self._alone.figures[name.removeprefix(_ALONE)], dark=look.dark)
            return lambda: alone
        if name == "front":
            return partial(front_drawing, self._suggester.front, self._suggester.tolerance, dark=look.dark)
        return super().drawing(name, look)

    def data(self) -> dict[str, object]:
        """The columns of all sources, of the difference, the map, a suggestion and a measurement."""
        scale, front, placed = self._result.setting.scale, self._suggester.front, self._place()
        more = {"difference": dict(self.motion.sources["difference"].data)} if self._draws_difference else {}
        more |= {"front": front} if front else {}
        more |= {"comparison": columns_in_units(self.comparison.table, scale)} if self.comparison.rows else {}
        more |= {"alone": self._alone.facts} if self._alone.facts else {}
        more |= {"measured": placed._asdict()} if len(placed.phase["x1"]) else {}
        return {**self._result.columns, **more, "diagram": columns_in_units(self.eta_map.in_view(), scale)}

    @property
    def _draws_difference(self) -> bool:
        return self._result.setting.frame == "difference"

    def words(self) -> dict[str, str]:
        """The text of the findings."""
        return self._interpretation.paragraphs() | self._measured.words

    def suggestion(self) -> list[str]:
        """The result of the search, if there is one."""
        return self._suggester.sentences

    def command(self, setting: Setting) -> str:
        """Commands that find the same numbers, those of the measurement too."""
        return as_command(setting, *self._measured.arguments)

    def shown_setting(self) -> Setting | None:
        """The last setting that could be computed."""
        return self._result.setting if self._result else None

    # -- a result ----------------------------------------------------------------------

    def _push_shipped(self, move: Move) -> bool:
        """Show a shipped result until this machine has computed its own; returns whether there is one."""
        shipped = shipped_result(move.setting)
        if shipped is not None:
            result = Result(move.setting, shipped.columns, shipped.description, shipped.explanation)
            self._push(move.number, result)
        return shipped is not None

    def _solve(self, setting: Setting, cancelled: Poll) -> Result:
        """In a worker: the result, and those of the pins that are drawn beside it."""
        result = prepare(compute_runs(setting, cancelled))
        self._pinned.prepare_like(setting)
        return result

    def _take(self, move: int, found: Result | Exception) -> None:
        if isinstance(found, Exception):
            self._fail(move, found)
        else:
            self._push(move, found)

    def _push(self, move: int, result: Result) -> None:
        if self._visible:
            self.host.push(move, partial(self._draw, result), partial(self._say, result))

    def _fail(self, move: int, error: Exception) -> None:
        self.host.report_error(
            f"This setting could not be computed ({error_text(error)}). The figures show the last one that could be: "
            "undo the last move, or choose another value.",
            move,
        )
        if self._result is not None:  # what belongs to its figures was stopped for this move
            setting = self._result.setting
            self._kinds = self._kinds or self._judge.follow(setting)
            self._update_findings(self._explanation or self._explainer.follow(setting))

    def _draw(self, result: Result) -> None:
        """Change all figures in place."""
        setting = result.setting
        scene = preset_of(setting)
        if self._fresh:
            self.unzoom()
        fresh = self._fresh or (scene is not None and scene != self._scene) or setting.scale != self._scale
        self._result, self._scene, self._scale, self._fresh = result, scene, setting.scale, False
        self._arrange(setting)
        self.ranges["time"].put(0, shown_periods(setting) * setting.period, fresh=fresh)
        self._measured.follow(setting)
        self._pinned.follow(setting)
        self._draw_beside()
        for name, shown in result.columns.items():
            self._sender.put(self.motion.sources[name], shown)
        self._sender.send()
        self.motion.update(setting, fresh=fresh)
        self.eta_map.update(setting, self._map.follow(setting), fresh=fresh)

    def _say(self, result: Result) -> None:
        """Change what stands beside the figures."""
        setting = result.setting
        self.mechanism.follow(setting)
        self._kinds = None if result.shipped else self._judge.follow(setting)
        self._update_findings(result.shipped or self._explainer.follow(setting))

    def _arrange(self, setting: Setting) -> None:
        """Show one phase plot in the place of two if body 2 is a wall, which has none."""
        at_wall = setting.bodies == "wall"
        self.motion.figures["phase2"].visible = not at_wall
        self._grid.css_classes = [_GRID, "at-wall"] if at_wall else [_GRID]

    def _draw_beside(self) -> None:
        """Draw pins, a motion of a branch and a measurement beside both solutions."""
        setting, placed = self._result.setting, self._place()
        points = {"measured_phase": placed.phase, "measured_time": placed.displacements}
        missing = self.motion.draw_beside(self._pinned.columns(setting), self._opened.columns(setting), points)
        if missing:
            self.host.add_models(partial(self.motion.add, missing), self._redraw)

    def _redraw(self) -> None:
        """Draw again what stands beside both solutions."""
        if self._result is not None:
            with pn.io.hold(self.host.doc):
                self._draw_beside()
                self.motion.update(self._result.setting, fresh=False)
                self._compare()

    def _place(self) -> Placed:
        return self._measured.placed(self._result.setting, self._result.columns["displacements"])

    def _compare(self) -> None:
        """Show the numbers of the pinned settings beside those of the present one."""
        self.comparison.show(self._result, self._explanation, self._pinned.results)

    def _show_explanation(self, explanation: Explanation) -> None:
        if explanation is not self._explanation:
            with pn.io.hold(self.host.doc):  # in one message
                self._update_findings(explanation)

    def _show_alone(self, facts: AloneFacts) -> None:
        if self._explanation is None:
            with pn.io.hold(self.host.doc):
                self._draw_alone(facts)

    def _add_alone(self) -> None:
        """The user has opened what is asked for less often."""
        if not self._alone.has_figures:
            self.host.add_models(self._alone.add_figures, self.host.update_offers)

    def _draw_alone(self, facts: AloneFacts | None) -> None:
        """Draw the curves over each number alone, as far as they are known."""
        self._alone.show(facts, self._result.setting, self._sender.put)
        self._sender.send()
        self.host.update_offers()

    def _show_kinds(self, kinds: Kinds) -> None:
        self._kinds = kinds
        self.findings.show(self._interpretation)

    def _update_findings(self, explanation: Explanation | None) -> None:
        self._explanation = explanation
        self.findings.show(self._interpretation)
        self.motion.explain(explanation.series if explanation else {}, self._result.setting)
        self._compare()
        if explanation is None:
            self._alone.wait(self._sender.put)
            self._sender.send()
        if explanation is not None:  # only then, so that a screen reader reads one summary for each result
            self._draw_alone(explanation.alone)
            self._suggester.offer(explanation)
            self.host.summarise(self._interpretation.summary())

    @property
    def _interpretation(self) -> Interpretation:
        return Interpretation(self._result, self._explanation, self._kinds)

    # -- the map over η ----------------------------------------------------------------

    def _redraw_map(self, points: MapPoints) -> None:
        with pn.io.hold(self.host.doc):
            self.eta_map.redraw(points)
            self.host.update_offers()


def _cell(view, name: str):
    view.css_classes = [*view.css_classes, "cell", name]
    return view
