"""System files: the constants of a system as TOML, with the physical units of its results.

    [system]
    kappa = 2.41        # and the other constants; those left out have the values of the paper's Table 1
    clearance = 0.0     # optional; wall = true in place of the constants of body 2

    [excitation]
    base = 1.0          # optional: base motion, forces on the bodies

    [units]
    omega1 = 1.0        # optional, for results in physical units

Or in place of these three one table [physical], with the unit in each name (:mod:`.physical`).

:func:`system_text` writes such a file and explains every constant. :func:`read_system` refuses names that it does not
know: otherwise a misspelt constant would silently keep its default.

Read files that users give: bounded in size, and with errors that name the file.
"""

import math
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, TypeVar

from vibroscope.engine.arguments import near_names
from vibroscope.engine.excitation import HELD, Excitation
from vibroscope.engine.fields import described_fields
from vibroscope.engine.methods import Reference
from vibroscope.engine.model import BODY_2, FORCES_ON_BODY_2, SECOND_STOP, System
from vibroscope.engine.physical import KEYS, NOT_AT_A_WALL, WALL, physical_entry, refuse_body_2, system_of_physical
from vibroscope.engine.units import Units

T = TypeVar("T")


def read_file(path: str | Path, size_limit: int, parse: Callable[[bytes], T]) -> T:
    """Read a file and return what ``parse`` makes of its bytes.

    At most ``size_limit + 1`` bytes are read, so ``parse`` recognises a file that is too large by its length.

    Raises
    ------
    ValueError
        If the file cannot be read or ``parse`` refuses its content: one line that begins with the path.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(size_limit + 1)
    except OSError as problem:
        raise ValueError(f"{path}: cannot be read: {problem.strerror or problem}") from None
    try:
        return parse(content)
    except ValueError as problem:
        raise ValueError(f"{path}: {problem}") from None


SYSTEM_SIZE_LIMIT = 65_536  # bytes; a hundred times the size of a commented file
_MOST_DOTS = 200  # in a line: tomllib reads a.a.a … in quadratic time, seconds for a file of SYSTEM_SIZE_LIMIT


MASS_RATIO = "mass_ratio"  # m2/m1; a file may give it in place of kappa3, which follows from it
NOT_MEASURED = "derived"  # in place of a number for d3
_KINDS = {"system": System, "excitation": Excitation, "units": Units}
_TABLES = (*_KINDS, "physical")


_NO_RESTITUTION = (
    "[physical] gives no restitution, and {:g} is taken, that of the paper: give it, since it decides how fast the "
    "bodies part"
)
_NO_SPRING = (
    "[physical] gives body 1 no spring, by stiffness1_N_per_m or frequency1_Hz: it is free, and time is counted in "
    "{:.4g} s, {}"
)
_PAPERS_JOINT = (
    "[system] describes bodies other than the paper's and gives no d3; {:g} is taken, which was measured there: give "
    'yours, or d3 = "derived" where the joined bodies were never measured, here {:.4g}'
)
_PAPERS_RATIO = (
    "[system] gives kappa without kappa3 or mass_ratio, and kappa3 = {:g} is taken, that of the paper: the mass ratio "
    "follows from it, m2/m1 = {:.4g}"
)
_BODIES = "kappa", "d1", "d2", "kappa3", "mu"  # what the joint damping depends on, by the names of System


@dataclass(frozen=True)
class SystemFile:
    """Content of a system file: the system, the units to show results in, and η where the file gives it.

    ``has_units``: whether it says what its numbers are counted in, by [physical] or [units].
    ``assumed``: in a sentence each, what a description of an own system leaves out and what is taken for it.
    ``forms``: of the numbers of [physical] that may be given in several forms, the names of those not in the first.
    """

    system: System = field(default_factory=System)
    units: Units = field(default_factory=Units)
    eta: float | None = None
    assumed: tuple[str, ...] = ()
    forms: tuple[str, ...] = ()
    has_units: bool = field(default=False, compare=False)

    @property
    def usual_eta(self) -> float | None:
        """η of the file. A free vibration has none: its periods are then 2π/ω₁ long."""
        return 1.0 if self.eta is None and not self.system.excitation.drives else self.eta


class DescribedKey(NamedTuple):
    """A key of a table: what it means, its unit, what it may be, and what is taken where it is left out."""

    meaning: str
    unit: str
    allowed: str
    default: float | bool | str


def described_keys(table: str) -> dict[str, DescribedKey]:
    """Return every key that a table of a system file may have, by its name.

    Parameters
    ----------
    table : {"system", "excitation", "units", "physical"}

    Examples
    --------
    >>> from vibroscope.engine.system_file import described_keys
    >>> described_keys("physical")["restitution"].default
    0.5
    """
    wall = {WALL: DescribedKey("whether body 2 is a wall", "-", "true or false", False)}
    if table == "physical":
        keys = {
            name: DescribedKey(k.meaning, k.unit or "-", k.allowed.words(""), k.default) for name, k in KEYS.items()
        }
        return keys | wall
    kind = _KINDS[table]
    usual = kind()
    taken = vars(usual) | {"clearance2": "no second stop", "restitution2": "restitution"}
    keys = {
        name: DescribedKey(each.meaning, each.unit, each.allowed_words, taken[name])
        for name, each in described_fields(kind).items()
    }
    if table != "system":
        return keys
    ratio = keys.pop("mu")._replace(default="of kappa and kappa3")
    return keys | {MASS_RATIO: ratio} | wall


def system_text(system: System | None = None, units: Units | None = None) -> str:
    """Write a system file that explains every constant; by default the system of the paper's Table 1."""
    system, units = system or System(), units or Units()
    speed, usual = units.base_amplitude * units.omega1, Reference().threshold
    lines = ["# The system: two bodies that may touch, on a moving base (defaults: the paper's pendulums, Table 1)."]
    lines += ["", "[system]", *_system_lines(system)]
    stiffness = "k1" if system.spring1 == 1.0 else "k1 = m1 omega1^2"
    counted = f"lengths are counted in the unit of length below, forces in {stiffness} times that length"
    lines += ["", f"# What drives it; {counted}."]
    lines += ["# A velocity that is held is counted in length omega1, an acceleration in length omega1^2."]
    lines += ["[excitation]", *_excitation_lines(system)]
    lines += [
        "",
        "# What the numbers are counted in. They only convert results; the motion does not depend on them.",
        "[units]",
        *_constant_lines(vars(units), described_keys("units")),
        *([] if system.spring1 == 1.0 else ["# omega1 is no frequency of body 1 here, but 1 over the unit of time."]),
        f"# Speeds are counted in base_amplitude omega1 = {speed:.4g} mm/s, and so is the threshold of the reference",
        f"# (--threshold), which scales with the system: its default, {usual:g}, is {usual * speed:.3g} mm/s here.",
    ]
    return "\n".join(lines) + "\n"


