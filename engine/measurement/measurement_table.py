"""The table in the lines of a measurement file: its header, its rows, and what stands before and after them.

A file may be packed by gzip, and is text in any of the usual encodings.

Programs write titles above the header, units below it and words below the data. The first row of numbers shows what
separates the columns. The header is the last row of words above it that names the time, or else the last one. Titles
above the header are left out, and so are words below the data. LabVIEW names the time X_Value, and leaves its column
empty where the instants follow from the first one and their interval. A CalculiX file has a small table for each
instant, which becomes a row with a column for each component and node.
"""

import codecs
import csv
import gzip
import io
import math
import re
import zlib
from collections.abc import Iterator
from typing import NamedTuple

from vibroscope.engine.measurement.measurement_columns import (
    NO_HEADER,
    is_units_row,
    name_and_unit,
    names_time,
    with_units,
)

_BEGINNING = 64  # bytes by which UTF-16 is known that does not say so
MEASUREMENT_SIZE_LIMIT = 16 * 2**20  # bytes, unpacked; some 400,000 samples
MOST_TITLE_LINES = 200  # among which the first row of numbers is looked for
_SEPARATOR = re.compile(r"sep=([;,\t |:])\s*", re.IGNORECASE)  # first line that spreadsheets write and read
_DELIMITERS = (";", "\t", ",", " ")  # tried in this order: between the first two, a comma may be that of a decimal
_BETWEEN_WORDS = re.compile(r"\s*[,;\t]\s*|\s+(?![\s\[(])")  # of a header above blanks: "x1 [mm]" is one
_CALCULIX = re.compile(r"\s*(\w[\w ]*) \(([\w,]+)\) for set \S+ and time\s+(\S+)\s*")
_COMMENTS = ("#", "%")
_LABVIEW_TIME, _LABVIEW_UNITS, _LABVIEW_INSTANTS = "X_Value", "Y_Unit_Label", ("X0", "Delta_X")


def lines_of(content: bytes, largest: int) -> list[str]:
    """Split the bytes of a file into lines.

    Text is UTF-16 if it says so by its first two bytes or every other byte of its beginning is 0, else UTF-8, else
    Latin-1, as older instruments write it.

    Parameters
    ----------
    content : bytes
    largest : int
        Bytes that the file may have, also unpacked.

    Raises
    ------
    ValueError
        If the file is larger, damaged, or no text.
    """
    if content.startswith(b"\x1f\x8b"):
        content = _unpacked(content, largest)
    if len(content) > largest:
        raise ValueError(f"larger than {largest // 2**20} MiB: give fewer periods, or fewer samples of each")
    return _text(content).replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _unpacked(content: bytes, largest: int) -> bytes:
    """What a gzip file holds, of which at most a byte more than allowed is unpacked."""
    try:
        return gzip.GzipFile(fileobj=io.BytesIO(content)).read(largest + 1)
    except (OSError, EOFError, zlib.error) as problem:
        raise ValueError(f"line 1: the gzip file is damaged ({problem}); pack it again, or give it unpacked") from None


