"""Completion in shells: the script is run by the shell itself, where it is installed."""

import shutil
import subprocess

import pytest

from tests.app.command_line import run_command

# Asks bash what it completes the words to, the last of which is begun.
ASK = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
_shtab_vibroscope
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def script(capsys, tmp_path):
    """A function from a shell to the file of its script."""

    def write(shell):
        status, text, error = run_command(capsys, "completion", shell)
        assert (status, error) == (0, "")
        path = tmp_path / f"vibroscope.{shell}"
        path.write_text(text)
        return path

    return write


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["sim"], {"simulate"}),
        (["simulate", "--solv"], {"--solver"}),
        (["simulate", "--solver", ""], {"reference", "exact", "newmark"}),
        (["compare", "--integrator", "hht"], {"hht", "hht-interpolated"}),
        (["sweep", "pl"], {"plane"}),
        (["sweep", "plane", "--loc"], {"--located"}),
        (["compare", "--system", "my"], {"my.toml"}),
        (["compare", "--measured", "my"], {"my.toml"}),
        (["export", "--out", "my"], {"my.toml"}),
        (["completion", "z"], {"zsh"}),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bash_completes_commands_options_values_and_files(script, tmp_path, words, found):
    (tmp_path / "my.toml").write_text("")
    asked = ["bash", "-c", ASK, "bash", script("bash"), "vibroscope", *words]
    done = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == found


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_can_read_theirs(script, shell):
    path = script(shell)
    assert "--without-solution" in path.read_text()
    if shutil.which(shell):
        subprocess.run([shell, "-n", path], check=True)
