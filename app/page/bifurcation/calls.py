"""A bifurcation diagram and its branches as a Python script, and as commands."""

from __future__ import annotations

from collections.abc import Mapping

from vibroscope.app.export.scripts import branch_command, initial_option, method_options, sweep_command, sweep_python
from vibroscope.app.studies.bifurcation import SAMPLE, DiagramQuestion
from vibroscope.app.studies.branches import BranchQuestion
from vibroscope.engine import COORDINATES


def diagram_python(question: DiagramQuestion, branches: Mapping[str, BranchQuestion]) -> str:
    """`EtaStudy` and, for the branches by the name of their result, `find_branches`."""
    how = f"direction={question.direction!r}, coordinates={tuple(COORDINATES)}"
    how += "" if question.over == "eta" else f", over={question.over!r}, eta={question.eta!r}"
    how += "" if question.initial is None else f", initial={question.initial}"
    values = f"np.linspace({question.span[0]!r}, {question.span[1]!r}, {question.count})"
    values = f"np.unique(np.round({values}))" if question.over == "steps" else values
    calls = {name: _branch_call(each) for name, each in branches.items()}
    names = [type(each.method).__name__ for each in branches.values()]
    call = f"sweep(EtaStudy(\n    system, {question.method!r}, values={values},\n"
    call += f"    {how}, transient={question.transient}, sample={SAMPLE},\n))"
    names += ["EtaStudy", type(question.method).__name__]
    return sweep_python({"diagram": call, **calls}, question.system, *names)


def diagram_command(question: DiagramQuestion, branches: Mapping[str, BranchQuestion]) -> str:
    """``vibroscope sweep eta`` and ``vibroscope branch``."""
    low, high = question.span
    options = f" --from {low!r} --to {high!r} --count {question.count}{method_options(question.method)}"
    options += "" if question.over == "eta" else f" --over {question.over} --eta {question.eta!r}"
    options += f" --direction {question.direction} --coordinates {','.join(COORDINATES)}"
    options += initial_option(question.initial)
    sweep = sweep_command("eta", question.system, f"{options} --transient {question.transient} --sample {SAMPLE}")
    if not branches:
        return sweep
    return sweep + branch_command(question.system, {name: _branch_options(each) for name, each in branches.items()})


def _branch_call(question: BranchQuestion) -> str:
    numbers = ", ".join(f"{name}={value!r}" for name, value in question.search.items())
    _, eta, method = question.problem
    return f"find_branches(\n    system, {eta!r}, {method!r}, {numbers},\n)"


def _branch_options(question: BranchQuestion) -> str:
    how, (_, eta, method) = question.search, question.problem
    options = f" --over {question.over} --from={how['low']!r} --to={how['high']!r} --max-period {how['max_period']}"
    options += f" --most-orbits {how['most_orbits']}{initial_option(how.get('initial'))}"
    given = "" if question.over == "eta" and how.get("initial") is None else f" --eta {eta!r}"
    return f"{options}{method_options(method)}{given}"
