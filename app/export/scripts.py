"""Scripts and commands that reproduce the numbers of the page. No panel import.

Tests run them and compare their numbers with those of the page.
"""

import ast
from collections.abc import Mapping, Sequence
from dataclasses import fields
from shlex import quote
from textwrap import indent

from vibroscope import engine
from vibroscope.app.explorer.compute import run_length
from vibroscope.app.explorer.parameters import FIELDS, STEPPING_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import units_table
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.load import LoadQuestion, Pulse, RecordFile
from vibroscope.app.studies.peaks import record_of
from vibroscope.app.studies.speed import SpeedQuestion
from vibroscope.engine import (
    ExactPenalty,
    Impact,
    Method,
    Newmark,
    Reference,
    System,
    TimeStepping,
    Units,
    brief_system_text,
)

_PAPER = System().as_dict()

# ---- one setting ----------------------------------------------------------------------------------------------------


def as_python(setting: Setting) -> str:
    """A script that runs both solvers as the page did, and compares them."""
    p = setting.penalty
    start = "" if setting.from_rest else f", initial={setting.initial}"
    length = run_length(setting.system, setting.eta, setting.initial)
    start += "".join(f", {name}={periods}" for name, periods in length.items())
    runs = f"""system = {_system(setting.system)}
reference = simulate(system, {setting.eta!r}, {method_python(setting.reference)}{start})
penalty = simulate(
    system, {setting.eta!r}, {method_python(p)}{start}
)

for response in (reference, penalty):
    print(motion(response) if response.ok else response.message)
    print("xi1, xi1', xi2, xi2' at the end:", *response.section[-1:])

"""
    compared = f"""found = compare(
    ComparisonQuestion(system, {setting.eta!r}, penalty.method, reference=reference.method{start}),
    responses=(reference, penalty),
)
{_VERDICT}"""
    if p.has_choices:  # of which the engine may have no comparison, or no verdict
        compared = f"try:\n{indent(compared, '    ')}except ValueError as error:\n    print('not known:', error)\n"
    return script(runs + compared)


def script(body: str, imports: str = "") -> str:
    """A script: ``imports``, those of what ``body`` uses of NumPy and of the engine, and ``body``."""
    names = [each for each in ast.walk(ast.parse(body)) if isinstance(each, ast.Name)]
    used = {each.id for each in names} - {each.id for each in names if isinstance(each.ctx, ast.Store)}
    numpy = "import numpy as np\n\n" if "np" in used else ""
    of_engine = sorted(used & set(engine.__all__), key=lambda name: (name.islower(), name))
    return f"{numpy}{imports}from vibroscope.engine import {', '.join(of_engine)}\n\n{body}"


_VERDICT = """answer = verdict(found)
print(answer.headline, *answer.details, sep="\\n")
if found.parts:
    print("total", found.difference.total, "of the", found.difference.measure)
    for name, value in found.difference.parts.items():
        print(name, value)
print("change first:", answer.change or "nothing")
"""


def as_command(setting: Setting, measured: str = "", columns: str = "", in_units: bool = True) -> str:
    """The runs of the page as shell commands; constants other than the paper's go into a file that the commands read.

    ``measured`` is the name of the file of a measurement, which is compared, too, and ``columns`` says which of its
    columns is what, where it does not say so itself, and ``in_units`` whether its numbers have units.
    """
    file, options = _file_and_options(setting, bool(measured) and in_units)
    periods = "".join(f" --{name} {number}" for name, number in _length(setting).items())
    eta = print_number(setting.eta)
    reference, newmark = (penalty_options(method) for method in (setting.reference, setting.penalty))
    compared = f"vibroscope compare --eta {eta}{newmark}{reference}{options}"
    chosen = f" --columns {quote(columns)}" if columns else ""
    return (
        f"{file}vibroscope simulate --solver reference --eta {eta}{reference}{options}{periods}\n"
        f"vibroscope simulate --solver newmark --eta {eta}{newmark}{options}{periods}\n"
        f"{compared}\n"
    ) + (f"{compared} --measured {quote(measured)}{chosen}\n" if measured else "")


def _length(setting: Setting) -> dict[str, int]:
    return run_length(setting.system, setting.eta, setting.initial)


def peaks_python(setting: Setting) -> str:
    """A script that reads the largest values off both solutions."""
    length = _length(setting)
    how = "" if setting.from_rest else f", initial={setting.initial}"
    how += "".join(f", {name}={periods}" for name, periods in length.items())
    sampled = record_of(length)
    record = f"record=Record({sampled.periods}, {sampled.per_period})"
    calls = {
        solver: f"peaks(simulate(system, {setting.eta!r}, {method_python(method)}, {record}{how}))"
        for solver, method in setting.methods.items()
    }
    return sweep_python(calls, setting.system)