def brief_system_text(system: System) -> str:
    """Write what differs from the paper's system, as tables without comments; empty if nothing does.

    The joint of other bodies is written in any case, so that nobody has to assume it.
    """
    constants = system.as_dict()
    usual, tables = System().as_dict(), {"system": {}, "excitation": {}}
    usual_drive = Excitation().as_dict()
    joint = ("kappa3", "d3") if _has_other_bodies(system) else ()
    for name, value in constants.items():
        if name not in usual or value != usual[name] or name in joint:
            tables["excitation" if name in usual_drive else "system"][name] = value
    own = tables["system"]
    if "mu" in own:
        own[MASS_RATIO] = own.pop("mu")
    if own.get("d3", 0.0) is None:
        own["d3"] = NOT_MEASURED
    return "\n".join(
        "\n".join([f"[{table}]", *(f"{name} = {_toml(value)}" for name, value in values.items())])
        for table, values in tables.items()
        if values
    )


def _system_lines(system: System) -> list[str]:
    values, keys = vars(system) | {MASS_RATIO: system.mu}, described_keys("system")
    without = [name for name in ("clearance2", *SECOND_STOP) if not system.two_stops or values[name] is None]
    for name in (WALL, *without):
        del keys[name]
    if system.wall:
        known = {name: key for name, key in keys.items() if name not in (*BODY_2, MASS_RATIO)}
        return [f"{'wall = true':24}# body 2 is a wall that is fixed to the base", *_constant_lines(values, known)]
    ratio = keys.pop(MASS_RATIO)
    if system.spring1 == 1.0:
        del keys["spring1"]
    if system.mu is not None:
        keys = {(MASS_RATIO if name == "kappa3" else name): key for name, key in keys.items()} | {MASS_RATIO: ratio}
    if system.d3 is None:
        values["d3"] = NOT_MEASURED
    lines = _constant_lines(values, keys)
    if system.mu is None:
        lines += [
            "# kappa3 sets the mass ratio m2/m1 = (kappa3^2 - 1)/(kappa^2 - kappa3^2), here "
            f"{system.mass_ratio:.6g}. Instead of kappa3",
            f"# the file may give it as {MASS_RATIO}. With wall = true, body 2 is a wall and has no constants.",
        ]
    if system.kappa3 == 0.0:
        return lines
    derived = system.derived_joint_damping
    return [*lines, f"# The two dampers alone would give d3 = {derived:.4g} (--joint-damping derived)."]


