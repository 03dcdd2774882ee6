"""What commands print where letters cannot be written, or where nothing can."""

import io
import sys

import pytest
from vibroscope.app.commands.cli import COMMANDS, main
from vibroscope.app.commands.report import ascii_name

from tests.served import ROOT

NEWMARK = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "200"]
SHORT = {
    "simulate": ["simulate", "--solver", "newmark", *NEWMARK, "--periods", "300"],
    "motion": ["motion", "--solver", "newmark", *NEWMARK],
    "compare": ["compare", *NEWMARK, "--periods", "60", "--units"],
    "stability": ["stability", "--eta", "2.76"],
}


@pytest.fixture
def printed(monkeypatch):
    """Runs the command line on streams of an encoding; gives the status and both texts."""

    def run(arguments, encoding):
        streams = {name: io.TextIOWrapper(io.BytesIO(), encoding=encoding) for name in ("stdout", "stderr")}
        with monkeypatch.context() as patch:
            for name, stream in streams.items():
                patch.setattr(sys, name, stream)
            try:
                status = main(arguments)
            except SystemExit as end:  # --help
                status = end.code
            for stream in streams.values():
                stream.flush()
        return status, *(stream.buffer.getvalue().decode(encoding) for stream in streams.values())

    return run


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
@pytest.mark.parametrize(("name", "symbol"), [("motion", "xi2"), ("compare", "x2")])  # that with units
def test_letters_that_cannot_be_written_are_named(printed, name, symbol, encoding):
    status, out, _ = printed(SHORT[name], encoding)
    _, whole, _ = printed(SHORT[name], "utf-8")
    assert status == 0
    assert any(ord(character) > 255 for character in whole)
    assert symbol in out
    assert "?" not in out


@pytest.mark.parametrize("name", COMMANDS)
def test_help_can_be_read_in_ascii(printed, name):
    status, out, _ = printed([name, "--help"], "ascii")
    assert status == 0
    assert "usage: vibroscope" in out
    assert "?" not in out.replace("?", "", printed([name, "--help"], "utf-8")[1].count("?"))


def test_names_of_letters():
    assert "".join(map(ascii_name, "ξ₂′ η Ω ω₁ ≤ 3·κ² ± – “ 日")) == "xi2' eta Omega omega1 <= 3.kappa2 +- - \" ?"


def test_every_character_of_ours_has_a_name():
    files = [path for folder in ("app", "engine", "assets") for path in (ROOT / folder).rglob("*.*")]
    texts = "".join(path.read_text() for path in files if path.suffix in (".py", ".toml"))
    unnamed = {character for character in set(texts) if not character.isascii() and ascii_name(character) == "?"}
    assert unnamed == {"\N{REPLACEMENT CHARACTER}"}


def test_a_closed_output_is_said_in_one_line(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", None)
    assert main(SHORT["simulate"]) == 1
    sys.stdout.close()  # what took its place
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "the standard output is closed" in error


def test_both_outputs_closed(monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    assert main(SHORT["simulate"]) == 1
    assert main(["simulate", "--solver", "reference", "--eta", "-1"]) == 2
    sys.stdout.close()
    sys.stderr.close()
