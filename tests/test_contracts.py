"""The doors between the rooms stay shut."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def imported_by(statement):
    code = f"import sys; {statement}; print(' '.join(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return {name.split(".")[0] for name in done.stdout.split()}


@pytest.mark.parametrize(
    "statement",
    [
        "import vibroscope.engine",
        "import vibroscope.app.explorer.compute",
        "import vibroscope.app.explorer.present",
        "import vibroscope.app.explorer.state",
        "import vibroscope.app.commands.cli",
    ],
)
def test_no_screen_is_loaded_where_none_is_needed(statement):
    assert not imported_by(statement) & {"panel", "bokeh", "holoviews", "tornado"}


def test_import_contracts_hold():
    done = subprocess.run(
        [Path(sys.executable).parent / "lint-imports"], cwd=ROOT, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout
