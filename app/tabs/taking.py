"""The files that a user takes away, of whatever tab is open: each of a kind that the menu offers, and of no other."""

from __future__ import annotations

from datetime import UTC, datetime

from app.report import as_report
from app.state import Setting
from app.tabs.base import Tab
from app.takeaway import as_csv, as_json, as_toml, program


def offers(tab: Tab) -> list[list]:
    """Name and title of each figure, and whether there is a picture of it beside the table."""
    return [[figure.name, figure.title, figure.drawn] for figure in tab.figures()]


def take(tab: Tab, what: str, setting: Setting, address: str) -> dict[str, str] | None:
    """The file that is asked for, as ``name``, ``type`` (of media) and ``text``; None if there is no such.

    Parameters
    ----------
    tab : Tab
        The one that is open.
    what : str
        ``"toml"``, ``"python"``, ``"command"``; where there are figures ``"json"``, ``"report"``, ``"csv:NAME"``.
    setting : Setting
        That holds.
    address : str
        That restores the page.
    """
    if what == "toml":
        return _file("vibroscope.toml", "application/toml", as_toml(setting))
    if what == "python":
        return _file("vibroscope_run.py", "text/x-python", tab.python(setting))
    if what == "command":
        return _file("vibroscope.sh", "text/x-shellscript", tab.command(setting))
    figures = {figure.name: figure for figure in tab.figures()}
    kind, _, name = what.partition(":")
    if kind == "csv" and name in figures:
        return _file(f"vibroscope-{name}.csv", "text/csv", as_csv(tab.table(name)))
    if what == "json" and figures:
        shown = tab.shown()
        told = {**_source(address), **({"setting": shown._asdict()} if shown else {})}
        told |= {"words": tab.words(), "data": tab.data()}
        return _file(f"vibroscope-{tab.key}.json", "application/json", as_json(told))
    if what == "report" and figures:
        return _file("vibroscope-report.html", "text/html", _report(tab, setting, address))
    return None


def _report(tab: Tab, setting: Setting, address: str) -> str:
    made = datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC")
    return as_report(
        tab.title,
        tab.words(),
        tab.shown(),
        [figure for figure in tab.figures() if figure.drawn],
        [tab.command(setting), tab.python(setting)],
        {**_source(address), "made": made},
    )


def _source(address: str) -> dict[str, str]:
    return {"program": program(), "address": address}


def _file(name: str, kind: str, text: str) -> dict[str, str]:
    return {"name": name, "type": kind, "text": text}
