"""System files: the constants of a system as TOML, with the physical units of its results.

    [system]
    kappa = 2.41        # and the other constants; those left out have the values of the paper's Table 1

    [units]
    omega1 = 1.0        # optional, for results in physical units

:func:`system_text` writes such a file and explains every constant. :func:`read_system` refuses names that it does not
know: otherwise a misspelt constant would silently keep its default.
"""

import difflib
import tomllib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import NamedTuple

from .files import read_file
from .model import System
from .units import Units

SIZE_LIMIT = 65_536  # bytes; a hundred times the size of a commented file
_MOST_DOTS = 200  # in a line: tomllib reads a.a.a … in quadratic time, seconds for a file of SIZE_LIMIT


class Constant(NamedTuple):
    """How a system file explains one of its constants."""

    meaning: str
    allowed: str
    unit: str


_KAPPA3_ALLOWED = "between 1 and kappa, neither of them"
SYSTEM_CONSTANTS = {
    "kappa": Constant("frequency ratio of pendulum 2, omega2/omega1", "0.001 to 1000", "-"),
    "d1": Constant("damping ratio of pendulum 1", "0 to below 1", "-"),
    "d2": Constant("damping ratio of pendulum 2", "0 to below 1", "-"),
    "kappa3": Constant("frequency ratio of the joined pendulums, omega3/omega1", _KAPPA3_ALLOWED, "-"),
    "d3": Constant("damping ratio of the joined pendulums, as measured", "0 to below 1", "-"),
    "restitution": Constant("coefficient of restitution e", "0 to 1", "-"),
}
UNIT_CONSTANTS = {
    "omega1": Constant("angular frequency of pendulum 1", "1e-6 to 1e9", "1/s"),
    "m1": Constant("mass of pendulum 1", "1e-9 to 1e12", "kg"),
    "base_amplitude": Constant("amplitude of the base", "1e-9 to 1e6", "mm"),
}
MASS_RATIO = "mass_ratio"  # m2/m1; a file may give it in place of kappa3, which follows from it


@dataclass(frozen=True)
class SystemFile:
    """Content of a system file: the constants of the system and the units to show results in."""

    system: System = field(default_factory=System)
    units: Units = field(default_factory=Units)


def system_text(system: System | None = None, units: Units | None = None) -> str:
    """Write a system file that explains every constant; by default the system of the paper's Table 1."""
    system, units = system or System(), units or Units()
    lines = ["# The system: two neighbouring pendulums on a shaken base (the defaults are the paper's Table 1).", ""]
    lines += ["[system]", *_constant_lines(system.as_dict(), SYSTEM_CONSTANTS)]
    lines += [
        "# kappa3 sets the mass ratio m2/m1 = (kappa3^2 - 1)/(kappa^2 - kappa3^2), here "
        f"{system.mass_ratio:.6g}. Instead of kappa3",
        f"# the file may give it as {MASS_RATIO}.",
        f"# The two dampers alone would give d3 = {system.derived_joint_damping:.4g} (--joint-damping derived).",
        "",
        "# What the numbers are counted in. They only convert results; the motion does not depend on them.",
        "[units]",
        *_constant_lines(asdict(units), UNIT_CONSTANTS),
    ]
    return "\n".join(lines) + "\n"


def _constant_lines(values: dict[str, float], constants: dict[str, Constant]) -> list[str]:
    return [
        f"{f'{name} = {values[name]!r}':24}# {constant.meaning} [{constant.unit}]; {constant.allowed}"
        for name, constant in constants.items()
    ]


def read_system(path: str | Path) -> SystemFile:
    """Read a system file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    SystemFile

    Raises
    ------
    ValueError
        If the file cannot be read, is larger than SIZE_LIMIT, or is not a system file: one line that names the file
        and the fault.
    """
    return read_file(path, SIZE_LIMIT, parse_system)


def parse_system(content: bytes) -> SystemFile:
    """Parse the bytes of a system file; raises as :func:`read_system`, without the name of the file."""
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"larger than {SIZE_LIMIT} bytes: a system file holds ten numbers")
    return system_of_tables(toml_tables(content))


def system_of_tables(tables: dict) -> SystemFile:
    """The same of the tables of a TOML file."""
    _refuse_unknown(tables, ("system", "units"), "table")
    constants = _numbers(tables, "system", (*SYSTEM_CONSTANTS, MASS_RATIO))
    units = Units(**_numbers(tables, "units", tuple(UNIT_CONSTANTS)))
    if MASS_RATIO not in constants:
        return SystemFile(System(**constants), units)
    if "kappa3" in constants:
        raise ValueError(f"gives both kappa3 and {MASS_RATIO}: one follows from the other, leave one out")
    return SystemFile(System.from_mass_ratio(**constants), units)


def toml_tables(content: bytes) -> dict:
    """Parse the bytes of any TOML file; raises ValueError that names the line, where it is known, and the fault."""
    try:
        text = content.decode("utf-8-sig")
        if any(line.count(".") > _MOST_DOTS for line in text.split("\n")):
            raise ValueError
        return tomllib.loads(text)
    except UnicodeDecodeError as problem:
        line = content[: problem.start].count(b"\n") + 1
        raise ValueError(f"line {line}: not UTF-8 text; save the file as UTF-8") from None
    except tomllib.TOMLDecodeError as problem:
        lines = content.count(b"\n") + 1
        raise ValueError(
            f"not valid TOML: {problem}".replace("at end of document", f"at the end, line {lines}")
        ) from None
    except (ValueError, RecursionError):  # thousands of digits in a number, thousands of nested brackets
        raise ValueError("not valid TOML: a value is too long or nested too deep; give plain numbers") from None


def _refuse_unknown(table: dict, known: tuple[str, ...], kind: str) -> None:
    for name in table:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            advice = f"did you mean {close[0]}?" if close else f"known: {', '.join(known)}"
            raise ValueError(f"unknown {kind} {name[:60]!r}; {advice}")


def _numbers(tables: dict, name: str, known: tuple[str, ...]) -> dict[str, float]:
    """Return the numbers of one table by name; refuses unknown names and values that are not numbers."""
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{name} is no table: begin it with a line [{name}]")
    _refuse_unknown(table, known, f"constant in [{name}]:")
    for key, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{key} = {str(value)[:60]!r} in [{name}] is no number: give it without quotes")
    return {key: _as_float(key, value) for key, value in table.items()}


def _as_float(key: str, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{key} is a whole number beyond 1e308: give one within its range") from None
