"""What several commands share: the parser that speaks in one line, kinds of argument, and the solver asked for."""

import argparse
import sys

from engine import ExactPenalty, Method, Newmark, Reference, System, SystemFile, Units, read_system

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


def method_of(options: argparse.Namespace) -> Method:
    """The solver that the options ask for; options of other solvers get a note on stderr."""
    own = SOLVER_OPTIONS[options.solver]
    for name in dict.fromkeys(name for names in SOLVER_OPTIONS.values() for name in names):
        if name not in own and getattr(options, name) not in (None, False):
            print(
                f"vibroscope: --{name.replace('_', '-')} has no effect on the {options.solver} solver", file=sys.stderr
            )
    missing = [f"--{name}" for name in NEEDED[options.solver] if getattr(options, name) is None]
    if missing:
        raise ValueError(
            f"the {options.solver} solver needs {', '.join(missing)}; the paper's numbers for eta 2.76: "
            f"--K 12000 --D 18{' --steps 8000' if options.solver == 'newmark' else ''}"
        )
    if options.solver == "reference":
        given = {name: getattr(options, name) for name in ("joint_damping", "threshold")}
        return Reference(**{name: value for name, value in given.items() if value is not None})
    if options.solver == "exact":
        return ExactPenalty(options.K, options.D)
    return Newmark(options.K, options.D, options.steps, every_step=options.every_step, located=options.located)


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
