"""A measurement laid over both solutions: the upload of its file, the points in the figures, its verdict and its fit.

The file stays in the memory of the session. No link holds it, and no log.
"""

from collections.abc import Callable

import param
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.field_units import shown_content, shown_text, words_of_change
from vibroscope.app.explorer.measured import (
    FITTED_NAMES,
    LARGEST_FILE,
    NOWHERE,
    MeasuredFile,
    Placed,
    comparison_rows,
    fit_content,
    headline,
    judge_file,
    own_eta,
    place,
)
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.shared.component import LONGEST_NAME, Component, Upload, too_large
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.job import Answer
from vibroscope.engine import FITTED, Fit, MeasuredComparison, UnknownColumns, fitted_names, measured_verdict
from vibroscope.engine.facts import sentence

_REST = 150  # ms without a new result before the measurement is compared with it
_MOST_COLUMNS = 50  # to choose from
_IDLE = {"phase": "idle"}


class MeasurementButton(Component):
    """Chooses a file, or takes one that is dropped on the page, and sends it in parts, a character for each byte.

    See `Upload`.
    """

    largest = param.Integer(default=LARGEST_FILE, constant=True, doc="Bytes; of a larger file the name alone is sent")

    script = "explore/measurement_button"
    sheets = ("shared/upload",)


class MeasurementPanel(Component):
    """Verdict, numbers and fit; sends ``{"fit": names}``, ``{"cancel": true}`` and ``{"remove": true}``.

    Where the header of a file does not say which column is what, it asks, and sends ``{"columns": {name: column}}``.
    """

    names = param.Dict(default=FITTED_NAMES, constant=True, doc="Symbol and name of each constant that can be fitted")
    content = param.Dict(default=_IDLE, doc="phase: idle, reading, columns, failed or done; see `Overlay._show`")

    script = "explore/measurement"

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)


