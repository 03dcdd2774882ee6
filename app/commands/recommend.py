"""``vibroscope recommend``: which K, D and steps to set instead."""

import argparse
import json
import math
import sys

from vibroscope.app.commands.options import add_system_option, default_of, system_of
from vibroscope.app.commands.physical import add_units_option, settings_text, wanted_units
from vibroscope.engine import Recommendation, Reference, Units, design_curve, recommend

ETAS_LIMIT = 1000


def add(commands) -> None:
    """``vibroscope recommend``."""
    command = commands.add_parser(
        "recommend",
        allow_abbrev=False,
        help="find K, D and steps that meet a tolerance at the least cost",
        description="Find the contact stiffness K, the contact damping D and the steps per period with which Newmark's "
        "method keeps to the reference at the least number of steps. The error is the rms difference of the "
        "displacements over 50 periods, relative to the reference. Every setting told was run from rest, and with "
        "it half the step and neighbours with other n (2 %%), K and D (1 %%): it does not meet the tolerance by luck.",
        epilog="A tolerance that nothing meets is a result, with the reason; the exit status is 2 only for bad input.",
    )
    add = command.add_argument
    where = command.add_mutually_exclusive_group(required=True)
    where.add_argument("--eta", type=float, metavar="F", help="excitation frequency Omega/omega1; paper: 1.08 to 3.25")
    where.add_argument("--eta-range", type=eta_range, metavar="A:B:N", help="N frequencies from A to B: a design curve")
    add("--tolerance", type=float, metavar="F", help="largest relative error (default %(default)s)")
    add("--located", action="store_true", help="steps cut at contact changes only; the least solves per period")
    add("--joint-damping", choices=("table", "derived"), help="of the reference (default %(default)s)")
    add("--K-max", type=float, metavar="F", help="largest K to try (default %(default)g)")
    add("--steps-max", type=float, metavar="N", help="most steps per period to try (default %(default)s)")
    add_units_option(command)
    add_system_option(command)
    add("--json", action="store_true", help="print one JSON object (a list of them for --eta-range)")
    usual = {"tolerance": "tolerance", "K_max": "stiffness_max", "steps_max": "steps_max"}  # option: the engine's name
    command.set_defaults(**{ours: default_of(recommend, theirs) for ours, theirs in usual.items()})
    command.set_defaults(run=run, joint_damping=Reference().joint_damping)


def eta_range(text: str) -> list[float]:
    """``A:B:N`` as N numbers from A to B."""
    try:
        first, last, count = text.split(":")
        low, high, n = float(first), float(last), int(count)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not A:B:N: give 2.6:2.9:7 for seven frequencies") from None
    if not 2 <= n <= ETAS_LIMIT:
        raise argparse.ArgumentTypeError(f"N = {n} is outside [2, {ETAS_LIMIT}]: give the number of frequencies")
    return [low + (high - low) * i / (n - 1) for i in range(n)]


def run(options: argparse.Namespace) -> None:
    """Search and print."""
    asked = {
        "tolerance": options.tolerance,
        "reference": Reference(options.joint_damping),
        "stiffness_max": options.K_max,
        "steps_max": options.steps_max,
        "progress": _progress() if sys.stderr.isatty() else None,
    }
    system, units = system_of(options), wanted_units(options)
    if options.eta_range:
        found = design_curve(system, options.eta_range, located=options.located, **asked)
        print(
            json.dumps([as_json(one, units) for one in found], allow_nan=False) if options.json else curve_text(found)
        )
    elif options.json:
        found = recommend(system, options.eta, located=options.located, **asked)
        print(json.dumps(as_json(found, units), allow_nan=False))
    else:
        for located in (True,) if options.located else (False, True):
            print(as_text(recommend(system, options.eta, located=located, **asked), units), flush=True)


def as_json(found: Recommendation, units: Units | None = None) -> dict:
    """The contract for scripts; numbers that do not exist are null."""
    best = found.best
    k, d, n = best.setting if best else (None, None, None)
    numbers = {
        "eta": found.eta,
        "tolerance": found.tolerance,
        "located": found.located,
        "K": k,
        "D": d,
        "steps": n,
        "error": best and best.error,
        "robust": best and best.robust,
        "solves": best and best.cost,
        "met": found.met,
        "front": [_row(trial) for trial in found.front],
        "front_solves": [trial.cost for trial in found.front],
        "joint_damping": None if math.isnan(found.joint_damping) else found.joint_damping,
        "compensated": found.compensated,
        "reason": found.reason,
    }
    if units is not None and best:
        numbers["physical"] = units.settings(found.eta, found.method)
    return numbers


def _row(trial) -> list[float]:
    k, d, n = trial.setting
    return [n, trial.error, k, d]


def as_text(found: Recommendation, units: Units | None = None) -> str:
    """The same for people."""
    kind = "steps cut at contact changes" if found.located else "constant step"
    lines = [f"eta = {found.eta:g}, {kind}, tolerance {_percent(found.tolerance)}"]
    if not found.met:
        lines.append(f"not met           {found.reason}")
    if found.best is None:
        return "\n".join(lines)
    k, d, n = found.best.setting
    lines += [
        f"{'set' if found.met else 'best found':18s}K = {k:g}, D = {d:g}, {n} steps per period",
        f"error             {_percent(found.best.error)}; {_percent(found.best.robust)} is kept to with half the step "
        "and by 9 in 10 neighbours",
    ]
    if found.located:
        lines.append(f"cost              {found.best.cost:.1f} solves per period")
    if found.compensated:
        part = _percent(found.joint_damping)
        lines.append(
            f"mind              the joint damping alone makes {part}: errors cancel here, and need not elsewhere"
        )
    if units is not None:
        lines.append(f"physical          {settings_text(units, found.eta, found.method)}")
    lines.append("front             steps  solves     error    robust         K         D")
    for trial in found.front:
        k, d, n = trial.setting
        lines.append(
            f"{n:23d} {trial.cost:7.0f} {_percent(trial.error):>9s} {_percent(trial.robust):>9s} {k:9g} {d:9g}"
        )
    return "\n".join(lines)


def curve_text(found: list[Recommendation]) -> str:
    """One line an η."""
    lines = ["    eta         K         D   steps  solves     error    robust  met"]
    for one in found:
        if one.best is None:
            lines.append(f"{one.eta:7.4f}  {one.reason.split(' (')[0]}")
            continue
        (k, d, n), best = one.best.setting, one.best
        error, robust = _percent(best.error), _percent(best.robust)
        met = "yes" if one.met else f"no: {one.reason.split(':')[0]}"
        lines.append(f"{one.eta:7.4f} {k:9g} {d:9g} {n:7d} {best.cost:7.0f} {error:>9s} {robust:>9s}  {met}")
    return "\n".join(lines)


def _percent(value: float) -> str:
    return f"{100 * value:.3g} %"


def _progress():
    """Prints the share that is done over itself on the terminal."""

    def told(share: float) -> None:
        print(f"\rsearching {100 * share:3.0f} %", end="\n" if share >= 1 else "", file=sys.stderr, flush=True)

    return told
