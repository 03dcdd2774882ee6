"""Writes the gallery as files that open without a server: a report for each scene and each system of the shelf.

.venv/bin/python docs/static_gallery.py [--out FOLDER] [KEY …]
"""

import argparse
import io
import sys
from datetime import UTC, datetime
from html import escape
from importlib.metadata import version
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "figures")]
mpl.use("svg")

from entries import histories, phases  # noqa: E402
from gallery import comparison, settings  # noqa: E402
from vibroscope.app.explorer.presets import scenes, shelf  # noqa: E402
from vibroscope.app.export.report import STYLE, Findings, as_report  # noqa: E402
from vibroscope.app.export.scripts import as_command, as_python  # noqa: E402
from vibroscope.engine import percent, verdict  # noqa: E402

PLANE = "Velocity over displacement, at most twelve periods"
TIME = "Displacements and contact force over time; the reference has impulses in place of a force"
FIGURES = {PLANE: phases, TIME: histories}


def drawn(figure) -> str:
    """A figure as SVG that stands in a page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight")
    plt.close(figure)
    return text.getvalue()


def page(key: str) -> str:
    """The report of one entry, with its figures."""
    entry, setting = (scenes() | shelf())[key], settings()[key]
    found = comparison(setting)
    said = verdict(found)
    parts = {name.replace("_", " "): percent(getattr(found, name)) for name in found.part_names} if found.parts else {}
    words = {"What it shows": entry.caption, "Verdict": " ".join((said.headline, *said.details))}
    words |= {"Parts of the difference": "; ".join(f"{name} {text}" for name, text in parts.items())} if parts else {}
    source = {"program": f"Vibroscope {version('vibroscope')}", "made": f"{datetime.now(UTC):%d %B %Y}", "address": ""}
    figures = [(drawn(draw(setting)), caption) for caption, draw in FIGURES.items()]
    return as_report(entry.title, Findings(words), setting, figures, [as_command(setting), as_python(setting)], source)


def index(keys: list[str]) -> str:
    """The page that leads to the reports."""
    lists = ""
    for heading, entries in (("The paper's pendulums", scenes()), ("Published systems", shelf())):
        links = [
            f'<li><a href="{key}.html">{escape(entries[key].title)}</a>: {escape(entries[key].caption)}</li>'
            for key in keys
            if key in entries
        ]
        lists += f"<h2>{heading}</h2><ul>{''.join(links)}</ul>" if links else ""
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Vibroscope: gallery</title><style>{STYLE}</style></head><body><h1>Gallery</h1>
<p>A report of each scene and of each published system: verdict, setting, figures, and what gives the same numbers.</p>
{lists}</body></html>
"""


def main() -> None:
    """Write the pages and their index."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("build/gallery"), metavar="FOLDER")
    parser.add_argument("keys", nargs="*", metavar="KEY", help="only these")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    entries = scenes() | shelf()
    for key in options.keys or entries:
        (options.out / f"{key}.html").write_text(page(key))
        print(options.out / f"{key}.html", flush=True)
    (options.out / "index.html").write_text(index(options.keys or list(entries)))


if __name__ == "__main__":
    main()
