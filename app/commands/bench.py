"""``vibroscope bench``: cost and error of every solver."""

import argparse
from collections.abc import Iterator

from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.report import Report


def run(options: argparse.Namespace) -> Report:
    """Measure."""
    from vibroscope.app.performance import bench  # compiles the plain loop, which no other command needs

    report = bench.report()
    return Report(_lines(report), report)


def _lines(report: dict) -> Iterator[str]:
    """The report of `app.performance.bench` as tables, one a scene."""
    machine, version = report["machine"], report["heyoka"]
    yield (
        f"{machine['processor']}, {machine['cores']} cores; heyoka {version or 'not installed'}; "
        f"{report['periods']} periods from rest, medians of {report['rounds']} rounds; error after "
        f"{report['error_after_periods']} periods"
    )
    for key, scene in report["scenes"].items():
        yield f"\n[{key}] eta = {scene['eta']:g}, K = {scene['K']:g}, D = {scene['D']:g}"
        yield from _table(scene)


def _table(scene: dict) -> list[str]:
    """One row a solver, what a step costs, and notes."""
    errors, heyoka = scene["errors"], scene["heyoka_us_per_period"]
    heyoka_penalty = scene["heyoka_penalty_us_per_period"]
    rows = [
        f"  {'':34}{'us per period':>14}{'error':>12}",
        _row("reference", scene["reference_us_per_period"], errors["reference"]),
        _row("heyoka", heyoka, errors["heyoka"], scene["heyoka_over_reference"]),
        _row("exact penalty", scene["exact_us_per_period"], errors["exact"]),
        _row("heyoka, penalty", heyoka_penalty, errors["heyoka_penalty"], scene["heyoka_over_exact"]),
    ]
    for n, fast in scene["newmark_fast_us_per_period"].items():
        ratio, located = scene["newmark_plain_over_fast"][n], scene["newmark_located_us_per_period"][n]
        rows += [
            _row(f"Newmark T/{n}", fast, errors["newmark_fast"][n]),
            _row(f"Newmark T/{n}, plain loop", fast * ratio, errors["newmark_plain"][n], ratio),
            _row(f"Newmark T/{n}, located", located, errors["newmark_located"][n]),
        ]
    step = (
        f"a step costs {scene['newmark_plain_ns_per_step']:.1f} ns in the plain loop, "
        f"{scene['newmark_every_step_ns_per_step']:.1f} ns in ours (--every-step)"
    )
    return [*rows, *(f"  {line}" for line in (step, *scene["notes"]))]


def _row(name: str, cost: float | None, error: float | None, ratio: float | None = None) -> str:
    cells = "-" if cost is None else f"{cost:.3f}", "-" if error is None else f"{error:.1e}"
    return f"  {name:34}{cells[0]:>14}{cells[1]:>12}" + ("" if ratio is None else f"{ratio:10.1f} x ours")


COMMAND = Command(
    "measure cost and error of every solver (half a minute)",
    "Measure microseconds per period and the error of every solver on scenes of the paper, beside heyoka where it is "
    "installed.",
    run=run,
    json="one JSON object",
)
