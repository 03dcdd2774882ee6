"""The work–precision diagram as SVG text; a few hundred marks need no plotting library.

One panel for each problem, with logarithmic axes: the error upwards, microseconds per period to the right. Below and
left is better. A solver's line joins its best settings: those that no other of its settings beats in both.
"""

import json
import math
import sys
from html import escape
from itertools import pairwise
from pathlib import Path

WIDTH, HEIGHT = 370, 300  # of a panel
LEFT, TOP, RIGHT, BOTTOM = 46, 30, 12, 40
COLUMNS = 3
COST = (-1.2, 5.3)  # powers of ten
ERROR = (-15.6, 1.4)
FONT = "font-family='Helvetica, Arial, sans-serif'"
# Colour and radius of the marks. Later ones lie on top of earlier ones, and their names are placed first.
STYLES = {
    "SciPy Radau": ("#5f6368", 2.5),
    "SciPy LSODA": ("#7a6a00", 2.5),
    "SciPy DOP853": ("#4d7c32", 2.5),
    "Newmark, plain loop": ("#8e44ad", 2.5),
    "heyoka, batch": ("#d1570a", 3.5),
    "heyoka": ("#d1570a", 3.5),
    "Newmark": ("#1f8fd6", 3.5),
    "Newmark, located": ("#0a7f6f", 3.5),
    "exact penalty": ("#0b57a4", 6),
    "reference": ("#0b57a4", 6),
}
NAMES = {
    "reference": "Vibroscope",
    "exact penalty": "Vibroscope, exact",
    "Newmark": "Vibroscope, Newmark",
    "Newmark, located": "Vibroscope, located",
    "Newmark, plain loop": "Newmark, plain loop",
    "heyoka, batch": "batch of 8, per lane",
    "SciPy DOP853": "DOP853",
    "SciPy LSODA": "LSODA",
    "SciPy Radau": "Radau",
}


def best_points(points):
    """The settings that no other beats in both cost and error, by rising cost."""
    found, least = [], math.inf
    for point in sorted((p for p in points if p["error"] is not None), key=lambda p: p["us_per_period"]):
        if point["error"] < least:
            found.append(point)
            least = point["error"]
    return found


def position(point):
    """Position of a point in its panel, in pixels; an error of 0 is drawn on the lower edge."""
    x = (math.log10(point["us_per_period"]) - COST[0]) / (COST[1] - COST[0])
    y = (math.log10(max(point["error"], 10 ** ERROR[0])) - ERROR[0]) / (ERROR[1] - ERROR[0])
    return LEFT + x * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - y * (HEIGHT - TOP - BOTTOM)


def text(x, y, words, *, size=11, colour="#333", anchor="start", more=""):
    """A line of text; ``more`` are further attributes."""
    where = f"x='{x:.1f}' y='{y:.1f}' font-size='{size}' fill='{colour}' text-anchor='{anchor}'"
    return f"<text {where} {more}>{escape(words)}</text>"


def axes(title, first_column, last_row):
    """Frame, grid lines at powers of ten, their labels, the panel's title."""
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    yield text(LEFT, TOP - 10, title, size=12.5, colour="#111", more="font-weight='bold'")
    for power in range(math.ceil(COST[0]), math.floor(COST[1]) + 1):
        x, _ = position({"us_per_period": 10.0**power, "error": 1.0})
        yield f"<line x1='{x:.1f}' x2='{x:.1f}' y1='{TOP}' y2='{bottom}' stroke='#e4e4e4'/>"
        yield text(x, bottom + 14, f"{10.0**power:,.10g}".replace(",", "\u202f"), size=10, anchor="middle")
    for power in range(-15, 1, 3):
        _, y = position({"us_per_period": 1.0, "error": 10.0**power})
        yield f"<line x1='{LEFT}' x2='{right}' y1='{y:.1f}' y2='{y:.1f}' stroke='#e4e4e4'/>"
        yield text(LEFT - 5, y + 3.5, f"1e{power}" if power else "1", size=10, anchor="end")
    yield f"<path d='M{LEFT} {TOP}V{bottom}H{right}' fill='none' stroke='#777'/>"
    if last_row:
        yield text((LEFT + right) / 2, bottom + 31, "microseconds per period", anchor="middle")
    if first_column:
        middle = (TOP + bottom) / 2
        yield text(
            11, middle, "error after 10 periods", anchor="middle", more=f"transform='rotate(-90 11 {middle:.0f})'"
        )


