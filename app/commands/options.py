"""What several commands share: the parser that speaks in one line, kinds of argument, and the solver asked for."""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from inspect import signature

from vibroscope.engine import ExactPenalty, Method, Newmark, Reference, System, SystemFile, Units, read_system

# what each solver takes, and of that needs; restitution belongs to the system, yet only the reference has an impact law
SOLVER_OPTIONS = {
    "reference": ("joint_damping", "threshold", "restitution"),
    "exact": ("K", "D"),
    "newmark": ("K", "D", "steps", "every_step", "located"),
}
NEEDED = {"reference": (), "exact": ("K", "D"), "newmark": ("K", "D", "steps")}


class OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line and exits with status 2."""

    def error(self, message: str):
        """Print the line; point to --help."""
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def default_of(function: Callable, name: str):
    """The engine's own default of a parameter."""
    return signature(function).parameters[name].default


def numbers(text: str) -> tuple[float, ...]:
    """Comma-separated numbers."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers: give x1,v1,x2,v2") from None


def port_number(text: str) -> int:
    """A TCP port."""
    if not (text.isascii() and text.isdigit() and int(text[:6]) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is no port: give 0 to 65535")
    return int(text)


def note_unused(options: argparse.Namespace) -> None:
    """Say on stderr which of the options given belong to other solvers."""
    own = SOLVER_OPTIONS[options.solver]
    for name in dict.fromkeys(name for names in SOLVER_OPTIONS.values() for name in names):
        if name not in own and getattr(options, name, None) not in (None, False):
            print(
                f"vibroscope: --{name.replace('_', '-')} has no effect on the {options.solver} solver", file=sys.stderr
            )


def reference_of(options: argparse.Namespace) -> Reference:
    """The reference, with what is given of its numbers."""
    given = {name: getattr(options, name, None) for name in ("joint_damping", "threshold")}
    return Reference(**{name: value for name, value in given.items() if value is not None})


def method_of(options: argparse.Namespace) -> Method:
    """The solver that the options ask for; options of other solvers get a note on stderr."""
    note_unused(options)
    missing = [f"--{name}" for name in NEEDED[options.solver] if getattr(options, name) is None]
    if missing:
        raise ValueError(
            f"the {options.solver} solver needs {', '.join(missing)}; the paper's numbers for eta 2.76: "
            f"--K 12000 --D 18{' --steps 8000' if options.solver == 'newmark' else ''}"
        )
    if options.solver == "reference":
        return reference_of(options)
    if options.solver == "exact":
        return ExactPenalty(options.K, options.D)
    return Newmark(options.K, options.D, options.steps, every_step=options.every_step, located=options.located)


def add_solver_options(command: argparse.ArgumentParser) -> None:
    """What is solved, how, and from where, for :func:`problem_of`."""
    add, usual = command.add_argument, Reference()
    add(
        "--solver",
        required=True,
        choices=tuple(SOLVER_OPTIONS),
        help="semi-analytical reference; penalty model without a time step, or by Newmark",
    )
    add("--eta", required=True, type=float, metavar="F", help="excitation frequency Omega/omega1; paper: 1.08 to 3.25")
    add("--K", type=float, metavar="F", help="exact, newmark: contact stiffness")
    add("--D", type=float, metavar="F", help="exact, newmark: contact damping")
    add("--steps", type=float, metavar="N", help="newmark: steps per excitation period, the time step is T/N")
    add("--every-step", action="store_true", help="newmark: walk through every step, as an FE code must (slower)")
    add("--located", action="store_true", help="newmark: cut the steps at each contact change, located within the step")
    add(
        "--joint-damping",
        choices=("table", "derived"),
        help=f"reference: damping of the joined pendulums (default {usual.joint_damping})",
    )
    add(
        "--restitution",
        type=float,
        metavar="F",
        help=f"reference: coefficient of restitution (default: the system's; the paper's is {System().restitution:g})",
    )
    add(
        "--threshold",
        type=float,
        metavar="F",
        help=f"reference: parting speed that begins permanent contact (default {usual.threshold:g}); 0: its limit",
    )
    add(
        "--initial",
        type=numbers,
        metavar="x1,v1,x2,v2",
        default=(0.0, 0.0, 0.0, 0.0),
        help="state at tau = 0 (default rest); the reference needs x2 >= x1",
    )
    add_system_option(command)


def problem_of(options: argparse.Namespace) -> tuple[System, float, Method]:
    """System, eta and method that the options ask for."""
    system = system_of(options)
    if options.solver == "reference" and options.restitution is not None:  # the penalty model knows no impact law
        system = replace(system, restitution=options.restitution)
    return system, options.eta, method_of(options)


def add_system_option(command: argparse.ArgumentParser) -> None:
    """``--system FILE.toml``, for :func:`system_of` and :func:`units_of`."""
    command.add_argument(
        "--system",
        metavar="FILE.toml",
        type=system_file,
        default=SystemFile(),
        help="a system other than the paper's; `vibroscope system` prints one to start from",
    )


def system_file(path: str) -> SystemFile:
    """A system file that was read."""
    try:
        return read_system(path)
    except ValueError as problem:
        raise argparse.ArgumentTypeError(str(problem)) from None


def system_of(options: argparse.Namespace) -> System:
    """The system that the options ask for, by default the paper's."""
    return options.system.system


def units_of(options: argparse.Namespace) -> Units:
    """The units to show results in, by default the paper's."""
    return options.system.units
