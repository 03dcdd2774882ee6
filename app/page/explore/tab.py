"""Explore: both solvers for what is set, laid over each other, with what the difference means."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import panel as pn
from vibroscope.app.explorer import words
from vibroscope.app.explorer.compute import Frame, Latest, kept_frame
from vibroscope.app.explorer.diagrams import kept
from vibroscope.app.explorer.link import LINEAR
from vibroscope.app.explorer.present import WINDOW, Columns, factor_of, present
from vibroscope.app.explorer.scenes import scene_of
from vibroscope.app.explorer.state import Setting, print_number
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.tables import DIFFERENCE, FIGURES, difference_of, table_of
from vibroscope.app.page.delivery import prepared
from vibroscope.app.page.explore.diagram import DiagramView
from vibroscope.app.page.explore.displacement import DisplacementView
from vibroscope.app.page.explore.explaining import Explaining
from vibroscope.app.page.explore.findings import Findings
from vibroscope.app.page.explore.force import ForceView
from vibroscope.app.page.explore.mechanism import Mechanism
from vibroscope.app.page.explore.phase import PhaseView
from vibroscope.app.page.explore.pin import Pin
from vibroscope.app.page.explore.suggesting import Suggesting
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.feed import Feed
from vibroscope.app.page.shared.figure import PARTS
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.tab import COMPUTING, Desk, Move, Tab
from vibroscope.engine import Diagram, Units

_WHOSE = {"diagram": "reference", "front": "found"}  # figures of one series, and what its rows are called


@dataclass(frozen=True, eq=False)
class _Ready:
    """What the views need of a frame, and no more: its runs hold 3 MB, and this may wait long for its turn."""

    setting: Setting
    columns: dict[str, Columns]
    told: words.Told


def _ready(frame: Frame) -> _Ready:
    return _Ready(frame.setting, present(frame), words.tell(frame))


class Explore(Tab):
    """The figures of one setting."""

    key = "explore"
    title = "Explore"
    motions = True
    axes = dict.fromkeys(("time", "x1", "x2", "v1", "v2", "displacement", "force", "impulse", "eta", "section"), LINEAR)
    legends = {  # noqa: RUF012 - read only
        **dict.fromkeys(("phase1", "phase2"), ("reference", "penalty", "pinned")),
        "displacement": ("reference1", "reference2", "penalty1", "penalty2", *PARTS, "pinned"),
        "force": ("reference", "reference_impulses", "penalty", "penalty_impulses", "pinned"),
    }

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self._latest = Latest(prepared(desk, _ready, self._arrived, self._failed))
        self._explaining = Explaining(desk, lambda: self._visible, self._mean)
        self._pin = Pin(desk, self._draw_pinned)
        self._meaning: words.Meaning | None = None
        self._visible = False
        self._fresh = False  # ranges start afresh with the next push
        self._scene = ""
        self._shown: _Ready | None = None
        self._scale: Units | None = None  # that the ranges are in

    def build(self) -> pn.viewable.Viewable:
        """Mechanism, figures and findings; `explore.css` lays them out as a grid."""
        self._time = OwnedRange(0, WINDOW)
        self._feed = Feed()
        self.mechanism = Mechanism()
        self.findings = Findings()
        self._suggesting = Suggesting(self.desk)
        self.phase = PhaseView()
        self.displacement = DisplacementView(self._time.range)
        self.force = ForceView(self._time.range)
        self.diagram = DiagramView(self.phase.sections, self._diagram, self._tapped)
        self.ranges = {"time": self._time, **self.phase.ranges, "displacement": self.displacement.range}
        self.ranges |= {"force": self.force.force, "impulse": self.force.impulse, **self.diagram.ranges}
        figures = [
            *self.phase.figures,
            self.displacement.figure,
            self.displacement.strip,
            self.force.figure,
            self.diagram.figure,
        ]
        self.muting = Muting(self.legends, figures)
        cells = [
            self._feed,
            _cell(self.mechanism, "mechanism"),
            *(_cell(pn.pane.Bokeh(plot, sizing_mode="stretch_both"), plot.name) for plot in figures),
            _cell(self.findings, "findings"),
            _cell(self._suggesting.view, "suggest"),
        ]
        return pn.Column(
            *cells, css_classes=["desk"], stylesheets=[style("explore/explore")], sizing_mode="stretch_both"
        )

    # -- the open tab --------------------------------------------------------

    def at_once(self, move: Move) -> bool:
        """A setting that was solved before goes out with the page itself, a round trip earlier."""
        frame = kept_frame(move.setting)
        if frame is None:
            return False
        self._visible = True
        self._suggesting.follow(move.setting)
        self._arrived(move.number, _ready(frame))
        return True

    def show(self, move: Move) -> None:
        """Solve and draw."""
        self._visible = True
        self._fresh |= move.fresh
        self._explaining.withdraw()
        self._suggesting.follow(move.setting)
        self._latest.submit(move.number, move.setting)

    def summary(self, setting: Setting) -> str:
        """The verdict, once it is known."""
        return self._said() if setting == self.shown() and self._meaning is not None else COMPUTING

    def hide(self) -> None:
        """What is still solved will not be drawn."""
        self._visible = False
        self._suggesting.withdraw()

    def close(self) -> None:
        """Nothing more is wanted."""
        self._latest.close()
        self._explaining.close()
        self._pin.close()
        self._suggesting.close()

    # -- what can be taken away ----------------------------------------------

    def figures(self) -> list[Figure]:
        """All, once there is a result; the map once it has been read or computed, a suggestion once it is found."""
        if self._shown is None:
            return []
        drawn = FIGURES | ({"displacement": DIFFERENCE} if self._in_parts else {})
        there = {"diagram": self.diagram.ready, "front": bool(self._suggesting.front)}
        return [figure for figure in drawn.values() if there.get(figure.name, True)]

    def table(self, name: str) -> list[Series]:
        """The columns that are drawn, in the units that are shown."""
        setting, columns = self._shown.setting, self.data()
        if name in _WHOSE:
            return [Series(_WHOSE[name], columns[name])]
        if name == "displacement" and self._in_parts:
            return difference_of(columns["difference"], setting.coordinate, setting.scale)
        return table_of(name, columns, setting.scale)

    def data(self) -> dict[str, object]:
        """The columns of all sources, the difference, the map and what a search has found."""
        more = {"difference": dict(self.displacement.difference.data)} if self._in_parts else {}
        more |= {"front": self._suggesting.front} if self._suggesting.front else {}
        return {**self._shown.columns, **more, "diagram": self.diagram.in_view()}

    def words(self) -> dict[str, str]:
        """Verdict and motions."""
        return words.lines(self._shown.told, self._meaning)

    def shown(self) -> Setting | None:
        """The last that could be solved."""
        return self._shown.setting if self._shown else None

    @property
    def _in_parts(self) -> bool:
        """Whether the difference is drawn, in place of the displacements."""
        return self._shown.setting.frame == "difference"

    # -- compute -------------------------------------------------------------

    def _arrived(self, move: int, ready: _Ready) -> None:
        if self._visible:
            self.desk.push(move, partial(self._write, ready))

    def _mean(self, meaning: words.Meaning) -> None:
        """The explanation of what is shown has come."""
        if meaning is not self._meaning:
            with pn.io.hold(self.desk.doc):  # one message
                self._tell(self._shown.told, meaning)

    def _tell(self, told: words.Told, meaning: words.Meaning | None) -> None:
        self._meaning = meaning
        self.findings.update(told, meaning)
        self.displacement.explain(meaning.series if meaning else {}, self._shown.setting)
        if meaning is not None:  # a screen reader is told once, when all is known
            self.desk.summarise(self._said())

    def _said(self) -> str:
        return " ".join(f"{head}: {text}" for head, text in self.words().items())

    def _failed(self, move: int, error: Exception) -> None:
        self.desk.tell(
            f"This setting could not be computed ({words.cause(error)}). The figures show the last one that could: "
            "undo, or change what you moved last.",
            move,
        )

    def _diagram(self, joint_damping: str) -> Diagram | None:
        """The kept diagram, or None until it has been read or computed."""
        future = kept(joint_damping)
        if not future.done():
            future.add_done_callback(lambda _: self.desk.later(self._redraw))
            return None
        return future.result() if future.exception() is None else None

    def _redraw(self) -> None:
        with pn.io.hold(self.desk.doc):
            self.diagram.redraw()
            self.desk.offer()

    def _tapped(self, eta: float) -> None:
        self.desk.set({"eta": print_number(eta)})

    # -- push ----------------------------------------------------------------

    def _write(self, ready: _Ready) -> None:
        """All figures, in place."""
        setting, columns = ready.setting, ready.columns
        scene = scene_of(setting)
        if self._fresh:
            self.unzoom()
        fresh = self._fresh or (bool(scene) and scene != self._scene) or setting.scale != self._scale
        self._shown, self._scene, self._scale, self._fresh = ready, scene, setting.scale, False
        self._time.put(0, WINDOW * setting.period, fresh=fresh)
        self._pin.follow(setting)
        for view in (self.phase, self.displacement, self.force):
            for name, source in view.sources.items():
                self._feed.put(source, columns[name])
        self._feed.send()
        self.phase.update(columns, setting, fresh=fresh)
        self.displacement.update(columns, setting, fresh=fresh)
        self.force.update(columns, setting, fresh=fresh)
        self.diagram.update(setting, fresh=fresh)
        self.mechanism.param.update(absolute=setting.frame == "absolute", amplitude=factor_of("displacement", setting))
        self._tell(ready.told, self._explaining.follow(setting))

    def _draw_pinned(self, columns: dict[str, Columns] | None) -> None:
        """As thin grey curves."""
        for view in (self.phase, self.displacement, self.force):
            view.ghost.update(columns)


def _cell(view, name: str):
    view.css_classes = [*view.css_classes, "cell", name]
    return view
