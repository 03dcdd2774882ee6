"""Compilation beside the server: who hears of it, what waits for it, and that it ends with the server."""

import contextlib
import itertools
import json
import os
import subprocess
import sys
import threading

import pytest
from vibroscope.app.commands.report import compilation_text, show_compilation
from vibroscope.app.explorer import shipped
from vibroscope.app.explorer.compute import needed
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.page.explore import tab as explore
from vibroscope.app.page.tab import Move
from vibroscope.app.runtime import compilation as module
from vibroscope.app.runtime.compilation import Compilation
from vibroscope.engine import Compiled, CompileProgress
from vibroscope.engine import compilation as engine

from tests.app.fakes import Document, FakeHost
from tests.waiting import PATIENCE

HALF, ALL = CompileProgress(0.5, "reference"), CompileProgress(1.0, "Newmark")
SHOWS = CompileProgress(0.4, "Newmark", Compiled.MOTIONS)
EXPLAINS = CompileProgress(0.6, "Newmark, every step", Compiled.VERDICTS)


def printing(*progress, then=""):
    lines = "".join(f"print({json.dumps(json.dumps(one))}, flush=True);" for one in progress)
    return [sys.executable, "-c", f"import time; {lines} {then}"]


@pytest.fixture
def nothing_compiled(monkeypatch, request):
    if request.config.getoption("--quick"):  # here, since the process is started in another thread
        pytest.skip("starts a process: run by `make test`")
    monkeypatch.setattr(module, "is_compiled", lambda: False)
    monkeypatch.setattr(module, "is_cache_private", lambda: False)


def ended(compilation):
    """Wait until everybody has been called."""
    compilation.thread.join(PATIENCE)
    assert not compilation.thread.is_alive()


def test_everything_waits_until_all_is_compiled_and_hears_how_far_it_is(nothing_compiled, tmp_path):
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    compilation = Compilation(printing(HALF, ALL, then=f"open({str(gate)!r})"))
    heard, done, half = [], [], threading.Event()
    compilation.start()
    compilation.watch(lambda progress: (heard.append(progress), progress == ALL and half.set()))
    compilation.when_done(lambda: done.append(compilation.progress))
    assert half.wait(PATIENCE)
    assert (done, compilation.progress) == ([], ALL)
    gate.open("w").close()  # lets the process end
    ended(compilation)
    assert heard[-3:] == [HALF, ALL, None]
    assert done == [None]
    compilation.when_done(lambda: done.append("at once"))
    assert done == [None, "at once"]


