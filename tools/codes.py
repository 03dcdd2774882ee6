"""What other codes give for the same problems: runs their decks, and prints a table of how far they agree with ours.

    make codes                                           # runs all and writes docs/validation/codes.md
    .venv/bin/python -m tools.codes                      # runs all, prints the page

OpenSees and MuJoCo are run where openseespy and mujoco can be imported (group `codes` of pyproject.toml), CalculiX
where there is a command ccx (Debian: calculix-ccx). A code that is not there is left out, with the reason.
"""

import argparse
import platform
import sys
import tempfile
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from vibroscope.app.export.decks import DeckProblem
from vibroscope.engine.sweeps.digest import solver_digest

from tools import drops
from tools.hertz_codes import compare_law, is_offered, law_cells, law_problems
from tools.mujoco_code import CASES, IMPEDANCE, PERIODS, compare_mujoco, mujoco_version
from tools.mujoco_code import STEPS as MUJOCO_STEPS
from tools.other_codes import (
    STEPS,
    TOLERANCE,
    Row,
    as_spring2,
    calculix_problems,
    calculix_version,
    compare_calculix,
    compare_opensees,
    default_tolerance,
    end_inertia,
    opensees_version,
    problems,
    repeated,
)

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "validation" / "codes.md"

_PAGE = """\
# Other codes beside ours

Written by `make codes` on {date}, with {codes}; {machine}, Python {python}. Solvers: {solvers}.

OpenSees and CalculiX run the deck that `vibroscope export` writes: the paper's pendulums, a spring and a damper as
contact, from rest. Displacements are in base amplitudes.

## OpenSees

{opensees}

### Materials of Hertz

{hertz}

## CalculiX

{calculix}

## MuJoCo

{mujoco}

## One drop

A body of 1 kg meets the ground at 1 m/s, with K = {stiffness:g} N/m and c = {damping:g} N·s/m in each code's own words
(`vibroscope codes translate`), and leaves it; it touches in the middle of a step. Ours is the same touch of One impact.

{drops}

## Not run

Abaqus and Ansys need licences, and no tool for Modelica is at hand: their decks are written from the manuals, and tests
check their text alone.

Chrono could not be had: the wheel `pychrono` is another package, of decorators.
"""

_OPENSEES = """\
Ten periods with `ViscoelasticGap`, contact status iterated to the end of the step (`TimeStepping` with the status "end"
and the initial acceleration "zero", as OpenSees begins unless accelerations are given), iterations to
{tolerance}. The difference is the largest of displacements and velocities after ten periods.

{table}

In all {steps} steps of these runs OpenSees' step is one that our step matrices give from the same state, to {own}.
Where it stops, they give none: it stops in {stops} of {runs} runs, each time in the step that is predicted.

**Other solution.** Where both contact statuses agree with their own end, ours keeps the former one, OpenSees that of
its iterations.

**Growth.** "a a step grows to b, ours to c": steps from the same state agree to a, the runs to b after ten periods,
and two of ours to c if each step of one is off by a.

**Solutions that Newton's iterations do not find.** The tangent of `ViscoelasticGap` leaves out its damper, so that the
iterations may cycle. The deck then tries OpenSees' Krylov-Newton algorithm. Of the runs with T/500,
Newton's alone stop:

{repeated}

**Generalised-α.** `HHTGeneralized`, with one number ρ∞, is the method of Chung and Hulbert. `GeneralizedAlpha` is not:
from the second iteration on its update hands over the acceleration at the end of the step, not the one between (in its
source: `theModel->setResponse(*Ualpha,*Ualphadot,*Udotdot)`). At η = 2.76, K = 12000, D = 18, T/2000, ρ∞ = 0.8 its
steps differ from generalised-α by up to {proper}, and by {end} from the same method with the inertia at the end of the
step. That method is of first order, and without dampers its spectral radius is {apart} apart
and {contact} in contact, so that it amplifies with every step. The deck therefore has `HHTGeneralized`.

**TR-BDF2.** OpenSees counts each half as a step; the deck takes two of them. **HHT**: its α is 1 + ours, with forces at
the interpolated displacement (`hht-interpolated`)."""

