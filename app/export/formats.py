"""Formats of the files to take away: parameters as TOML, tables as CSV, data as JSON. No panel import."""

import csv
import io
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from itertools import repeat
from platform import python_version
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.physical_fields import CONTACT_OF_SYSTEM, values_of_system
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import print_value
from vibroscope.engine import Units, system_of_tables, toml_tables


class Figure(NamedTuple):
    """A figure of a tab that can be taken away.

    Attributes
    ----------
    name, title, caption : str
        Name of its file, title in the menu, caption in a report.
    drawn, tabled : bool
        Whether there is a picture of it, and whether there is a table of its data.
    """

    name: str
    title: str
    caption: str
    drawn: bool = True
    tabled: bool = True


class Series(NamedTuple):
    """Rows of a table that belong together.

    Attributes
    ----------
    label : str
        Its name in a file and in a legend.
    columns : mapping of str to ndarray
        All of one length.
    """

    label: str
    columns: Mapping[str, np.ndarray]


_OF_SYSTEM = ("system", "excitation", "physical")  # tables of a system file beside [units]
_UNITS = {"omega1": "omega1", "m1": "m1", "amplitude": "base_amplitude"}  # name of the parameter: name in `Units`


def as_toml(setting: Setting) -> str:
    """The setting as TOML, for `texts_from_toml`."""
    lines = [f"# Vibroscope {version('vibroscope')}: the setting of the page", "[setting]"]
    for name, text in setting.texts().items():
        value = getattr(setting, name)
        if name in _UNITS:
            continue
        lines.append(f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {text}")
    lines += ["", *units_table(Units(setting.omega1, setting.m1, setting.amplitude))]
    return "\n".join(lines) + "\n"


def units_table(units: Units) -> list[str]:
    """Lines of the table [units] of a system file, as `engine.read_system` reads it."""
    comments = {"omega1": "1/s", "m1": "kg", "base_amplitude": "mm"}
    return ["[units]", *(f"{name} = {getattr(units, name)!r}  # {unit}" for name, unit in comments.items())]


class Loaded(NamedTuple):
    """The texts and the view that a file sets.

    Attributes
    ----------
    texts : mapping of str to str
        For `app.explorer.reading.read_setting`.
    assumed : tuple of str
        In a sentence each, what it leaves out and what is taken for it: `engine.SystemFile.assumed`.
    """

    texts: Mapping[str, str]
    assumed: tuple[str, ...] = ()


def loaded_from_toml(text: str) -> Loaded:
    """Read a TOML file.

    The file has the tables [setting] and [units] as `as_toml` writes them, or it is a system file as
    `engine.parse_system` reads it, or both: then what [setting] says counts.

    Raises
    ------
    ValueError
        If it is neither, or no TOML, or has an unknown name: no part of a file is ignored.
    """
    content = text.encode()
    tables = toml_tables(content)
    rest = {name: table for name, table in tables.items() if name != "setting"}
    if "setting" in tables and (unknown := rest.keys() - {*_OF_SYSTEM, "units"}):
        known = ", ".join(f"[{name}]" for name in ("setting", *_OF_SYSTEM, "units"))
        raise ValueError(f"unknown table [{min(unknown)[:40]}]: known are {known}")
    values, assumed = {}, ()
    if rest.keys() & set(_OF_SYSTEM) or ("units" in rest and "setting" not in tables):
        file = system_of_tables(rest)
        values, assumed = values_of_system(file.system, file.units, file.eta, file.forms), file.assumed
        values |= {"units": "si"} if "physical" in rest else {}
        values |= CONTACT_OF_SYSTEM if "setting" not in tables and "physical" in rest else {}
    elif "units" in rest:
        values = _read_table(rest, "units", {unit: name for name, unit in _UNITS.items()})
    if "setting" in tables or not values:
        values |= _read_table(tables, "setting", {name: name for name in FIELDS if name not in _UNITS})
    return Loaded({name: print_value(value) for name, value in values.items()}, assumed)


def _read_table(tables: Mapping, table: str, names: Mapping[str, str]) -> dict:
    """The values of one table by the name of the parameter; ``names`` gives it for each name in the file."""
    given = tables.get(table)
    if not isinstance(given, dict):
        raise ValueError(f"the file has no table [{table}]: save one with the page's menu Take away")
    if unknown := [name for name in given if name not in names]:
        raise ValueError(f"unknown name {unknown[0][:40]!r} in [{table}]: known are {', '.join(names)}")
    return {names[name]: value for name, value in given.items()}


def as_csv(table: Iterable[Series]) -> str:
    """One row per point, with the label of its series; cells that do not apply or hold no number are empty."""
    table = list(table)
    names = list(dict.fromkeys(name for series in table for name in series.columns))
    buffer = io.StringIO()
    writer = csv.writer(buffer)
    writer.writerow(["series", *names])
    for label, columns in table:
        length = len(next(iter(columns.values())))
        cells = (_texts(columns[name]) if name in columns else repeat("", length) for name in names)
        writer.writerows(zip(repeat(label, length), *cells, strict=True))
    return buffer.getvalue()


def _texts(column: np.ndarray) -> np.ndarray:
    """Each value with all its digits."""
    column = np.asarray(column)
    texts = column.astype(str)
    return np.where(np.isfinite(column), texts, "") if column.dtype.kind == "f" else texts


def program() -> str:
    """Name and version of this program and of the libraries that it computes with."""
    used = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba"))
    return f"vibroscope {version('vibroscope')} (Python {python_version()}, {used})"
