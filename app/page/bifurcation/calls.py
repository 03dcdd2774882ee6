"""A bifurcation diagram and its branches as a Python script, and as commands."""

from __future__ import annotations

from collections.abc import Mapping

from vibroscope.app.export.scripts import branch_command, initial_option, method_options, sweep_command, sweep_python
from vibroscope.app.studies.bifurcation import SAMPLE, DiagramQuestion
from vibroscope.app.studies.branches import BranchesQuestion
from vibroscope.engine import COORDINATES


def diagram_python(question: DiagramQuestion, branches: Mapping[str, BranchesQuestion]) -> str:
    """`EtaStudy` and, for the branches by the name of their result, `find_branches`."""
    how = f"direction={question.direction!r}, coordinates={tuple(COORDINATES)}"
    how += "" if question.over == "eta" else f", over={question.over!r}, eta={question.eta!r}"
    how += "" if question.initial is None else f", initial={question.initial}"
    values = f"np.linspace({question.span[0]!r}, {question.span[1]!r}, {question.count})"
    values = f"np.unique(np.round({values}))" if question.over == "steps" else values
    calls = {name: _branch_call(each) for name, each in branches.items()}
    names = [name for each in branches.values() for name in ("BranchQuestion", *each.method.made_by)]
    call = f"sweep(EtaStudy(\n    system, {question.method!r}, values={values},\n"
    call += f"    {how}, transient={question.transient}, sample={SAMPLE},\n))"
    names += ["EtaStudy", *question.method.made_by]
    return sweep_python({"diagram": call, **calls}, question.system, *names)


def diagram_command(question: DiagramQuestion, branches: Mapping[str, BranchesQuestion]) -> str:
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


def _branch_call(question: BranchesQuestion) -> str:
    asked = question.search
    names = ("over", "low", "high", "max_period", "most_orbits", *(("initial",) if asked.initial is not None else ()))
    numbers = ", ".join(f"{name}={getattr(asked, name)!r}" for name in names)
    return f"find_branches(\n    BranchQuestion(system, {asked.eta!r}, {asked.method!r}, {numbers}),\n)"


def _branch_options(question: BranchesQuestion) -> str:
    asked = question.search
    options = f" --over {asked.over} --from={asked.low!r} --to={asked.high!r} --max-period {asked.max_period}"
    options += f" --most-orbits {asked.most_orbits}{initial_option(asked.initial)}"
    given = "" if asked.over == "eta" and asked.initial is None else f" --eta {asked.eta!r}"
    return f"{options}{method_options(asked.method)}{given}"
