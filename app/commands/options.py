"""Options that several commands share, and the objects that they describe."""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from inspect import signature
from itertools import chain

from vibroscope.app.commands.numbers import count, of_field, state_numbers
from vibroscope.app.commands.parser import option
from vibroscope.app.commands.report import note
from vibroscope.app.explorer.parameters import FIELDS, STEPPING_FIELDS
from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    INTEGRATORS,
    LAWS_BY_RESTITUTION,
    ExactPenalty,
    Method,
    NewmarkBeta,
    Reference,
    System,
    SystemFile,
    TimeStepping,
    read_system,
    stiffness_of_step,
    with_located_steps,
)
from vibroscope.engine.law_table import laws_with, numbers_of
from vibroscope.engine.physical import held_text

# What can be asked of a penalty solution, beside K, D and the steps: its law; of one with a time step also the rest
LAW_OPTIONS = tuple(name for name in STEPPING_FIELDS if FIELDS[name].solvers == ("exact", "newmark"))
STEPPING_OPTIONS = tuple(
    name for name in STEPPING_FIELDS if FIELDS[name].solvers == ("newmark",) and name != "step_scale"
)
INTEGRATOR_NUMBERS = tuple(name for name in STEPPING_OPTIONS if not FIELDS[name].choices)
REFERENCE_OPTIONS = "joint_damping", "restitution", "threshold"
SOLVERS = "reference", "exact", "newmark"
STEP_SCALE = "stiffness_of_step"  # the option of the field "step_scale"
SCHEME_OPTIONS = (*LAW_OPTIONS, *STEPPING_OPTIONS)
PENALTY_OPTIONS = "K", STEP_SCALE, "D", "steps", "located"
CONDITIONS = "reference:", "integrator ", "law ", "status "  # which begin the words of an option that says who has it
# The options of each solver. Restitution belongs to the system, but only the reference has an impact law.
SOLVER_OPTIONS = {solver: [name for name, field in FIELDS.items() if solver in field.solvers] for solver in SOLVERS}
SOLVER_OPTIONS["newmark"] += ["every_step", STEP_SCALE]
NEEDED = {"reference": (), "exact": ("K", "D"), "newmark": ("K", "D", "steps")}
OTHER_ETA = "a --system with frequency_Hz in its table [physical]"
_PAPER = {"eta": 2.76, "K": 12000, "D": 18, "steps": 8000}  # numbers of its Figure 14
FREE_VIBRATION = "nothing drives the bodies: a free vibration from its start, and eta only sets the length of a period"
UNDER_LOAD = f"only constant forces act on the bodies{FREE_VIBRATION.removeprefix('nothing drives the bodies')}"


def default_of(function: Callable, name: str):
    """The engine's own default of a parameter."""
    return signature(function).parameters[name].default


# --- kinds of argument ------------------------------------------------------------------------------------------------


def system_file(path: str) -> SystemFile:
    """The contents of a system file; what it leaves out gets a note on stderr."""
    try:
        found = read_system(path)
    except ValueError as problem:
        raise argparse.ArgumentTypeError(str(problem)) from None
    for text in found.assumed:
        note(f"{path}: {text}")
    return found


# --- the system -------------------------------------------------------------------------------------------------------


def add_system_option(command: argparse.ArgumentParser) -> None:
    """Add ``--system FILE.toml``: as ``file`` the options have the system, by default the paper's, and its units."""
    command.add_argument(
        "--system",
        dest="file",
        metavar="FILE.toml",
        type=system_file,
        default=SystemFile(),
        help="a system other than the paper's; `vibroscope system` prints one to start from. With [physical] or "
        "[units] in it, other numbers may have a unit, as --K '1e6 N/m' and --D '40 N s/m', the damper of an FE code",
    )


def eta_of(options: argparse.Namespace) -> float:
    """η that the options give, or else the system file, which the options then hold as if it were given."""
    given, options.eta = options.eta, options.file.usual_eta if options.eta is None else options.eta
    if options.eta is None:
        raise ValueError(missing_words("the command", {"eta": OTHER_ETA}))
    if given not in (None, options.file.eta):
        note_held(options)
    return options.eta


def note_held(options: argparse.Namespace) -> None:
    """Note on stderr what of the base keeps its amplitude at other frequencies than that of the system file."""
    file = options.file
    held = held_text(file.system.excitation, file.units if file.has_units else None, file.forms)
    if held and file.eta is not None:
        note(f"{held} is held over the frequency".replace("²", "2"))


# --- the solver -------------------------------------------------------------------------------------------------------


def add_fields(
    command: argparse.ArgumentParser, *names: str, solvers: Sequence[str] = (), required: Sequence[str] = (), **how
) -> None:
    """Add an option for each field, as the table of fields says.

    Parameters
    ----------
    command : ArgumentParser
    *names : str
        In the table. With "stiffness_of_step" K can follow the step, in place of ``--K``.
    solvers : sequence of str
        Those that the command has a choice of: then the help says which of them have the option.
    required : sequence of str
        Names of those that have to be given.
    **how : mapping
        By the name of a field, what `argparse` is told in another way.
    """
    either = command.add_mutually_exclusive_group(required="K" in required) if STEP_SCALE in names else command
    for name in names:
        place = either if name in ("K", STEP_SCALE) else command
        needed = {"required": True} if name in required and place is command else {}
        place.add_argument(option(name), **_field(name, solvers) | needed | how.get(name, {}))