def peaks_command(setting: Setting) -> str:
    """``vibroscope peaks`` of a setting."""
    file, options = _file_and_options(setting)
    methods = penalty_options(setting.penalty) + penalty_options(setting.reference)
    return f"{file}vibroscope peaks --eta {print_number(setting.eta)}{methods}{options}\n"


def impact_python(asked: Impact) -> str:
    """A script that solves a contact alone, and finds the largest step."""
    numbers = ", ".join(f"{name}={getattr(asked, name)!r}" for name in ("speed", "mass", "time_step", "restitution"))
    return script(f"""question = Impact({method_python(asked.method)}, {numbers})
print(question.without_step)
print(question.steps_per_contact, impact(question).restitution)
print(largest_step(question, asked=question.restitution))
""")


def impact_command(asked: Impact) -> str:
    """``vibroscope impact`` of a contact alone, in the numbers of the model."""
    numbers = {"mass": asked.mass, "speed": asked.speed, "K": asked.method.stiffness, "time-step": asked.time_step}
    damper = {"restitution": asked.without_step.restitution}  # from which the law takes it
    numbers |= damper if asked.method.damping is None else {"D": asked.method.damping}
    options = "".join(f" --{name} {print_number(value)}" for name, value in numbers.items())
    scheme = scheme_options(asked.method).replace(" --located", " --status located")
    return f"vibroscope impact{options}{scheme} --schemes\n"


def load_python(asked: LoadQuestion) -> str:
    """A script that runs both solutions under a load, and splits their difference."""
    source = asked.source
    if isinstance(source, Pulse):
        load = f"Load.{source.kind}({', '.join(map(repr, source.numbers))}, on={source.on!r})"
    else:
        u = source.units
        load = f"read_record({source.name!r}, Units({u.omega1!r}, {u.m1!r}, {u.base_amplitude!r}), {source.on!r})"
    how = f"free={asked.free!r}" + ("" if asked.initial is None else f", initial={asked.initial}")
    methods = f"{method_python(asked.penalty)}, {method_python(asked.reference)}"
    return script(f"""load = {load}
found = transient_difference({_system(asked.system)}, load, {methods}, {how})
print(found.difference)
for run in (found.reference, found.penalty):
    print(run.peaks, run.residual)
""")


def load_command(setting: Setting, asked: LoadQuestion) -> str:
    """``vibroscope transient`` of a setting."""
    file, options = _file_and_options(setting, isinstance(asked.source, RecordFile) and asked.source.in_units)
    source, what = asked.source, "base" if asked.source.on == "base" else "force"
    if isinstance(source, Pulse):
        numbers = ",".join(print_number(value) for value in source.numbers if value is not None)
        load = f" --{what}-{source.kind.replace('_', '-')}={numbers}"
    else:
        load = f" --{what}-record {quote(source.name)}"
    load += "" if what == "base" else f" --body {source.on[-1]}"
    methods = penalty_options(asked.penalty) + penalty_options(asked.reference)
    return f"{file}vibroscope transient{load} --free {print_number(asked.free)}{methods}{options}\n"


def _file_and_options(setting: Setting, reads: bool = False) -> tuple[str, str]:
    """A command that writes the system file, and the options for file, units and start.

    ``reads``: whether the command reads a file whose numbers have units.
    """
    units = Units(setting.omega1, setting.m1, setting.amplitude)
    file, options = _system_file(setting.system, units if setting.scale or (reads and units != Units()) else None)
    options += f" --units {setting.scale.system}" if setting.scale else ""
    return file, options + initial_option(setting.own_start)


# ---- a study --------------------------------------------------------------------------------------------------------


def sweep_python(calls: Mapping[str, str], system: System) -> str:
    """A script that runs each study, a call of `engine`, and prints the results."""
    made = "\n".join(f"{name} = {call}" for name, call in calls.items())
    return script(f"system = {_system(system)}\n{made}\n\nprint({', '.join(calls)}, sep='\\n')\n")


def speed_python(asked: SpeedQuestion) -> str:
    """A script that measures cost and error as the page does."""
    start = "" if asked.initial is None else f", {asked.initial}"
    start += "" if asked.stiffness_of_step is None else f", stiffness_of_step={asked.stiffness_of_step}"
    body = f"""method = {method_python(asked.method)}
question = SpeedQuestion({_system(asked.system)}, {asked.eta!r}, method, {asked.reference!r}{start})
*_, found = grow_speed(question, None, lambda: False)
for solver in found.turns:
    print(*solver, found.cost(solver), "µs per period, error", found.errors.get(solver))
"""
    return script(body, "from vibroscope.app.studies.speed import SpeedQuestion, grow_speed\n")


