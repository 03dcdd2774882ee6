"""The points of the map over η: from the shipped diagram of the paper's system, else from a study of the present one.

That study is the one of the tab Bifurcation from rest, so each of the two finds what the other has computed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.diagrams import load_diagram
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.ranges import slider_range
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.studies.bifurcation import DiagramQuestion, PartialDiagram, grow_diagram
from vibroscope.app.studies.study_job import RESULTS, StudyJob
from vibroscope.engine import Reference, System

_REST = 400  # ms without another system before its diagram is computed


class MapPoints(NamedTuple):
    """Points of the map.

    Attributes
    ----------
    eta : (n,) ndarray
    displacement : (2, n, keep) ndarray
        ξ₁ and ξ₂ at τ ≡ 0 mod T.
    share : float
        Of all η that are computed.
    """

    eta: np.ndarray
    displacement: np.ndarray
    share: float


NOTHING = MapPoints(np.empty(0), np.empty((2, 0, 1)), 0.0)


def is_shipped(setting: Setting) -> bool:
    """Whether the diagram of the setting is one of those that are shipped."""
    return setting.system == System() and setting.reference == Reference(setting.joint_damping)


class MapSource:
    """Finds the points of the setting that is followed; ``show`` gets those that come later."""

    def __init__(self, host: TabHost, show: Callable[[MapPoints], None]) -> None:
        self._host = host
        self._show = show
        self._question: DiagramQuestion | None = None
        self._points = NOTHING
        self._asker = Asker(host, _REST)

    def follow(self, setting: Setting) -> MapPoints:
        """The points of the setting that are known now; the rest comes later."""
        question = DiagramQuestion(setting.system, setting.reference, "rest", slider_range("eta", setting.system))
        if question != self._question:
            self.cancel()
            self._question, self._points = question, NOTHING
        if self._points.share < 1 and setting.is_driven:  # a free vibration decays, whatever η is
            self._find(setting)
        return self._points

    def cancel(self) -> None:
        """The map is no longer seen: stop what is computed for it."""
        self._asker.drop()

    def _find(self, setting: Setting) -> None:
        if is_shipped(setting):
            self._load(setting.joint_damping)
            return
        known = RESULTS.get(self._question)
        if known is not None:
            self._points = _points_of(known)
        if self._points.share < 1 and self._asker.job is None:
            self._asker.ask(lambda: StudyJob(self._question, grow_diagram, on_loop(self._host, self._take)))

    def _load(self, joint_damping: str) -> None:
        future, question = load_diagram(joint_damping), self._question
        if not future.done():
            future.add_done_callback(lambda _: self._host.call_later(partial(self._loaded, question, joint_damping)))
        elif future.exception() is None:
            self._points = MapPoints(future.result().eta, future.result().displacement, 1.0)

    def _loaded(self, question: DiagramQuestion, joint_damping: str) -> None:
        if question == self._question and self._points is NOTHING:
            self._load(joint_damping)
            self._show(self._points)

    def _take(self, job: StudyJob, result: PartialDiagram | Exception) -> None:
        if isinstance(result, Exception):
            self._host.report_error(f"The map over η could not be computed ({error_text(result)}).")
            return
        self._points = _points_of(result)
        if self._points.share == 1:  # the map does not show kinds of motion, which the study finds last
            job.cancel()
        self._show(self._points)


def _points_of(result: PartialDiagram) -> MapPoints:
    known = result.known
    sections = [result.section(name)[known] for name in ("xi1", "xi2")]
    return MapPoints(result.question.axis[known], np.stack(sections), result.computed)
