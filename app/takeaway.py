"""What a user takes away: parameters, the equivalent script and commands, the data shown, a report. No panel import.

Each is a dict with ``name`` (of a file), ``type`` (its media type) and ``text``. That the script and the commands give
the numbers of the page is held by tests that run them.
"""

from __future__ import annotations

import csv
import io
import json
import math
import tomllib
from collections.abc import Mapping
from importlib.metadata import version

import numpy as np

from app.present import Columns, quantity_of
from app.state import Setting, print_address, print_number, texts_of
from engine import Reference, System, Units, parse_system

# The series of each figure: what a row is called, the source, and its columns under the names the file gives them.
FIGURES: dict[str, list[tuple[str, str, dict[str, str]]]] = {
    "displacement": [
        (solver, "displacements", {"time": "t", "xi1": f"{solver}1", "xi2": f"{solver}2"})
        for solver in ("reference", "penalty")
    ],
    "strip": [(s, f"strip_{s}", {"contact_begin": "left", "contact_end": "right"}) for s in ("reference", "penalty")],
    "force": [
        *((s, f"force_{s}", {"time": "t", "force": "force"}) for s in ("reference", "penalty")),
        *((f"{s} impulse", f"impulse_{s}", {"time": "t", "impulse": "impulse"}) for s in ("reference", "penalty")),
    ],
} | {
    f"phase{n}": [
        (f"{s}{kind}", f"{source}_{s}", {f"xi{n}": f"x{n}", f"velocity{n}": f"v{n}"})
        for source, kind in (("phase", ""), ("section", " section"))
        for s in ("reference", "penalty")
    ]
    for n in (1, 2)
}


_UNITS = {"omega1": "omega1", "m1": "m1", "amplitude": "base_amplitude"}  # ours: the engine's name


def of_setting(what: str, setting: Setting) -> dict | None:
    """What follows from the setting alone: ``"toml"``, ``"python"`` or ``"command"``; None for anything else."""
    if what == "toml":
        return {"name": "vibroscope.toml", "type": "application/toml", "text": as_toml(setting)}
    if what == "python":
        return {"name": "vibroscope_run.py", "type": "text/x-python", "text": as_python(setting)}
    if what == "command":
        return {"name": "vibroscope.sh", "type": "text/x-shellscript", "text": as_command(setting)}
    return None


def as_toml(setting: Setting) -> str:
    """Every number and switch; reads back with `setting_of_toml`."""
    texts = texts_of(setting)
    lines = [f"# Vibroscope {version('vibroscope')}: the setting of the page", "[setting]"]
    for name, text in texts.items():
        value = getattr(setting, name)
        if name in _UNITS:
            continue
        lines.append(f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {text}")
    lines += ["", *_units_table(setting)]
    return "\n".join(lines) + "\n"


def _units_table(setting: Setting) -> list[str]:
    """The units as `engine.read_system` takes them."""
    units = Units(setting.omega1, setting.m1, setting.amplitude)
    comments = {"omega1": "1/s", "m1": "kg", "base_amplitude": "mm"}
    return ["[units]", *(f"{name} = {getattr(units, name)!r}  # {unit}" for name, unit in comments.items())]


def setting_of_toml(text: str) -> dict[str, str]:
    """The texts of a TOML file, as `app.state.read` takes them.

    The file is one of ours, with the tables [setting] and [units], or a system file as `engine.parse_system` reads it.

    Raises
    ------
    ValueError
        If it is neither, or holds a name that is not known: nothing of a file is passed over in silence.
    """
    tables = tomllib.loads(text)
    if "setting" not in tables and {"system", "units"} & tables.keys():
        file = parse_system(text.encode())
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


def as_python(setting: Setting) -> str:
    """A script that runs both solvers as the page did."""
    p, r = setting.penalty, setting.reference
    located = ", located=True" if p.located else ""
    names = "Newmark, Reference, System, motion, simulate"
    return f"""from engine import {names}

system = System({_differing(setting.system.as_dict(), System().as_dict())})
reference = simulate(system, {setting.eta!r}, Reference({_differing(vars(r), vars(Reference()))}))
penalty = simulate(
    system, {setting.eta!r}, Newmark(stiffness={p.stiffness!r}, damping={p.damping!r}, steps={p.steps}{located})
)

for response in (reference, penalty):
    print(motion(response) if response.ok else response.message)
    print("xi1, xi1', xi2, xi2' at the end:", *response.section[-1:])
"""


def _differing(values: Mapping, usual: Mapping) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in values.items() if value != usual[name])


def as_command(setting: Setting) -> str:
    """The same as commands for a shell; constants other than the paper's go into a file that they read."""
    eta = print_number(setting.eta)
    system = _differing(setting.system.as_dict(), System().as_dict()).replace(", ", "\n").replace("=", " = ")
    tables = [f"[system]\n{system}"] if system else []
    tables += ["\n".join(_units_table(setting))] if setting.scale else []
    file = "cat > system.toml <<'END'\n" + "\n".join(tables) + "\nEND\n" if tables else ""
    given = (" --system system.toml" if tables else "") + (" --units" if setting.scale else "")
    law = "".join(
        f" --{name.replace('_', '-')} {getattr(setting.reference, name)}"
        for name in ("joint_damping", "threshold")
        if getattr(setting.reference, name) != getattr(Reference(), name)
    )
    numbers = f"--K {print_number(setting.K)} --D {print_number(setting.D)} --steps {setting.steps}"
    located = " --located" if setting.penalty.located else ""
    return (
        f"{file}vibroscope simulate --solver reference --eta {eta}{law}{given}\n"
        f"vibroscope simulate --solver newmark --eta {eta} {numbers}{located}{given}\n"
    )


def as_csv(figure: str, columns: Mapping[str, Columns], scale: Units | None = None) -> str:
    """The data of one figure, a row a point; ``series`` says whose it is, and cells that do not apply are empty.

    Times are counted from the beginning of the last two excitation periods, in periods. With a ``scale``, which the
    columns must be in already, the head names the unit of each.
    """
    series = FIGURES[figure]
    names = list(dict.fromkeys(name for _, _, chosen in series for name in chosen))
    buffer = io.StringIO()
    writer = csv.writer(buffer)
    sources = {name: column for _, _, chosen in series for name, column in chosen.items()}
    units = {name: f" [{scale.unit(quantity_of(sources[name]))}]" if scale else "" for name in names}
    writer.writerow(["series", *(name + units[name] for name in names)])
    for label, source, chosen in series:
        for row in zip(*(columns[source][column].tolist() for column in chosen.values()), strict=True):
            cells = dict(zip(chosen, row, strict=True))
            writer.writerow([label, *(_cell(cells.get(name)) for name in names)])
    return buffer.getvalue()


def _cell(value: float | None) -> str:
    return "" if value is None or not math.isfinite(value) else f"{np.float32(value)}"


def as_json(setting: Setting, columns: Mapping[str, Columns], words: Mapping[str, str]) -> str:
    """Everything that is shown: the setting, the words, and the columns of every figure; not a number becomes null."""
    shown = {
        source: {
            name: [float(str(np.float32(x))) if math.isfinite(x) else None for x in column.tolist()]
            for name, column in data.items()
        }
        for source, data in columns.items()
    }
    return json.dumps(
        provenance(setting) | {"setting": setting._asdict(), "words": dict(words), "columns": shown},
        ensure_ascii=False,
        allow_nan=False,
    )


def provenance(setting: Setting) -> dict[str, str]:
    """What made these numbers."""
    return {"program": f"vibroscope {version('vibroscope')}", "address": f"?{print_address(setting)}"}
