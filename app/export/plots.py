"""Scripts that draw the data of a figure with matplotlib, for a paper. No panel import.

A script reads the CSV file of its figure, which lies beside it. It is meant to be edited: it has a line for each curve.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from vibroscope.app.export.formats import MEASURED, Series
from vibroscope.app.studies.bifurcation import kind_names
from vibroscope.app.studies.cell_classes import KINDS, PERIOD_EDGES, PERIODS

_SUBSCRIPTS = str.maketrans("123", "₁₂₃")
_AXES = {  # name of a column without its unit: label of an axis
    "time": "time τ/T",
    "tau": "time τ",
    "force": "contact force λ",
    "force_or_mean": "contact force λ, or its mean",
    "impulse": "impulse",
    "eta": "excitation frequency η",
    "f": "excitation frequency f",
    "K": "contact stiffness K",
    "D": "contact damping D",
    "2D": "contact damper 2D",
    "n": "steps per period T/Δτ",
    "steps": "steps per period T/Δτ",
    "scatter": "blur about the cycle (standard deviation)",
    "error": "error",
    "error_time_step": "error by the time step",
    "us_per_period": "processor time per period / µs",
    "difference": "difference ξ",
}
_KIND_COLOURS = {kind_names(np.array([kind]))[0]: colour for kind, (_, colour) in KINDS.items()}
_LOOKS = {  # of curves, by the solver in their label
    "reference": 'color="C0", linewidth=2.4, alpha=0.6',
    "penalty": 'color="C1", linewidth=0.9',
}

_SCRIPT = '''"""{text}

Run this with matplotlib installed, beside {name}.csv: it writes {name}.pdf and {name}.png.
"""

import csv
from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

WIDTH, HEIGHT, DPI = 85, 64, 300  # mm, mm, dots per inch
LABEL = {label!r}


def column(texts):
    """Numbers, with nan in empty cells; or texts."""
    try:
        return np.array([float(text or "nan") for text in texts])
    except ValueError:
        return np.array(texts)


data = Path(__file__).with_suffix(".csv")
rows = defaultdict(lambda: defaultdict(list))
with data.open(encoding="utf-8", newline="") as file:
    for row in csv.DictReader(file):
        label = row.pop("series")
        for name, text in row.items():
            rows[label][name].append(text)
series = {{label: {{name: column(texts) for name, texts in table.items()}} for label, table in rows.items()}}

plt.rcParams.update({{"font.size": 8, "pdf.fonttype": 42}})  # letters as letters
plt.style.use("tableau-colorblind10")
figure, axes = plt.subplots(figsize=(WIDTH / 25.4, HEIGHT / 25.4), layout="constrained")
{drawn}
about = {{"Title": LABEL["title"], "Subject": LABEL["description"]}}
figure.savefig(data.with_suffix(".pdf"), metadata=about)
about = {{"Title": LABEL["title"], "Description": LABEL["description"]}}
figure.savefig(data.with_suffix(".png"), dpi=DPI, metadata=about)
'''


def plot_script(name: str, table: Sequence[Series], label: Mapping[str, str]) -> str:
    """A script that draws the CSV file ``name`` of a table.

    Parameters
    ----------
    name : str
        Of the file, without its suffix; the script has the same.
    table : sequence of Series
        What the file holds.
    label : mapping of str to str
        What the figure shows: `figure_label`.
    """
    known = {key: text.replace("\\", "/") for key, text in label.items()}
    text = "\n\n".join(known.values()).replace('"""', "'''")
    return _SCRIPT.format(text=text, name=name, label=known, drawn="\n".join(_drawn(table)))


def _drawn(table: Sequence[Series]) -> Iterator[str]:
    """Lines that draw all series, with labels of the axes and a legend."""
    kinds = [_kind(series, table) for series in table]
    for place, (series, (kind, x, ys)) in enumerate(zip(table, kinds, strict=True)):
        yield f"\ntable = series.get({series.label!r}, {{}})"
        yield "if table:"
        yield from (f"    {line}" for line in _DRAW[kind](series, x, ys, place))
    kind, x, ys = next((kind for kind in kinds if kind[0] not in ("bars", "stems")), kinds[0])
    yield f"\naxes.set_xlabel({_axis(x)!r})"
    if kind == "bars":
        yield f"axes.set_yticks(range({len(table)}), {[series.label for series in table]!r})"
        return
    if kind == "curve" and len({kind for kind, *_ in kinds}) > 1 and _name(x) in ("time", "tau"):
        yield f"shown = series[{table[0].label!r}][{x!r}]"
        yield "axes.set_xlim(np.nanmin(shown), np.nanmax(shown))"
    if kind in ("powers", "cells"):
        yield 'axes.set(xscale="log", yscale="log")'
    if kind == "stretches":
        yield "axes.set_yticks([])"
    else:
        yield f"axes.set_ylabel({_common_axis(ys)!r})"
    yield 'figure.legend(loc="outside upper center", ncols=2, frameon=False)'


