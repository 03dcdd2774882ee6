"""A walk over the page: random moves of all controls, and what there is to see afterwards."""

import io
import re
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.ui.snapshots_page import AFRESH, read, words

SCRIPT = Path(__file__).with_name("walk.js").read_text(encoding="utf-8")
# Not in a link: files, dialogs, how fast the motion plays, which of two units a number is typed in, what stops or
# begins a search of its own.
LEFT_ALONE = re.compile(
    r"^(Cancel|Stop|Go on|Tour|\?|Help|Take away|Keys|Close|×|Open Help|All terms|Exercises|Fit|Use these values|Load"
    r"|Speed of the motion|Play|Pause|Copy|\+ CSV|Coexisting|Evidence|Back to the branches|Remove)"
    r"|: its unit$|computing|documentation|Download|measurement|as (PDF|SVG|PNG|CSV)$",
    re.IGNORECASE,
)
# How often each kind of move is made.
WEIGHTS = {"tab": 2, "scene": 2, "slider": 4, "typed": 4, "choice": 5, "select": 3, "button": 4, "legend": 3, "fold": 1}
WEIGHTS |= {"zoom": 3, "tap": 2, "key": 2}
KEYS = ("1", "2", "3", "4", "p", "r", "l", ".", ",", "Control+z", "Control+Shift+z")
FACTORS = (0.2, 0.5, 0.8, 0.97, 1.03, 1.3, 2, 5)
# Not compared: what a machine takes, and what is no part of a link.
MASKED = ".chips, .row.actions, .suggest .more, .message, .coexisting, .refusal"
MEASURED = ("speed",)  # tabs whose figures show measured times
APART = 24  # of 255, by which a pixel differs
FEW = 1e-3  # share of the pixels that may differ: edges of a legend that lies half a pixel elsewhere


class Walk:
    """Random moves on one page, which are told in ``moves``."""

    def __init__(self, explorer, draw):
        """``draw``: a `random.Random`."""
        self.explorer, self.page, self.draw = explorer, explorer.page, draw
        self.moves, self.slow = [], 0
        self.page.evaluate(SCRIPT)

    def step(self):
        """One move, after which the page may still be computing."""
        choices = [each | {"place": i} for i, each in enumerate(self.page.evaluate("walk.choices()"))]
        choices = [each for each in choices if each["kind"] and not LEFT_ALONE.search(each["name"])]
        frames = self.page.evaluate("walk.frames()")
        kinds = sorted({each["kind"] for each in choices} | {"key"} | ({"zoom", "tap"} if frames else set()))
        kind = self.draw.choices(kinds, [WEIGHTS[kind] for kind in kinds])[0]
        if kind == "key":
            self._press(self.draw.choice(KEYS))
        elif kind in ("zoom", "tap"):
            self._on_figure(kind, self.draw.choice(frames))
        else:
            self._on_control(self.draw.choice([each for each in choices if each["kind"] == kind]))
        if self.draw.random() < 0.5:
            self.rest()
        else:
            self.page.wait_for_timeout(self.draw.choice((30, 200, 600)))

    def _press(self, key):
        self.moves.append(f"key {key}")
        self.page.evaluate("document.activeElement?.blur()")
        self.page.keyboard.press(key)

    def _on_figure(self, kind, frame):
        def at(x, y):
            return frame["x"] + x * frame["width"], frame["y"] + y * frame["height"]

        ends = sorted((self.draw.uniform(0.05, 0.6), self.draw.uniform(0.65, 0.95)))
        if kind == "tap" or not frame["zooms"]:
            self.moves.append(f"tap {frame['name']} {ends}")
            self.page.mouse.click(*at(*ends))
            return
        self.moves.append(f"zoom {frame['name']} {ends}")
        self.page.mouse.move(*at(ends[0], 0.1))
        self.page.mouse.down()
        self.page.mouse.move(*at(ends[1], 0.9), steps=3)
        self.page.mouse.up()

    def _on_control(self, choice):
        kind, name = choice["kind"], f"{choice['group']} {choice['name']}".strip()
        element = self.page.evaluate_handle("i => walked[i]", choice["place"]).as_element()
        text = ""
        if kind == "slider":
            text = self.draw.choice(["ArrowLeft", "ArrowRight", "PageUp", "PageDown"])
            element.focus()
            for _ in range(self.draw.choice((1, 3, 9))):
                self.page.keyboard.press(text)
        elif kind == "typed":
            text = self._number(choice["value"])
            element.fill(text)
            element.press("Enter")
        elif kind == "select":
            text = self.draw.choice(choice["options"])
            element.select_option(text)
        elif kind == "choice":
            element.evaluate("e => e.click()")
        elif kind in ("legend", "fold"):
            element.focus()
            element.press("Enter")
        else:
            element.evaluate("e => { e.scrollIntoView({block: 'nearest'}); e.click(); }")
        self.moves.append(f"{kind} {name} {text}".strip())
        self._take_back_refused()

    def _number(self, text):
        try:
            value = float(text.replace(",", ""))
        except ValueError:
            return text
        value = value * self.draw.choice(FACTORS) if value else self.draw.choice((0, 0.1, 1))
        return f"{value:.4g}"

    def _take_back_refused(self):
        """A refused number stands in its field until Escape; it is no part of a link."""
        self.page.wait_for_timeout(60)
        if self.page.locator("[aria-invalid=true]").count():
            self.explorer.settle()
            for field in self.page.locator("input[aria-invalid=true]").all():
                field.press("Escape")
            self.moves.append("Escape")

    def rest(self, seconds=30):
        """Wait until nothing is being computed; what takes longer is left by way of the opening scene."""
        if not self._is_quiet(seconds):
            self.moves.append("slow: back to the opening scene")
            self.slow += 1
            self.page.evaluate("document.activeElement?.blur()")
            self.page.keyboard.press("r")
            if self.page.locator(".entry:popover-open").count():
                self.page.keyboard.press("Escape")  # an entry of the glossary, which may cover the tabs
            self.explorer.open_tab("Explore")
            assert self._is_quiet(120), f"still {self.page.evaluate('walk.busy()')}; moves: {self.moves}"

    def _is_quiet(self, seconds):
        end = time.monotonic() + seconds
        quiet = 0
        while quiet < 4 and time.monotonic() < end:
            quiet = 0 if self.page.evaluate("walk.busy()") else quiet + 1
            self.page.wait_for_timeout(60)
        return quiet == 4