def _text(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    beginning = content[: 2 * (min(len(content), _BEGINNING) // 2)]
    for zeros, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if beginning and not any(beginning[zeros::2]) and all(beginning[1 - zeros :: 2]):
            return content.decode(encoding, errors="replace")
    if (zero := content.find(b"\0")) >= 0:
        line = content[:zero].count(b"\n") + 1
        raise ValueError(f"line {line}: a byte 0, so that this is no text; save the file as CSV")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


class Table(NamedTuple):
    """A file in cells.

    Attributes
    ----------
    header : list of str
        The names of the columns, or the first row of numbers where there are none.
    where : str
        The place of the header, such as "line 1".
    rows : iterator of (int, list of str)
        The rows of data, with the numbers of their lines.
    delimiter : str
        What separates the columns.
    left_out : tuple of str
        The lines before and after the table.
    """

    header: list[str]
    where: str
    rows: Iterator[tuple[int, list[str]]]
    delimiter: str
    left_out: tuple[str, ...] = ()


def table_of(lines: list[str]) -> Table:
    """Find the table in the lines of a file.

    Raises
    ------
    ValueError
        If there is no header, or, once the rows are read, one of them is not CSV.
    """
    if any(map(_CALCULIX.fullmatch, lines[:MOST_TITLE_LINES])):
        return _calculix_table(lines)
    # comments become empty lines, so that the others keep their numbers
    texts = ["" if line.lstrip().startswith(_COMMENTS) else line.strip(" ") for line in lines]
    start = next((i for i, text in enumerate(texts) if text), None)
    named = _SEPARATOR.fullmatch(texts[start]) if start is not None else None
    if named:
        start = next((i for i in range(start + 1, len(texts)) if texts[i]), None)
    if start is None:
        raise ValueError(
            "line 1: the file has no header; begin it with names and units of columns, as time [s], x1 [mm]"
        )
    data, delimiter = _first_numbers(texts, start, named[1] if named else "")
    at = _header_line(texts, start, data, delimiter)
    titles = {cells[0]: cells[1:] for text in texts[start:data] if (cells := cells_of(text, delimiter))}
    if at is None:
        at, begin = data, data
        commented = _commented_header(lines[:data], texts[data], delimiter)
        header = commented or cells_of(texts[data], delimiter)
        where = f"line {data + 1}" if commented else f"line {data + 1} {NO_HEADER}"
    else:
        where = f"line {at + 1}"
        header, begin = _with_units(texts, at, delimiter, titles)
    if not any(map(str.strip, header)):
        raise ValueError(f"{where}: the header names no column; begin the file with: time [s], x1 [mm], x2 [mm]")
    end = next((i for i in range(len(texts), begin, -1) if _has_number(texts[i - 1], delimiter)), len(texts))
    left_out = (*_named_lines(texts, start, at), *_named_lines(texts, end, len(texts)))
    rows = _with_instants(_rows(texts[begin:end], begin, delimiter), titles, delimiter)
    return Table(header, where, rows, delimiter, left_out)


def number_in(cell: str, delimiter: str) -> float:
    """Return the number in a cell; nan if there is none, or none that is finite."""
    text = cell.strip()
    if delimiter != "," and text.count(",") == 1 and "." not in text:
        text = text.replace(",", ".")
    try:
        value = math.nan if "_" in text else float(text)  # Python alone reads 1_000 as a number
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def is_number(cell: str, delimiter: str) -> bool:
    """Whether a cell holds a finite number."""
    return not math.isnan(number_in(cell, delimiter))


def cells_of(text: str, delimiter: str) -> list[str]:
    """The cells of one line, without empty last ones; in a line of words between blanks, a unit belongs to its name."""
    if delimiter == " " and not _is_row_of_numbers(text.split(), delimiter):
        return _BETWEEN_WORDS.split(text)
    try:
        return _without_empty_ends(next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), []))
    except csv.Error:
        return [text]


def _without_empty_ends(cells: list[str]) -> list[str]:
    while cells and not cells[-1].strip():
        cells.pop()
    return cells


def _has_number(text: str, delimiter: str) -> bool:
    return any(is_number(cell, delimiter) for cell in cells_of(text, delimiter))


def _is_row_of_numbers(cells: list[str], delimiter: str) -> bool:
    """Whether each of two cells or more is a number or empty."""
    filled = [cell for cell in cells if cell.strip()]
    return len(filled) > 1 and all(is_number(cell, delimiter) for cell in filled)


def _first_numbers(texts: list[str], start: int, named: str) -> tuple[int, str]:
    """Where the first row of numbers is and what separates them; where there is none, the first line's separator."""
    for i in range(start, min(start + MOST_TITLE_LINES, len(texts))):
        for delimiter in named or _DELIMITERS:
            cells = texts[i].split() if delimiter == " " else cells_of(texts[i], delimiter)
            if _is_row_of_numbers(cells, delimiter):
                return i, delimiter
    return start, named or next((each for each in _DELIMITERS[:3] if each in texts[start]), ",")


def _header_line(texts: list[str], start: int, data: int, delimiter: str) -> int | None:
    """The line of the header, which names more than one column; None if the data begin without one."""
    if data == start:  # a row of numbers, or there is none in the file
        return None if is_number(texts[start].split(delimiter)[0], delimiter) else start
    words = [i for i in range(start, data) if texts[i] and not _has_number(texts[i], delimiter)]
    named = [i for i in words if any(map(_is_time, cells_of(texts[i], delimiter)))]
    others = [i for i in words if not is_units_row(cells_of(texts[i], delimiter))]
    found = (named or others or [start])[-1]
    cells = cells_of(texts[found], delimiter)
    return found if len(cells) > 1 and not is_number(cells[0], delimiter) else None


def _is_time(cell: str) -> bool:
    """Whether a cell of a header is the name of the time, also as LabVIEW writes it."""
    return cell == _LABVIEW_TIME or names_time(cell)


def _commented_header(lines: list[str], first: str, delimiter: str) -> list[str] | None:
    """The header in the last comment before the data that names the time and has as many columns as they."""
    for line in reversed(lines):
        header = cells_of(line.strip("".join((" ", *_COMMENTS))), delimiter)
        if len(header) == len(cells_of(first, delimiter)) and any(map(names_time, header)):
            return header
    return None


def _with_units(texts: list[str], at: int, delimiter: str, titles: dict[str, list[str]]) -> tuple[list[str], int]:
    """The header with the units of the row below it, or of a title, and the line at which the data begin."""
    header = cells_of(texts[at], delimiter)
    if header[:1] == [_LABVIEW_TIME]:
        return ["time [s]", *with_units(header[1:], titles.get(_LABVIEW_UNITS, []))], at + 1
    below = next((i for i in range(at + 1, len(texts)) if texts[i]), None)
    units = cells_of(texts[below], delimiter) if below is not None else []
    if not is_units_row(units) or len(units) > len(header) or any(name_and_unit(cell)[1] for cell in header):
        return header, at + 1
    return with_units(header, units), below + 1


def _with_instants(
    rows: Iterator[tuple[int, list[str]]], titles: dict[str, list[str]], delimiter: str
) -> Iterator[tuple[int, list[str]]]:
    """The rows, in which LabVIEW's instants are written where their cells are empty."""
    first, step = (titles.get(name) for name in _LABVIEW_INSTANTS)
    for count, (number, cells) in enumerate(rows):
        if first and step and not cells[0].strip():
            cells[0] = repr(number_in(first[0], delimiter) + count * number_in(step[0], delimiter))
        yield number, cells


def _named_lines(texts: list[str], begin: int, end: int) -> list[str]:
    """What stands in these lines: the first of them, and their numbers; nothing if all are empty."""
    filled = [i for i in range(begin, end) if texts[i]]
    if len(filled) > 1:
        return [f"{texts[filled[0]][:40]} … (lines {filled[0] + 1} to {filled[-1] + 1})"]
    return [f"{texts[i][:40]} (line {i + 1})" for i in filled]


def _rows(texts: list[str], begin: int, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the cells of every line that is not empty, without empty last cells."""
    reader = csv.reader(texts, delimiter=delimiter, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            if _without_empty_ends(cells):
                yield begin + reader.line_num, cells
    except csv.Error as problem:
        raise ValueError(f"line {begin + reader.line_num}: not CSV: {problem}") from None


def _calculix_table(lines: list[str]) -> Table:
    """A column "vx 3" for each component and node, "velocities vx 3" if it is none of displacements; a row per instant.

    Raises
    ------
    ValueError
        If a node has two values at one time, which is printed with too few digits then.
    """
    rows: dict[str, tuple[int, dict[str, str]]] = {}
    names, row = [], {}
    for number, line in enumerate(lines, 1):
        if block := _CALCULIX.fullmatch(line):
            quantity, components, time = block.groups()
            names = [name if quantity == "displacements" else f"{quantity} {name}" for name in components.split(",")]
            _, row = rows.setdefault(time, (number, {"time": time}))
        elif len(cells := line.split()) == len(names) + 1:
            values = {f"{name} {cells[0]}": cell for name, cell in zip(names, cells[1:], strict=True)}
            if any(row.get(name, cell) != cell for name, cell in values.items()):
                raise ValueError(f"line {number}: a second value of node {cells[0]} at the time {row['time']}")
            row |= values
    header = list(dict.fromkeys(name for _, row in rows.values() for name in row))
    found = ((number, [row.get(name, "") for name in header]) for number, row in rows.values())
    return Table(header, f"line {next(iter(rows.values()))[0]}", found, ",")