def _field(name: str, solvers: Sequence[str]) -> dict[str, object]:
    """What `argparse` is told of a field."""
    field = FIELDS["step_scale" if name == STEP_SCALE else name]
    named = ", ".join(solver for solver in field.solvers if solver in solvers)
    says_so = not named or field.words.startswith(CONDITIONS)
    words = {"help": field.words if says_so else f"{named}: {field.words}"}
    if tuple(field.choices) == ("no", "yes"):
        return words | {"action": "store_true"}
    if field.choices:  # on the page "located" is a switch of its own
        return words | {"choices": CONTACT_STATUSES if name == "status" else tuple(field.choices)}
    metavar = "S" if name == STEP_SCALE else "N" if field.whole else "F"
    return words | {"type": of_field(field.name), "metavar": metavar}


def add_solver_options(command: argparse.ArgumentParser) -> None:
    """Add the problem, the solver and the initial state, for :func:`problem_of`."""
    add_solver(command)
    add_fields(command, "eta")
    add_fields(command, *PENALTY_OPTIONS, solvers=SOLVERS)
    add = command.add_argument
    add("--every-step", action="store_true", help="newmark: take every step, as an FE code must (slower)")
    add_fields(command, *REFERENCE_OPTIONS, *SCHEME_OPTIONS, solvers=SOLVERS)
    add_initial_option(command)
    add_system_option(command)


def add_solver(command: argparse.ArgumentParser, **how) -> None:
    """Add ``--solver``."""
    words = "semi-analytical reference; penalty model without a time step, or by Newmark's method"
    usual = {"required": True, "choices": SOLVERS, "help": words}
    command.add_argument("--solver", **usual | how)


def add_both_solutions(command: argparse.ArgumentParser) -> None:
    """Add what the penalty solution with a time step and the reference beside it are computed from."""
    add_fields(command, "eta", *PENALTY_OPTIONS)
    add_fields(command, *SCHEME_OPTIONS, "joint_damping", "threshold")
    add_initial_option(command)
    add_system_option(command)


def add_initial_option(command: argparse.ArgumentParser, name: str = "initial", more: str = "") -> None:
    """Add ``--initial``; a list that begins with a minus sign is given as ``--initial=-1,0,2,0``."""
    command.add_argument(
        f"--{name}",
        type=state_numbers,
        metavar="x1,v1,x2,v2",
        default=None,
        help=f"state at tau = 0 (default: rest, the static equilibrium), as --{name}=-1,0,2,0"
        f"{more or '; the reference needs an open gap: clearance + x2 - x1 >= 0'}",
    )


def add_run_length(command: argparse.ArgumentParser, usual: str, keep: int, what: str = "report") -> None:
    """Add ``--periods``, with its default in words, and ``--keep``."""
    add = command.add_argument
    add("--periods", type=count, metavar="N", help=f"excitation periods to run ({usual})")
    add("--keep", type=count, metavar="N", help=f"last periods to {what} (default {keep}, or all if fewer are run)")


def kept_periods(options: argparse.Namespace, usual: int) -> int:
    """How many of the last periods are kept: by default so many, or all if fewer are run."""
    return min(usual, options.periods) if options.keep is None else options.keep


def stiffness_of(options: argparse.Namespace) -> float | None:
    """K that the options give, by itself or by the time step; None if neither does."""
    scale = getattr(options, "stiffness_of_step", None)
    if scale is None or options.steps is None:
        return options.K
    return stiffness_of_step(options.file.system, eta_of(options), options.steps, scale)


def problem_of(options: argparse.Namespace) -> tuple[System, float, Method]:
    """The system, eta and method that the options describe."""
    system = system_of_solver(options)
    if not system.excitation.drives:
        loaded = system.excitation.constant1 or system.excitation.constant2
        note(UNDER_LOAD if loaded else FREE_VIBRATION)
    method = method_of(options)
    return system, eta_of(options), method


def system_of_solver(options: argparse.Namespace) -> System:
    """The system, with the restitution that is given for a solver that has it."""
    system, given = options.file.system, options.restitution
    return system if given is None or "restitution" not in _own_options(options) else replace(system, restitution=given)


def _own_options(options: argparse.Namespace) -> tuple[str, ...]:
    """The options of the solver. A law whose damper follows from it has the restitution of the system, too."""
    own = SOLVER_OPTIONS[options.solver]
    follows = getattr(options, "law", None) in LAWS_BY_RESTITUTION and options.D is None
    return (*own, "restitution") if follows else own