# ---- which kind of curve a series is --------------------------------------------------------------------------------

_Kind = tuple[str, str, list[str]]  # a name of `_DRAW`, column of x, columns of y
_PHASE = tuple(  # axes of a phase plot
    (f"{x}{body}", f"{v}{body}") for x, v in (("xi", "velocity"), ("x", "velocity"), ("xi", "v")) for body in (2, 1)
)


def _kind(series: Series, table: Sequence[Series]) -> _Kind:
    """How a series is drawn: its columns decide, and whether the figure has a Poincaré section."""
    columns = {_name(column): column for column in series.columns}
    first, *others = columns
    if first == "contact_begin":
        return "bars", columns[first].replace(first, "time"), list(series.columns)
    if first.startswith("from_"):
        return "stretches", columns[first].removeprefix("from_"), [*list(series.columns)[:2], "kind"]
    if "us_per_period" in columns:
        return "powers", "us_per_period", [columns["error"]]
    if first in ("n", "steps") or "left" in columns:
        return "powers", first, [columns[others[0]]]
    if "K" in columns and len(columns) > 2:
        return "cells", columns["K"], [list(series.columns)[1], "period" if "period" in columns else "kind"]
    if "impulse" in columns:
        return "stems", columns[first], [columns["impulse"]]
    drawn = next((pair for pair in _PHASE if columns.keys() >= set(pair)), None)
    if drawn and (first != "tau" or any("section" in each.label for each in table)):
        kind = "dots" if "section" in series.label or series.label == MEASURED else "curve"
        return kind, columns[drawn[0]], [columns[drawn[1]]]
    if first in ("time", "tau"):
        return (
            "dots" if series.label == MEASURED else "curve",
            columns[first],
            [columns[n] for n in others if n == others[0] or n[0] == others[0][0]],
        )
    return "points", columns[first], [columns[others[-1]]]


def _name(column: str) -> str:
    """The name of a column without its unit."""
    return column.partition(" [")[0]


# ---- lines of a script, by kind -------------------------------------------------------------------------------------


