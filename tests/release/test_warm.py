"""After ``vibroscope warm`` no command compiles anything: one of each kind of call is made with a cache of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

VIBROSCOPE = Path(sys.executable).parent / "vibroscope"
SCENE = ["--eta", "2.76", "--K", "5000", "--D", "20", "--steps", "500"]
EXACT = ["--solver", "exact", "--eta", "2.76", "--K", "5000", "--D", "20"]
PULSE = ["--base-half-sine", "30,1", "--K", "1000", "--D", "5"]
CONTACT = ["--K", "1e6 N/m", "--restitution", "0.5", "--steps-per-contact", "5"]
RANGE = ["--from", "1.6", "--to", "1.8", "--count", "20", "--out", "study.zarr"]
PLANE = ["--K", "1000:5000:3", "--D", "10:20:2", "--out", "plane.zarr"]
BETWEEN = ["--system", "between.toml"]  # two stops
CALLS = [
    ["simulate", *EXACT],
    ["simulate", *EXACT, "--law", "hunt-crossley", "--json"],
    ["simulate", "--solver", "newmark", *SCENE, "--json"],
    ["motion", "--solver", "reference", "--eta", "1.7"],
    ["motion", "--solver", "reference", "--eta", "3.2", "--attractors"],
    ["motion", "--solver", "exact", "--eta", "1.7", "--K", "12000", "--D", "18"],
    ["compare", *SCENE],
    ["motion", "--solver", "reference", "--eta", "1.08", *BETWEEN],
    ["compare", *SCENE, *BETWEEN],
    ["compare", *SCENE, "--law", "cut"],
    ["compare", *SCENE, "--law", "hunt-crossley", "--status", "located"],
    ["compare", *SCENE, "--integrator", "bathe", "--status", "end", "--without-solution", "halve"],
    ["peaks", *SCENE],
    ["transient", *PULSE],
    ["transient", *PULSE, "--steps", "500", "--energy"],
    ["impact", *CONTACT, "--over", "time"],
    ["impact", *CONTACT, "--over", "time", "--status", "located"],
    ["impact", *CONTACT, "--law", "cut"],
    ["sweep", "eta", "--solver", "reference", *RANGE],
    ["sweep", "eta", "--solver", "exact", "--K", "100", "--D", "8", *RANGE[:-1], "other.zarr"],
    ["sweep", "plane", *SCENE[:2], *SCENE[-2:], "--law", "cut", *PLANE],
    ["branch", "--from", "2.6", "--to", "2.76"],
    ["recommend", "--eta", "2.76", "--tolerance", "0.2"],
]


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A cache folder in which everything has been compiled."""
    folder = tmp_path_factory.mktemp("cache")
    (folder / "between.toml").write_text("[system]\nclearance2 = 1.0\n")
    call(folder, "warm")
    return folder


def call(folder, *words):
    environment = os.environ | {"VIBROSCOPE_CACHE_DIR": str(folder)}
    done = subprocess.run([VIBROSCOPE, *words], env=environment, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done


def machine_code(folder):
    return {path.name for path in folder.rglob("kernels-*/**/*.nb*")}


@pytest.mark.parametrize("words", CALLS, ids=" ".join)
def test_a_command_finds_all_machine_code(cache, words):
    before = machine_code(cache)
    call(cache, *words)
    assert machine_code(cache) == before
