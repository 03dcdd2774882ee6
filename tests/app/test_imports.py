"""What a command imports: starting takes most of the time of a short one."""

import json
import subprocess
import sys

import pytest
from vibroscope import engine

SCRIPT = """
import sys
from vibroscope.app.commands.cli import main
main(sys.argv[1:])
print("\\n".join(["imported", *sys.modules]))
import scipy.linalg, yaml  # as ever
"""


def test_a_run_imports_neither_studies_nor_searches_nor_the_page_nor_scipy_nor_yaml():
    command = "simulate", "--solver", "reference", "--eta", "2.76", "--periods", "10", "--keep", "5", "--json"
    done = subprocess.run([sys.executable, "-c", SCRIPT, *command], capture_output=True, text=True, check=True)
    text, _, modules = done.stdout.partition("\nimported\n")
    assert json.loads(text)["status"] == "ok"
    heavy = ("vibroscope.engine.cells", "vibroscope.engine.compilation", "vibroscope.engine.motions")
    heavy += ("vibroscope.engine.sweeps", "vibroscope.engine.recommendation", "vibroscope.engine.measurement")
    heavy += ("vibroscope.app.page", "vibroscope.app.explorer", "vibroscope.app.paper")
    heavy += ("bokeh", "panel", "param", "scipy", "xarray", "yaml", "zarr")
    # the table of fields, of which options are made, and its words for a method: they import nothing else
    light = {f"vibroscope.app.explorer{name}" for name in ("", ".parameters", ".method_words")}
    assert [name for name in modules.split() if name.startswith(heavy) and name not in light] == []


def test_every_public_name_of_the_engine_is_found_and_is_no_module():
    for name in engine.__all__:
        assert type(getattr(engine, name)).__name__ != "module", name
    with pytest.raises(AttributeError, match="no attribute 'simulator'"):
        _ = engine.simulator
    assert dir(engine) == sorted(engine.__all__)
