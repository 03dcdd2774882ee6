"""The list below the figures of a tab: tables, and searches that fill them while a user watches."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import param
from vibroscope.app.page.asker import StudyAsker
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.curves import Curves
from vibroscope.app.page.tab import TabHost
from vibroscope.app.studies.study_job import Grow, PartialResult
from vibroscope.engine.facts import Statement, joined


class ListPanel(Component):
    """Two tables, of what can be opened, too. Sends ``{"open": name in a cell}``, ``{"stop": true or false}``."""

    label = param.String(default="Branches of periodic motions", doc="For screen readers")
    status = param.Dict(default={}, doc="text, running, stopped, notes")
    near = param.Dict(default={}, doc="What is near to what is set: title, heads and rows")
    points = param.Dict(default={}, doc="All that was found: title, heads and rows")

    script = "study/list"
    sheets = ("shared/scroll_cue", "shared/table")


def cell(text: str, opens: str = "", title: str = "") -> dict[str, str]:
    """A cell, and the name of what it opens; without what is empty, since there may be hundreds."""
    return {"text": text} | ({"open": opens} if opens else {}) | ({"title": title} if title else {})


def row(kind: str, *cells: str | dict[str, str], mark: str = "") -> dict[str, object]:
    """A row of texts, or of what `cell` makes; rows can be chosen by their kind."""
    return {"mark": mark, "kind": kind, "cells": [cell(each) if isinstance(each, str) else each for each in cells]}


class ListedSearches:
    """One search for each solver whose results are listed.

    Attributes
    ----------
    view : ListPanel
    studies : dict of str to StudyAsker
        By solver.

    Parameters
    ----------
    host : TabHost
    figures : Curves
        Over which the results are drawn.
    on_result : callable
        Called when a search has found more.
    """

    names: ClassVar[Mapping[str, str]]  # each solver in words
    grow: ClassVar[Grow]
    switch: ClassVar[str]  # of the panel: "off" where nothing is searched for
    head: ClassVar[str]  # of what is said of a search that is over; with the solver in braces
    kept: ClassVar[str]  # of a result: what the search has found

    def __init__(self, host: TabHost, figures: Curves, on_result: Callable[[], None]) -> None:
        self.host, self.figures, self._on_result = host, figures, on_result
        self.view = ListPanel(visible=False)
        self.view.listen(stop=(bool, self._stop), open=(object, self.open_named))
        self.studies = {solver: StudyAsker(host, type(self).grow, on_result) for solver in self.names}

    @abstractmethod
    def ask(self, asked: object) -> None:
        """Search for what the tab's ``search_questions`` gives, and end what else is searched for."""

    @abstractmethod
    def clear(self) -> None:
        """Show none."""

    @abstractmethod
    def open_named(self, name: object) -> None:
        """Open what a cell names, in Explore."""

    @property
    def results(self) -> dict[str, PartialResult]:
        """What was found, by solver, in the order of the names."""
        return {solver: study.result for solver, study in self.studies.items() if study.result is not None}

    @property
    def found(self) -> dict[str, PartialResult]:
        """Of the results those in which there is anything."""
        return {solver: result for solver, result in self.results.items() if getattr(result, self.kept)}

    def cancel(self) -> None:
        """Stop all searches; what they have found stays."""
        for study in self.studies.values():
            study.drop()

    def words(self) -> list[list[str | Statement]]:
        """Head and text for the panel, of each search that is over."""
        over = {solver: result for solver, result in self.results.items() if result.share == 1}
        return [
            [self.head.format(self.names[solver]), joined(" ", filter(None, (f"{result.words()}.", result.cut)))]
            for solver, result in over.items()
        ]

    def _list(self, notes: Sequence[str], **tables: dict) -> None:
        """Show the tables; ``notes`` are sentences about what is shown and what is not."""
        notes = [*notes, *(self._note(solver, result.cut) for solver, result in self.results.items() if result.cut)]
        notes += [
            self._note(solver, f"the search ended early ({study.failed}); what it had found stays.")
            for solver, study in self.studies.items()
            if study.failed
        ]
        running = any(study.job for study in self.studies.values())
        stopped = any(study.stopped for study in self.studies.values())
        texts = [f"{self.names[solver].capitalize()}: {result.words()}" for solver, result in self.results.items()]
        text = "; ".join([*texts, *(["searching …"] if running else ["stopped"] if stopped else [])])
        new = {
            "status": {"text": text, "running": running, "stopped": stopped, "notes": notes},
            "visible": bool(notes) or any(study.question for study in self.studies.values()),
            **tables,
        }
        self.view.param.update({name: value for name, value in new.items() if value != getattr(self.view, name)})

    def _note(self, solver: str, text: str) -> str:
        """A note on a search, which says which one where there are several."""
        return f"{self.names[solver].capitalize()}: {text}" if len(self.names) > 1 else text[0].upper() + text[1:]

    def _stop(self, on: bool) -> None:
        for study in self.studies.values():
            study.stop(on)
        self._on_result()
