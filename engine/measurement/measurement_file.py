"""Measurements as files of columns: displacements of the bodies over time, perhaps a contact sensor or a contact force.

    # any comment
    time [s], x1 [mm], x2 [mm], contact
    0.000, 1.812, 1.823, 1

The header names columns and units; a unit stands in brackets, after a slash or an underscore, or in the line below.
``x1`` and ``x2`` are absolute, as measured by a fixed sensor (paper, section 3); ``xi1`` and ``xi2`` are relative to
the base. Body 1 alone is enough. ``a1`` and ``a2`` are accelerations of fixed axes, in place of displacements. Units
are s (sec), ms, µs, min; m, cm, mm, µm, in; m/s², mm/s², g. Or all are without dimension (``[-]``, or no unit): time in
units of 1/ω₁, displacements in base amplitudes. ``contact`` is 1 while the sensor's circuit is closed, else 0; of a
``force`` the contact is where it exceeds a share of its largest value. Other columns are left out. Columns are
separated by commas, semicolons, tabs or spaces; with semicolons, tabs and spaces, numbers may have decimal commas. In a
file of the page, of several curves with the time in excitation periods, the measured curve is read, or else the first.

A file is either read completely or refused with an error that names line and column, since a measurement that is
misread silently looks like a discovery. Words before and after the table are left out, which is said.

Accelerations are integrated twice to displacements, without the drift that integration adds. The integral x̃ of an
acceleration differs from the displacement by what the velocity and the displacement at the start and a bias of the
sensor add, a polynomial c₀ + c₁t + c₂t². A motion in step with the excitation has no part that grows, so that the
polynomial is found by a least-squares fit to x̃ together with harmonics of η/p. It takes the mean of the displacement
with it, which an accelerometer does not show.

Outliers are samples that no body can have been at, such as a sensor's dropout or an overflow.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from vibroscope.engine.facts import ETA, stated
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.measurement_columns import (
    ACCELERATIONS,
    PAIRS,
    SERIES,
    Column,
    UnknownColumns,
    find_columns,
)
from vibroscope.engine.measurement.measurement_table import (
    MEASUREMENT_SIZE_LIMIT,
    Table,
    is_number,
    lines_of,
    number_in,
    table_of,
)
from vibroscope.engine.measurement.recurrence import HARMONIC_SAMPLES, LONGEST, coefficients, harmonics
from vibroscope.engine.measurement.tolerances import COMMON, CONTACT_FORCE, FAR_OUT, JUMP, OVERLAP, TOO_FAST, WRONG_UNIT
from vibroscope.engine.system_file import read_file
from vibroscope.engine.units import Units

FEWEST_SAMPLES = 16


def integrated(time: np.ndarray, acceleration: np.ndarray, eta: float) -> np.ndarray:
    """Displacements without their means, (k, n), from accelerations of fixed sensors, (k, n), in units of the model.

    Parameters
    ----------
    time : (n,) ndarray
        τ, increasing from 0.
    acceleration : (k, n) ndarray
    eta : float
        Excitation frequency, about.
    """
    moved = Measurement(time, _integral(time, _integral(time, acceleration)), None, "absolute")
    thin = moved.thinned(HARMONIC_SAMPLES)
    period = max(1, min(LONGEST, int(moved.span * eta / (2 * np.pi) / OVERLAP)))
    basis, _ = harmonics(thin, eta, period)
    growing = np.vander(thin.time / moved.span, 3, increasing=True)
    found = coefficients(np.hstack([growing, basis[:, 1:]]), thin.displacement.T)[:3]
    rest = moved.displacement - (np.vander(time / moved.span, 3, increasing=True) @ found).T
    return rest - rest.mean(axis=1, keepdims=True)


def _integral(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The integral from the first sample on, by the trapezoidal rule, (k, n)."""
    steps = np.diff(time) * (values[:, 1:] + values[:, :-1]) / 2
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(steps, axis=1)], axis=1)


def first_outlier(time: np.ndarray, values: np.ndarray) -> tuple[int, float] | None:
    """Find the first sample that lies too far out to belong to the motion.

    A body moves on and does not jump: a sample is an outlier if it lies FAR_OUT sizes of the motion from its middle and
    the body got there between two samples, or if the body moved to it and back with TOO_FAST times the speed that it
    has in all but few of the other intervals. An impact turns a velocity and moves no body between two samples.

    Parameters
    ----------
    time, values : (n,) ndarray

    Returns
    -------
    (int, float) or None
        Its number, and its distance from the middle in sizes of the motion.
    """
    low, middle, high = np.quantile(values, [(1 - COMMON) / 2, 0.5, (1 + COMMON) / 2])
    size = max(high - middle, middle - low)
    if size == 0.0:
        return None
    distance = np.abs(values - middle) / size
    slopes = np.diff(values) / np.diff(time)
    fast = np.abs(slopes) > TOO_FAST * np.quantile(np.abs(slopes), COMMON)
    spike = np.zeros(len(values), bool)
    spike[1:-1] = fast[:-1] & fast[1:] & (slopes[:-1] * slopes[1:] < 0)
    found = np.flatnonzero(_beyond_a_jump(values, distance > FAR_OUT, distance * size) | (spike & (distance > 1)))
    return (int(found[0]), float(distance[found[0]])) if len(found) else None


