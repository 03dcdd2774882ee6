"""Records as files: the acceleration of a base, or a force on a body, over time.

    time [s], a [g]
    0.00, 0.0012
    0.02, 0.0035

A file has a column of times and one of the load: the one that is named ``a``, ``acceleration``, ``f`` or ``force``, or
else the only other one. Units stand as in a measurement (:mod:`..measurement.measurement_file`); without any the
numbers are those of the model, which beside a system in physical units is to be said by ``[-]``. A strong-motion file
of PEER (.AT2) says how many samples there are and how far apart; its accelerations are in g.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from vibroscope.engine.load import SIZE_RANGE, Load, quantity_of
from vibroscope.engine.measurement.measurement_columns import (
    ACCELERATIONS,
    NO_HEADER,
    name_and_unit,
    names_time,
    unit_factor,
    without_header,
    without_units,
)
from vibroscope.engine.measurement.measurement_table import MEASUREMENT_SIZE_LIMIT, lines_of, number_in, table_of
from vibroscope.engine.system_file import read_file
from vibroscope.engine.units import Units
from vibroscope.engine.wording import counted

_NAMES = {"acceleration": ("a", "acc", "acceleration", *ACCELERATIONS), "force": ("f", "force")}
_AS = {"time": "[s] or [ms]", "acceleration": "[m/s2] or [g]", "force": "[N] or [kN]"}
_PEER = re.compile(r"NPTS\s*=\s*(\d+)\s*,\s*DT\s*=\s*([\d.eE+-]+)", re.IGNORECASE)


def read_record(path: str | Path, units: Units | None = None, on: str = "base", physical: bool = False) -> Load:
    """Read a load from a file.

    Parameters
    ----------
    path : str or Path
    units : Units, optional
        What the numbers of the model are counted in, for columns with a unit; by default the paper's.
    on : {"base", "force1", "force2"}
        What the load is.
    physical : bool
        Whether the system is in physical units: then a file in numbers of the model has to say so, by [-] in its
        header.

    Returns
    -------
    Load

    Raises
    ------
    ValueError
        If the file cannot be read, or is no record: one line that names the file, the line and the fault.
    """
    return read_file(path, MEASUREMENT_SIZE_LIMIT, lambda content: parse_record(content, units, on, physical))


def parse_record(content: bytes, units: Units | None = None, on: str = "base", physical: bool = False) -> Load:
    r"""Parse the bytes of a record; raises as :func:`read_record`, without the name of the file.

    Examples
    --------
    >>> from vibroscope.engine import Units, parse_record
    >>> text = b"time [ms], a [m/s2]\n0, 0\n10, 5\n20, 0\n"
    >>> load = parse_record(text, Units(omega1=100.0, base_amplitude=1.0))
    >>> round(load.end, 12), round(load.peak, 12)  # 5 m/s² over ω₁² times 1 mm
    (2.0, 0.5)
    """
    units, lines = replace(units or Units(), system="mm-t-s"), lines_of(content, MEASUREMENT_SIZE_LIMIT)
    peer = next((found for line in lines[:8] if (found := _PEER.search(line))), None)
    if peer:
        return _peer(lines, peer, units, on)
    table, loaded = table_of(lines), quantity_of(on)
    example = f"time {_AS['time'].split()[0]}, {_NAMES[loaded][0]} {_AS[loaded].split()[0]}"
    if NO_HEADER in table.where:  # what its numbers count is not known
        raise ValueError(without_header(table.where, example))
    time, value = _places(table.header, table.where, loaded)
    if physical and not any(name_and_unit(table.header[place])[1] for place in (time, value)):
        raise ValueError(without_units(table.where, example))
    factors = []
    for place, quantity in (time, "time"), (value, loaded):
        size = unit_factor(name_and_unit(table.header[place])[1], quantity)
        if size is None:
            cell = table.header[place].strip()
            raise ValueError(
                f"{table.where}, column {place + 1}: {cell!r} has no unit of {quantity}; give {_AS[quantity]}"
            )
        factors.append(size / units.factor(quantity) if size else 0.0)
    if (factors[0] == 0.0) != (factors[1] == 0.0):
        raise ValueError(f"{table.where}: mixes columns with and without a unit; give both, as [s] and [g], or neither")
    lines_read, rows = [], []
    for number, cells in table.rows:
        lines_read.append(number)
        rows.append([number_in(cells[at], table.delimiter) if at < len(cells) else math.nan for at in (time, value)])
    if len(rows) < 2:
        raise ValueError(f"line {len(lines)}: the file ends after {counted(len(rows), 'sample')}; give at least 2")
    columns = np.array(rows).T * [[size or 1.0] for size in factors]
    wrong = {
        "has no time and value; delete it": np.isnan(columns).any(axis=0),
        "goes back in time; sort the lines": np.diff(columns[0], prepend=-math.inf) < 0.0,
        "is out of range; look at its digits": np.abs(columns[1]) > SIZE_RANGE[1],
    }
    for words, bad in wrong.items():
        if bad.any():
            at = lines_read[int(np.argmax(bad))]
            raise ValueError(f"line {at}: {lines[at - 1].strip()[:40]!r} {words}")
    words = "record" if factors[0] else "record, in a file without units,"
    return Load.record(columns[0] - min(columns[0, 0], 0.0), columns[1], on, words)


def _places(header: list[str], where: str, quantity: str) -> tuple[int, int]:
    """The columns of the time and of the load."""
    names = [name_and_unit(cell)[0].strip().lower() for cell in header]
    times = [i for i, cell in enumerate(header) if names_time(cell)] or ([0] if len(header) == 2 else [])
    others = [i for i in range(len(header)) if i not in times]
    named = [i for i in others if names[i] in _NAMES[quantity]] or others
    if len(times) != 1 or len(named) != 1:
        listed = ", ".join(map(repr, names[:20]))
        raise ValueError(f"{where}: columns {listed}; give one named time and one named {quantity}")
    return times[0], named[0]


def _peer(lines: list[str], head: re.Match, units: Units, on: str) -> Load:
    """The load of a file of PEER: numbers in g, some in a line, after the line that says how many there are."""
    if on != "base":
        raise ValueError("a file with NPTS and DT is an acceleration of the ground: give it as that of the base")
    at = next(i for i, line in enumerate(lines) if head[0] in line)
    values = " ".join(lines[at + 1 :]).split()
    try:
        numbers, step = np.array(values, dtype=float), float(head[2])
    except ValueError:
        raise ValueError(f"line {at + 2}: not only numbers follow NPTS and DT; delete what stands below them") from None
    if len(numbers) != int(head[1]):
        raise ValueError(f"line {at + 1}: NPTS is {head[1]}, and {len(numbers)} numbers follow: the file is incomplete")
    time = np.arange(len(numbers)) * step / units.factor("time")
    return Load.record(time, numbers * (unit_factor("g", "acceleration") / units.factor("acceleration")), on)