_CALCULIX = """\
Displacements have seven digits in its output. Its HHT method averages the forces of both ends, as `hht` does.

{table}

With a damper a contact pair of the type surface to surface stands for the contact, without one `SPRINGA` with a table.

**Tolerance.** The deck sets 1e-8 for residuals and corrections. With the default, 0.5 % and 1 %, the first row is off
by {default} after two periods. `SPRING2` with the same table needs the tighter one: it is off by {loose} with the
default, and by {tight} with 1e-8.

**Energy.** CalculiX checks the energy of an impact, too: at T/500 it stops at the first touch after the start
("solution seems to diverge"), where its iterations have converged."""


_MUJOCO = """\
The same pendulums with springs, dampers and loads as applied forces, so that the contact alone is MuJoCo's, in steps of
semi-implicit Euler. There is no deck: this contact is a law of accelerations. With `solref="-k -b"` and a
constant impedance d in `solimp` its force is, by its documentation,

    λ = max(0, (−kg/d − bg′/d − a₀) d/A),    A = 1/m₁ + 1/m₂,

a₀ being the acceleration of the gap without contact. Here d = {impedance}, the largest that MuJoCo takes, k = KAd and
b = 2DAd. Ours is spring and damper cut at zero, with the contact status from the start of the step (`cut`, `start`,
`semi-implicit-euler`), for {periods} periods.

{table}

In all steps MuJoCo's is that of the formula to {own}. What differs from spring and damper is a₀: springs and loads do
not act on the gap while the bodies touch. With shorter steps this remains."""


_HERTZ = """\
Newmark's method, the damper by the formula of each law with e = 0.5, ten periods.

{table}

In all {steps} steps of its runs `JankowskiImpact` gives the step that ours gives from the same state, to {own}: what
stays of its iterations. `Hertzdamp`
takes the closing speed at the end of its first step in contact, ours that at touch. Its damper is set to zero where a
trial of an iteration opens the gap, and stays so for the rest of the contact. Such trials are frequent, since the
tangents of both materials have the wrong sign in their source (`trialTangent = -n*...`)."""


