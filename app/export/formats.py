"""The formats of what a user takes away: parameters as TOML, tables as CSV, data as JSON. No panel import."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from itertools import repeat
from platform import python_version
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.state import Setting, print_number, texts_of
from vibroscope.engine import Units, parse_system, toml_tables


class Figure(NamedTuple):
    """Something that a tab shows and that can be taken away: by this name, title (in the menu), caption (in a report).

    What is not ``drawn`` is a table alone, what is not ``tabled`` a picture alone.
    """

    name: str
    title: str
    caption: str
    drawn: bool = True
    tabled: bool = True


class Series(NamedTuple):
    """Rows of a table that belong together: whose they are, and their columns, all of one length."""

    label: str
    columns: Mapping[str, np.ndarray]


_LONGEST_FILE = 65_536  # characters
_UNITS = {"omega1": "omega1", "m1": "m1", "amplitude": "base_amplitude"}  # ours: the engine's name


def as_toml(setting: Setting) -> str:
    """Every number and switch; reads back with `setting_of_toml`."""
    texts = texts_of(setting)
    lines = [f"# Vibroscope {version('vibroscope')}: the setting of the page", "[setting]"]
    for name, text in texts.items():
        value = getattr(setting, name)
        if name in _UNITS:
            continue
        lines.append(f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {text}")
    lines += ["", *units_table(setting)]
    return "\n".join(lines) + "\n"


def units_table(setting: Setting) -> list[str]:
    """The units as `engine.read_system` takes them."""
    units = Units(setting.omega1, setting.m1, setting.amplitude)
    comments = {"omega1": "1/s", "m1": "kg", "base_amplitude": "mm"}
    return ["[units]", *(f"{name} = {getattr(units, name)!r}  # {unit}" for name, unit in comments.items())]


def joined(parts: object) -> str:
    """The text of a file that a browser sends in parts by number; raises ValueError where it is too long."""
    texts = parts.values() if isinstance(parts, dict) else []
    text = "".join(part for part in texts if isinstance(part, str))
    if len(text) > _LONGEST_FILE:
        raise ValueError(f"it is longer than {_LONGEST_FILE} characters")
    return text


def setting_of_toml(text: str) -> dict[str, str]:
    """The texts of a TOML file, as `app.explorer.state.read` takes them.

    The file is one of ours, with the tables [setting] and [units], or a system file as `engine.parse_system` reads it.

    Raises
    ------
    ValueError
        If it is neither, or no TOML, or holds a name that is not known: nothing of a file is passed over in silence.
    """
    content = text.encode()
    tables = toml_tables(content)
    if "setting" not in tables and {"system", "units"} & tables.keys():
        file = parse_system(content)
        values = file.system.as_dict() | {name: getattr(file.units, theirs) for name, theirs in _UNITS.items()}
    else:
        names = [name for name in Setting._fields if name not in _UNITS]
        values = _known(tables, "setting", {name: name for name in names})
        values |= (
            _known(tables, "units", {theirs: name for name, theirs in _UNITS.items()}) if "units" in tables else {}
        )
    return {name: value if isinstance(value, str) else print_number(value) for name, value in values.items()}


def _known(tables: Mapping, table: str, names: Mapping[str, str]) -> dict:
    """The values of one table, under our names."""
    given = tables.get(table)
    if not isinstance(given, dict):
        raise ValueError(f"the file has no table [{table}]: save one with the page's menu Take away")
    if unknown := [name for name in given if name not in names]:
        raise ValueError(f"unknown name {unknown[0][:40]!r} in [{table}]: known are {', '.join(names)}")
    return {names[name]: value for name, value in given.items()}


def as_csv(table: Iterable[Series]) -> str:
    """A row a point; ``series`` says whose it is, and cells that do not apply or hold no number are empty."""
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
    """Each value with as many digits as it has."""
    column = np.asarray(column)
    texts = column.astype(str)
    return np.where(np.isfinite(column), texts, "") if column.dtype.kind == "f" else texts


def as_json(told: Mapping[str, object]) -> str:
    """Numbers, words, arrays and mappings of those; what is not a number becomes null."""
    return json.dumps(_plain(told), ensure_ascii=False, allow_nan=False)


def _plain(value: object) -> object:
    """What JSON knows in place of arrays and of what is not a number."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        if value.dtype.kind != "f":
            return value.tolist()
        digits = value.astype(str).astype(float) if value.dtype == np.float32 else value
        return np.where(np.isfinite(digits), digits.astype(object), None).tolist()
    if isinstance(value, np.generic):
        return _plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def program() -> str:
    """What made these numbers, and what it computes with."""
    used = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba"))
    return f"vibroscope {version('vibroscope')} (Python {python_version()}, {used})"
