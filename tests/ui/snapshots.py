"""Comparison of the page with baselines: data and pictures.

Baselines lie in tests/snapshots; ``make snapshots`` writes them, a missing one fails. Data must agree on any machine
within rounding. Pictures must be equal where browser and fonts are those that drew the baseline (of chaotic motions,
also the arithmetic), and similar elsewhere.
"""

import functools
import io
import json
import math
import re
from pathlib import Path

from PIL import Image, ImageChops

from tests.ui.snapshots_report import Report

FOLDER = Path(__file__).parents[1] / "snapshots"
REPORT = Report(Path(__file__).parents[1] / "results" / "index.html")
DRAWN_BY = "drawn-by.json"
# Another browser or other fonts change letters and the edges of lines, but not figures.
TOLERATED_SHARE = 0.06
TOLERATED_STEP = 60  # of 255, per channel
# In a chaotic motion another last bit, from the arithmetic of another machine, gives another curve.
IRREGULAR_SHARE = 0.2
TOLERATED_PIXELS = 24  # between boxes of parts that hold letters
DIGITS = 4


class Snapshots:
    """Baselines of one test run.

    Parameters
    ----------
    renew
        Write instead of compare.
    drawn_by
        ``browser``, ``letters`` and ``numbers``: what pictures depend on beside the page.

    Attributes
    ----------
    loose
        Names of the pictures that were only required to be similar.
    """

    def __init__(self, renew, drawn_by):
        self.renew = renew
        self.loose = []
        path = FOLDER / DRAWN_BY
        if renew:
            path.write_text(printed(drawn_by))
        before = json.loads(path.read_text()) if path.exists() else {}
        self.same = {name for name in drawn_by if before.get(name) == drawn_by[name]}

    def check_data(self, name, data):
        """Compare numbers, texts and boxes; a line of text for each difference."""
        path = FOLDER / f"{name}.json"
        text = printed(rounded(data))
        if self.renew:
            path.write_text(text)
            return []
        if not path.exists():
            return [missing(path)]
        old = path.read_text()
        differences = list(
            compare(json.loads(old), json.loads(text), loose=0 if "letters" in self.same else TOLERATED_PIXELS)
        )
        if not differences:
            return []
        shown = REPORT.add_data(name, differences, old, text)
        few = "; ".join(differences[:3]) + (f" and {len(differences) - 3} more" if len(differences) > 3 else "")
        return [f"the data of {name} differ ({few}); see {shown}"]

    def check_picture(self, name, png, irregular=False):
        """Compare pixels; a line of text if they differ."""
        path = FOLDER / f"{name}.webp"
        new = opened(png)
        if self.renew:
            if not path.exists() or opened(path.read_bytes()).tobytes() != new.tobytes():
                new.save(path, "WEBP", lossless=True, quality=100, method=4, exact=True)
            return []
        if not path.exists():
            return [missing(path)]
        exact = {"browser", "letters"} | ({"numbers"} if irregular else set()) <= self.same
        if not exact:
            self.loose.append(name)
        tolerated = 0 if exact else IRREGULAR_SHARE if irregular else TOLERATED_SHARE
        old = opened(path.read_bytes())
        fault, difference = differing(old, new, tolerated, 0 if exact else TOLERATED_STEP)
        if not fault:
            return []
        return [f"{name}: {fault}; see {REPORT.add_pictures(name, fault, old, new, difference)}"]

    def check_files(self, names):
        """Baselines that no test uses; renewing removes them."""
        old = {path for path in FOLDER.iterdir() if path.name not in {*names, DRAWN_BY, "README.md"}}
        if self.renew:
            for path in old:
                path.unlink()
            return []
        return [f"outdated: no test asks for {path.name}; `make snapshots` removes it" for path in sorted(old)]


def missing(path):
    return f"no baseline {path.name}: look at the page, then run `make snapshots`"


def opened(picture):
    return Image.open(io.BytesIO(picture)).convert("RGB")


def differing(old, new, tolerated_share, tolerated_step):
    """The fault of a picture, empty if it has none, and where it differs."""
    if old.size != new.size:
        return f"the picture was {old.size} and is {new.size}", None
    worst = functools.reduce(ImageChops.lighter, ImageChops.difference(old, new).split())
    where = worst.point(lambda value: 255 if value > tolerated_step else 0)
    count = where.histogram()[255]
    if count <= tolerated_share * old.size[0] * old.size[1]:
        return "", None
    return f"{count} pixels differ, by up to {worst.getextrema()[1]} of 255", where


def printed(data):
    """JSON with one list of plain values per line, for readable differences in git."""
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=True)
    return re.sub(r"\[[^\[\]{}]*\]", lambda found: re.sub(r"\s+", " ", found.group()), text) + "\n"


def rounded(data):
    """Numbers to a few significant digits: libraries may differ in the last bits."""
    if isinstance(data, dict):
        return {name: rounded(value) for name, value in data.items()}
    if isinstance(data, list):
        return [rounded(value) for value in data]
    return float(f"{data:.{DIGITS}g}") if isinstance(data, float) else data


def compare(old, new, where="", scale=None, loose=0):
    """Every difference, as a line of text; boxes may be off by ``loose`` pixels."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in sorted(old.keys() | new.keys()):
            if name not in old or name not in new:
                yield f"{where}.{name}: {'is new' if name in new else 'is gone'}"
            else:
                yield from compare(old[name], new[name], f"{where}.{name}", loose=loose)
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield f"{where}: had {len(old)} entries, has {len(new)}"
            return
        scale = max((abs(v) for v in old if isinstance(v, int | float)), default=None)
        for index, pair in enumerate(zip(old, new, strict=True)):
            yield from compare(*pair, f"{where}[{index}]", scale, loose)
    elif isinstance(old, int | float) and isinstance(new, int | float):
        allowed = loose if ".box" in where else 2e-3 * (scale or 1)
        if not math.isclose(old, new, rel_tol=0 if ".box" in where else 2e-3, abs_tol=allowed):
            yield f"{where}: was {old}, is {new}"
    elif old != new:
        yield f"{where}: was {old!r}, is {new!r}"