def test_motions_and_then_verdicts_wait_for_their_own_solvers_alone(nothing_compiled, tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    os.mkfifo(first)
    os.mkfifo(second)
    words = printing(HALF, SHOWS, then=f"open({str(first)!r}); {printing(EXPLAINS)[-1]} open({str(second)!r})")
    compilation, done, shown, explained = Compilation(words), [], threading.Event(), threading.Event()
    compilation.start()
    compilation.when_done(lambda: done.append("all"))
    compilation.when_done(explained.set, Compiled.VERDICTS)
    compilation.when_done(shown.set, Compiled.MOTIONS)
    assert shown.wait(PATIENCE)
    assert (done, explained.is_set(), compilation.progress) == ([], False, SHOWS)
    compilation.when_done(lambda: done.append("a later move"), Compiled.MOTIONS)
    assert done == ["a later move"]
    first.open("w").close()  # lets the process go on
    assert explained.wait(PATIENCE)
    assert (done, compilation.progress) == (["a later move"], EXPLAINS)
    second.open("w").close()
    ended(compilation)
    assert done == ["a later move", "all"]


def test_a_move_waits_for_the_solvers_of_its_setting():
    first = Compiled.MOTIONS
    assert needed(opening_setting(), first) == first
    assert needed(opening_setting()._replace(bodies="wall"), first) == first  # the same solvers
    for other in ({"integrator": "hht"}, {"law": "cut"}, {"status": "end"}):
        assert needed(opening_setting()._replace(**other), first) == Compiled.ALL


def test_what_the_explorer_opens_with_is_compiled_first_whole_comparisons_last(monkeypatch, tmp_path):
    heard, real = [], engine.stages()
    monkeypatch.setattr(engine, "complete_mark", lambda: tmp_path / "none" / "mark")
    monkeypatch.setattr(engine, "stages", lambda: [[call._replace(make=str) for call in stage] for stage in real])
    engine.compile_kernels(heard.append)
    last = {progress.compiled: progress.what for progress in heard}
    assert (last[Compiled.NOTHING], last[Compiled.MOTIONS]) == ("Newmark", "differences")
    assert [progress.compiled for progress in heard] == sorted(progress.compiled for progress in heard)


def test_nothing_is_started_where_all_is_compiled(monkeypatch):
    monkeypatch.setattr(module, "is_compiled", lambda: True)
    compilation = Compilation(["no such command"])
    compilation.start()
    assert compilation.progress is None


@pytest.mark.parametrize("command", [["no such command"], [sys.executable, "-c", "raise SystemExit(3)"]])
def test_a_compilation_that_fails_holds_nobody_up(nothing_compiled, command):
    compilation, done = Compilation(command), threading.Event()
    compilation.start()
    compilation.when_done(done.set)
    assert done.wait(PATIENCE)


def test_a_server_that_stops_ends_it_and_nobody_is_called(nothing_compiled):
    compilation, begun, called = Compilation(printing(HALF, then="time.sleep(60)")), threading.Event(), []
    compilation.start()
    compilation.watch(lambda progress: begun.set())
    compilation.when_done(lambda: called.append("a job"))
    assert begun.wait(PATIENCE)
    compilation.stop()
    compilation.thread.join(PATIENCE)
    assert not compilation.thread.is_alive()
    assert called == []


def test_a_cache_of_this_process_alone_is_filled_in_this_process(monkeypatch):
    monkeypatch.setattr(module, "is_compiled", lambda: False)
    monkeypatch.setattr(module, "is_cache_private", lambda: True)
    monkeypatch.setattr(module, "lower_priority", lambda: None)
    monkeypatch.setattr(module, "compile_kernels", lambda report: report(HALF))
    compilation = Compilation(["no such command"])
    compilation.start()
    compilation.thread.join(PATIENCE)
    assert compilation.progress is None


def test_the_shipped_result_is_shown_marked_and_then_replaced(monkeypatch):
    """The tab shows the opening scene at once; its job waits for the solvers, and its result replaces what is shown."""
    compilation = Compilation()
    compilation.progress = HALF
    for user in ("vibroscope.app.explorer.compute", "vibroscope.app.explorer.shipped"):
        monkeypatch.setattr(f"{user}.compilation", compilation)
    monkeypatch.setattr(explore, "cached_runs", lambda setting: None)
    shown = threading.Event()

    class Host(FakeHost):
        def push(self, move, *parts):
            super().push(move, *parts)
            if not tab.findings.content["shipped"]:
                shown.set()

    tab = explore.Explore(host := Host(doc=Document()))
    tab.build()
    assert tab.show_if_ready(Move(1, opening_setting()))
    assert host.moves == [1]
    assert tab.findings.content["shipped"]
    assert tab.findings.content["headline"]
    assert not tab.show_if_ready(Move(2, opening_setting()._replace(K=1000.0)))
    tab.show(Move(2, opening_setting()))
    compilation.finish()
    assert shown.wait(PATIENCE)
    assert not tab.findings.content["shipped"]
    tab.close()


def test_the_terminal_shows_a_bar_on_one_line(capsys, monkeypatch):
    assert compilation_text(HALF) == "Compiling, once: [##########..........]  50 % reference"
    assert len(compilation_text(CompileProgress(1.0, "exact penalty, for studies"))) < 80
    show_compilation(HALF)
    assert capsys.readouterr().err == ""  # no terminal
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    show_compilation(HALF)
    show_compilation(None)
    assert "\n" not in capsys.readouterr().err


def test_the_share_rises_to_all_without_a_jump(monkeypatch, tmp_path):
    functions, compiled, shares = [f"function{i}" for i in range(8)], [], []

    class Listener(contextlib.nullcontext):
        def __init__(self, act):
            super().__init__()
            compiled.append(act)

    calls = [engine.Call(i, name, lambda name=name: compiled[0](name)) for i, name in enumerate(functions)]
    monkeypatch.setattr(engine, "compilable_functions", lambda: {*functions})
    monkeypatch.setattr(engine, "complete_mark", lambda: tmp_path / "complete")
    monkeypatch.setattr(engine, "CompileListener", Listener)
    monkeypatch.setattr(engine, "stages", lambda: [calls, [], [], []])
    engine.compile_kernels(lambda progress: shares.append(progress.share))
    steps = [later - earlier for earlier, later in itertools.pairwise(shares)]
    assert (shares[0], shares[-1]) == (0, 1)
    assert 0 <= min(steps) <= max(steps) <= 1 / 8
    assert (tmp_path / "complete").exists()


def test_a_first_start_compiles_into_an_empty_cache_in_another_process(tmp_path):
    """What `Compilation` starts says at once what it compiles; it is ended here, since all of it takes a minute."""
    variables = {**os.environ, "VIBROSCOPE_CACHE_DIR": str(tmp_path)}
    process = subprocess.Popen(Compilation().command, stdout=subprocess.PIPE, text=True, env=variables)
    try:
        assert CompileProgress(*json.loads(process.stdout.readline())) == CompileProgress(0.0, "reference")
        assert 0 < CompileProgress(*json.loads(process.stdout.readline())).share < 0.1
    finally:
        process.kill()
        process.communicate()
    assert not list(tmp_path.rglob("complete-*"))


@pytest.mark.parametrize("kept", ["shipped", None])
def test_a_diagram_that_must_be_computed_waits_for_the_solvers_and_a_shipped_one_does_not(monkeypatch, kept):
    compilation = Compilation()
    compilation.progress = HALF
    monkeypatch.setattr(shipped, "FUTURES", {})
    monkeypatch.setattr(shipped, "compilation", compilation)
    monkeypatch.setattr(shipped, "shipped_diagram", lambda system, method: kept)
    monkeypatch.setattr(shipped, "diagram", lambda system, method: f"computed, progress {compilation.progress}")
    future = shipped.load_diagram("table")
    if kept is None:
        compilation.finish()
    assert future.result(PATIENCE) == (kept or "computed, progress None")
