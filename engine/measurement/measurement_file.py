"""Measurements as CSV files: displacements of both pendulums over time, and perhaps a contact sensor.

    # any comment
    time [s], x1 [mm], x2 [mm], contact
    0.000, 1.812, 1.823, 1

The header names columns and units. ``x1`` and ``x2`` are absolute, as measured by a fixed sensor (paper, section 3);
``xi1`` and ``xi2`` are relative to the base. Times are in s, ms or µs and displacements in m, mm or µm. Or all are
without dimension (``[-]``, or no unit): time in units of 1/ω₁, displacements in base amplitudes. ``contact`` is 1 while
the sensor's circuit is closed, else 0. Columns are separated by commas, semicolons or tabs; with the last two, numbers
may have decimal commas.

A file is either read completely or refused with an error that names line and column, since a measurement that is
misread silently looks like a discovery.
"""

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..files import read_file
from ..units import Units
from .measurement import Measurement

SIZE_LIMIT = 16 * 2**20  # bytes; some 400,000 samples
FEWEST_SAMPLES = 16
LARGEST = 1e9  # in units of the model: a larger number has a wrong unit

_SECONDS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "μs": 1e-6, "us": 1e-6}
_MILLIMETRES = {"m": 1e3, "mm": 1.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3}
_DIMENSIONLESS = ("", "-", "1")
_PAIRS = {"absolute": ("x1", "x2"), "relative": ("xi1", "xi2")}
_COLUMN_NAMES = ("time", "x1", "x2", "xi1", "xi2", "contact")
_HEADER = re.compile(r"\s*(\w+)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


@dataclass(frozen=True)
class _Column:
    """A column of the file: its name, and the factor that converts its numbers to units of the model."""

    name: str
    factor: float
    physical: bool | None  # None for the contact sensor, which has no unit in either case


def read_measurement(path: str | Path, units: Units | None = None) -> Measurement:
    """Read a measurement from a CSV file.

    Parameters
    ----------
    path : str or Path
    units : Units, optional
        To convert physical numbers; by default the paper's.

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
    """Parse the bytes of a CSV file; raises as :func:`read_measurement`, without the name of the file."""
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"larger than {SIZE_LIMIT // 2**20} MiB: give fewer periods, or fewer samples of each")
    lines = _lines(content)
    start = next((i for i, line in enumerate(lines) if line.strip()), None)
    if start is None:
        raise ValueError("line 1: the file has no header; begin it with: time [s], x1 [mm], x2 [mm]")
    delimiter = next((character for character in ";\t" if character in lines[start]), ",")
    rows = _rows(lines, delimiter)
    number, header = next(rows)
    columns = _columns(header, number, _in_millimetres(units or Units()))
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
    """Write a CSV file in s and mm for :func:`read_measurement`, with a comment at the top."""
    first, second = _PAIRS[measurement.frame]
    has_contact = measurement.contact is not None
    lines = [f"# {line}" for line in comment.splitlines()]
    lines.append(f"time [s], {first} [mm], {second} [mm]" + (", contact" if has_contact else ""))
    units = _in_millimetres(units)
    time = units.physical("time", measurement.time)
    x1, x2 = units.physical("displacement", measurement.displacement)
    for i in range(len(measurement)):
        row = f"{time[i]:.9g}, {x1[i]:.7g}, {x2[i]:.7g}"
        lines.append(f"{row}, {int(measurement.contact[i])}" if has_contact else row)
    return "\n".join(lines) + "\n"


def _lines(content: bytes) -> list[str]:
    """Split into lines; comments become empty lines, so that the others keep their numbers."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = content[: problem.start].count(b"\n") + 1
        raise ValueError(f"line {line}: not UTF-8 text; save the file as CSV in UTF-8") from None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return ["" if line.lstrip().startswith("#") else line for line in lines]


def _in_millimetres(units: Units) -> Units:
    """The same units with lengths in mm, as the columns of a file have them."""
    return replace(units, system="mm-t-s")


def _rows(lines: list[str], delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of every line that is not empty."""
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield reader.line_num, cells
    except csv.Error as problem:
        raise ValueError(f"line {reader.line_num}: not CSV: {problem}") from None


def _columns(header: list[str], number: int, units: Units) -> list[_Column]:
    """Parse the header in line ``number``."""
    columns: list[_Column] = []
    for place, cell in enumerate(header, 1):
        where = f"line {number}, column {place}"
        new = _column(cell, where, units)
        if any(new.name == column.name for column in columns):
            raise ValueError(f"{where}: a second column {new.name}; give each once")
        columns.append(new)
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
    """Parse one cell of the header, such as "x1 [mm]"."""
    match = _HEADER.fullmatch(cell)
    name = match[1].lower() if match else ""
    if name not in _COLUMN_NAMES:
        known = ", ".join(_COLUMN_NAMES)
        raise ValueError(f"{where}: unknown column {cell.strip()[:40]!r}; known: {known}, as in x1 [mm]")
    unit = match[2] or ""
    if unit in _DIMENSIONLESS:
        return _Column(name, 1.0, None if name == "contact" else False)
    sizes = {"time": _SECONDS, "contact": {}}.get(name, _MILLIMETRES)
    if unit not in sizes:
        known = ", ".join([*dict.fromkeys(sizes), "-"])
        raise ValueError(f"{where} ({name}): unknown unit {unit[:20]!r}; known: {known}")
    quantity = "time" if name == "time" else "displacement"
    return _Column(name, units.model(quantity, sizes[unit]), True)


def _append(data: list[list[float]], cells: list[str], columns: list[_Column], number: int, delimiter: str) -> None:
    """Append a sample, after a check of its numbers; times must increase."""
    if len(cells) != len(columns):
        advice = "; decimal commas need semicolons between columns" if delimiter == "," else ""
        raise ValueError(f"line {number}: {len(cells)} columns, the header has {len(columns)}{advice}")
    row = []
    for place, (cell, column) in enumerate(zip(cells, columns, strict=True), 1):
        value = _number(cell, delimiter) * column.factor
        previous = data[-1][place - 1] if data else -math.inf
        fault = _fault(value, column.name, previous)
        if fault:
            raise ValueError(f"line {number}, column {place} ({column.name}): {cell.strip()[:40]!r} {fault}")
        row.append(value)
    data.append(row)


def _fault(value: float, name: str, previous: float) -> str:
    """Say what is wrong with a number in units of the model; empty if nothing is."""
    if math.isnan(value):
        return "is no finite number"
    if abs(value) > LARGEST:
        return f"is {value:.3g} in units of the model; is the unit right?"
    if name == "contact" and value not in (0.0, 1.0):
        return "is neither 0 nor 1; set a threshold to the sensor's signal"
    if name == "time" and value <= previous:
        return "does not come after the time before it; sort by time"
    return ""


def _number(cell: str, delimiter: str) -> float:
    """Return the number in a cell; nan if there is none, or none that is finite."""
    text = cell.strip()
    if delimiter != "," and text.count(",") == 1 and "." not in text:
        text = text.replace(",", ".")
    try:
        value = math.nan if "_" in text else float(text)  # Python alone reads 1_000 as a number
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
