"""Processes that help to compile: each call is made by one of them, and none is waited for in vain."""

import sys
import threading
import time

import pytest
from vibroscope.engine import compilation
from vibroscope.engine.compilation import Claims, Helpers

# Of a process that helps: it makes the calls 3, 2, 1, and compiles a function in each.
HELP = """
import json, pathlib, sys
for call in (3, 2, 1):
    try:
        (pathlib.Path(sys.argv[1]) / str(call)).touch(exist_ok=False)
    except FileExistsError:
        continue
    print(json.dumps(f"function {call}"), flush=True)
    print(json.dumps(call), flush=True)
sys.stdin.read()
"""


def command(program):
    return sys.executable, "-c", program


def test_a_call_is_made_by_who_asks_first(tmp_path):
    one, other = Claims(tmp_path), Claims(tmp_path)
    assert [one.take(0), other.take(0), other.take(1), one.take(1)] == [True, False, True, False]


@pytest.mark.parametrize("count", [0, 1, 2])
def test_each_call_is_made_once_and_others_are_waited_for(count):
    compiled, own = [], []
    with Helpers(count, compiled.append, command(HELP)) as helpers:
        for call in range(4):
            if helpers.claims.take(call):
                own.append(call)
                helpers.made(call)
        helpers.wait(range(4))
    assert sorted([*own, *(int(name.split()[1]) for name in compiled)]) == [0, 1, 2, 3]
    assert own if count else own == [0, 1, 2, 3]


@pytest.mark.parametrize(
    "program", ["raise SystemExit(3)", "import sys, pathlib; (pathlib.Path(sys.argv[1]) / '0').touch()"]
)
def test_one_that_fails_is_not_waited_for(program):
    with Helpers(1, print, command(program)) as helpers:
        helpers.wait([0])


def test_where_no_process_can_be_started_this_one_compiles_alone():
    with Helpers(2, print, ("no such command",)) as helpers:
        assert helpers.claims.take(0)
        helpers.wait([0, 1])


PARTS = [0, 1], [2], [3], [4, 5]  # calls of the stages: two of solvers, the differences, all others


def test_they_end_with_the_block():
    begin = time.perf_counter()
    with Helpers(1, print, command("import sys; sys.stdin.read()")):
        pass
    assert time.perf_counter() - begin < 20


def test_a_process_that_helps_makes_the_last_calls_first_and_never_the_differences(monkeypatch, tmp_path):
    made, reported = [], []
    stages = [[compilation.Call(i, str(i), lambda i=i: made.append(i)) for i in part] for part in PARTS]
    monkeypatch.setattr(compilation, "stages", lambda: stages)
    monkeypatch.setattr(compilation, "end_with_input", lambda: None)
    monkeypatch.setattr(compilation, "report", reported.append)
    Claims(tmp_path).take(5)
    compilation.help_to_compile(tmp_path)
    assert made == reported == [1, 0, 2, 4]


def test_all_calls_are_made_in_stages_whoever_compiles(monkeypatch, tmp_path):
    """By the first process after the others have made theirs, too: it loads what they have compiled."""
    made, mark = [], tmp_path / "mark"
    stages = [[compilation.Call(i, str(i), lambda i=i: made.append(i)) for i in part] for part in PARTS]
    monkeypatch.setattr(compilation, "stages", lambda: stages)
    monkeypatch.setattr(compilation, "complete_mark", lambda: mark)
    monkeypatch.setattr(compilation, "Helpers", lambda count, act: Helpers(count, act, command(HELP)))
    compilation.compile_kernels(processes=2)
    order = [made.index(call) for call in range(6)]
    assert set(made) == {*range(6)}
    assert max(order[:2]) < order[2] < order[3] < min(order[4:])
    assert mark.exists()
    assert not any(thread.name == "compiles" and thread.is_alive() for thread in threading.enumerate())
