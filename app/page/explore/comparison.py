"""The comparison: the numbers of the present setting and of the pinned ones in a table, with the errors of each.

The pinned results beside the live one: each is computed once, and drawn again when it is drawn in another way.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import panel as pn
import param
from vibroscope.app.explorer.compute import cached_runs, compute_runs, needed
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.explanation import AloneFacts, Explanation
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.parameters import DRAWING_FIELDS, FIELDS, MAIN_FIELDS
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.explore.explainer import begin_explanation, known_explanation
from vibroscope.app.page.explore.result import Result, prepare
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import PARTS, name_of_part
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.job import Answer, Job
from vibroscope.app.runtime.workers import workers
from vibroscope.engine import Compiled, Excitation, percent
from vibroscope.engine.arguments import Poll


def begin_runs(setting: Setting, deliver: Callable[[Job, object], None]) -> Answer:
    """Compute a setting, to be drawn, in one of the threads of the figures."""
    return Answer(setting, _compute, deliver, workers(), "pin", needs=needed(setting, Compiled.MOTIONS))


def _compute(setting: Setting, cancelled: Poll, _: Callable) -> Result:
    return prepare(compute_runs(setting, cancelled))


class PinnedResults:
    """Finds the results of the host's pinned settings, one after the other, then their explanations.

    ``draw`` is called when one has come, or a pin has come or gone.
    """

    def __init__(self, host: TabHost, draw: Callable[[], None]) -> None:
        self.host = host
        self._draw = draw
        self._computed, self._explained = Asker(host), Asker(host)
        self._wanted: tuple[Setting, ...] = ()
        self._results: dict[Setting, Result | None] = {}  # None: it could not be computed
        self._ready: dict[Setting, Result] = {}  # prepared ahead
        self._unexplained: set[Setting] = set()  # their explanation has failed

    @property
    def results(self) -> list[tuple[Setting, Result | None]]:
        """The pinned settings, drawn like the present one, with the results that are there."""
        return [(setting, self._results.get(setting)) for setting in self._wanted]

    def columns(self, live: Setting) -> list[dict[str, Columns]]:
        """The columns to be drawn of each pin; a reference that is the live one is left out."""
        return [_without_reference(result, live) if result else {} for _, result in self.results]

    def prepare_like(self, setting: Setting) -> None:
        """Prepare the pinned settings that are cached to be drawn like ``setting``; in a worker, ahead of `follow`."""
        pins = (pinned.drawn_like(setting) for pinned in self.host.pinned)
        known = self._results
        runs = {pinned: cached_runs(pinned) for pinned in pins if pinned not in known}
        self._ready = {pinned: prepare(found) for pinned, found in runs.items() if found is not None}

    def follow(self, setting: Setting) -> None:
        """Draw the pinned settings like ``setting``: those that are cached now, the others when they come."""
        wanted = tuple(pinned.drawn_like(setting) for pinned in self.host.pinned)
        if not (wanted or self._wanted):
            return
        self._wanted, ready = wanted, self._ready
        self._results = {pinned: result for pinned, result in self._results.items() if pinned in wanted}
        for pinned in wanted:
            if pinned in self._results:
                continue
            if pinned in ready:
                self._results[pinned] = ready[pinned]
            elif (runs := cached_runs(pinned)) is not None:
                self._results[pinned] = prepare(runs)
        self._draw()
        self._continue()

    def drop(self) -> None:
        """The session has ended."""
        self._computed.drop()
        self._explained.drop()

    def _continue(self) -> None:
        """Ask for what comes next, unless something is under way that is still wanted."""
        self._ask(self._computed, [pinned for pinned in self._wanted if pinned not in self._results], begin_runs)
        ready = [pinned for pinned in self._wanted if self._results.get(pinned) and pinned not in self._unexplained]
        self._ask(self._explained, [pinned for pinned in ready if known_explanation(pinned) is None], begin_explanation)

    def _ask(self, asker: Asker, missing: list[Setting], begin: Callable[..., Job]) -> None:
        if asker.job is not None and asker.job.question in missing:
            return
        asker.drop()
        if missing:
            asker.ask(lambda: begin(missing[0], on_loop(self.host, self._take)))

    def _take(self, job: Job, found: Result | AloneFacts | Explanation | Exception) -> None:
        """Also while another tab is open, since nothing would ask for the result again."""
        failed = isinstance(found, Exception)
        if job is self._explained.job:
            self._unexplained |= {job.question} if failed else set()
        else:
            self._results[job.question] = None if failed else found
            if failed:
                self.host.report_error(
                    f"A pinned setting could not be computed ({error_text(found)}). Unpin it, or pin another setting."
                )
        with pn.io.hold(self.host.doc):
            self._draw()
        self._continue()


def _reference_run(setting: Setting) -> tuple:
    return setting.system, setting.eta, setting.reference, setting.initial


def _without_reference(result: Result, live: Setting) -> dict[str, Columns]:
    setting = result.setting
    if _reference_run(setting) != _reference_run(live):
        return result.columns
    return {
        source: {
            name: np.full_like(column, np.nan) if "reference" in source or name.startswith("reference") else column
            for name, column in columns.items()
        }
        for source, columns in result.columns.items()
    }


_OTHER_FIELDS = [name for name in FIELDS if name not in (*MAIN_FIELDS, *DRAWING_FIELDS)]


class PinComparison(Component):
    """A row for each setting; without a pin there are none."""

    parts = param.Dict(default={}, doc="Heads of the errors: those that a row has, or all until they are known")
    rows = param.List(default=[], doc="See `_row`; the first is the present setting, the others are in their order")

    script = "explore/comparison"
    sheets = ("shared/scroll_cue", "shared/table")

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)

    def show(
        self, live: Result, explanation: Explanation | None, pinned: Sequence[tuple[Setting, Result | None]]
    ) -> None:
        """Show the pinned settings below the present one."""
        rows = []
        if pinned:
            settings = [live.setting, *(setting for setting, _ in pinned)]
            other = [name for name in _OTHER_FIELDS if len({getattr(setting, name) for setting in settings}) > 1]
            shown = (setting.drawn_like(live.setting) for setting, _ in pinned)
            rows = [_row(live.setting, live, explanation, other)]
            rows += [
                _row(setting, result, known_explanation(setting), other)
                for setting, (_, result) in zip(shown, pinned, strict=True)
            ]
        if rows != self.rows:
            has = {part for row in rows for part in row["errors"]} or PARTS  # a column has a number at least
            parts = {part: name_of_part(part) for part in PARTS if part in has}
            self.param.update(rows=rows, parts=parts, visible=bool(rows))

    @property
    def table(self) -> dict[str, list]:
        """The columns of the table as numbers; not a number where an error is unknown."""
        names = self.rows[0]["texts"] if self.rows else {}
        columns = {name: [_as_number(row["texts"][name]) for row in self.rows] for name in names}
        if self.rows:  # of the base, whatever is held, the amplitude of its displacement
            drives = (Excitation(base, held=held) for base, held in zip(columns["base"], columns["held"], strict=True))
            columns["base"] = [drive.base_amplitude(eta) for drive, eta in zip(drives, columns["eta"], strict=True)]
        errors = {name: [row["errors"].get(name, math.nan) for row in self.rows] for name in self.parts}
        return columns | {f"error {name}": column for name, column in errors.items()}


def _as_number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:  # a choice
        return text


def _row(setting: Setting, result: Result | None, explanation: Explanation | None, other: list[str]) -> dict:
    """Make the row of a setting.

    Returns
    -------
    dict
        ``texts``: what sets its parameters. ``numbers``: symbol, name with unit, and text of each slider. ``other``:
        those beside the sliders in which the rows differ. ``motion``: what the penalty model shows. ``explained``:
        whether the following are known. ``errors``: the parts of its difference by name, as far as they have a meaning.
        ``shown``: the same as texts. ``measure``: what they measure. ``headline``: the difference in words.
    """
    texts, explanation = setting.texts(), explanation and explanation.in_units(setting.scale)
    return {
        "texts": {name: texts[name] for name in FIELDS if name not in DRAWING_FIELDS},
        "numbers": [_number(name, setting) for name in MAIN_FIELDS],
        "other": ", ".join(_in_words(name, setting) for name in other),
        "motion": result.description.lines(explanation)["penalty"] if result else "",
        "explained": explanation is not None,
        "errors": explanation.parts if explanation else {},
        "shown": {name: percent(value) for name, value in explanation.parts.items()} if explanation else {},
        "measure": explanation.measure if explanation else "",
        "headline": explanation.headline if explanation else "",
    }


def _number(name: str, setting: Setting) -> list[str]:
    field = shown_field(name, setting)
    return [field.label, field.name, field.number(getattr(setting, name))]


def _in_words(name: str, setting: Setting) -> str:
    field, value = FIELDS[name], getattr(setting, name)
    return f"{field.label}: {value}" if field.choices else shown_field(name, setting).words(value)