def _curve(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    look = next((look for solver, look in _LOOKS.items() if solver in series.label), "linewidth=1.2")
    for dash, y in zip(("-", "--", "-.", ":"), ys, strict=False):
        more = f" {_symbol(y)}" if len(ys) > 1 else ""
        yield f'axes.plot(table[{x!r}], table[{y!r}], "{dash}", {look}, label={series.label + more!r})'


def _dots(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    colour = next((f"C{i}" for i, solver in enumerate(_LOOKS) if solver in series.label), "C1")
    mark, size = ("o" if colour == "C0" else "D"), 4
    if series.label == MEASURED:
        colour, mark, size = "0.15", "o", 1.5
    look = f'"{mark}", color="{colour}", markersize={size}, fillstyle="none"'
    for y in ys:
        more = f" {_symbol(y)}" if len(ys) > 1 else ""
        yield f"axes.plot(table[{x!r}], table[{y!r}], {look}, label={series.label + more!r})"


def _points(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    look = f'".", color="C{place}", markersize=1, markeredgewidth=0, rasterized=True'
    yield f"axes.plot(table[{x!r}], table[{ys[0]!r}], {look}, label={series.label!r})"


def _powers(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    yield f'axes.plot(table[{x!r}], table[{ys[0]!r}], "o-", markersize=3, linewidth=1, label={series.label!r})'


def _stems(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    yield 'other = axes.inset_axes([0, 0, 1, 1], sharex=axes, facecolor="none")  # with an axis of its own at the right'
    yield "other.xaxis.set_visible(False)"
    yield "other.yaxis.tick_right()"
    yield 'other.yaxis.set_label_position("right")'
    yield f'other.stem(table[{x!r}], table[{ys[0]!r}], "C{place % 10}", label={series.label!r}, basefmt=" ")'
    yield f"other.set_ylabel({_axis(ys[0])!r})"


def _bars(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    begin, end = (
        next(column for column in series.columns if column.startswith(f"contact_{e}")) for e in ("begin", "end")
    )
    yield f"spans = np.column_stack([table[{begin!r}], table[{end!r}] - table[{begin!r}]])"
    yield f'axes.broken_barh(spans, ({place} - 0.4, 0.8), color="C{place}", edgecolor="C{place}", linewidth=0.8)'


def _stretches(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    begin, end, kind = ys
    yield from _key_of_periods()
    yield 'periods = names[np.digitize(table["period"], edges)]'
    yield f'labels = np.where(table[{kind!r}] == "periodic", periods, table[{kind!r}])'
    yield f"colours |= {_KIND_COLOURS!r}"
    yield "for label in dict.fromkeys([*colours, *labels]):"
    yield "    chosen = labels == label"
    yield "    if chosen.any():"
    yield f"        begin, end = table[{begin!r}][chosen], table[{end!r}][chosen]"
    yield "        spans = np.column_stack([begin, end - begin])"
    yield '        axes.broken_barh(spans, (0, 1), color=colours.get(label, "0.5"), label=label)'


def _key_of_periods() -> Iterator[str]:
    """Lines with the classes of periods: their edges, names and colours, as the page has them."""
    names = [f"period {text}" if text[-1].isdigit() or " " in text else text for text, _ in PERIODS]
    yield f"edges, names = {list(PERIOD_EDGES)!r}, np.array({names!r})"
    yield f"colours = dict(zip(names, {[colour for _, colour in PERIODS]!r}))"


def _cells(series: Series, x: str, ys: list[str], place: int) -> Iterator[str]:
    y, kind = ys
    yield f"(x, i), (y, j) = (np.unique(table[name], return_inverse=True) for name in ({x!r}, {y!r}))"
    if kind == "kind":
        yield f"names, numbers = np.unique(table[{kind!r}], return_inverse=True)"
        yield 'colours = dict(zip(names, plt.get_cmap("viridis", len(names)).colors))'
    else:
        yield from _key_of_periods()
        yield f"numbers = np.digitize(table[{kind!r}], edges)"
    yield "cells = np.full((len(y), len(x)), np.nan)"
    yield "cells[j, i] = numbers"
    yield "shades = ListedColormap(list(colours.values()))"
    yield 'axes.pcolormesh(x, y, cells, cmap=shades, vmin=-0.5, vmax=len(names) - 0.5, shading="nearest")'
    yield "for number in np.unique(numbers):"
    yield '    axes.plot([], [], "s", color=colours[names[number]], label=names[number])'


_DRAW = {
    "curve": _curve,
    "dots": _dots,
    "points": _points,
    "powers": _powers,
    "stems": _stems,
    "bars": _bars,
    "stretches": _stretches,
    "cells": _cells,
}


# ---- words ----------------------------------------------------------------------------------------------------------


def _axis(column: str) -> str:
    """Label of an axis, with the unit that the name of the column holds."""
    name, _, unit = column.partition(" [")
    unit = unit.rstrip("]")
    words = _AXES.get(name) or _state(name)
    words = words.replace("τ/T", "t") if unit and name == "time" else words
    return f"{words} / {f'({unit})' if '/' in unit or '·' in unit else unit}" if unit else words


def _state(name: str) -> str:
    what = "velocity" if name.startswith("v") else "displacement" if name[:-1] in ("xi", "x") else ""
    return f"{what} {_symbol(name)}".strip()


def _symbol(column: str) -> str:
    """Symbol of a column of the state, or its name."""
    name = _name(column)
    if not re.fullmatch(r"(xi|x|v|velocity)[12]", name):
        return name.replace("_", " ")
    return f"ξ{name[-1].translate(_SUBSCRIPTS)}{'′' * name.startswith('v')}"


def _common_axis(columns: list[str]) -> str:
    """Label of an axis with one or several curves."""
    if len(columns) == 1 or _name(columns[0]) in _AXES:
        return _axis(columns[0])
    return re.sub("[₁₂]", "", _axis(columns[0]))
