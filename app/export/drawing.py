"""A figure as calls of matplotlib: they draw its PNG, SVG and PDF, and they are the lines of its script.

Lengths of a drawing are those of the page, in px. matplotlib is imported when the first file is drawn.
"""

import io
import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from textwrap import wrap
from typing import NamedTuple

import numpy as np

PT = 0.75  # of a pixel
_MM = 25.4 / 96
_RECT = (20, 500)  # mm, sides of a picture
_DPI = (50, 1200)
_USUAL_DPI = 300
_MOST_PIXELS = 20_000_000  # of a PNG: 80 MB while it is drawn
_FONT, _LABEL, _TITLE = 10 * PT, 11 * PT, 12 * PT  # that of matplotlib is wider than those of the page
_LETTER = 0.58  # mean width of a letter of the font, of its size; a bold one is wider
_BOLD = 0.68
_BESIDE = 60  # px, an axis with its numbers and label
_HANDLE = 34  # px, the sign of an entry of the legend with the gaps beside it
_LINE = 15  # px, height of a row of the legend
MANY = 2000  # points or cells that are an image in SVG and PDF, too: as shapes they make files of many megabytes
_STYLE = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, and has all symbols
    "font.size": _FONT,
    "axes.labelsize": _LABEL,
    "axes.titlesize": _TITLE,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.linewidth": PT,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-5, 6),
    "axes.xmargin": 0,
    "legend.fontsize": _FONT,
    "legend.frameon": False,
    "legend.borderpad": 0,
    "legend.columnspacing": 1.2,
    "hatch.linewidth": 0.8,
    "pdf.fonttype": 42,  # letters as letters
    "svg.fonttype": "none",
    "svg.hashsalt": "vibroscope",  # the same drawing, the same file
}
_lock = threading.Lock()  # the style of matplotlib is global


class Call(NamedTuple):
    """One call of matplotlib.

    Attributes
    ----------
    on : str
        "axes", or "right": with the same horizontal axis, and a vertical one of its own at the right.
    method : str
    given : tuple
        Arrays, numbers and texts.
    options : mapping of str to object
        ``cmap`` is a list of colours.
    """

    on: str
    method: str
    given: tuple
    options: Mapping[str, object] = {}


class Drawing(NamedTuple):
    """A figure.

    Attributes
    ----------
    size : tuple of float
        Width and height on the page in px.
    title : str
    labels : mapping of str to str
        Of the axes: "x", "y" and "right", as far as there are such.
    calls : sequence of Call
        What is drawn; the labels of the calls are the entries of its legend, in their order.
    style : mapping of str to object
        Colours, as parameters of matplotlib.
    """

    size: tuple[float, float]
    title: str
    labels: Mapping[str, str]
    calls: Sequence[Call]
    style: Mapping[str, object]


class Size(NamedTuple):
    """Width and height in mm, None as on the page; dots per inch of a PNG.

    >>> Size.of({"width": "85", "dpi": "600"})
    Size(width=85.0, height=None, dpi=600.0)
    >>> Size.of({"height": "5"})
    Traceback (most recent call last):
    ValueError: height = 5: give mm from 20 to 500, or nothing for the height on the page
    """

    width: float | None = None
    height: float | None = None
    dpi: float = _USUAL_DPI

    @classmethod
    def of(cls, texts: Mapping[str, str]) -> "Size":
        """Read the texts of a request; raises ValueError if one is out of its range."""
        sides = (
            _number(texts, name, _RECT, f"mm from 20 to 500, or nothing for the {name} on the page")
            for name in ("width", "height")
        )
        return cls(*sides, _number(texts, "dpi", _DPI, "50 to 1200 dots per inch, or nothing for 300") or _USUAL_DPI)


def _number(texts: Mapping[str, str], name: str, bounds: tuple[float, float], wanted: str) -> float | None:
    text = texts.get(name, "")
    try:
        number = float(text) if text else None
    except ValueError:
        number = math.nan
    if number is None or bounds[0] <= number <= bounds[1]:
        return number
    raise ValueError(f"{name} = {text[:20]}: give {wanted}")


