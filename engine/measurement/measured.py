"""Measured motion, read from a CSV file: displacements of both pendulums over time, and perhaps a contact sensor.

    # any comment
    time [s], x1 [mm], x2 [mm], contact
    0.000, 1.812, 1.823, 1

A header names columns and units. ``x1`` and ``x2`` are absolute, as a sensor that stands still sees them (paper,
section 3); ``xi1`` and ``xi2`` are relative to the base. Times are in s, ms or µs and displacements in m, mm or µm, or
all without dimension (``[-]``, or no unit): time counted in 1/ω₁, displacements in base amplitudes. ``contact`` is 1
while the sensor's circuit is closed, else 0. Columns are parted by commas, semicolons or tabs; with the last two,
numbers may have decimal commas.

A file is read completely or refused: whatever is odd about it gives an error that names line and column, since a
measurement that is quietly misread looks like a discovery.
"""

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..files import read_file
from ..units import Units

SIZE_LIMIT = 16 * 2**20  # bytes; some 400,000 samples
FEWEST_SAMPLES = 16
LARGEST = 1e9  # in units of the model: what is larger is a misread unit

_SECONDS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "μs": 1e-6, "us": 1e-6}
_MILLIMETRES = {"m": 1e3, "mm": 1.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3}
_NONE = ("", "-", "1")
_PAIRS = {"absolute": ("x1", "x2"), "relative": ("xi1", "xi2")}
_KNOWN = ("time", "x1", "x2", "xi1", "xi2", "contact")
_HEADER = re.compile(r"\s*(\w+)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


@dataclass(frozen=True)
class Measurement:
    """Displacements over time, in units of the model.

    Attributes
    ----------
    time : (n,) ndarray
        τ since the first sample, increasing; the samples need not be equally spaced.
    displacement : (2, n) ndarray
        Of pendulum 1 and 2, in base amplitudes.
    contact : (n,) bool ndarray or None
        Whether the pendulums touch, if a sensor told.
    frame : {"absolute", "relative"}
        Seen by a fixed sensor, ξ + cos ητ, or relative to the base, ξ.
    """

    time: np.ndarray
    displacement: np.ndarray
    contact: np.ndarray | None
    frame: str

    def __len__(self) -> int:
        return len(self.time)

    @property
    def span(self) -> float:
        """τ from the first to the last sample."""
        return float(self.time[-1])


@dataclass(frozen=True)
class _Column:
    """A column of the file: what it holds, and what its numbers are multiplied by."""

    name: str
    factor: float
    physical: bool | None  # None: has no unit either way


def read_measurement(path: str | Path, units: Units | None = None) -> Measurement:
    """Read a measurement.

    Parameters
    ----------
    path : str or Path
    units : Units, optional
        What physical numbers are divided by; by default the paper's.

    Returns
    -------
    Measurement

    Raises
    ------
    ValueError
        If the file cannot be read, is larger than SIZE_LIMIT, or is malformed: one line that names file, line and
        column.
    """
    return read_file(path, SIZE_LIMIT, lambda content: parse_measurement(content, units))


def parse_measurement(content: bytes, units: Units | None = None) -> Measurement:
    """What the bytes of a file say; raises as :func:`read_measurement`, but knows no file name."""
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"larger than {SIZE_LIMIT // 2**20} MiB: give fewer periods, or fewer samples of each")
    lines = _lines(content)
    start = next((i for i, line in enumerate(lines) if line.strip()), None)
    if start is None:
        raise ValueError("line 1: the file has no header; begin it with: time [s], x1 [mm], x2 [mm]")
    delimiter = next((sign for sign in ";\t" if sign in lines[start]), ",")
    rows = _rows(lines, delimiter)
    number, header = next(rows)
    columns = _columns(header, number, units or Units())
    data: list[list[float]] = []
    for number, cells in rows:
        _append(data, cells, columns, number, delimiter)
    if len(data) < FEWEST_SAMPLES:
        raise ValueError(f"line {len(lines)}: the file ends after {len(data)} samples; give at least {FEWEST_SAMPLES}")
    values = dict(zip((column.name for column in columns), np.array(data).T, strict=True))
    frame = "absolute" if "x1" in values else "relative"
    return Measurement(
        time=values["time"] - values["time"][0],
        displacement=np.stack([values[name] for name in _PAIRS[frame]]),
        contact=values["contact"] > 0 if "contact" in values else None,
        frame=frame,
    )


