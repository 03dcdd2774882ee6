"""Files between the page and the user: those to take away from the open view, and the parameter file to load."""

import base64
import logging
import re
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from datetime import UTC, datetime
from functools import partial
from urllib.parse import parse_qsl

from bokeh.models import Plot
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.decks import DECKS, deck, problem_of
from vibroscope.app.export.drawing import Drawing, Size, plot_script, write_picture
from vibroscope.app.export.formats import (
    Figure,
    Loaded,
    as_csv,
    as_toml,
    loaded_from_toml,
    program,
)
from vibroscope.app.export.report import Findings, as_report, figure_label
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.tab import Look, TabHost, TabView
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.json_text import json_text
from vibroscope.app.runtime.workers import lower_priority, pool
from vibroscope.engine.facts import sentence

File = dict[str, str]  # name, type (of media), and text, or bytes in base64
_PAGE = re.compile(r"https?://[^\s\"<>]{1,300}")
LARGEST_FILE = 65_536  # bytes of parameters that the page takes, as in `take_away.js`
_PICTURES = {"png": "image/png", "svg": "image/svg+xml", "pdf": "application/pdf"}


class TakeAway:
    """Writes and reads the files of one session, one after the other, in a low-priority thread."""

    def __init__(self, host: TabHost, send: Callable[[str, File], None]) -> None:
        """``send(what, file)`` sends a file to the browser; it is called on the session's loop."""
        self._host = host
        self._send = send
        self._busy = False

    def request(self, asked: str, view: TabView, setting: Setting, address: str) -> None:
        """Write the file ``asked`` of `file_writer` and send it, or report why not."""
        write = file_writer(view, asked, setting, address)
        if write is None:
            self._host.report_error("There is no such file yet: wait for the figures.")
        else:
            self._do(write, partial(self._written, asked))

    def load(self, content: bytes, on_read: Callable[[Future], None]) -> None:
        """Read an uploaded file; ``on_read`` is called on the session's loop with a `Loaded`."""
        self._do(partial(read_upload, content), on_read)

    def _do(self, job: Callable[[], object], then: Callable[[Future], None]) -> None:
        if self._busy:
            self._host.report_error("The last file is not done yet: try again in a moment.")
            return
        self._busy = True

        def done(found: Future) -> None:
            self._busy = False
            if not found.cancelled():
                then(found)

        job = pool("files", 1, lower_priority).submit(job, session=logs.session.get())  # so that none delays the loop
        job.add_done_callback(lambda found: self._host.call_later(partial(done, found)))

    def _written(self, what: str, done: Future) -> None:
        if done.exception() is None:
            self._send(what, done.result())
        elif isinstance(done.exception(), ValueError):
            self._host.report_error(f"This file was not written: {done.exception()}.")
        else:
            logs.event("not written", logging.ERROR, error=done.exception(), what=what)
            self._host.report_error(f"This file could not be written ({error_text(done.exception())}): try again.")


def offered_figures(view: TabView) -> list[list]:
    """Name and title of each figure, and whether a picture and a table of it are offered."""
    return [[figure.name, figure.title, figure.drawn, figure.tabled] for figure in view.figures()]