class Overlay:
    """The measurement of one session, compared with what is shown. ``draw`` is called when its points have changed."""

    def __init__(self, host: TabHost, draw: Callable[[], None]) -> None:
        self.host = host
        self._draw = draw
        self.button, self.panel = MeasurementButton(), MeasurementPanel()
        self.button.listen(**Upload(self._begin, self._take).acts)
        ends = {"cancel": (bool, lambda _: self._cancel_fit()), "remove": (bool, lambda _: self._remove())}
        self.panel.listen(columns=(dict, self._choose), fit=(str, self._begin_fit), **ends)
        self._name = ""
        self._file: MeasuredFile | None = None
        self._header: list[str] = []  # to choose from, of a file that does not say which column is what
        self._setting: Setting | None = None
        self._asker, self._fit_asker = Asker(host), Asker(host)
        self._rest = Asker(host, _REST)  # before a comparison
        self._compared: tuple[Setting, MeasuredComparison] | None = None
        self._placed: tuple[object, Placed] = None, NOWHERE
        self._fit: dict = _IDLE
        self._fitted: Fit | None = None

    # -- the session's setting ---------------------------------------------------------

    def follow(self, setting: Setting) -> None:
        """The figures show this setting now: compare the measurement with it a moment later."""
        before, self._setting = self._setting, setting
        self._rest.drop()
        if before is not None and _fit_key(before) != _fit_key(setting):
            self._end_fit()
        if self._file is None:
            return
        if self._compared is not None and _key(self._compared[0]) == _key(setting):
            self._show()
            return
        self._show(pending=True)
        self._rest.ask(self._compare)

    def placed(self, setting: Setting, drawn: Columns) -> Placed:
        """The points in the figures, which the reference alone places if it repeats itself; see `place`."""
        if self._compared is None:
            return NOWHERE
        of, comparison = self._compared
        if _key(of) != _key(setting) and (
            comparison.reference.alignment is None or _reference_key(of) != _reference_key(setting)
        ):
            return NOWHERE
        key = id(comparison), setting.frame, setting.scale
        if self._placed[0] != key:
            self._placed = key, place(comparison, setting, drawn)
        return self._placed[1]

    @property
    def words(self) -> dict[str, str]:
        """The verdict and the fit as paragraphs by their headings; empty without a measurement."""
        content = self.panel.content
        if content["phase"] != "done":
            return {}
        fitted = content["fit"]
        rows = "; ".join(" ".join(row) for row in fitted.get("rows", []))
        texts = [f"{content['headline']}.", content["words"], *([f"Fit: {rows}."] if rows else [])]
        return {f"Measurement {content['name']}": " ".join([*texts, *fitted.get("remarks", [])])}

    @property
    def arguments(self) -> tuple[str, str, bool]:
        """Of the command: the file's name, what was said of its columns, and whether it has units; or no name."""
        if self._file is None:
            return "", "", False
        columns = ", ".join(f"{name}={column}" for name, column in (self._file.columns or {}).items())
        return self._file.name, columns, self._file.in_units

    def cancel(self) -> None:
        """Another setting will be shown: stop."""
        self._rest.drop()
        self._asker.drop()

    def close(self) -> None:
        """The session has ended."""
        self.cancel()
        self._fit_asker.drop()

    # -- from the browser --------------------------------------------------------------

    def _begin(self, name: str, size: float) -> None:
        self._remove()
        self._name = name
        fewer = "periods, fewer samples of each, or fewer digits"
        if why := too_large(size, fewer, "vibroscope compare --measured"):
            self._fail(why)
        else:
            self._write(phase="reading", name=self._name)

    def _take(self, content: bytes) -> None:
        """The file is complete; it is parsed in a worker thread."""
        self._file = MeasuredFile(self._name, content)
        if self._setting is not None:
            self._compare()

    def _choose(self, columns: dict) -> None:
        """The user says which column is what: read the file again."""
        if self._file is not None and all(isinstance(each, str) for pair in columns.items() for each in pair):
            self._file.columns = columns
            self._write(phase="reading", name=self._name)
            self._compare()

    def _remove(self) -> None:
        self.cancel()
        self._end_fit()
        self._file, self._compared, self._header = None, None, []
        self._write(**_IDLE)
        self._draw()

    def _fail(self, error: str) -> None:
        self._write(phase="failed", name=self._name, error=error)

    # -- the comparison ----------------------------------------------------------------

    def _compare(self) -> None:
        self._judge(self._asker)

    def _judge(self, asker: Asker, names: tuple[str, ...] = ()) -> None:
        question = self._file, self._setting, names
        asker.ask(lambda: judge_file(question, on_loop(self.host, self._show_result)))

    def _show_result(self, job: Answer, found: MeasuredComparison | Fit | Exception) -> None:
        """Show what a job has found."""
        if job is self._fit_asker.job:
            self._fit_asker.drop()
            failed = isinstance(found, Exception)
            self._fit = {"phase": "failed", "error": self._sentence(found)} if failed else {"phase": "done"}
            self._fitted = None if failed else found
            self._show()
        elif job is self._asker.job:
            failed = isinstance(found, Exception)
            self._compared = None if failed else (job.question[1], found)
            self._draw()  # first: the browser recolours the figures when it shows the words
            if isinstance(found, UnknownColumns):
                self._header = [cell.strip()[:LONGEST_NAME] for cell in found.header[:_MOST_COLUMNS]]
            if failed and self._header:
                self._write(phase="columns", name=self._name, error=self._sentence(found), header=self._header)
            elif failed:
                self._fail(self._sentence(found))
            else:
                self._show()

    def _begin_fit(self, names: str) -> None:
        names = tuple(name for name in FITTED if name in names.split())
        if self._compared is None or not names:
            return
        self._end_fit()
        self._fit = {"phase": "running"}
        self._show()
        self._judge(self._fit_asker, names)

    def _cancel_fit(self) -> None:
        self._end_fit()
        if self._compared is not None:
            self._show()

    def _end_fit(self) -> None:
        self._fit_asker.drop()
        self._fit, self._fitted = _IDLE, None

    # -- to the browser ----------------------------------------------------------------

    def _show(self, *, pending: bool = False) -> None:
        if self._compared is None:
            return
        scale, comparison = self._setting.scale, self._compared[1]
        content = {
            "headline": headline(comparison),
            "words": measured_verdict(comparison),
            "rows": comparison_rows(comparison, scale),
            "names": list(fitted_names(self._setting.system, comparison.measurement)),
            "eta": (eta := own_eta(comparison)),
            "offer": words_of_change({"eta": eta}, self._setting) if eta else "",
            "fit": self._fit | (fit_content(self._fitted, scale) if self._fitted is not None else {}),
        }
        self._write(phase="done", name=self._file.name, pending=pending, **shown_content(content, scale))

    def _sentence(self, error: Exception) -> str:
        return shown_text(sentence(error_text(error)), self._setting.scale)

    def _write(self, **content) -> None:
        if content != self.panel.content:
            self.panel.param.update(content=content, visible=content["phase"] != "idle")
            self.host.update_offers()


def _fit_key(setting: Setting) -> object:
    """Everything that a fit depends on."""
    return setting.system, setting.eta, setting.omega1, setting.amplitude, setting.initial


def _reference_key(setting: Setting) -> object:
    return *_fit_key(setting), setting.reference


def _key(setting: Setting) -> object:
    """Everything that a comparison depends on."""
    return *_reference_key(setting), setting.penalty
