"""Options that several commands share, and the objects that they describe."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from inspect import signature

from vibroscope.app.commands.numbers import measured, measured_count, number, state_numbers
from vibroscope.app.commands.output import note
from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    INITIAL_ACCELERATIONS,
    INTEGRATORS,
    LAWS_BY_RESTITUTION,
    NEWMARK_LAWS,
    WITHOUT_SOLUTION,
    ExactPenalty,
    Method,
    Newmark,
    NewmarkBeta,
    Reference,
    System,
    SystemFile,
    TimeStepping,
    Units,
    read_system,
    stiffness_of_step,
)
from vibroscope.engine.law_table import HERTZ, laws_with, numbers_of
from vibroscope.engine.physical import held_text

# What can be asked of a method with a time step, beside its numbers
INTEGRATOR_NUMBERS = "beta", "gamma", "alpha", "rho"
STEPPING_OPTIONS = "integrator", "status", "without_solution", "initial_acceleration", *INTEGRATOR_NUMBERS
LAW_OPTIONS = "law", "exponent", "penetration"
# The options of each solver. Restitution belongs to the system, but only the reference has an impact law.
SOLVER_OPTIONS = {
    "reference": ("joint_damping", "threshold", "restitution"),
    "exact": ("K", "D", *LAW_OPTIONS),
    "newmark": ("K", "D", "steps", "every_step", "located", "stiffness_of_step", *STEPPING_OPTIONS, *LAW_OPTIONS),
}
NEEDED = {"reference": (), "exact": ("K", "D"), "newmark": ("K", "D", "steps")}
FREE_VIBRATION = "nothing drives the bodies: a free vibration from its start, and eta only sets the length of a period"
UNDER_LOAD = f"only constant forces act on the bodies{FREE_VIBRATION.removeprefix('nothing drives the bodies')}"


def default_of(function: Callable, name: str):
    """The engine's own default of a parameter."""
    return signature(function).parameters[name].default


# --- kinds of argument ------------------------------------------------------------------------------------------------