def write_picture(drawing: Drawing, kind: str, size: Size, label: Mapping[str, str]) -> bytes:
    """The file of a drawing.

    Parameters
    ----------
    drawing : Drawing
    kind : str
        "png", "svg" or "pdf".
    size : Size
    label : mapping of str to str
        ``title`` and ``description`` of the figure, for the metadata of the file.

    Raises
    ------
    ValueError
        If a PNG would have too many pixels.

    Examples
    --------
    >>> line = Call("axes", "plot", ([0, 1], [0, 1]), {"label": "reference"})
    >>> drawing = Drawing((300, 200), "A line", {"x": "time", "y": "force"}, [line], {})
    >>> write_picture(drawing, "png", Size(dpi=50), {"title": "Line", "description": ""})[1:4]
    b'PNG'
    """
    width, height = _in_inches(drawing, size)
    if kind == "png" and (pixels := width * height * size.dpi**2) > _MOST_PIXELS:
        raise ValueError(
            f"it would have {pixels / 1e6:.0f} million pixels, and may have {_MOST_PIXELS / 1e6:.0f}: "
            "take a smaller width or height, or fewer dots per inch"
        )
    if kind == "png":
        width, height = _whole_pixels((width, height), size.dpi)
    from matplotlib import rc_context, rcParamsDefault

    about = {"Title": label["title"], "Subject" if kind == "pdf" else "Description": label["description"]}
    about |= {"png": {}, "svg": {"Date": None}, "pdf": {"Creator": "Vibroscope", "CreationDate": None}}[kind]
    plain = {name: value for name, value in rcParamsDefault.items() if not name.startswith("backend")}
    file = io.BytesIO()
    with _lock, rc_context({**plain, **_STYLE, **drawing.style}):
        _drawn(drawing, (width, height)).savefig(file, format=kind, dpi=size.dpi, metadata=about)
    return file.getvalue()


def _in_inches(drawing: Drawing, size: Size) -> tuple[float, float]:
    """As on the page, in the wanted width; the rows of the legend are below."""
    shown, high = drawing.size
    width = size.width / _MM if size.width else shown
    height = max(width * high / shown, min(high, width)) + _LINE * _legend(drawing, width)[1]
    return width / 96, size.height / 25.4 if size.height else height / 96


def _whole_pixels(inches: tuple[float, float], dpi: float) -> tuple[float, float]:
    """The next size of whole pixels, and a bit: matplotlib cuts what is left of one."""
    width, height = inches
    return (round(width * dpi) + 0.3) / dpi, (round(height * dpi) + 0.3) / dpi


def _legend(drawing: Drawing, width: float) -> tuple[int, int]:
    """Columns and rows of the legend in a width in px."""
    entries = [label for call in drawing.calls if (label := call.options.get("label"))]
    if not entries:
        return 1, 0
    widths = [_HANDLE + _LETTER * _FONT / PT * len(entry) for entry in entries]
    fits = (n for n in range(len(widths), 1, -1) if sum(map(max, np.array_split(widths, n))) <= width)
    columns = next(fits, 1)
    return columns, math.ceil(len(entries) / columns)


def _all_calls(drawing: Drawing, inches: tuple[float, float]) -> list[Call]:
    """What is drawn, then title and labels; a dollar is a dollar, and begins no formula."""

    def plain(part: object) -> object:
        return part.replace("$", r"\$") if isinstance(part, str) else part

    calls = [*drawing.calls, *_texts(drawing, inches)]
    labels = [{"label": plain(call.options["label"])} if "label" in call.options else {} for call in calls]
    return [
        call._replace(given=tuple(map(plain, call.given)), options={**call.options, **label})
        for call, label in zip(calls, labels, strict=True)
    ]


def _texts(drawing: Drawing, inches: tuple[float, float]) -> Iterator[Call]:
    """Title and labels, broken into lines that have room."""
    width, height = (96 * side for side in inches)
    beside = _BESIDE * (1 + ("right" in drawing.labels))
    title = _broken(drawing.title, (width - _BESIDE) / (_TITLE / PT * _BOLD))
    if title:
        yield Call("axes", "set_title", (title,))
    height -= _LINE * (_legend(drawing, width)[1] + len(title.split("\n")))
    for axis, label in drawing.labels.items():
        on, side = ("right", "y") if axis == "right" else ("axes", axis)
        room = width - beside if side == "x" else height - _BESIDE
        yield Call(on, f"set_{side}label", (_broken(label, room / (_LABEL / PT * _LETTER)),))


def _broken(text: str, letters: float) -> str:
    return "\n".join(wrap(text, max(int(letters), 12), break_long_words=False))