def method_of(options: argparse.Namespace) -> Method:
    """The method that the options describe; options of other solvers get a note on stderr."""
    of_all, own = dict.fromkeys(chain(*SOLVER_OPTIONS.values())), _own_options(options)
    note_unused(options, [name for name in of_all if name not in own], f"on the {options.solver} solver")
    refuse_missing(options, options.solver)
    if options.solver == "reference":
        return reference_of(options)
    if options.solver == "exact":
        return ExactPenalty(options.K, options.D, **law_of(options))
    return stepping_of(options)


def law_of(options: argparse.Namespace) -> dict[str, str | float]:
    """The options of the contact law that are given; raises ValueError for a number that the law does not have."""
    given = {name: value for name in LAW_OPTIONS if (value := getattr(options, name, None)) is not None}
    law = given.get("law", CONTACT_LAWS[0])
    for name in given.keys() - {"law", *numbers_of(law)}:
        others = " or ".join(laws_with(name))
        raise ValueError(f"--{name} is no number of the law {law}: leave it out, or give --law {others}")
    return given


def stepping_of(options: argparse.Namespace, **numbers: float) -> TimeStepping:
    """The method with a time step: Newmark's, unless more is asked for.

    ``numbers``: K, D and steps, in place of those that the options give.
    """
    D, n = (numbers.get(name, getattr(options, name, None)) for name in ("D", "steps"))
    K = numbers["K"] if "K" in numbers else stiffness_of(options)
    given = {name: value for name in STEPPING_OPTIONS if (value := getattr(options, name, None)) is not None}
    status = given.pop("status", CONTACT_STATUSES[0])
    located = options.located or status == "located"
    if given.get("integrator") == NewmarkBeta.name:
        del given["integrator"]
    law, every_step = law_of(options), getattr(options, "every_step", False)
    if located and status not in (CONTACT_STATUSES[0], "located"):
        raise ValueError(f"--located is --status located, and goes with no --status {status}")
    kind = INTEGRATORS[given.pop("integrator", NewmarkBeta.name)]
    more = {name: given.pop(name) for name in ("without_solution", "initial_acceleration") if name in given}
    if status != "end":
        note_unused(options, ["without_solution"], "unless --status is end")
    own = [each.name for each in fields(kind)]
    if unknown := [name for name in given if name not in own]:
        has = f"it has {' and '.join(f'--{name}' for name in own)}" if own else "it has no numbers"
        raise ValueError(f"--{unknown[0]} is no number of the integrator {kind.name}: {has}")
    start = CONTACT_STATUSES[0] if located else status
    method = TimeStepping(K, D, n, kind(**given), start, **law, **more, every_step=every_step)
    return replace(with_located_steps(method), every_step=every_step) if located else method


def scheme_of(options: argparse.Namespace) -> TimeStepping:
    """The method that :func:`stepping_of` makes, for a search or a study that finds or varies its numbers."""
    return stepping_of(options, K=1.0, D=0.0, steps=1000)


def refuse_missing(options: argparse.Namespace, solver: str, why: str = "") -> None:
    """Raise ValueError that names all numbers that are not given, of eta and of those that a solver needs, and why."""
    follows = solver == "newmark" and hasattr(options, STEP_SCALE)  # K may follow the step
    instead = {  # whether something else stands for a number, and what that could be
        "eta": (options.file.usual_eta is not None, OTHER_ETA),
        "K": (follows and getattr(options, STEP_SCALE) is not None, option(STEP_SCALE) if follows else ""),
        "D": (
            getattr(options, "law", None) in LAWS_BY_RESTITUTION,
            f"a --law that takes it from the restitution: {', '.join(LAWS_BY_RESTITUTION)}",
        ),
        "steps": (False, ""),
    }
    missing = [name for name in ("eta", *NEEDED[solver]) if getattr(options, name, 0) is None and not instead[name][0]]
    if missing:
        if solver != "reference":  # which has none of them: a number out of range is named first
            given = {name: getattr(options, name, None) for name in ("K", "D", "steps")}  # of a sweep a range of one
            stands = {name: 1000.0 for name, value in given.items() if not isinstance(value, float | int)}
            stepping_of(options, **stands)
        who = f"the {solver} solver" if hasattr(options, "solver") else "a penalty solution"
        raise ValueError(missing_words(who, {name: instead[name][1] for name in missing}) + why)


def missing_words(who: str, missing: Mapping[str, str]) -> str:
    """Which numbers are missing, those of the paper, and what could stand in place of each, where something could."""
    paper = " ".join(f"{option(name)} {_PAPER[name]}" for name in missing)
    others = (f"; in place of {option(name)} {other}" for name, other in missing.items() if other)
    return f"{who} needs {', '.join(map(option, missing))}; the paper's numbers: {paper}{''.join(others)}"


def reference_of(options: argparse.Namespace) -> Reference:
    """The reference, with those of its numbers that the options give."""
    given = {name: getattr(options, name, None) for name in ("joint_damping", "threshold")}
    return Reference(**{name: value for name, value in given.items() if value is not None})


def note_unused(options: argparse.Namespace, names: Iterable[str], where: str) -> None:
    """Note on stderr which of these options are given, and have no effect there."""
    for name in names:
        if getattr(options, name, None) not in (None, False):
            note(f"{option(name)} has no effect {where}")