def _excitation_lines(system: System) -> list[str]:
    idle = FORCES_ON_BODY_2 if system.wall else ()
    known = {name: key for name, key in described_keys("excitation").items() if name not in idle}
    return _constant_lines(system.excitation.as_dict(), known)


def physical_text(system: System, units: Units, eta: float | None = None, forms: Sequence[str] = ()) -> str:
    """Write the same system as a table [physical], every number with its unit, to 15 digits: 0.9, no rounding of it.

    ``forms`` as in :func:`physical_entry`.
    """
    lines = ["# The system in physical units", "", "[physical]"]
    entry = physical_entry(system, units, eta, forms)
    for name in ("length_mm", "time_s"):
        if name in entry and (system.excitation.base or name == "time_s") and _follows(name, entry, units):
            del entry[name]
    for name, value in entry.items():
        meaning = "body 2 is a wall" if name == WALL else KEYS[name].meaning
        text = _toml(value if isinstance(value, bool) else float(f"{value:.15g}"))
        lines.append(f"{f'{name} = {text}':43} # {meaning}")
    return "\n".join(lines) + "\n"


def _follows(unit: str, entry: dict, units: Units) -> bool:
    """Whether the unit of length, or of time, is what the rest of an entry gives without it."""
    try:
        found = system_of_physical({name: value for name, value in entry.items() if name != unit}).units
    except ValueError:
        return False
    pairs = (found.base_amplitude, units.base_amplitude), (found.omega1, units.omega1)
    return all(math.isclose(*pair, rel_tol=1e-12) for pair in pairs)