def curve(name, spots):
    """Line and marks of one solver."""
    colour, radius = STYLES[name]
    path = "L".join(f"{x:.1f} {y:.1f}" for x, y in spots)
    yield f"<path d='M{path}' fill='none' stroke='{colour}' stroke-width='1.6'/>"
    hollow = name.endswith("batch")
    fill = "fill='#fff' stroke-width='1.5'" if hollow else f"fill='{colour}' stroke-width='0.5'"
    for x, y in spots:
        yield f"<circle cx='{x:.1f}' cy='{y:.1f}' r='{radius}' {fill} stroke='{colour if hollow else '#fff'}'/>"


def ink_points(spots):
    """Points along the line through the spots, closer than a letter."""
    for (x, y), (u, v) in pairwise(spots):
        pieces = max(1, round(math.hypot(u - x, v - y) / 4))
        yield from ((x + (u - x) * k / pieces, y + (v - y) * k / pieces) for k in range(pieces + 1))
    for x, y in spots:  # a mark counts more than a line, and is wider
        yield from ((x + dx, y + dy) for dx in (-3, 0, 3) for dy in (-3, 0, 3))


def label(name, spots, ink, boxes):
    """The solver's name at the place beside its line where it hides least; adds its box to ``boxes``."""
    words, colour = NAMES.get(name, name), STYLES[name][0]
    bold = words.startswith("Vibroscope")
    wide, high, gap = len(words) * (6.4 if bold else 5.9), 12, STYLES[name][1] + 5

    def penalty(box):
        """Points and names that it would hide, and whether it leaves the frame."""
        x, y = box
        off = x < LEFT + 2 or x + wide > WIDTH - 2 or y - high < TOP or y > HEIGHT - BOTTOM - 2
        over = sum(x - 2 < u < x + wide + 2 and y - high < v < y + 2 for u, v in ink)
        cut = sum(x < u + w and u < x + wide and y - high < v and v - high < y for u, v, w in boxes)
        return over + 300 * cut + 1000 * off

    candidates = []
    for x, y in spots:
        for away in (0, 7, 14):  # farther off where it is crowded; min takes the first of equals
            candidates += [(x - wide / 2, y - gap - away), (x - gap - wide, y + 4), (x + gap, y + 4)]
            candidates += [(x + gap - 3, y + side * (gap + away) + 4) for side in (-1, 1)]
            candidates += [(x + 3 - gap - wide, y + side * (gap + away) + 4) for side in (-1, 1)]
            candidates += [(x - wide / 2, y + gap + away + 8)]
    x, y = min(candidates, key=penalty)
    boxes.append((x, y, wide))
    halo = "paint-order='stroke' stroke='#fff' stroke-width='3' stroke-linejoin='round'"
    return text(x, y, words, colour=colour, more=halo + (" font-weight='bold'" if bold else ""))


def draw(data):
    """The figure as SVG text; ``data`` is what work_precision.py writes."""
    panels = data["problems"]
    rows = math.ceil(len(panels) / COLUMNS)
    width, height = COLUMNS * WIDTH + 10, rows * HEIGHT + 26
    out = [
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' {FONT} role='img'>",
        "<title>Error against cost of every solver, problem by problem; below and left is better</title>",
        f"<rect width='{width}' height='{height}' fill='#fff'/>",
    ]
    for k, panel in enumerate(panels):
        row, column = divmod(k, COLUMNS)
        out.append(f"<g transform='translate({column * WIDTH} {row * HEIGHT})'>")
        out += axes(panel["title"], column == 0, row == rows - 1)
        points = {series["name"]: series["points"] for series in panel["series"]}
        spots = {name: [position(point) for point in best_points(points.get(name, []))] for name in STYLES}
        spots = {name: found for name, found in spots.items() if found}
        for name, found in spots.items():
            out += curve(name, found)
        ink, boxes = [point for found in spots.values() for point in ink_points(found)], []
        out += [label(name, spots[name], ink, boxes) for name in reversed(spots)]
        out.append("</g>")
    versions = ", ".join(f"{name} {number}" for name, number in data["versions"].items() if number)
    versions += f", solvers {data['solvers']}"
    out.append(
        text(
            LEFT,
            height - 10,
            f"{data['processor']}; {versions}. 200 periods from rest; processor time, medians of interleaved rounds.",
            size=10,
            colour="#666",
        )
    )
    return "\n".join([*out, "</svg>", ""])


if __name__ == "__main__":  # draw stored data again
    assets = Path(__file__).resolve().parents[1] / "assets"
    source = Path(sys.argv[1]) if sys.argv[1:] else assets / "speed" / "work-precision.json"
    source.with_suffix(".svg").write_text(draw(json.loads(source.read_text())))
