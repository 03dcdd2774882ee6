"""Files between the page and the user: those to take away from the open view, and the parameter file to load."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from datetime import UTC, datetime
from functools import partial

from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.decks import DECKS, deck, problem_of
from vibroscope.app.export.formats import (
    Figure,
    Loaded,
    as_csv,
    as_json,
    as_toml,
    join_parts,
    loaded_from_toml,
    program,
)
from vibroscope.app.export.label import figure_label
from vibroscope.app.export.plots import plot_script
from vibroscope.app.export.report import Findings, as_report
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.tab import TabHost, TabView
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import lower_priority, pool

File = dict[str, str]  # name, type (of media), text
# Pictures, which the browser draws; it is sent what they are to say of themselves, and the name of the file.
_PICTURES = {"png": "image/png", "svg": "image/svg+xml", "pdf": "application/pdf"}


class TakeAway:
    """Writes and reads the files of one session, one after the other, in a low-priority thread."""

    def __init__(self, host: TabHost, send: Callable[[str, File], None]) -> None:
        """``send(what, file)`` sends a file to the browser; it is called on the session's loop."""
        self._host = host
        self._send = send
        self._writing = self._reading = False

    def request(self, what: str, view: TabView, setting: Setting, address: str) -> None:
        """Write the file ``what`` of `file_writer` and send it, or report why not."""
        write = file_writer(view, what, setting, address)
        if write is None:
            self._host.report_error("There is no such file yet: wait for the figures.")
        elif self._writing:
            self._host.report_error("The last file is still being written: try again in a moment.")
        else:
            self._writing = True
            _submit(write).add_done_callback(lambda done: self._host.call_later(partial(self._written, what, done)))

    def load(self, parts: object, on_read: Callable[[Future], None]) -> None:
        """Read an uploaded file; ``on_read`` is called on the session's loop with a `Loaded`."""
        if self._reading:
            self._host.report_error("The last file is still being read: try again in a moment.")
            return
        self._reading = True

        def done(read: Future) -> None:
            self._reading = False
            if not read.cancelled():
                on_read(read)

        _submit(read_upload, parts).add_done_callback(lambda read: self._host.call_later(partial(done, read)))

    def _written(self, what: str, done: Future) -> None:
        self._writing = False
        if done.cancelled():
            return
        if done.exception() is None:
            self._send(what, done.result())
        elif isinstance(done.exception(), ValueError):
            self._host.report_error(f"This file was not written: {done.exception()}.")
        else:
            logs.event("not written", logging.ERROR, error=done.exception(), what=what)
            self._host.report_error(f"This file could not be written ({error_text(done.exception())}): try again.")


def _submit(job: Callable, *arguments) -> Future:
    """Run a job of files in their thread, so that none delays the loop."""
    return pool("files", 1, lower_priority).submit(job, *arguments, session=logs.session.get())


def offered_figures(view: TabView) -> list[list]:
    """Name and title of each figure, and whether a picture and a table of it are offered."""
    return [[figure.name, figure.title, figure.drawn, figure.tabled] for figure in view.figures()]


def file_writer(view: TabView, what: str, setting: Setting, address: str) -> Callable[[], File] | None:
    """A function that writes the requested file; None if there is no such file.

    The content of the view is collected now. Writing takes up to a second, and may be done in another thread.

    Parameters
    ----------
    view : TabView
        The open view.
    what : str
        ``"toml"``, ``"python"``, ``"command"``, ``"deck:CODE"``; where there are figures also ``"json"``,
        ``"report"``, and of each figure ``"csv:NAME"``, ``"plot:NAME"`` (a script that draws it), ``"png:NAME"``,
        ``"svg:NAME"``, ``"pdf:NAME"``.
    setting : Setting
        The present setting, for the parameter file. The other files are of the setting that the view shows, if any.
    address : str
        Address that restores what is shown.
    """
    if what == "toml":
        return partial(_write, "vibroscope.toml", "application/toml", as_toml, setting)
    setting = view.shown_setting() or setting
    if what == "python":
        return partial(_write, "vibroscope_run.py", "text/x-python", str, view.python(setting))
    if what == "command":
        return partial(_write, "vibroscope.sh", "text/x-shellscript", str, view.command(setting))
    figures = {figure.name: figure for figure in view.figures()}
    kind, _, name = what.partition(":")
    if kind == "deck" and name in DECKS:
        return partial(_write_deck, name, setting)
    if name in figures:
        return _figure_writer(view, kind, figures[name], setting, address)
    if what == "json" and figures:
        return partial(_write, f"vibroscope-{view.key}.json", "application/json", as_json, _content(view, address))
    if what == "report" and figures:
        drawn = [figure for figure in figures.values() if figure.drawn]
        scripts = [view.command(setting), view.python(setting)]
        source = _source(address) | {"made": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC")}
        findings = Findings(view.words(), view.suggestion())
        report = view.title, findings, view.shown_setting(), drawn, scripts, source
        return partial(_write, "vibroscope-report.html", "text/html", as_report, *report)
    return None


def _figure_writer(
    view: TabView, kind: str, figure: Figure, setting: Setting, address: str
) -> Callable[[], File] | None:
    name = f"vibroscope-{figure.name}"
    label = figure_label(view.title, figure, view.shown_setting(), address)
    if kind in _PICTURES and figure.drawn:
        return partial(_write, f"{name}.{kind}", _PICTURES[kind], as_json, label)
    table = table_in_units(view.table(figure.name), setting.scale) if figure.tabled else []
    if kind == "csv" and figure.tabled:
        return partial(_write, f"{name}.csv", "text/csv", as_csv, table)
    if kind == "plot" and figure.tabled and figure.drawn:
        return partial(_write, f"{name}.py", "text/x-python", plot_script, name, table, label)
    return None


def _write_deck(code: str, setting: Setting) -> File:
    problem = problem_of(setting, code)
    return _write(f"{problem.name}.{DECKS[code].SUFFIX}", "text/plain", deck, code, problem)


def _content(view: TabView, address: str) -> dict[str, object]:
    shown = view.shown_setting()
    setting = {"setting": shown._asdict()} if shown else {}
    return {**_source(address), **setting, "words": view.words(), "data": view.data()}


def _source(address: str) -> dict[str, str]:
    return {"program": program(), "address": address}


def _write(name: str, kind: str, write: Callable[..., str], *args) -> File:
    return {"name": name, "type": kind, "text": write(*args)}


def read_upload(parts: object) -> Loaded:
    """Read an uploaded file; raises ValueError if this program did not write it."""
    return loaded_from_toml(join_parts(parts))
