"""The outputs and figures that pages show: made here (`make shown`), kept in the pages and beside them.

So they can be read without building the site. A block of a page that begins with ``$ vibroscope`` holds the output of
that command, up to a line ``…`` where it is cut.
"""

import argparse
import contextlib
import io
import os
import re
import runpy
import shlex
import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
from vibroscope.app.commands.cli import main as vibroscope

DOCS = Path(__file__).parent
FIGURES = DOCS / "figures"
DRAWN = sorted(path.stem for path in FIGURES.glob("*.py") if path.stem not in ("entries", "style"))
BLOCK = re.compile(r"^```text\n\$ vibroscope (?P<call>.*)\n(?P<output>(?s:.*?))^```$", re.MULTILINE)
CUT = "…"


def pages() -> list[Path]:
    """The pages that show an output."""
    return [path for path in (DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md"))) if BLOCK.search(path.read_text())]


def output(call: str) -> str:
    """What a command prints, in the folder of the pages and 100 columns wide."""
    os.environ["COLUMNS"] = "100"
    printed = io.StringIO()
    with contextlib.chdir(DOCS), contextlib.redirect_stdout(printed), contextlib.redirect_stderr(io.StringIO()):
        vibroscope(shlex.split(call))
    return re.sub(r" +$", "", printed.getvalue(), flags=re.MULTILINE).strip("\n") + "\n"


def shown(block: re.Match) -> str:
    """What the block of a page is to show: its command's output, cut where the block is cut."""
    lines, found = block["output"].splitlines(), output(block["call"])
    if lines[-1:] == [CUT]:
        found = "".join(f"{line}\n" for line in [*found.splitlines()[: len(lines) - 1], CUT])
    return found


def draw(name: str, folder: Path) -> Path:
    """Draw a figure into a folder; its path."""
    style = runpy.run_path(str(FIGURES / "style.py"))["STYLE"]
    sys.path.insert(0, str(FIGURES))
    try:
        with contextlib.chdir(FIGURES), mpl.rc_context(style):
            runpy.run_path(f"{name}.py")
            plt.savefig(folder / f"{name}.svg", metadata={"Date": None})
            plt.close("all")
    finally:
        sys.path.remove(str(FIGURES))
    return folder / f"{name}.svg"


def main() -> None:
    """Renew what pages show."""
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    mpl.use("agg")
    for page in pages():
        page.write_text(
            BLOCK.sub(lambda block: f"```text\n$ vibroscope {block['call']}\n{shown(block)}```", page.read_text())
        )
        print(page.name)
    for name in DRAWN:
        print(draw(name, FIGURES).name)


if __name__ == "__main__":
    main()
