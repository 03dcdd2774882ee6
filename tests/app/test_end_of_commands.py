"""A short run begins without what it does not need, and ends with its status, after all that waits for its end."""

import json
import signal
import subprocess
import sys

import pytest

PROGRAM = """
import contextlib, io, json, sys
from vibroscope.app.commands.cli import main
with contextlib.redirect_stdout(io.StringIO()) as text:
    main(["simulate", "--solver", "reference", "--eta", "1.08", "--json"])
imported = [name for name in ("scipy", "yaml") if name in sys.modules]
import scipy.linalg, yaml
print(json.dumps([json.loads(text.getvalue())["status"], imported]))
"""


def test_a_short_run_needs_neither_blas_nor_files_of_settings():
    found = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert json.loads(found.stdout) == ["ok", []]


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


def test_a_long_comparison_says_so_beforehand_and_ctrl_c_ends_it():
    words = ["compare", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "1000000"]
    run = [sys.executable, "-c", "import sys; from vibroscope.app.commands.cli import main; sys.exit(main())", *words]
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert "2,050,000,000 steps in each run" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")
    assert said.strip() == "vibroscope compare: stopped by Ctrl-C before its end"
