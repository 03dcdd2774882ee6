"""The columns of a measurement file: which is what, and in which unit."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest

from vibroscope.engine.arguments import shown
from vibroscope.engine.units import Units

ACCELERATIONS = ("a1", "a2")  # of fixed axes, in place of displacements
PAIRS = {"absolute": ("x1", "x2"), "relative": ("xi1", "xi2")}
SERIES = "series"  # names the curve of a row in the files of the page, which count time in excitation periods
_NAMES = {name: name for name in ("time", "x1", "x2", "xi1", "xi2", *ACCELERATIONS, "contact", "force", SERIES)}
_NAMES["t"] = "time"
_MORE_NAMES = ("disp", "displacement", "a", "acc", "acceleration", "f")  # others behind which a unit may stand
_WANTED = "time, x1, x2 (absolute) or xi1, xi2 (relative to the base) or a1, a2 (accelerations), contact, force"

_SECONDS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "μs": 1e-6, "us": 1e-6, "min": 60.0, "sec": 1.0, "msec": 1e-3}
_MILLIMETRES = {"m": 1e3, "cm": 10.0, "mm": 1.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3, "in": 25.4}
_NEWTONS = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605}
_ACCELERATION = {"m/s²": 1e3, "m/s2": 1e3, "m/s^2": 1e3, "mm/s²": 1.0, "mm/s2": 1.0, "mm/s^2": 1.0, "g": 9806.65}
_UNITS = {"time": _SECONDS, "contact": {}, SERIES: {}, "force": _NEWTONS} | dict.fromkeys(ACCELERATIONS, _ACCELERATION)
NO_HEADER = "(no header)"  # behind the line where the numbers begin
_DIMENSIONLESS = ("", "-", "1")
_EXAMPLE = "time [s], x1 [mm]"
MOST_LISTED = 20  # columns that an error names
_HEADER = re.compile(r"\s*(.*?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*([^()]*?)\s*\)|/\s*([^\s/]+))?\s*")


class UnknownColumns(ValueError):
    """A header does not say which column is the time and which a displacement.

    Attributes
    ----------
    header : tuple of str
        The cells of the header, or of the first row of numbers where there is none.
    """

    def __init__(self, text: str, header: tuple[str, ...]) -> None:
        super().__init__(text)
        self.header = header


@dataclass(frozen=True)
class Column:
    """A column that is read: its place in a row, its name, and the factor to units of the model."""

    place: int
    name: str
    factor: float
    physical: bool | None  # None where a unit changes nothing: contact, force, series


def name_and_unit(cell: str) -> tuple[str, str]:
    """Split a cell of a header such as "x1 [mm]", "x1 (mm)", "x1/mm" or "x1_mm" into name and unit, perhaps empty."""
    before, _, behind = cell.strip().rpartition("_")
    if before.lower() in (*_NAMES, *_MORE_NAMES) and _is_unit(behind):
        return before, behind
    name, *units = _HEADER.fullmatch(cell).groups()
    return name, next((unit for unit in units if unit), "")


def names_time(cell: str) -> bool:
    """Whether a cell of a header names the time."""
    return _NAMES.get(name_and_unit(cell)[0].lower()) == "time"


def is_units_row(cells: list[str]) -> bool:
    """Whether all cells are names of units, as those below a header may be: known ones, or any in brackets."""
    return len(cells) > 1 and all(_unit(cell) is not None for cell in cells)


def with_units(header: list[str], units: list[str]) -> list[str]:
    """The header with the units of another row, which may hold fewer cells; a name that has its unit keeps it."""
    found = [_unit(cell) or cell.strip() for cell in units[: len(header)]]
    pairs = zip_longest(map(str.strip, header), found, fillvalue="")
    return [f"{name} [{unit}]" if unit and not name_and_unit(name)[1] else name for name, unit in pairs]


def _unit(cell: str) -> str | None:
    """The unit that a cell holds, in brackets or not; None if it holds something else."""
    name, unit = name_and_unit(cell)
    text = cell.strip()
    return text if text in _DIMENSIONLESS or _is_unit(text) else unit if unit and not name else None


def _is_unit(text: str) -> bool:
    return any(text in sizes for sizes in (_SECONDS, _MILLIMETRES, _NEWTONS, _ACCELERATION))


def unit_factor(unit: str, quantity: str) -> float | None:
    """One of a unit of "time", "acceleration" or "force" in s, mm/s² or N; 0 without dimension, None if unknown."""
    sizes = {"time": _SECONDS, "acceleration": _ACCELERATION, "force": _NEWTONS}[quantity]
    return 0.0 if unit in _DIMENSIONLESS else sizes.get(unit)


def without_header(where: str, example: str) -> str:
    """The words of a refusal of a file whose first line is one of numbers."""
    return f"{where}: nothing says what its numbers are; begin the file with a line, as {example}"


def without_units(where: str, example: str) -> str:
    """The words of a refusal of a file beside a system in physical units, in which no column says what it counts."""
    return (
        f"{where}: no column has a unit, and the system is in physical units; give each its unit, as {example}, or [-] "
        "for a number of the model"
    )


def find_columns(
    header: list[str], where: str, units: Units, chosen: Mapping[str, str] | None, physical: bool = False
) -> list[Column]:
    """Find out which column is what.

    Parameters
    ----------
    header : list of str
        The cells of the header; numbers where the file has none.
    where : str
        The header's place, such as "line 1".
    units : Units
        With lengths in mm.
    chosen : mapping of str to str, optional
        For each name the column, by its number from 1 or its text in the header, perhaps with a unit in brackets.
    physical : bool
        Whether the system is in physical units: then columns without a unit have to say so, as [-].

    Raises
    ------
    UnknownColumns
        If time or displacement is missing.
    ValueError
        If a column is given twice, a unit is unknown, columns with and without a unit are mixed, or none says its unit.
    """
    unnamed = without_header(where, _EXAMPLE) if NO_HEADER in where else ""
    if unnamed and not chosen:
        raise UnknownColumns(f"{unnamed}, or say which column is which", tuple(header))
    places = _chosen_places(header, chosen) if chosen else _known_places(header, where)
    if unnamed and any(not unit for name, (_, unit) in places.items() if name not in ("contact", "force")):
        raise ValueError(f"{unnamed}, or give each column its unit, as time=1 [s], or [-] without dimension")
    names = set(places)
    displaced = [pair for pair in PAIRS.values() if pair[0] in names]
    wanted = displaced or [pair for pair in (ACCELERATIONS,) if pair[0] in names]
    others = {name for pair in PAIRS.values() for name in pair} & names
    if "time" not in names or len(wanted) != 1 or not others <= set(wanted[0]):
        raise UnknownColumns(
            f"{where}: columns {_listed(header)}; give time and either x1, x2 (absolute) or xi1, xi2 (relative to the "
            "base), of one body x1 or xi1 alone, as in x1 [mm], or accelerations a1, a2, or say which column is which",
            tuple(header),
        )
    unused = set(ACCELERATIONS) if displaced else set()  # beside displacements they are not needed
    columns = [_column(name, place, unit, where, units) for name, (place, unit) in places.items() if name not in unused]
    if len({column.physical for column in columns} - {None}) > 1:
        raise ValueError(f"{where}: mixes columns with and without a unit; give all as [s], [mm] or all as [-]")
    counted = [places[column.name][1] for column in columns if column.physical is not None]
    if physical and SERIES not in names and not any(counted):
        raise ValueError(without_units(where, _EXAMPLE))
    return columns


def _listed(header: list[str]) -> str:
    """The cells of a header, of which a long one is cut."""
    more = ["…"] if len(header) > MOST_LISTED else []
    return ", ".join([*(shown(cell.strip()) for cell in header[:MOST_LISTED]), *more])


def _known_places(header: list[str], where: str) -> dict[str, tuple[int, str]]:
    """Place and unit of each column whose name is known."""
    places: dict[str, tuple[int, str]] = {}
    for place, cell in enumerate(header):
        text, unit = name_and_unit(cell)
        name = _NAMES.get(text.lower())
        if name in places:
            raise ValueError(f"{where}, column {place + 1}: a second column {name}; give each once")
        if name:
            places[name] = place, unit
    return places


def _chosen_places(header: list[str], chosen: Mapping[str, str]) -> dict[str, tuple[int, str]]:
    """Place and unit of each column that is named by the user; a unit in the header counts where none is given."""
    texts = [cell.strip() for cell in header]
    places = {}
    for name, text in chosen.items():
        if _NAMES.get(name) != name or name == SERIES:
            raise ValueError(f"unknown column name {shown(name)}; known: {_WANTED}")
        text, own = text.strip(), ""
        place = _place(text, texts)
        if place is None:
            text, own = name_and_unit(text)
            place = _place(text, texts)
        if place is None:
            known = f"1 to {len(texts)}, or one of {_listed(texts)}"
            raise ValueError(f"no column {shown(text)} for {name}: give its number, {known}")
        places[name] = place, own or name_and_unit(texts[place])[1]
    return places


def _place(text: str, header: list[str]) -> int | None:
    """The place of a column that is given by its number from 1, its cell in the header, or the name in it."""
    if text.isdecimal() and 1 <= int(text) <= len(header):
        return int(text) - 1
    names = [name_and_unit(cell)[0] for cell in header]
    return next((cells.index(text) for cells in (header, names) if text in cells), None)


def _column(name: str, place: int, unit: str, where: str, units: Units) -> Column:
    if name in ("contact", "force", SERIES) and unit in _DIMENSIONLESS:
        return Column(place, name, 1.0, None)
    if unit in _DIMENSIONLESS:
        return Column(place, name, 1.0, False)
    sizes = _UNITS.get(name, _MILLIMETRES)
    if unit not in sizes:
        known = ", ".join([*dict.fromkeys(sizes), "-"])
        raise ValueError(f"{where}, column {place + 1} ({name}): unknown unit {shown(unit)}; known: {known}")
    if name == "force":
        return Column(place, name, sizes[unit], None)
    quantity = "time" if name == "time" else "acceleration" if name in ACCELERATIONS else "displacement"
    return Column(place, name, units.model(quantity, sizes[unit]), True)
