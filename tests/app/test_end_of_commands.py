"""A program ends with its status, after all that waits for its end."""

import signal
import subprocess
import sys

import pytest

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
import os, sys
from vibroscope.app.commands import cli
for code in (None, 3, 259, True, "no such thing"):
    def run(words):
        raise SystemExit(code)
    cli._run = run
    child = os.fork()
    if not child:
        sys.exit(cli.main())
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


def test_a_program_that_ends_in_another_way_has_the_status_that_python_gives_it():
    found = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, check=True)
    assert [int(status) for status in found.stdout.split()] == [0, 3, 3, 1, 1]
    assert found.stderr == "no such thing\n"


def test_a_long_comparison_says_so_beforehand_and_ctrl_c_ends_it():
    words = ["compare", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "1000000"]
    # as at a terminal: what a shell runs in the background ignores Ctrl-C
    heard = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    run = [sys.executable, "-c", f"{heard}from vibroscope.app.commands.cli import main; sys.exit(main())", *words]
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert "2,050,000,000 steps in each run" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")
    assert said.strip() == "vibroscope compare: stopped by Ctrl-C before its end"