def _beyond_a_jump(values: np.ndarray, far: np.ndarray, excursion: np.ndarray) -> np.ndarray:
    """Which of the samples that lie far out, (n,) of bool, belong to a row of such that begins or ends with a jump."""
    found = np.zeros(len(values), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
    for start, end in edges.reshape(-1, 2):
        sides = [pair for pair in ((start - 1, start), (end, end - 1)) if 0 <= pair[0] < len(values)]
        found[start:end] = any(abs(values[out] - values[into]) > JUMP * excursion[into] for out, into in sides)
    return found


def read_measurement(
    path: str | Path,
    units: Units | None = None,
    columns: Mapping[str, str] | None = None,
    eta: float | None = None,
    physical: bool = False,
) -> Measurement:
    """Read a measurement from a CSV file.

    Parameters
    ----------
    path : str or Path
    units : Units, optional
        To convert physical numbers; by default the paper's.
    columns : mapping of str to str, optional
        Which column is what, by its number from 1 or its text in the header, perhaps with a unit:
        ``{"time": "1 [s]", "x1": "Disp [mm]"}``; by default the header says so.
    eta : float, optional
        Excitation frequency, for the time of files that the page wrote without units.
    physical : bool
        Whether the system is in physical units: then a file in numbers of the model has to say so, by [-] in its
        header; those of the page need not.

    Returns
    -------
    Measurement

    Raises
    ------
    UnknownColumns
        If nothing says which column is the time and which a displacement.
    ValueError
        If the file cannot be read, is larger than MEASUREMENT_SIZE_LIMIT, or is malformed: one line that names file,
        line and column.
    """
    content = read_file(path, MEASUREMENT_SIZE_LIMIT, bytes)
    try:
        return parse_measurement(content, units, columns, eta, physical=physical)
    except UnknownColumns as problem:
        raise UnknownColumns(f"{path}: {problem}", problem.header) from None
    except ValueError as problem:
        raise ValueError(f"{path}: {problem}") from None


def parse_measurement(
    content: bytes,
    units: Units | None = None,
    columns: Mapping[str, str] | None = None,
    eta: float | None = None,
    largest: int = MEASUREMENT_SIZE_LIMIT,
    physical: bool = False,
) -> Measurement:
    """Parse the bytes of a file; raises as :func:`read_measurement`, without its name.

    ``largest``: bytes that it may have, also once it is unpacked.
    """
    lines = lines_of(content, largest)
    table = table_of(lines)
    chosen = find_columns(table.header, table.where, _in_millimetres(units or Units()), columns, physical)
    series, found = _data(table, chosen)
    read = {column.place for column in chosen}
    left_out = [cell.strip() for place, cell in enumerate(table.header) if place not in read]
    chosen = [column for column in chosen if column.name != SERIES]
    names = [column.name for column in chosen]
    if len(found) < FEWEST_SAMPLES:
        last = f"line {len(lines)}: the file ends after {len(found)} samples"
        raise ValueError(f"{last}; give at least {FEWEST_SAMPLES}")
    values = dict(zip(names, np.array([row for _, row in found]).T, strict=True))
    frame = "relative" if "xi1" in values else "absolute"
    measured = PAIRS[frame] if PAIRS[frame][0] in values else ACCELERATIONS
    of_bodies = {name: values[name] for name in measured if name in values}
    if measured != ACCELERATIONS:  # of which an impact is a peak
        for name, each in of_bodies.items():
            where = f"column {chosen[names.index(name)].place + 1} ({name})"
            _refuse_outlier(values["time"], each, where, [number for number, _ in found])
    time, displacement = values["time"] - values["time"][0], np.stack(list(of_bodies.values()))
    in_periods = bool(series) and not chosen[names.index("time")].physical
    needs_eta = in_periods or measured == ACCELERATIONS
    if eta is None and needs_eta:
        raise ValueError(
            stated("{}: time in periods and accelerations need the excitation frequency: give {}", table.where, ETA)
        )
    time = time * 2 * np.pi / eta if in_periods else time
    return Measurement(
        time=time,
        displacement=integrated(time, displacement, eta) if measured == ACCELERATIONS else displacement,
        contact=_contact(values),
        frame=frame,
        mean_known=measured != ACCELERATIONS,
        eta=eta if needs_eta else None,
        left_out=(*left_out, *(f"other curves than {one}" for one in series), *table.left_out),
        physical=any(column.physical for column in chosen),
    )


def measurement_text(measurement: Measurement, units: Units, comment: str) -> str:
    """Write a CSV file in s and mm for :func:`read_measurement`, with a comment at the top."""
    has_contact = measurement.contact is not None
    names = PAIRS[measurement.frame][: len(measurement.displacement)]
    lines = [f"# {line}" for line in comment.splitlines()]
    lines.append(", ".join(["time [s]", *(f"{name} [mm]" for name in names), *["contact"][:has_contact]]))
    units = _in_millimetres(units)
    time = units.physical("time", measurement.time)
    displacement = units.physical("displacement", measurement.displacement)
    for i in range(len(measurement)):
        row = ", ".join([f"{time[i]:.9g}", *(f"{each[i]:.7g}" for each in displacement)])
        lines.append(f"{row}, {int(measurement.contact[i])}" if has_contact else row)
    return "\n".join(lines) + "\n"


def _in_millimetres(units: Units) -> Units:
    """The same units with lengths in mm, as the columns of a file have them."""
    return replace(units, system="mm-t-s")


def _data(table: Table, columns: list[Column]) -> tuple[list[str], list[tuple[int, list[float]]]]:
    """Read the samples, with the numbers of their lines; in a file of the page those of one curve, and its name."""
    place = next((column.place for column in columns if column.name == SERIES), None)
    rows, found, data = table.rows, [], []
    if place is not None:
        whole = [(number, cells) for number, cells in rows if len(cells) > place]
        curves = list(dict.fromkeys(cells[place].strip() for _, cells in whole))
        found = ["measured" if "measured" in curves else next(iter(curves), "")]
        rows = (row for row in whole if row[1][place].strip() == found[0])
        columns = [column for column in columns if column.name != SERIES]
    for number, cells in rows:
        _append(data, cells, columns, number, table)
    return found, data


def _append(
    data: list[tuple[int, list[float]]], cells: list[str], columns: list[Column], number: int, table: Table
) -> None:
    """Append a sample, after a check of its numbers; times must increase."""
    if len(cells) != len(table.header) and (len(cells) > len(table.header) or _ends_early(cells, columns)):
        raise ValueError(f"line {number}: {_miscount(cells, table)}")
    row = []
    for place, column in enumerate(columns):
        cell = cells[column.place]
        value = number_in(cell, table.delimiter) * column.factor
        fault = _fault(value, column.name, data[-1][1][place] if data else -math.inf)
        if fault:
            where = f"line {number}, column {column.place + 1} ({column.name})"
            raise ValueError(f"{where}: {cell.strip()[:40]!r} {fault}")
        row.append(value)
    data.append((number, row))


def _ends_early(cells: list[str], columns: list[Column]) -> bool:
    return len(cells) <= max(column.place for column in columns)


def _miscount(cells: list[str], table: Table) -> str:
    """Why a row has not as many columns as the header, and what to do."""
    numbers = sum(is_number(cell, table.delimiter) for cell in cells)
    if numbers < len(cells):
        return f"{table.delimiter.join(cells)[:40]!r} is no row of {len(table.header)} numbers; delete such lines"
    advice = ""
    if table.delimiter == "," and len(cells) > len(table.header):
        advice = "; decimal commas need semicolons between columns"
    elif len(cells) < len(table.header):
        advice = "; complete the row, or delete it"
    return f"{len(cells)} columns, the header has {len(table.header)}{advice}"


def _contact(values: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """Where the bodies touch, (n,), by the contact sensor or else by the contact force; None without either."""
    if "contact" in values:
        return values["contact"] > 0
    if "force" not in values:
        return None
    force = np.abs(values["force"])
    return force > CONTACT_FORCE * force.max()


def _refuse_outlier(time: np.ndarray, values: np.ndarray, column: str, numbers: list[int]) -> None:
    """Raise a ValueError that names the line of the first outlier of a displacement, if there is one."""
    found = first_outlier(time, values)
    if found:
        at, distance = found
        raise ValueError(
            f"line {numbers[at]}, {column}: an outlier, {distance:.3g} times as far from the middle as "
            "98 % of the samples; correct it, or delete the line"
        )


def _fault(value: float, name: str, previous: float) -> str:
    """Say what is wrong with a number in units of the model; empty if nothing is."""
    if math.isnan(value):
        return "is no finite number; correct it, or delete the line"
    if abs(value) > WRONG_UNIT and name != "force":
        return f"is {value:.3g} in units of the model; is the unit right?"
    if name == "contact" and value not in (0.0, 1.0):
        return "is neither 0 nor 1; set a threshold to the sensor's signal"
    if name == "time" and value == previous:
        return "is the time of the sample before it, too; keep one of the two"
    if name == "time" and value < previous:
        return "comes before the time of the sample before it; sort by time"
    return ""