def port_number(text: str) -> int:
    """A TCP port."""
    if not (text.isascii() and text.isdigit() and int(text[:6]) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is no port: give 0 to 65535")
    return int(text)


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

ETA = {
    "type": measured,
    "metavar": "F",
    "help": "excitation frequency Omega/omega1; paper: 1.08 to 3.25 (default: what frequency_Hz of --system gives)",
}


def add_system_option(command: argparse.ArgumentParser) -> None:
    """Add ``--system FILE.toml``, for :func:`system_of` and :func:`units_of`."""
    command.add_argument(
        "--system",
        metavar="FILE.toml",
        type=system_file,
        default=SystemFile(),
        help="a system other than the paper's; `vibroscope system` prints one to start from. With [physical] or "
        "[units] in it, other numbers may have a unit, as --K '1e6 N/m' and --D '40 N s/m', the damper of an FE code",
    )


def system_of(options: argparse.Namespace) -> System:
    """The system that the options describe, by default the paper's."""
    return options.system.system


def eta_of(options: argparse.Namespace) -> float:
    """η that the options give, or else the system file, which the options then hold as if it were given."""
    given, options.eta = options.eta, options.system.eta if options.eta is None else options.eta
    if options.eta is None:
        raise ValueError("--eta is missing: give it, or a system file with a table [physical] and frequency_Hz")
    if given not in (None, options.system.eta):
        note_held(options)
    return options.eta


def note_held(options: argparse.Namespace) -> None:
    """Note on stderr what of the base keeps its amplitude at other frequencies than that of the system file."""
    file = options.system
    held = held_text(file.system.excitation, file.units if file.has_units else None, file.forms)
    if held and file.eta is not None:
        note(f"{held} is held over the frequency".replace("²", "2"))


def units_of(options: argparse.Namespace) -> Units:
    """The units that the options describe, by default the paper's."""
    return options.system.units


# --- the solver -------------------------------------------------------------------------------------------------------

# Of commands with a choice of solvers: before the text of an option, the solvers that have it
OF_SOLVERS = {"both": "exact, newmark: ", "newmark": "newmark: "}
_STIFFNESS = "contact stiffness; the paper uses 100 to 12000"
_DAMPING = "contact damping; the paper uses 8 to 50"
_LAW = "contact law (default: a spring and a damper, which may pull)"


def add_solver_options(command: argparse.ArgumentParser) -> None:
    """Add the problem, the solver and the initial state, for :func:`problem_of`."""
    add = command.add_argument
    add(
        "--solver",
        required=True,
        choices=tuple(SOLVER_OPTIONS),
        help="semi-analytical reference; penalty model without a time step, or by Newmark's method",
    )
    add("--eta", **ETA)
    add_penalty_options(command, **OF_SOLVERS)
    add("--every-step", action="store_true", help="newmark: take every step, as an FE code must (slower)")
    _add_reference_options(command)


def add_branch_options(command: argparse.ArgumentParser) -> None:
    """Add the problem, a solver whose orbits have equations and the initial state, for :func:`problem_of`."""
    add = command.add_argument
    add(
        "--solver",
        default="reference",
        type=_without_step,
        choices=("reference", "exact"),
        help="semi-analytical reference; penalty model without a time step, its contact a spring and a damper (default "
        "%(default)s)",
    )
    add("--eta", **ETA)
    add("--K", type=measured, metavar="F", help=f"exact: {_STIFFNESS}")
    add("--D", type=measured, metavar="F", help=f"exact: {_DAMPING}")
    _add_reference_options(command)


def _without_step(solver: str) -> str:
    """A solver that has branches."""
    if solver == "newmark":
        raise argparse.ArgumentTypeError(
            f"{solver!r} has a time step, and so no branches: give 'reference', or 'exact', to which it tends with "
            "smaller steps"
        )
    return solver


def _add_reference_options(command: argparse.ArgumentParser) -> None:
    """Add the numbers of the reference, the initial state and the system."""
    add = command.add_argument
    add_joint_damping_option(command)
    add(
        "--restitution",
        type=number,
        metavar="F",
        help=f"reference: coefficient of restitution (default: the system's; the paper's is {System().restitution:g})",
    )
    add_threshold_option(command)
    add_initial_option(command)
    add_system_option(command)


def add_initial_option(command: argparse.ArgumentParser) -> None:
    """Add ``--initial``; a list that begins with a minus sign is given as ``--initial=-1,0,2,0``."""
    command.add_argument(
        "--initial",
        type=state_numbers,
        metavar="x1,v1,x2,v2",
        default=None,
        help="state at tau = 0 (default: rest, the static equilibrium), as --initial=-1,0,2,0; the reference needs an "
        "open gap: clearance + x2 - x1 >= 0",
    )


def add_penalty_options(
    command: argparse.ArgumentParser, *, required: bool = False, both: str = "", newmark: str = ""
) -> None:
    """Add ``--K``, ``--D``, ``--steps`` and ``--located``.

    ``required``: whether K and steps have to be given. ``both``, ``newmark``: as in `OF_SOLVERS`.
    """
    add = command.add_argument
    add_stiffness_option(command, f"{both}{_STIFFNESS}", required, newmark=newmark)
    add("--D", type=measured, metavar="F", help=f"{both}{_DAMPING}; some laws need none: --law")
    add(
        "--steps",
        required=required,
        type=measured_count,
        metavar="N",
        help=f"{newmark}steps per excitation period, the time step is T/N; or the longest time step, as '10 us'",
    )
    add("--located", action="store_true", help=f"{newmark}cut each step at a contact change, located within the step")


def add_stiffness_option(
    command: argparse.ArgumentParser, text: str, required: bool = False, follows: bool = True, newmark: str = ""
) -> None:
    """Add ``--K``, and where K can follow the step ``--stiffness-of-step`` in its place."""
    place = command.add_mutually_exclusive_group(required=required)
    place.add_argument("--K", type=measured, metavar="F", help=text)
    if follows:
        place.add_argument(
            "--stiffness-of-step",
            type=number,
            metavar="S",
            help=f"{newmark}K = S m/(time step)^2 instead of --K, m the reduced mass; half the step has four times K",
        )


def stiffness_of(options: argparse.Namespace) -> float | None:
    """K that the options give, by itself or by the time step; None if neither does."""
    scale = getattr(options, "stiffness_of_step", None)
    if scale is None or options.steps is None:
        return options.K
    return stiffness_of_step(system_of(options), eta_of(options), options.steps, scale)


def _add_law_options(command: argparse.ArgumentParser, more: tuple[str, ...], both: str) -> None:
    """Add the contact law and its numbers, for :func:`law_of`."""
    add = command.add_argument
    add(
        "--law",
        choices=(*CONTACT_LAWS, *more),
        help=f"{both}{_LAW}. Without --D those from hunt-crossley to constant-restitution take their damper from the "
        "restitution of the system and the closing speed, by the formula of their authors",
    )
    power = f"power of the penetration in the law, at least 1 (default {HERTZ:g})"
    add("--exponent", type=number, metavar="F", help=power)
    deep = f"law {' or '.join(laws_with('penetration'))}: penetration from which on the damper acts in full"
    add("--penetration", type=measured, metavar="F", help=deep)


def add_integrator_options(command: argparse.ArgumentParser, *more: str, both: str = "", newmark: str = "") -> None:
    """Add the integrator, its numbers, the contact status and the contact law, for :func:`stepping_of`.

    ``more``: what else ``--integrator`` and ``--law`` can be. ``both``, ``newmark``: as in `OF_SOLVERS`.
    """
    _add_law_options(command, more, both)
    add = command.add_argument
    add(
        "--integrator",
        choices=(*INTEGRATORS, *more),
        help=f"{newmark}the one-step method (default newmark); hht averages the forces at both ends of a step, "
        "hht-interpolated takes them at the displacement between, as OpenSees does",
    )
    for option, text in {
        "--beta": "newmark (default 1/4)",
        "--gamma": "newmark; more than 1/2 damps (default 1/2)",
        "--alpha": "hht (default -0.05), hht-interpolated (-0.1): -1/3 to 0 as Hilber writes it; OpenSees' 0.9 is -0.1",
        "--rho": "generalised-alpha (default 0.8), bathe (0): spectral radius at high frequencies, 0 to 1",
    }.items():
        add(option, type=number, metavar="F", help=f"integrator {text}")
    add(
        "--status",
        choices=CONTACT_STATUSES,
        help=f"{newmark}contact status of a step from the gap at its start, iterated until it agrees with the gap at "
        f"its end, or located within the step, as --located (default {CONTACT_STATUSES[0]})",
    )
    add(
        "--without-solution",
        choices=WITHOUT_SOLUTION,
        help="status end: a step in which neither status agrees with its end stops the run, keeps the former status, "
        f"or is halved until all its parts have a solution (default {WITHOUT_SOLUTION[0]})",
    )
    add(
        "--initial-acceleration",
        choices=INITIAL_ACCELERATIONS,
        help=f"{newmark}accelerations at tau = 0 by the equations of motion, or zero, as OpenSees has them "
        f"(default {INITIAL_ACCELERATIONS[0]})",
    )


def add_joint_damping_option(command: argparse.ArgumentParser) -> None:
    """Add ``--joint-damping``, for :func:`reference_of`."""
    command.add_argument(
        "--joint-damping",
        choices=("table", "derived"),
        help="reference: damping of the joined pendulums; derived: only what their own dampers give "
        f"(default {Reference().joint_damping})",
    )


def add_threshold_option(command: argparse.ArgumentParser) -> None:
    """Add ``--threshold``, for :func:`reference_of`."""
    command.add_argument(
        "--threshold",
        type=measured,
        metavar="F",
        help="reference: parting speed that begins permanent contact, in the unit of length times omega1, so that it "
        f"scales with the system (default {Reference().threshold:g}); 0: the limit of the threshold",
    )


def problem_of(options: argparse.Namespace) -> tuple[System, float, Method]:
    """The system, eta and method that the options describe."""
    system = system_of(options)
    if "restitution" in _own_options(options) and options.restitution is not None:
        system = replace(system, restitution=options.restitution)
    if not system.excitation.drives:
        loaded = system.excitation.constant1 or system.excitation.constant2
        note(UNDER_LOAD if loaded else FREE_VIBRATION)
    return system, eta_of(options), method_of(options)


def _own_options(options: argparse.Namespace) -> tuple[str, ...]:
    """The options of the solver. A law whose damper follows from it has the restitution of the system, too."""
    own = SOLVER_OPTIONS[options.solver]
    follows = getattr(options, "law", None) in LAWS_BY_RESTITUTION and options.D is None
    return (*own, "restitution") if follows else own


def method_of(options: argparse.Namespace) -> Method:
    """The method that the options describe; options of other solvers get a note on stderr."""
    note_unused(options)
    by_restitution = getattr(options, "law", None) in LAWS_BY_RESTITUTION
    needed = [name for name in NEEDED[options.solver] if name != "D" or not by_restitution]
    missing = [f"--{name}" for name in needed if getattr(options, name) is None]
    if options.solver == "newmark" and getattr(options, "stiffness_of_step", None) is not None:
        missing = [name for name in missing if name != "--K"]
    refuse_missing(options.solver, missing)
    if options.solver == "reference":
        return reference_of(options)
    if options.solver == "exact":
        return ExactPenalty(options.K, options.D, **law_of(options))
    return stepping_of(options)


def refuse_missing(solver: str, missing: Sequence[str]) -> None:
    """Raise ValueError, with numbers to begin with, if options that a solver needs are missing."""
    if missing:
        steps = " --steps 8000" if solver == "newmark" else ""
        raise ValueError(
            f"the {solver} solver needs {', '.join(missing)}; the paper's numbers for eta 2.76: --K 12000 --D 18{steps}"
        )


def law_of(options: argparse.Namespace) -> dict[str, str | float]:
    """The options of the contact law that are given; raises ValueError for a number that the law does not have."""
    given = {name: value for name in LAW_OPTIONS if (value := getattr(options, name, None)) is not None}
    law = given.get("law", CONTACT_LAWS[0])
    for name in given.keys() - {"law", *numbers_of(law)}:
        others = " or ".join(laws_with(name))
        raise ValueError(f"--{name} is no number of the law {law}: leave it out, or give --law {others}")
    return given


def stepping_of(options: argparse.Namespace, **numbers: float) -> Newmark | TimeStepping:
    """The method with a time step: Newmark's with skipped or located steps, unless more is asked for.

    ``numbers``: K, D and steps, in place of those that the options give.
    """
    D, n = (numbers.get(name, getattr(options, name, None)) for name in ("D", "steps"))
    K = numbers["K"] if "K" in numbers else stiffness_of(options)
    if D is None and getattr(options, "law", None) not in LAWS_BY_RESTITUTION:
        laws = ", ".join(LAWS_BY_RESTITUTION)
        raise ValueError(f"--D is missing: give it, or a --law that takes its damper from the restitution: {laws}")
    given = {name: value for name in STEPPING_OPTIONS if (value := getattr(options, name, None)) is not None}
    status = given.pop("status", CONTACT_STATUSES[0])
    located = options.located or status == "located"
    if given.get("integrator") == NewmarkBeta.name:
        del given["integrator"]
    law, every_step = law_of(options), getattr(options, "every_step", False)
    linear = law.get("law", NEWMARK_LAWS[0]) in NEWMARK_LAWS
    if located and status not in (CONTACT_STATUSES[0], "located"):
        raise ValueError(f"--located is --status located, and goes with no --status {status}")
    if not given and linear and (located or status == CONTACT_STATUSES[0]):
        return Newmark(K, D, n, every_step, located, **law)
    status = "located" if located else status
    kind = INTEGRATORS[given.pop("integrator", NewmarkBeta.name)]
    more = {name: given.pop(name) for name in ("without_solution", "initial_acceleration") if name in given}
    if "without_solution" in more and status != "end":
        note("--without-solution has no effect unless --status is end")
    own = [each.name for each in fields(kind)]
    if unknown := [name for name in given if name not in own]:
        has = f"it has {' and '.join(f'--{name}' for name in own)}" if own else "it has no numbers"
        raise ValueError(f"--{unknown[0]} is no number of the integrator {kind.name}: {has}")
    return TimeStepping(K, D, n, kind(**given), status, **law, **more, every_step=every_step)


def reference_of(options: argparse.Namespace) -> Reference:
    """The reference, with those of its numbers that the options give."""
    given = {name: getattr(options, name, None) for name in ("joint_damping", "threshold")}
    return Reference(**{name: value for name, value in given.items() if value is not None})


def note_unused(options: argparse.Namespace) -> None:
    """Note on stderr which of the given options belong to other solvers."""
    own = _own_options(options)
    for name in dict.fromkeys(name for names in SOLVER_OPTIONS.values() for name in names):
        if name not in own and getattr(options, name, None) not in (None, False):
            note(f"--{name.replace('_', '-')} has no effect on the {options.solver} solver")