def file_writer(view: TabView, asked: str, setting: Setting, address: str) -> Callable[[], File] | None:
    """A function that writes the requested file; None if there is no such file.

    The content of the view is collected now. Writing takes up to a second, and may be done in another thread.

    Parameters
    ----------
    view : TabView
        The open view.
    asked : str
        ``"toml"``, ``"python"``, ``"command"``, ``"deck:CODE"``; where there are figures also ``"json"``,
        ``"report"``, and of each figure ``"csv:NAME"``, ``"plot:NAME"`` (a script that draws it), ``"png:NAME"``,
        ``"svg:NAME"``, ``"pdf:NAME"``. What is drawn has options, as in ``"png:force?width=85&dpi=600"``: ``width`` and
        ``height`` in mm, ``dpi``, ``dark`` (1 if the page is), the outlines of the ``bodies``, and the ``page`` without
        its query.
    setting : Setting
        The present setting, for the parameter file. The other files are of the setting that the view shows, if any.
    address : str
        Address that restores what is shown.
    """
    what, _, query = asked.partition("?")
    options = dict(parse_qsl(query))
    if what == "toml":
        return partial(_write, "vibroscope.toml", "application/toml", as_toml, setting)
    setting = view.shown_setting() or setting
    if what == "python":
        return partial(_write, "vibroscope_run.py", "text/x-python", str, view.python(setting))
    if what == "command":
        return partial(_write, "vibroscope.sh", "text/x-shellscript", str, view.command(setting))
    figures = {figure.name: _with_what_is_seen(figure, view) for figure in view.figures()}
    kind, _, name = what.partition(":")
    if kind == "deck" and name in DECKS:
        return partial(_write_deck, name, setting)
    if name in figures:
        return _figure_writer(view, kind, figures[name], setting, (address, options))
    if what == "json" and figures:
        return partial(_write, f"vibroscope-{view.key}.json", "application/json", json_text, _content(view, address))
    if what == "report" and figures:
        look = _look(options)
        drawn = [(view.drawing(name, look), figure.caption) for name, figure in figures.items() if figure.drawn]
        scripts = [view.command(setting), view.python(setting)]
        source = _source(_page(options) + address) | {"made": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC")}
        findings = Findings(view.words(), view.suggestion())
        write = partial(_report, view.title, findings, view.shown_setting(), drawn, scripts, source)
        return partial(_write, "vibroscope-report.html", "text/html", write)
    return None


def _report(title: str, findings: Findings, setting: Setting | None, drawn: list, scripts: list, source: dict) -> str:
    figures = [
        (write_picture(draw(), "svg", Size(), {"title": caption, "description": ""}).decode(), caption)
        for draw, caption in drawn
    ]
    return as_report(title, findings, setting, figures, scripts, source)


def _look(options: Mapping[str, str]) -> Look:
    """How the browser shows the figures."""
    return Look(options.get("dark") == "1", options.get("bodies", ""))


def _page(options: Mapping[str, str]) -> str:
    """The address of the page without its query, which the server does not know; empty if it is none."""
    page = options.get("page", "")
    return page if _PAGE.fullmatch(page) else ""


def _with_what_is_seen(figure: Figure, view: TabView) -> Figure:
    """The figure with a caption that says what is seen in it now, as its title on the page does."""
    plot = view.host.doc.get_model_by_name(figure.name)
    title = plot.title.text if isinstance(plot, Plot) and plot.title else ""
    return figure._replace(caption=f"{figure.caption} {sentence(title)}") if title else figure


def _figure_writer(
    view: TabView, kind: str, figure: Figure, setting: Setting, place: tuple[str, Mapping[str, str]]
) -> Callable[[], File] | None:
    name, (address, options) = f"vibroscope-{figure.name}", place
    if kind == "csv" and figure.tabled:
        table = table_in_units(view.table(figure.name), setting.scale)
        return partial(_write, f"{name}.csv", "text/csv", as_csv, table)
    if not figure.drawn or kind not in {*_PICTURES, "plot"}:
        return None
    label = figure_label(view.title, figure, view.shown_setting(), _page(options) + address)
    draw = view.drawing(figure.name, _look(options))
    if kind == "plot":
        return lambda: _write(f"{name}.py", "text/x-python", plot_script, name, draw(), Size.of(options), label)
    return partial(_picture, f"{name}.{kind}", draw, kind, options, label)


def _picture(
    name: str, draw: Callable[[], Drawing], kind: str, options: Mapping[str, str], label: Mapping[str, str]
) -> File:
    content = write_picture(draw(), kind, Size.of(options), label)
    return {"name": name, "type": _PICTURES[kind], "bytes": base64.b64encode(content).decode()}


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


def read_upload(content: bytes) -> Loaded:
    """Read an uploaded file; raises ValueError if this program did not write it."""
    return loaded_from_toml(content.decode("utf-8-sig", errors="replace"))
