"""Comparing what the page shows with what it showed when someone last looked: data and picture.

Baselines lie in tests/snapshots. ``pytest -m ui --renew-snapshots`` (``make snapshots``) writes them;
a missing one fails. Data must agree on any machine within rounding; pictures but for a
few pixels where the browser is the one that drew the baseline, and nearly so elsewhere.
"""

import base64
import functools
import html
import io
import json
import math
import re
from pathlib import Path

from PIL import Image, ImageChops

FOLDER = Path(__file__).parents[1] / "snapshots"
FAILED = Path(__file__).parents[1] / "results"
# Another browser or another set of fonts moves letters and the edges of lines, not figures.
TOLERATED_SHARE = 0.03
TOLERATED_STEP = 60  # of 255, per channel
# The same browser, drawing a rounded corner anew or from a cached tile, may round its greys to other levels, on some
# machines in some runs: seen on four pixels of 1.3 million. A changed letter has more, and text is compared as data.
ROUNDING_STEP = 1
ROUNDED_SHARE = 3e-5
DIGITS = 4


class Snapshots:
    """Baselines of one test run."""

    def __init__(self, renew, browser_version):
        self.renew = renew
        self.browser_version = browser_version

    def check_data(self, name, data):
        """Compare numbers and texts."""
        path = FOLDER / f"{name}.json"
        text = printed(rounded(data))
        if self.renew:
            path.write_text(text)
            return
        assert path.exists(), f"no baseline {path.name}: look at the page, then run `make snapshots`"
        differences = list(compare(json.loads(path.read_text()), json.loads(text)))
        if differences:
            rest = f"\n… and {len(differences) - 20} more" if len(differences) > 20 else ""
            raise AssertionError(f"{name} differs from its baseline:\n" + "\n".join(differences[:20]) + rest)

    def check_picture(self, name, png, tolerated_share=TOLERATED_SHARE, exact=True):
        """Compare pixels; ``exact`` asks for nearly each of them in the browser that drew the baseline."""
        path = FOLDER / f"{name}.png"
        if self.renew:
            path.write_bytes(png)
            (FOLDER / "browser.txt").write_text(self.browser_version + "\n")
            return
        assert path.exists(), f"no baseline {path.name}: look at the page, then run `make snapshots`"
        exact = exact and (FOLDER / "browser.txt").read_text().strip() == self.browser_version
        fault, difference = fault_in(path, png, exact, tolerated_share)
        if fault:
            shown = report(name, fault, path.read_bytes(), png, difference)
            raise AssertionError(f"{name}: {fault}; see {shown.relative_to(FOLDER.parents[1])}")


def fault_in(path, png, exact, tolerated_share):
    """What is wrong with a picture, empty if nothing, and where it differs."""
    old = Image.open(path).convert("RGB")
    new = Image.open(io.BytesIO(png)).convert("RGB")
    if old.size != new.size:
        return f"the picture was {old.size} and is {new.size}", None
    worst = functools.reduce(ImageChops.lighter, ImageChops.difference(old, new).split())
    differing = worst.point(lambda value: 255 if value > (ROUNDING_STEP if exact else TOLERATED_STEP) else 0)
    share = differing.histogram()[255] / (old.size[0] * old.size[1])
    if share <= (ROUNDED_SHARE if exact else tolerated_share):
        return "", None
    return f"{100 * share:.3g} % of the pixels differ", differing


def printed(data):
    """JSON with one list of plain values a line, so that git's difference can be read."""
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=True)
    return re.sub(r"\[[^\[\]{}]*\]", lambda found: re.sub(r"\s+", " ", found.group()), text) + "\n"


def rounded(data):
    """Numbers to a few significant digits: libraries may differ in the last bits."""
    if isinstance(data, dict):
        return {name: rounded(value) for name, value in data.items()}
    if isinstance(data, list):
        return [rounded(value) for value in data]
    return float(f"{data:.{DIGITS}g}") if isinstance(data, float) else data


def compare(old, new, where="", scale=None):
    """Every difference, as a line of text."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in sorted(old.keys() | new.keys()):
            if name not in old or name not in new:
                yield f"{where}.{name}: {'is new' if name in new else 'is gone'}"
            else:
                yield from compare(old[name], new[name], f"{where}.{name}")
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield f"{where}: had {len(old)} entries, has {len(new)}"
            return
        scale = max((abs(v) for v in old if isinstance(v, int | float)), default=None)
        for index, pair in enumerate(zip(old, new, strict=True)):
            yield from compare(*pair, f"{where}[{index}]", scale)
    elif isinstance(old, int | float) and isinstance(new, int | float):
        if not math.isclose(old, new, rel_tol=2e-3, abs_tol=2e-3 * (scale or 1)):
            yield f"{where}: was {old}, is {new}"
    elif old != new:
        yield f"{where}: was {old!r}, is {new!r}"


def report(name, fault, old, new, difference):
    """One page with old, new and difference."""
    FAILED.mkdir(exist_ok=True)
    pictures = {"was": old, "is": new}
    if difference is not None:
        buffer = io.BytesIO()
        difference.save(buffer, "PNG")
        pictures["difference"] = buffer.getvalue()
    cells = "".join(
        f"<h2>{title}</h2><img src='data:image/png;base64,{base64.b64encode(png).decode()}'>"
        for title, png in pictures.items()
    )
    path = FAILED / f"{name}.html"
    path.write_text(
        f"<!doctype html><meta charset=utf-8><title>{html.escape(name)}</title>"
        f"<h1>{html.escape(name)}: {html.escape(fault)}</h1>{cells}"
    )
    return path
