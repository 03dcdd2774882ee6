"""``vibroscope system`` and ``--system``."""

import json

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import Reference, System, simulate, system_text

SIMULATE = ["simulate", "--solver", "reference", "--eta", "2.76", "--periods", "20", "--json"]


def run(capsys, *arguments):
    try:
        status = main(arguments)
    except SystemExit as exit_:
        status = exit_.code
    out, err = capsys.readouterr()
    return status, out, err


def test_what_it_prints_is_taken_by_every_command(capsys, tmp_path):
    path = tmp_path / "own.toml"
    status, out, _ = run(capsys, "system")
    assert (status, out) == (0, system_text())
    path.write_text(out.replace("kappa = 2.41", "kappa = 2.6").replace("restitution = 0.5", "restitution = 0.4"))
    own = System(kappa=2.6, restitution=0.4)
    status, out, _ = run(capsys, *SIMULATE, "--system", str(path))
    assert status == 0
    assert json.loads(out)["section"] == simulate(own, 2.76, Reference(), periods=20, keep=20).section.tolist()
    _, out, _ = run(capsys, *SIMULATE, "--system", str(path), "--restitution", "0.7")
    again = simulate(System(kappa=2.6, restitution=0.7), 2.76, Reference(), periods=20, keep=20)
    assert json.loads(out)["section"] == again.section.tolist()
    _, out, _ = run(capsys, "system", "--system", str(path))
    assert out == system_text(own)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[system]\nkapa = 2\n", "own.toml: unknown constant in [system]: 'kapa'; did you mean kappa?"),
        ("[system]\nkappa = 2..\n", "own.toml: not valid TOML"),
        ("[system]\nd1 = 2\n", "own.toml: d1 = 2.0 is outside [0, 1)"),
        (None, "own.toml: cannot be read: No such file or directory"),
    ],
)
def test_a_bad_file_gives_one_line_and_status_2(capsys, tmp_path, content, words):
    path = tmp_path / "own.toml"
    if content is not None:
        path.write_text(content)
    status, out, err = run(capsys, *SIMULATE, "--system", str(path))
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert words in err