def main() -> None:
    """Run all and print the page, or write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.relative_to(ROOT)}")
    options = parser.parse_args()
    versions = {"OpenSeesPy": opensees_version(), "CalculiX": calculix_version(), "MuJoCo": mujoco_version()}
    missing = [name for name, found in versions.items() if found is None]
    if missing and options.write:
        sys.exit(f"{' and '.join(missing)} cannot be run here: the page is not written")
    with tempfile.TemporaryDirectory() as folder:
        text = _PAGE.format(
            date=datetime.now(UTC).strftime("%d %B %Y"),
            codes=", ".join(f"{name} {found}" for name, found in versions.items() if found),
            machine=f"{platform.system()} {platform.machine()}",
            python=platform.python_version(),
            solvers=solver_digest(),
            opensees=opensees_text(Path(folder)) if versions["OpenSeesPy"] else "Cannot be imported here.",
            hertz=hertz_text(Path(folder)) if versions["OpenSeesPy"] else "Not run here.",
            calculix=calculix_text(Path(folder)) if versions["CalculiX"] else "There is no command ccx here.",
            mujoco=mujoco_text() if versions["MuJoCo"] else "Cannot be imported here.",
            stiffness=drops.STIFFNESS,
            damping=drops.DAMPING,
            drops=drops_text(),
        )
    print(text, end="")
    if options.write:
        PAGE.parent.mkdir(exist_ok=True)
        PAGE.write_text(text, encoding="utf-8")


def opensees_text(folder: Path) -> str:
    """The part of the page on OpenSees."""
    rows = [compare_opensees(problem, folder) for problem in problems()]
    inertia = end_inertia(folder)
    found = [(row, repeated(row, folder)) for row in rows if row.problem.method.steps == STEPS[0]]
    again = [f"- η = {row.problem.eta:g}, {integrator_words(row.problem)}: {place}" for row, place in found if place]
    return _OPENSEES.format(
        tolerance=f"{TOLERANCE:.0e}",
        table=table(("η", "K", "D", "steps", "integrator", "OpenSees beside ours"), map(opensees_cells, rows)),
        steps=f"{sum(row.walk.steps for row in rows):,}",
        own=f"{max(row.walk.own for row in rows):.0e}",
        stops=sum(row.theirs is not None for row in rows),
        runs=len(rows),
        repeated="\n".join(again) or "- nowhere else",
        proper=f"{inertia.proper:.2g}",
        end=f"{inertia.end:.0e}",
        apart=f"1 + {inertia.radii[0] - 1:.1e}",
        contact=f"{inertia.radii[1]:.4f}",
    )


def opensees_cells(row: Row) -> list[str]:
    """A row of the table."""
    method = row.problem.method
    numbers = [f"{number:g}" for number in (row.problem.eta, method.stiffness, method.damping)]
    words = f"agree to {row.difference:.0e}" if row.cause == "agree" else row.cause
    return [*numbers, f"T/{method.steps}", integrator_words(row.problem), words]


def integrator_words(problem: DeckProblem) -> str:
    """Name and numbers of an integrator."""
    numbers = ", ".join(f"{name} {value:g}" for name, value in vars(problem.integrator).items())
    return " ".join(filter(None, (problem.integrator.name, numbers)))


def hertz_text(folder: Path) -> str:
    """The part of the page on laws that are not linear in contact."""
    if not is_offered():
        return "Not compared: this version has not these laws."
    rows = [compare_law(problem, folder) for problem in law_problems()]
    walked = [row.growth for row in rows if row.growth]
    return _HERTZ.format(
        table=table(("η", "K", "law", "material", "steps", "OpenSees beside ours"), map(law_cells, rows)),
        steps=f"{sum(each.steps for each in walked):,}",
        own=f"{max(each.own for each in walked):.0e}",
    )


def calculix_text(folder: Path) -> str:
    """The part of the page on CalculiX."""
    cells = []
    for problem in calculix_problems():
        periods, difference = compare_calculix(problem, folder)
        method = problem.method
        ran = f"{problem.periods} periods" if periods == problem.periods else f"stops after {periods:.2g} periods"
        numbers = [f"{number:g}" for number in (problem.eta, method.stiffness, method.damping)]
        words = f"{ran}, agree to {difference:.0e}"
        cells.append([*numbers, f"T/{method.steps}", integrator_words(problem), words])
    two = replace(calculix_problems()[0], periods=2, keep=2)
    changes = {
        "default": default_tolerance,
        "loose": lambda text: as_spring2(default_tolerance(text)),
        "tight": as_spring2,
    }
    found = {name: f"{compare_calculix(two, folder, change)[1]:.0e}" for name, change in changes.items()}
    return _CALCULIX.format(**found, table=table(("η", "K", "D", "steps", "integrator", "CalculiX beside ours"), cells))


def mujoco_text() -> str:
    """The part of the page on MuJoCo."""
    found = [(case, n, compare_mujoco(*case, n)) for case in CASES for n in MUJOCO_STEPS]
    cells = (
        [
            *(f"{number:g}" for number in case),
            f"T/{n}",
            f"{run.contact:,} in contact",
            f"{run.apart:.0e} apart; a₀ up to {100.0 * run.missing:.1f} % of what spring and damper accelerate",
        ]
        for case, n, run in found
    )
    return _MUJOCO.format(
        impedance=IMPEDANCE,
        periods=PERIODS,
        table=table(("η", "K", "D", "step", "steps", "MuJoCo beside ours"), cells),
        own=f"{max(run.own for _, _, run in found):.0e}",
    )


def drops_text() -> str:
    """The part of the page on drops: of the codes that can be imported."""
    head = "code", "its words", "step", "integrator of ours", "restitution, penetration and force beside ours"
    cells = []
    for code, (way, integrator) in drops.SCHEMES.items():
        for step in drops.STEPS if drops.runs_here(code) else ():
            words = drops.translated(code, way, step=step)
            found = drops.drop(code, words.words, mass=1.0, speed=1.0, step=step)
            off = max(abs(one / other - 1.0) for one, other in zip(found, drops.touch(integrator, step), strict=True))
            result = f"e = {found.restitution:.3f}; all three agree to {off:.0e}"
            cells.append([drops.CODES[code].module, f"`{words.line}`", f"{1e3 * step:g} ms", integrator.name, result])
    return table(head, cells) if cells else "None can be imported here."


def table(head, rows) -> str:
    """A table in Markdown."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows))


if __name__ == "__main__":
    main()