def _drawn(drawing: Drawing, inches: tuple[float, float]):
    """The figure of matplotlib."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    figure = Figure(figsize=inches, layout="constrained")
    axes = {"axes": figure.add_subplot()}
    calls = _all_calls(drawing, inches)
    if any(call.on == "right" for call in calls):
        axes["right"] = axes["axes"].twinx()
        axes["right"].grid(visible=False)
    for on, method, given, options in calls:
        more = {"cmap": ListedColormap(options["cmap"])} if "cmap" in options else {}
        attrgetter(method)(axes[on])(*given, **{**options, **more})
    columns, rows = _legend(drawing, 96 * inches[0])
    if rows:
        figure.legend(loc="outside lower left", ncols=columns)
    return figure


_SCRIPT = '''"""{text}

Run this with matplotlib installed: it writes {name}.pdf and {name}.png. The numbers stand at the end.
"""

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

WIDTH, HEIGHT, DPI = {width:.3f}, {height:.3f}, {dpi:g}  # mm, mm, dots per inch
LABEL = {label!r}
STYLE = {style}


def draw(data):
    """The figure, with a line for each curve."""
    figure = Figure(figsize=(WIDTH / 25.4, HEIGHT / 25.4), layout="constrained")
    axes = figure.add_subplot()
    {drawn}
    return figure


def main():
    """Write both files beside this one."""
    about = {{"Title": LABEL["title"], "Subject": LABEL["description"]}}
    file = Path(__file__)
    with rc_context(STYLE):
        figure = draw([np.array(column) for column in DATA])
        figure.savefig(file.with_suffix(".pdf"), dpi=DPI, metadata=about)
        about["Description"] = about.pop("Subject")
        figure.savefig(file.with_suffix(".png"), dpi=DPI, metadata=about)


nan = float("nan")
DATA = [
{data}
]
main()
'''


def plot_script(name: str, drawing: Drawing, size: Size, label: Mapping[str, str]) -> str:
    """A script with the calls and the numbers of a drawing; its file is ``name`` with the suffix ".py".

    >>> line = Call("axes", "plot", (np.array([0.0, 1.0]), np.array([2.0, 3.0])), {"color": "#0072B2"})
    >>> drawing = Drawing((300, 200), "", {"x": "time"}, [line], {})
    >>> script = plot_script("force", drawing, Size(), {"title": "Force", "description": ""})
    >>> print(script[script.index("axes.plot"):script.index("return")].rstrip())
    axes.plot(data[0], data[1], color='#0072B2')
        axes.set_xlabel('time')
    """
    inches = _in_inches(drawing, size)
    known = {key: text.replace("\\", "/") for key, text in label.items()}
    calls = _all_calls(drawing, inches)
    data: list[str] = []
    lines = [_line(call, data) for call in calls]
    if any(call.on == "right" for call in calls):
        lines[:0] = ["right = axes.twinx()", "right.grid(visible=False)"]
    columns, rows = _legend(drawing, 96 * inches[0])
    width, height = _whole_pixels(inches, size.dpi)
    lines += [f'figure.legend(loc="outside lower left", ncols={columns})'] if rows else []
    return _SCRIPT.format(
        text="\n\n".join(known.values()).replace('"""', "'''"),
        name=name,
        width=25.4 * width,
        height=25.4 * height,
        dpi=size.dpi,
        label=known,
        style="{\n" + "".join(f"    {key!r}: {value!r},\n" for key, value in {**_STYLE, **drawing.style}.items()) + "}",
        drawn="\n    ".join(lines),
        data="\n".join(f"    {column}," for column in data),
    )


def _line(call: Call, data: list[str]) -> str:
    """The call as code; its arrays are put into ``data``, unless they are there."""

    def code(value: object) -> str:
        if not isinstance(value, np.ndarray):
            return repr(value)
        text = _numbers(value)
        if text not in data:
            data.append(text)
        return f"data[{data.index(text)}]"

    given = [code(value) for value in call.given]
    for name, value in call.options.items():
        given.append(f"cmap=ListedColormap({value!r})" if name == "cmap" else f"{name}={code(value)}")
    return f"{call.on}.{call.method}({', '.join(given)})"


def _numbers(column: np.ndarray) -> str:
    """An array as a list, with as many digits as it has."""
    if column.ndim > 1:
        return f"[{', '.join(map(_numbers, column))}]"
    return f"[{', '.join(column.astype(str))}]"
