"""A system of one's own as a TOML file, with the units it is measured in.

    [system]
    kappa = 2.41        # and the others of Table 1; what is left out is as in Table 1

    [units]
    omega1 = 1.0        # optional, for results in physical units

:func:`system_text` writes such a file with every constant explained; :func:`read_system` takes nothing that it does not
know, since a misspelt constant that is quietly left at its default is the worst kind of error.
"""

import difflib
import tomllib
from dataclasses import asdict, dataclass, field
from pathlib import Path

from .files import read_file
from .model import System
from .units import Units

SIZE_LIMIT = 65_536  # bytes; a hundred times what a commented file takes
_DOTS = 200  # of a line; to read a.a.a … takes the square of its length, seconds for a file of that size

# name: meaning, allowed range, unit
_SYSTEM = {
    "kappa": ("frequency ratio of pendulum 2, omega2/omega1", "0.001 to 1000", "-"),
    "d1": ("damping ratio of pendulum 1", "0 to below 1", "-"),
    "d2": ("damping ratio of pendulum 2", "0 to below 1", "-"),
    "kappa3": ("frequency ratio of the joined pendulums, omega3/omega1", "between 1 and kappa, neither of them", "-"),
    "d3": ("damping ratio of the joined pendulums, as measured", "0 to below 1", "-"),
    "restitution": ("coefficient of restitution e", "0 to 1", "-"),
}
_UNITS = {
    "omega1": ("angular frequency of pendulum 1", "1e-6 to 1e9", "1/s"),
    "m1": ("mass of pendulum 1", "1e-9 to 1e12", "kg"),
    "base_amplitude": ("amplitude of the base", "1e-9 to 1e6", "mm"),
}
_INSTEAD = "mass_ratio"  # m2/m1, from which kappa3 follows


@dataclass(frozen=True)
class SystemFile:
    """What a system file says: the constants, and the units to show results in."""

    system: System = field(default_factory=System)
    units: Units = field(default_factory=Units)


def system_text(system: System | None = None, units: Units | None = None) -> str:
    """A system file with every constant, its meaning, its allowed range and its unit; by default that of Table 1."""
    system, units = system or System(), units or Units()
    lines = ["# The system: two neighbouring pendulums on a shaken base (the defaults are the paper's Table 1).", ""]
    lines += ["[system]", *_explained(system.as_dict(), _SYSTEM)]
    lines += [
        "# kappa3 sets the mass ratio m2/m1 = (kappa3^2 - 1)/(kappa^2 - kappa3^2), here "
        f"{system.mass_ratio:.6g}. Instead of kappa3",
        f"# the file may give it as {_INSTEAD}.",
        f"# The two dampers alone would give d3 = {system.derived_joint_damping:.4g} (--joint-damping derived).",
        "",
        "# What the numbers are counted in. They only convert results; the motion does not depend on them.",
        "[units]",
        *_explained(asdict(units), _UNITS),
    ]
    return "\n".join(lines) + "\n"


def _explained(values: dict[str, float], meanings: dict[str, tuple[str, str, str]]) -> list[str]:
    rows = [(f"{name} = {values[name]!r}", *meaning) for name, meaning in meanings.items()]
    return [f"{setting:24}# {meaning} [{unit}]; {span}" for setting, meaning, span, unit in rows]


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
        If the file cannot be read, is larger than SIZE_LIMIT, or is no system file: one line that names file and fault.
    """
    return read_file(path, SIZE_LIMIT, parse_system)


def parse_system(content: bytes) -> SystemFile:
    """What the bytes of a system file say; raises as :func:`read_system`, but knows no file name."""
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"larger than {SIZE_LIMIT} bytes: a system file holds ten numbers")
    tables = toml_tables(content)
    _known(tables, ("system", "units"), "table")
    given = _numbers(tables, "system", (*_SYSTEM, _INSTEAD))
    units = Units(**_numbers(tables, "units", tuple(_UNITS)))
    if _INSTEAD not in given:
        return SystemFile(System(**given), units)
    if "kappa3" in given:
        raise ValueError(f"gives both kappa3 and {_INSTEAD}: one follows from the other, leave one out")
    return SystemFile(System.from_mass_ratio(**given), units)


def toml_tables(content: bytes) -> dict:
    """What the bytes of any TOML file hold; whatever is wrong with them is a ValueError that names line and fault."""
    try:
        text = content.decode("utf-8-sig")
        if any(line.count(".") > _DOTS for line in text.split("\n")):
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
    except (ValueError, RecursionError):  # a number of thousands of digits, brackets nested by the thousand
        raise ValueError("not valid TOML: a value is too long or nested too deep; give plain numbers") from None


def _known(table: dict, names: tuple[str, ...], kind: str) -> None:
    for name in table:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            meant = f"did you mean {near[0]}?" if near else f"known: {', '.join(names)}"
            raise ValueError(f"unknown {kind} {name[:60]!r}; {meant}")


def _numbers(tables: dict, name: str, known: tuple[str, ...]) -> dict[str, float]:
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{name} is no table: begin it with a line [{name}]")
    _known(table, known, f"constant in [{name}]:")
    for key, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{key} = {str(value)[:60]!r} in [{name}] is no number: give it without quotes")
    return {key: _as_float(key, value) for key, value in table.items()}


def _as_float(key: str, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{key} is a whole number beyond 1e308: give one within its range") from None
