"""The table of codes: valid, cited, set as the engine has it, and printed."""

import json
import math
import re
from dataclasses import replace

import pytest
from vibroscope.app.codes.catalogue import Code, codes, input_numbers
from vibroscope.app.codes.rules import rules
from vibroscope.app.commands.cli import main
from vibroscope.app.export.decks import deck, opensees
from vibroscope.app.export.decks.problem import DeckProblem
from vibroscope.engine import CONTACT_LAWS, HHT, INTEGRATORS, NewmarkBeta, System, TimeStepping


@pytest.mark.parametrize("key", codes())
def test_every_code_is_cited_set_and_written_in_its_own_words(key):
    code = codes()[key]
    method = code.method(2500.0, 8.0, 2000)
    assert (method.stiffness, method.damping, method.steps) == (2500.0, None if code.damper else 8.0, 2000)
    if code.integrator:
        assert method.integrator == INTEGRATORS[code.integrator](**code.numbers)
        assert code.integrator in code.integrators
    if code.status:
        assert method.status == code.status
    assert code.leaves_out
    assert code.sources
    assert set(code.rules) <= set(rules())
    lines = code.lines(input_numbers(System(), 1.08, method, 2500.0, 16.0, 0.003), method.integrator.name)
    assert lines
    assert not [line for line in lines if "{" in line or "}" in line]
    assert "0.003" in " ".join(lines) or key == "simscape"  # its step is variable


@pytest.mark.parametrize("field", ["integrator", "status", "without_solution", "law", "initial_acceleration"])
def test_whatever_is_set_has_a_source_that_names_it(field):
    """And a source that has no address says why."""
    for code in codes().values():
        named = {name for source in code.sources for name in source.figure.split(", ")}
        assert not getattr(code, field) or field.replace("_", " ") in named, f"{code.key}: {field} has no source"
    for source in (source for code in codes().values() for source in code.sources):
        assert source.url or "not checked" in source.text or "nference" in source.text


def test_what_no_source_says_is_the_default():
    empty = Code("key", "name")
    assert empty.method(1.0, 2.0, 8) == TimeStepping(1.0, 2.0, 8)
    assert empty.lines({}, "newmark") == ("(its input for the integrator newmark is not known)",)
    assert Code("key", "name", law=CONTACT_LAWS[1]).method(1.0, 2.0, 8).law == CONTACT_LAWS[1]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("integrator", "rk4"),
        ("status", "middle"),
        ("law", "rubber"),
        ("without_solution", "pray"),
        ("numbers", {"x": 1}),
    ],
)
def test_a_fault_in_an_entry_is_refused(name, value):
    with pytest.raises((ValueError, TypeError)):
        Code(**({"key": "key", "name": "name", "integrator": "hht"} | {name: value}))


def test_the_numbers_of_other_codes_follow_from_ours():
    system, eta = System(), 2.76
    method = TimeStepping(12000, 18, 2000, HHT(-0.1))
    step = 2 * math.pi / (eta * 2000)
    numbers = {name: float(text) for name, text in input_numbers(system, eta, method, 1, 2, 3 * step).items()}
    assert numbers["openseesalpha"] == 0.9
    assert numbers["hhtdecay"] == 0.1
    assert numbers["zeta"] == pytest.approx(18 / math.sqrt(12000 * system.mass_share), rel=5e-6)
    critical = 2 * system.mass_ratio * math.sqrt(12000 * (1 + system.mass_ratio) / system.mass_ratio)
    assert numbers["vdc"] == pytest.approx(100 * 2 * 18 / critical, rel=5e-6)  # 2mω, m of the lighter body
    damped = 18 / system.mass_share  # ζω_c, half the damper over the reduced mass
    assert numbers["timeconst"] == pytest.approx(3 / damped, rel=5e-6)
    assert "timeconst" not in input_numbers(
        system, eta, replace(method, damping=0.0, integrator=NewmarkBeta()), 1, 0, 1
    )


@pytest.mark.parametrize("name", opensees.INTEGRATORS)
def test_the_words_of_opensees_are_those_of_its_deck(name):
    """The integrator with its numbers, and the size of its steps, which are halves with two stages."""
    method = TimeStepping(12000, 18, 500, INTEGRATORS[name](), "end")
    problem = DeckProblem(System(), 2.76, method)
    numbers = input_numbers(System(), 2.76, method, 12000, 36, problem.step)
    first, *lines = codes()["opensees"].lines(numbers, name)
    assert first == f"integrator({opensees.INTEGRATORS[name](method.integrator)})".replace('"', "'")
    (size,) = (line.partition(", ")[2].rstrip(")") for line in lines if line.startswith("analyze"))
    substeps = int(re.search(r"SUBSTEPS = (\d)", deck("opensees", problem))[1])
    assert float(size) == pytest.approx(problem.step / substeps, rel=1e-5)


def test_the_command_prints_the_table_and_entries(capsys):
    assert main(["codes"]) == 0
    printed = capsys.readouterr().out
    assert all(f"\n{key} " in printed for key in codes())
    assert main(["codes", "calculix"]) == 0
    printed = capsys.readouterr().out
    assert all(text in printed for text in ("*CONTACT DAMPING", "hht alpha=-0.05", codes()["calculix"].sources[0].url))
    assert main(["codes", "opensees"]) == 0
    printed = capsys.readouterr().out
    for name, words in codes()["opensees"].integrators.items():
        assert all((line if name == "newmark" else f"{name}: {line}") in printed for line in words)
    assert main(["codes", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [each["key"] for each in found] == list(codes())
