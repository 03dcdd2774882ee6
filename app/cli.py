"""The command line: ``vibroscope simulate | serve | bench | stability | diagram | warm``."""

import argparse
import gc
import json
import os
import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version

from engine import ExactPenalty, Method, Newmark, Reference, Response, Steady, System, motion, simulate, steady

DESCRIPTION = """\
Is what a penalty contact model shows the motion, or an artefact of K, D or the time step?
Two pendulums on a shaken base hit, chatter, stick and part; a semi-analytical reference
and the penalty model (Newmark, constant step) are solved and compared."""

EXAMPLES = """\
examples:
  vibroscope serve                                  open the explorer on this machine
  vibroscope simulate --solver reference --eta 1.08
  vibroscope simulate --solver newmark --eta 2.76 --K 12000 --D 18 --steps 8000 --json
  vibroscope simulate --solver exact --eta 2.76 --K 12000 --D 18
"""

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


def build_parser() -> argparse.ArgumentParser:
    """The whole command line."""
    parser = OneLineParser(
        prog="vibroscope",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"vibroscope {version('vibroscope')}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=OneLineParser)
    add_simulate(commands)
    add_serve(commands)
    bench = commands.add_parser(
        "bench", allow_abbrev=False, help="measure cost and error of every solver (half a minute)"
    )
    bench.add_argument("--json", action="store_true", help="print one JSON object")
    stability = commands.add_parser(
        "stability", allow_abbrev=False, help="run the hard cases; exit status 1 if any is not as expected"
    )
    stability.add_argument("--json", action="store_true", help="print one JSON list")
    write = commands.add_parser(
        "diagram", help="recompute the bifurcation diagrams that are shipped (some ten seconds)"
    )
    write.add_argument("--write", action="store_true", required=True, help="write them into assets/diagrams")
    commands.add_parser("warm", help="compile every kernel now, so that the first start is quick")
    return parser


def add_simulate(commands) -> None:
    """``vibroscope simulate``."""
    command = commands.add_parser(
        "simulate",
        allow_abbrev=False,
        help="run one solver and print what moves",
        description="Run one solver from rest (or --initial) and report the last --keep periods. All numbers are "
        "non-dimensional: time is counted in 1/omega1, lengths in base amplitudes.",
        epilog="A run that blows up prints its status and the step; the exit status is 2 only for bad input.",
    )
    add = command.add_argument
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
    add("--periods", type=float, default=2050, metavar="N", help="excitation periods to run (default %(default)s)")
    add("--keep", type=float, metavar="N", help="last periods to report (default 50, or all if fewer are run)")
    add(
        "--joint-damping",
        choices=("table", "derived"),
        help="reference: damping of the joined pendulums (default table)",
    )
    add("--restitution", type=float, metavar="F", help="reference: coefficient of restitution (default 0.5)")
    add(
        "--threshold",
        type=float,
        metavar="F",
        help="reference: parting speed that begins permanent contact (default 0.002); 0: its limit",
    )
    add(
        "--initial",
        type=numbers,
        metavar="x1,v1,x2,v2",
        help="state at tau = 0 (default rest); the reference needs x2 >= x1",
    )
    add(
        "--steady",
        action="store_true",
        help="reference, exact: find the steady motion without its transient (Newton's method on the Poincare map); "
        "if there is none, the usual run of 2050 periods; --periods and --keep have no effect",
    )
    add("--json", action="store_true", help="print one JSON object")


def add_serve(commands) -> None:
    """``vibroscope serve``."""
    command = commands.add_parser("serve", allow_abbrev=False, help="start the explorer")
    command.add_argument(
        "--port",
        type=port_number,
        default=5006,
        metavar="N",
        help="port to listen on; 0 takes a free one (default %(default)s)",
    )
    command.add_argument(
        "--address", default="127.0.0.1", help="address to listen on (default %(default)s: this machine only)"
    )
    command.add_argument(
        "--origin",
        action="append",
        metavar="HOST:PORT",
        help="host that browsers may use, if not the address itself; may be repeated",
    )
    command.add_argument("--show", action="store_true", help="open it in a browser")


def with_signs(arguments: Sequence[str]) -> list[str]:
    """The arguments with ``--initial -1,0,0,0`` as one word, since argparse takes -1,0,0,0 for an option."""
    words: list[str] = []
    for word in arguments:
        if words and words[-1] == "--initial":
            words[-1] = f"--initial={word}"
        else:
            words.append(word)
    return words


def port_number(text: str) -> int:
    """A TCP port."""
    if not (text.isascii() and text.isdigit() and int(text[:6]) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is no port: give 0 to 65535")
    return int(text)


def numbers(text: str) -> tuple[float, ...]:
    """Comma-separated numbers."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers: give x1,v1,x2,v2") from None


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


def run_simulate(options: argparse.Namespace) -> None:
    """Simulate and print."""
    hard = options.solver == "reference" and options.restitution is not None  # the penalty model knows no impact law
    system = System(restitution=options.restitution) if hard else System()
    keep = min(50, options.periods) if options.keep is None else options.keep
    start = (0.0, 0.0, 0.0, 0.0) if options.initial is None else options.initial
    if options.steady:
        found = steady(system, options.eta, method_of(options), initial=start)
        print(
            json.dumps(steady_as_json(found, options.solver), allow_nan=False) if options.json else steady_text(found)
        )
        return
    response = simulate(system, options.eta, method_of(options), periods=options.periods, keep=keep, initial=start)
    if options.json:
        print(json.dumps(as_json(response, options.solver), allow_nan=False))
    else:
        print(as_text(response))


def as_json(response: Response, solver: str) -> dict:
    """The contract for scripts."""
    return {
        "solver": solver,
        "eta": response.eta,
        "periods": response.periods,
        "keep": response.keep,
        "status": str(response.status),
        "message": response.message,
        "section": response.section.tolist(),
        "impacts": [
            list(pair)
            for pair in zip(response.impacts.time.tolist(), response.impacts.closing_speed.tolist(), strict=True)
        ],
        "contacts": response.contacts.tolist(),
        "seconds": response.cost.seconds,
    }


def steady_as_json(found: Steady, solver: str) -> dict:
    """The same of a steady motion, whose section holds one cycle; the run that it falls back to has the rest."""
    numbers = as_json(found.response, solver)
    return numbers | {
        "message": numbers["message"] or found.message,
        "periodic": found.periodic,
        "period": found.period,
        "multipliers": [[value.real, value.imag] for value in found.multipliers.tolist()],
        "residual": found.residual if found.periodic else None,
        "periods_run": found.periods,
    }


def steady_text(found: Steady) -> str:
    """The same for people."""
    if not found.periodic:
        return f"{as_text(found.response)}\n{found.message}"
    response, p = found.response, found.period
    begin, end = response.window
    spans = response.contacts.clip(begin, end)
    share = (spans[:, 1] - spans[:, 0]).sum() / (end - begin)
    begun = (response.contacts[:, 0] > begin).sum()
    multipliers = ", ".join(
        f"{value:.6g}" if value.imag else f"{value.real:.6g}" for value in found.multipliers.tolist()
    )
    state = ", ".join(f"{value:.6g}" for value in found.state)
    return "\n".join(
        [
            f"{response.method}",
            f"eta = {response.eta:g}, steady motion found by running {found.periods} periods",
            f"motion            repeats every {'period' if p == 1 else f'{p} periods'}, to {found.residual:.2g}",
            f"multipliers       {multipliers}, {'stable' if found.stable else 'unstable'}",
            f"impacts           {len(response.impacts) / p:g} per period",
            f"contacts          {begun / p:g} per period, {100 * share:.2f} % of the time",
            f"section           xi1, xi1', xi2, xi2' = {state}",
        ]
    )


def as_text(response: Response) -> str:
    """The same for people."""
    lines = [
        f"{response.method}",
        f"eta = {response.eta:g}, {response.periods} periods, the last {response.keep} kept",
        f"solved in {response.cost.seconds * 1e3:.2f} ms",
    ]
    if not response.ok:
        return "\n".join([*lines, f"{response.status}: {response.message}"])
    found = motion(response)
    repeats = {0: f"does not repeat within {response.keep // 2} periods", 1: "repeats every period"}
    if response.keep < 4:
        repeats[0] = f"{response.keep} kept periods are too few to tell"
    last = ", ".join(f"{value:.6g}" for value in response.section[-1])
    lines += [
        f"motion            {repeats.get(found.period, f'repeats every {found.period} periods')}",
        f"impacts           {found.impacts_per_period:g} per period",
        f"contacts          {found.contacts_per_period:g} per period, {100 * found.contact_share:.2f} % of the time",
        f"section at end    xi1, xi1', xi2, xi2' = {last}",
        f"spread of xi2     {found.spread:.3g}",
    ]
    return "\n".join(lines)


def run_serve(options: argparse.Namespace) -> None:
    """Start the explorer; the first scene is solved while the page's packages are imported, which takes longer."""
    from . import compute

    gc.disable()  # importing makes a million objects and no garbage; looking for it would take half a second
    compute.warm()
    from .main import serve

    gc.freeze()
    gc.enable()
    # Panel's server ends gracefully on an interrupt; a service manager sends the other signal
    signal.signal(signal.SIGTERM, lambda number, frame: signal.raise_signal(signal.SIGINT))
    try:
        serve(address=options.address, port=options.port, show=options.show, origins=options.origin)
    except BrokenPipeError:  # whoever read the output has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as problem:
        raise OSError(f"cannot listen on {options.address}:{options.port}: {problem.strerror}") from problem


def run_bench(options: argparse.Namespace) -> None:
    """Measure and print."""
    from . import bench

    found = bench.report()
    print(json.dumps(found, allow_nan=False) if options.json else bench.as_text(found))


def run_stability(options: argparse.Namespace) -> int:
    """Run the hard cases and print."""
    from . import stability

    return stability.run(as_json=options.json)


def run_diagram(options: argparse.Namespace) -> None:
    """Write the shipped diagrams anew."""
    from engine import ship_diagrams

    for path in ship_diagrams():
        print(path)


def run_warm(options: argparse.Namespace) -> None:
    """Compile, or load, every kernel."""
    newmark = Newmark(2500.0, 8.0, 2000)
    for method in (
        Reference(),
        ExactPenalty(2500.0, 8.0),
        newmark,
        replace(newmark, every_step=True),
        replace(newmark, located=True),
    ):
        simulate(System(), 1.08, method, periods=2, keep=1)
    steady(System(), 1.08, Reference())


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    options = build_parser().parse_args(with_signs(sys.argv[1:] if arguments is None else arguments))
    try:
        status = globals()[f"run_{options.command}"](options)
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read the output has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as problem:
        print(f"vibroscope {options.command}: {problem.strerror or problem}", file=sys.stderr)
        return 1
    except ValueError as problem:
        print(f"vibroscope {options.command}: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return status or 0
