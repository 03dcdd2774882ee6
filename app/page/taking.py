"""The files that a user takes away, of whatever tab is open: each of a kind that the menu offers, and of no other."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import as_csv, as_json, as_toml, program
from vibroscope.app.export.report import as_report
from vibroscope.app.page.tab import Tab


def offers(tab: Tab) -> list[list]:
    """Name and title of each figure, and whether there is a picture and a table of it."""
    return [[figure.name, figure.title, figure.drawn, figure.tabled] for figure in tab.figures()]


def take(tab: Tab, what: str, setting: Setting, address: str) -> Callable[[], dict[str, str]] | None:
    """What makes the file that is asked for, as ``name``, ``type`` (of media) and ``text``; None if there is no such.

    What the tab shows is gathered now; to write it takes up to a second, and may be done by another thread.

    Parameters
    ----------
    tab : Tab
        The one that is open.
    what : str
        ``"toml"``, ``"python"``, ``"command"``; where there are figures ``"json"``, ``"report"``, ``"csv:NAME"``.
    setting : Setting
        That holds: its parameters are taken. All else belongs to the setting that is shown, where there is one.
    address : str
        That restores what is shown.
    """
    if what == "toml":
        return partial(_file, "vibroscope.toml", "application/toml", as_toml, setting)
    setting = tab.shown() or setting
    if what == "python":
        return partial(_file, "vibroscope_run.py", "text/x-python", str, tab.python(setting))
    if what == "command":
        return partial(_file, "vibroscope.sh", "text/x-shellscript", str, tab.command(setting))
    figures = {figure.name: figure for figure in tab.figures()}
    kind, _, name = what.partition(":")
    if kind == "csv" and name in figures and figures[name].tabled:
        return partial(_file, f"vibroscope-{name}.csv", "text/csv", as_csv, tab.table(name))
    if what == "json" and figures:
        return partial(_file, f"vibroscope-{tab.key}.json", "application/json", as_json, _told(tab, address))
    if what == "report" and figures:
        drawn = [figure for figure in figures.values() if figure.drawn]
        scripts = [tab.command(setting), tab.python(setting)]
        source = _source(address) | {"made": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC")}
        report = tab.title, tab.words(), tab.shown(), drawn, scripts, source
        return partial(_file, "vibroscope-report.html", "text/html", as_report, *report)
    return None


def _told(tab: Tab, address: str) -> dict[str, object]:
    shown = tab.shown()
    setting = {"setting": shown._asdict()} if shown else {}
    return {**_source(address), **setting, "words": tab.words(), "data": tab.data()}


def _source(address: str) -> dict[str, str]:
    return {"program": program(), "address": address}


def _file(name: str, kind: str, write: Callable[..., str], *args) -> dict[str, str]:
    return {"name": name, "type": kind, "text": write(*args)}
