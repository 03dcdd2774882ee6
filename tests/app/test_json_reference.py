"""The keys of every JSON object that a command prints are those that docs/reference/files.md names."""

import json
import re
from pathlib import Path

import pytest
from vibroscope.app.commands import stability
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer import impact_words
from vibroscope.app.paper import CLAIMS, Finding, as_dict
from vibroscope.app.performance import bench
from vibroscope.engine import NewmarkBeta
from vibroscope.engine.hardcases.cases import hard_cases
from vibroscope.engine.hardcases.judgement import outcome

from tests.few_seeds import few_seeds

DOCS = Path(__file__).parents[2] / "docs"
REFERENCE = (DOCS / "reference/files.md").read_text()
SCHEMES = ["--schemes", "--tolerance", "0.4"]
PART = ["--system", str(DOCS / "my.toml")]
MET = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000"]
RANGE = ["--solver", "reference", "--from", "2.74", "--to", "2.76", "--most-orbits", "20", "--max-period", "1"]
CALLS = {
    "simulate": ["--solver", "newmark", *MET],
    "motion": ["--solver", "newmark", *MET],
    "compare": [*MET, "--alone"],
    "recommend": [*MET[:6], "--tolerance", "0.5", "--steps-max", "512"],
    "validate": ["B5"],
    "codes": ["calculix"],
    "impact": [*PART, "--K", "1e6", "--D", "20", "--steps-per-contact", "8", *SCHEMES, "--bounds"],
    "codes translate": ["--from", "gazebo", "--to", "bullet"],
    "rules": ["ansys-mode", *MET],
    "branch": RANGE,
    "transient": ["--base-sawtooth", "1,2", "--K", "1000", "--D", "5"],
}
ASKED = {"solver", "eta"}  # what a table may name although a call without it does not print it
PARTS = {
    "rules": ("rules", "each outcome"),
    "branch": ("branches", "each branch"),
    "transient": ("reference", "each run"),
}


def keys_of(title):
    """What the table with this title names in its first column."""
    table = re.search(rf"^\| {title} *\| \|\n\|.*\n((?:\|.*\n)+)", REFERENCE, re.MULTILINE)[1]
    cells = [line.split("|")[1] for line in table.splitlines()]
    return set(re.findall(r"`(\w+)`", " ".join(cells)))


def title_of(command):
    """How the table of a command begins; that of `motion` serves `compare`, too."""
    return rf"`{command}`[^|]*?(?<!each outcome)(?<!each branch)(?<!each run)"


def printed(capsys, *words):
    """The JSON of a call."""
    with few_seeds():
        main([*words[0].split(), *words[1:], "--json"])
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("command", CALLS)
def test_the_keys_of_the_json_are_those_that_are_documented(command, capsys, monkeypatch):
    monkeypatch.setattr(impact_words, "INTEGRATORS", {"newmark": NewmarkBeta})  # each row has the same keys
    found = printed(capsys, command, *CALLS[command])
    found = found[0] if isinstance(found, list) else found
    assert set(found) - ASKED <= keys_of(title_of(command))
    assert keys_of(title_of(command)) - {"curves", "not_followed"} <= set(found) | ASKED
    if command in PARTS:
        name, words = PARTS[command]
        first = found[name] if isinstance(found[name], dict) else found[name][0]
        assert set(first) == keys_of(rf"`{command}`, {words}")


def test_the_keys_of_studies(capsys, tmp_path):
    sweep = ["sweep", "basin", "--eta", "3.2", "--solver", "reference", "--x", "xi2:-1:1:3", "--y", "v2:-1:1:3"]
    paths = [str(tmp_path / name) for name in ("first.zarr", "second.zarr")]
    for path in paths:
        found = printed(capsys, *sweep, "--transient", "200", "--sample", "64", "--out", path)
        assert set(found) == keys_of("`sweep`")
    assert set(printed(capsys, "sweep", "basin-difference", *paths)) == keys_of("`sweep basin-difference`")
    assert set(printed(capsys, "sweep", "check", paths[0])) == keys_of("`sweep check`")


def test_the_keys_of_one_setting_for_a_range(capsys):
    search = ["--eta-range", "2.7:2.76:2", "--one-setting", "--K", "200", "--D", "4", "--tolerance", "0.9"]
    found = printed(capsys, "recommend", *search, "--steps-max", "64")
    assert set(found) == keys_of("`recommend --one-setting`")
    assert set(found["etas"][0]) == {
        "eta",
        "steps",
        "error",
        "robust",
        "restitution",
        "peak_force",
        "peak_force_without_step",
        "steps_per_contact",
    }


def test_the_keys_of_hard_cases_and_claims():
    assert set(stability.as_dict(outcome(hard_cases()[0]))) == keys_of("`stability`")
    finding = Finding(True, "found", None)
    assert set(as_dict(next(iter(CLAIMS.values())), finding)) == keys_of("`paper`")


def test_the_keys_of_the_benchmark(monkeypatch):
    monkeypatch.setattr(bench, "measure_scene", lambda *asked: {})
    assert set(bench.report(1, 1)) == keys_of("`bench`")