def measurement_text(measurement: Measurement, units: Units, comment: str) -> str:
    """A CSV file in s and mm that :func:`read_measurement` takes, headed by a comment."""
    first, second = _PAIRS[measurement.frame]
    touching = measurement.contact is not None
    lines = [f"# {line}" for line in comment.splitlines()]
    lines.append(f"time [s], {first} [mm], {second} [mm]" + (", contact" if touching else ""))
    time = units.physical("time", measurement.time)
    one, two = units.physical("displacement", measurement.displacement)
    for i in range(len(measurement)):
        row = f"{time[i]:.9g}, {one[i]:.7g}, {two[i]:.7g}"
        lines.append(f"{row}, {int(measurement.contact[i])}" if touching else row)
    return "\n".join(lines) + "\n"


def _lines(content: bytes) -> list[str]:
    """The lines, comments made empty so that the others keep their numbers."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = content[: problem.start].count(b"\n") + 1
        raise ValueError(f"line {line}: not UTF-8 text; save the file as CSV in UTF-8") from None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return ["" if line.lstrip().startswith("#") else line for line in lines]


def _rows(lines: list[str], delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that is not empty."""
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield reader.line_num, cells
    except csv.Error as problem:
        raise ValueError(f"line {reader.line_num}: not CSV: {problem}") from None


def _columns(header: list[str], number: int, units: Units) -> list[_Column]:
    columns: list[_Column] = []
    for place, cell in enumerate(header, 1):
        where = f"line {number}, column {place}"
        found = _column(cell, where, units)
        if any(found.name == column.name for column in columns):
            raise ValueError(f"{where}: a second column {found.name}; give each once")
        columns.append(found)
    names = {column.name for column in columns}
    pairs = [set(pair) for pair in _PAIRS.values()]
    if "time" not in names or names - {"time", "contact"} not in pairs:
        raise ValueError(
            f"line {number}: columns {', '.join(column.name for column in columns)}; "
            "give time and either x1, x2 (absolute) or xi1, xi2 (relative to the base)"
        )
    kinds = {column.physical for column in columns} - {None}
    if len(kinds) > 1:
        raise ValueError(f"line {number}: mixes columns with and without a unit; give all as [s], [mm] or all as [-]")
    return columns


def _column(cell: str, where: str, units: Units) -> _Column:
    match = _HEADER.fullmatch(cell)
    name = match[1].lower() if match else ""
    if name not in _KNOWN:
        raise ValueError(f"{where}: unknown column {cell.strip()[:40]!r}; known: {', '.join(_KNOWN)}, as in x1 [mm]")
    unit = match[2] or ""
    if unit in _NONE:
        return _Column(name, 1.0, None if name == "contact" else False)
    sizes = {"time": _SECONDS, "contact": {}}.get(name, _MILLIMETRES)
    if unit not in sizes:
        known = ", ".join([*dict.fromkeys(sizes), "-"])
        raise ValueError(f"{where} ({name}): unknown unit {unit[:20]!r}; known: {known}")
    quantity = "time" if name == "time" else "displacement"
    return _Column(name, units.model(quantity, sizes[unit]), True)


def _append(data: list[list[float]], cells: list[str], columns: list[_Column], number: int, delimiter: str) -> None:
    """One more sample, checked against the last."""
    if len(cells) != len(columns):
        advice = "; decimal commas need semicolons between columns" if delimiter == "," else ""
        raise ValueError(f"line {number}: {len(cells)} columns, the header has {len(columns)}{advice}")
    row = []
    for place, (cell, column) in enumerate(zip(cells, columns, strict=True), 1):
        value = _number(cell, delimiter) * column.factor
        fault = _fault(value, column.name, data[-1][place - 1] if data else -math.inf)
        if fault:
            raise ValueError(f"line {number}, column {place} ({column.name}): {cell.strip()[:40]!r} {fault}")
        row.append(value)
    data.append(row)


def _fault(value: float, name: str, before: float) -> str:
    """What is wrong with a number, in units of the model, that comes after another; empty if nothing."""
    if math.isnan(value):
        return "is no finite number"
    if abs(value) > LARGEST:
        return f"is {value:.3g} in units of the model; is the unit right?"
    if name == "contact" and value not in (0.0, 1.0):
        return "is neither 0 nor 1; set a threshold to the sensor's signal"
    if name == "time" and value <= before:
        return "does not come after the time before it; sort by time"
    return ""


def _number(cell: str, delimiter: str) -> float:
    """The number in a cell; nan if it holds none that is finite."""
    text = cell.strip()
    if delimiter != "," and text.count(",") == 1 and "." not in text:
        text = text.replace(",", ".")
    try:
        value = math.nan if "_" in text else float(text)  # Python reads 1_000, no other program means it
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
