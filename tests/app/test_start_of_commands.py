"""The command line leaves out what Numba's start does not need, and what is left out does not fail later."""

import json
import subprocess
import sys

import pytest

PROGRAM = """
import contextlib, io, json, sys, tempfile
checks = []
temporary_file = tempfile.TemporaryFile
tempfile.TemporaryFile = lambda *a, **o: checks.append(o["dir"]) or temporary_file(*a, **o)
from vibroscope.app.commands.cli import main
with contextlib.redirect_stdout(io.StringIO()) as text:
    main(["simulate", "--solver", "reference", "--eta", "1.08", "--json"])
imported = [name for name in ("scipy", "yaml", "numba.typed.typeddict") if name in sys.modules]
import numba, scipy.linalg, yaml
from vibroscope.engine.kernels.equations.rates import free_rate as kernel
from vibroscope.engine.kernels.parameters import Parameters
numbers = Parameters(*[0.5 for name in Parameters._fields])
loaded = kernel(numbers)
parsed = [one for one in kernel.overloads.values() if kernel.stats.cache_hits and not hasattr(one.library, "unparsed")]
compiled = numba.njit(lambda numbers: sum([kernel(numbers) for i in range(5)]))(numbers) / loaded
status = json.loads(text.getvalue())["status"]
print(json.dumps([status, imported, len(checks) - len(set(checks)), len(parsed), compiled]))
"""


def test_a_short_run_needs_neither_compiler_nor_bitcode_nor_blas():
    found = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    status, imported, repeated, parsed, compiled = json.loads(found.stdout)
    assert status == "ok"
    assert imported == []  # what only a compilation needs, Numba's way to BLAS, and its files of settings
    assert repeated == 0  # checks of a cache folder that was checked before
    assert parsed == 0  # machine code loaded with its bitcode
    assert compiled == 5.0  # a compilation afterwards, with what was left out


END = """
import atexit, sys, threading
from vibroscope.app.commands.cli import main
def thread():
    threading.main_thread().join()
    atexit.register(print, "file closed")
    print("thread done")
atexit.register(print, "memory cleared")  # registered before the program's own, it would run after that
threading.Thread(target=thread).start()
sys.exit(main())
"""


@pytest.mark.parametrize(("command", "status", "last"), [("--version", 0, "vibroscope"), ("simulate", 2, "simulate")])
def test_a_program_ends_with_its_status_after_all_that_waits_for_its_end(command, status, last):
    found = subprocess.run([sys.executable, "-c", END, command], capture_output=True, text=True, check=False)
    assert found.returncode == status
    assert last in (found.stdout if status == 0 else found.stderr)
    assert found.stdout.splitlines()[-2:] == ["thread done", "file closed"]


ENDING = """
import sys
from vibroscope.app.commands import cli
def run(words):
    raise SystemExit({code})
cli._run = run
sys.exit(cli.main())
"""


@pytest.mark.parametrize(
    ("code", "status", "printed"),
    [("None", 0, ""), ("3", 3, ""), ("259", 3, ""), ("True", 1, ""), ("'no such thing'", 1, "no such thing\n")],
)
def test_a_program_that_ends_in_another_way_has_the_status_that_python_gives_it(code, status, printed):
    command = [sys.executable, "-c", ENDING.format(code=code)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (found.returncode, found.stdout, found.stderr) == (status, "", printed)