PAPER_PYTHON = """from vibroscope.app.paper import CLAIMS, as_dict

for claim in CLAIMS.values():
    print(as_dict(claim, claim.find()))
"""
PAPER_COMMAND = "vibroscope paper\n"


def sweep_command(study: str, system: System, *options: str) -> str:
    """``vibroscope sweep`` with each of the ``options``; several stores are numbered."""
    file, system_option = _system_file(system)
    stores = [f"{study}{number if len(options) > 1 else ''}.zarr" for number in range(1, len(options) + 1)]
    return file + "".join(
        f"vibroscope sweep {study}{each}{system_option} --out {store}\n"
        for each, store in zip(options, stores, strict=True)
    )


def branch_command(system: System, options: Mapping[str, str]) -> str:
    """``vibroscope branch`` with options for each store, by its name."""
    file, system_option = _system_file(system)
    return file + "".join(
        f"vibroscope branch{each}{system_option} --out {store}.zarr\n" for store, each in options.items()
    )


def initial_option(initial: Sequence[float] | None) -> str:
    """``--initial`` where a run does not start from rest, None."""
    return "" if initial is None else f" --initial={','.join(map(print_number, initial))}"


def method_python(method: Method) -> str:
    """The method as a script makes it."""
    if method.rigid:
        return f"Reference({_differing(vars(method), vars(Reference()))})"
    if not (method.has_step and method.is_newmarks):
        return repr(method)
    more = ", located=True" if method.located else ""
    more += f", law={method.law!r}" if not method.linear else ""
    return f"Newmark(stiffness={method.stiffness!r}, damping={method.damping!r}, steps={method.steps}{more})"


def method_options(method: Method) -> str:
    """``--solver`` with the options of the method."""
    return f" --solver {'newmark' if method.has_step else method.name}{penalty_options(method)}"


def penalty_options(method: Method) -> str:
    """The options of a method's numbers, without ``--solver``."""
    if method.rigid:
        usual = vars(Reference())
        return "".join(f" --{n.replace('_', '-')} {v}" for n, v in vars(method).items() if v != usual[n])
    numbers = f" --K {print_number(method.stiffness)}"
    numbers += "" if method.damping is None else f" --D {print_number(method.damping)}"
    if not method.has_step:
        return numbers + _changed(method, ExactPenalty(method.stiffness, 0.0))
    return f"{numbers} --steps {method.steps}{scheme_options(method)}"


def scheme_options(method: TimeStepping) -> str:
    """The options of integrator, contact status and law, beside K, D and the steps."""
    if method.is_newmarks or method.resolves_contacts:
        usual = Newmark(method.stiffness, 0.0, method.steps, located=method.located)
        return (" --located" if method.located else "") + _changed(method, usual)
    own, usual = method.integrator, TimeStepping(method.stiffness, 0.0, method.steps)
    numbers = f" --integrator {own.name}"
    numbers += "".join(f" --{each.name} {print_number(getattr(own, each.name))}" for each in fields(own))
    return numbers + _changed(method, usual)


def _changed(method: Method, usual: Method) -> str:
    """Options for contact status and law, and their numbers, where they are not as usual."""
    own = {each.name for each in fields(method)} - {"integrator"}
    names = [name for name in STEPPING_FIELDS if name in own and FIELDS[name].words]
    changed = {name: getattr(method, name) for name in names if getattr(method, name) != getattr(usual, name)}
    return "".join(f" --{name.replace('_', '-')} {value}" for name, value in changed.items())


# ---- parts of both --------------------------------------------------------------------------------------------------


def _system(system: System) -> str:
    constants = {name: value for name, value in system.as_dict().items() if value != _PAPER.get(name)}
    if constants.keys() <= {field.name for field in fields(System)}:
        return f"System({_differing(constants, {})})"
    return f"System.from_dict({constants!r})"


def system_file_text(system: System, units: Units | None = None) -> str:
    """A system file with what differs from the paper's system, and with ``units``; empty if nothing does."""
    tables = (brief_system_text(system), "\n".join(units_table(units)) if units is not None else "")
    return "\n".join(table for table in tables if table)


def _system_file(system: System, units: Units | None = None) -> tuple[str, str]:
    """A command that writes a system file, and the option that reads it; empty where it would be empty."""
    text = system_file_text(system, units)
    return (f"cat > system.toml <<'END'\n{text}\nEND\n", " --system system.toml") if text else ("", "")


def _differing(values: Mapping, usual: Mapping) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in values.items() if name not in usual or value != usual[name])