def seen(walk):
    """What there is to see: controls, figures, texts, and a picture."""
    page = walk.page
    page.mouse.move(0, 0)
    walk.rest()
    page.evaluate("walk.calm()")
    page.wait_for_timeout(400)  # the address follows, and what opens is drawn
    walk.rest()
    found = page.evaluate("walk.state()")
    measured = page.evaluate("new URLSearchParams(location.search).get('view')") in MEASURED
    texts = [each["text"] for each in words(read(page)) if not each["measured"]]
    page.evaluate(AFRESH)
    page.evaluate("parts => walk.veil(parts, true)", MASKED)
    image = page.screenshot(full_page=True)
    page.evaluate("parts => walk.veil(parts, false)", MASKED)
    found["texts"] = [] if measured else texts
    if measured:
        found["figures"] = list(found["figures"])
    found["picture"] = None if measured else np.asarray(Image.open(io.BytesIO(image)).convert("RGB"), np.int16)
    return found


def differences(one, other):
    """In words, what of two states is not the same; empty if nothing."""
    found = []
    for kind in ("controls", "texts"):
        found += [f"{kind}: only where it was walked to: {text}" for text in _missing(one[kind], other[kind])]
        found += [f"{kind}: only by the link: {text}" for text in _missing(other[kind], one[kind])]
    if isinstance(one["figures"], dict):
        for name in sorted(one["figures"].keys() | other["figures"].keys()):
            first, second = (each["figures"].get(name, {}) for each in (one, other))
            for part in sorted(first.keys() | second.keys()):
                if not _alike(first.get(part), second.get(part)):
                    found.append(f"{name}, {part}: {_short(first.get(part))} by the link {_short(second.get(part))}")
    elif one["figures"] != other["figures"]:
        found.append(f"figures {one['figures']} by the link {other['figures']}")
    if one["picture"] is not None and not found:
        apart = pixels_apart(one["picture"], other["picture"])
        found += [f"{apart:.2%} of the picture"] if apart > FEW else []
    return found


def _alike(one, other):
    """Whether two values are the same, numbers as far as an address holds the ends of an axis."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return one == pytest.approx(other, rel=1e-3, abs=1e-9)
    return one == other


def _short(value):
    text = str(value)
    return text if len(text) < 700 else f"{text[:700]} …"


def _missing(texts, others):
    rest = list(others)
    found = []
    for text in texts:
        if text in rest:
            rest.remove(text)
        else:
            found.append(text)
    return found


def pixels_apart(one, other):
    """Share of the pixels of two pictures that differ."""
    if one.shape != other.shape:
        return 1.0
    return float((np.abs(one - other).max(axis=2) > APART).mean())
