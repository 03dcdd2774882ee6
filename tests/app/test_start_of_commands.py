"""The command line leaves out what Numba's start does not need, and what is left out does not fail later."""

import json
import subprocess
import sys

PROGRAM = """
import contextlib, io, json, sys, tempfile
checks = []
temporary_file = tempfile.TemporaryFile
tempfile.TemporaryFile = lambda *a, **o: checks.append(o["dir"]) or temporary_file(*a, **o)
from vibroscope.app.commands.cli import main
with contextlib.redirect_stdout(io.StringIO()) as text:
    main(["simulate", "--solver", "reference", "--eta", "1.08", "--json"])
imported = [name for name in ("scipy.linalg", "numba.typed.typeddict") if name in sys.modules]
import numba, scipy.linalg
compiled = numba.njit(lambda n: sum([0.5 * i for i in range(n)]))(5)
print(json.dumps([json.loads(text.getvalue())["status"], imported, len(checks) - len(set(checks)), compiled]))
"""


def test_a_short_run_needs_neither_compiler_nor_blas():
    found = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    status, imported, repeated, compiled = json.loads(found.stdout)
    assert status == "ok"
    assert imported == []  # what only a compilation needs, and Numba's way to BLAS
    assert repeated == 0  # checks of a cache folder that was checked before
    assert compiled == 5.0  # a compilation afterwards, with the tables that were left out