def _toml(value: float | bool | str) -> str:
    return str(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else repr(value)


def _constant_lines(values: dict[str, float | str], keys: dict[str, DescribedKey]) -> list[str]:
    return [
        f"{f'{name} = {_toml(values[name])}':23} # {key.meaning} [{key.unit}]; {key.allowed}"
        for name, key in keys.items()
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
        If the file cannot be read, is larger than SYSTEM_SIZE_LIMIT, or is not a system file: one line that names the
        file and the fault.
    """
    return read_file(path, SYSTEM_SIZE_LIMIT, parse_system)


def parse_system(content: bytes) -> SystemFile:
    """Parse the bytes of a system file; raises as :func:`read_system`, without the name of the file.

    Examples
    --------
    >>> from vibroscope.engine import System, parse_system, system_text
    >>> text = system_text(System(wall=True, clearance=0.5))
    >>> parse_system(text.encode()).system.clearance
    0.5
    """
    if len(content) > SYSTEM_SIZE_LIMIT:
        raise ValueError(f"larger than {SYSTEM_SIZE_LIMIT} bytes: a system file holds some twenty numbers")
    tables = toml_tables(content)
    found = system_of_tables(tables)
    if not any(tables.values()):
        raise ValueError(
            "has no entry: describe the system in a table [physical], or in [system], [excitation] and [units]"
        )
    return found


def system_of_tables(tables: dict) -> SystemFile:
    """Read a system from the tables of a TOML file."""
    _refuse_unknown(tables, _TABLES, "table")
    if "physical" in tables:
        others = [f"[{name}]" for name in _TABLES[:-1] if name in tables]
        if others:
            raise ValueError(f"gives [physical] and {', '.join(others)}: describe the system in one way, leave one out")
        entry = _values(tables, "physical", flags=(WALL,))
        found = system_of_physical(entry)
        assumed = () if "restitution" in entry else (_NO_RESTITUTION.format(found.system.restitution),)
        if not found.system.spring1:
            forms = ("time_s", "time_s"), ("frequency_Hz", "1/(2 pi frequency_Hz)")
            other = "sqrt(m2/k2)" if found.system.kappa == 1.0 else "sqrt(length/acceleration)"
            unit = next((words for key, words in forms if key in entry), other)
            assumed += (_NO_SPRING.format(1 / found.units.omega1, unit),)
        return SystemFile(found.system, found.units, found.eta, assumed, found.forms, has_units=True)
    constants = _values(tables, "system", flags=(WALL,), words={"d3": (NOT_MEASURED,)})
    driven, units = _values(tables, "excitation", words={"held": HELD}), Units(**_values(tables, "units"))
    if constants.get(WALL):
        refuse_body_2((*BODY_2, MASS_RATIO), constants)
        refuse_body_2(FORCES_ON_BODY_2, driven)
    if constants.get("d3") == NOT_MEASURED:
        constants["d3"] = None
    if MASS_RATIO in constants:
        if "kappa3" in constants:
            raise ValueError(f"gives both kappa3 and {MASS_RATIO}: one follows from the other, leave one out")
        System.from_mass_ratio(constants[MASS_RATIO])  # its range, by the name that the file uses
        constants["mu"] = constants.pop(MASS_RATIO)
    system = System(**constants, excitation=Excitation(**driven))
    assumed = tuple(_assumed_of_bodies(system, constants))
    return SystemFile(system, units, assumed=assumed, has_units="units" in tables)


def _has_other_bodies(system: System) -> bool:
    """Whether a measured joint damping of the paper's pendulums cannot be that of these two bodies."""
    return not system.wall and any(getattr(system, name) != getattr(System(), name) for name in _BODIES)


def _assumed_of_bodies(system: System, given: dict) -> Iterator[str]:
    """Yield what is taken from the paper for the joint of other bodies: a file of any age keeps its numbers."""
    if not _has_other_bodies(system):
        return
    if "kappa" in given and not given.keys() & {"kappa3", "mu"}:
        yield _PAPERS_RATIO.format(system.kappa3, system.mass_ratio)
    if "d3" not in given and system.d3 is not None:
        yield _PAPERS_JOINT.format(system.d3, system.derived_joint_damping)


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
            near = near_names(name, known)
            advice = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(known)}"
            raise ValueError(f"unknown {kind} {name[:60]!r}; {advice}")


def _values(
    tables: dict, name: str, flags: tuple[str, ...] = (), words: dict[str, tuple[str, ...]] | None = None
) -> dict:
    """Return the values of one table by name: numbers, flags, and the words that a name may have instead.

    Refuses unknown names, and values of another kind.
    """
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{name} is no table: begin it with a line [{name}]")
    known = described_keys(name)
    if (tables.get("system" if name == "excitation" else name) or {}).get(WALL) is True:
        known = [key for key in known if key not in (*NOT_AT_A_WALL, *BODY_2, *FORCES_ON_BODY_2, MASS_RATIO)]
    _refuse_unknown([key for key in table if key not in described_keys(name)], known, f"constant in [{name}]:")
    return {key: _value(key, value, name, key in flags, (words or {}).get(key, ())) for key, value in table.items()}


def _value(key: str, value: object, table: str, is_flag: bool, words: tuple[str, ...]) -> float | bool | str:
    if is_flag:
        if not isinstance(value, bool):
            raise ValueError(f"{key} = {str(value)[:60]!r} in [{table}] is not true or false: give one without quotes")
        return value
    if isinstance(value, str) and value in words:
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        alternative = "".join(f", or {word!r}" for word in words)
        raise ValueError(f"{key} = {str(value)[:60]!r} in [{table}] is no number: give it without quotes{alternative}")
    return _as_float(key, value)


def _as_float(key: str, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{key} is a whole number beyond 1e308: give one within its range") from None
