"""Settings from the environment and the command line."""

import pytest
from vibroscope.app.runtime.settings import Settings, describe, from_environment, unknown_variables, variable_of

from tests.app.command_line import run_command


def test_the_command_line_has_precedence_over_the_environment():
    environment = {"VIBROSCOPE_PORT": "8000", "VIBROSCOPE_ORIGINS": "a.example, b.example:81", "VIBROSCOPE_THREADS": ""}
    chosen = from_environment(environment, given={"port": 9000, "address": None})
    assert (chosen.port, chosen.origins, chosen.address) == (9000, ("a.example", "b.example:81"), "127.0.0.1")


@pytest.mark.parametrize(
    ("variable", "text"),
    [
        ("VIBROSCOPE_PORT", "65536"),
        ("VIBROSCOPE_PORT", "²"),
        ("VIBROSCOPE_THREADS", "0"),
        ("VIBROSCOPE_SESSIONS", "-1"),
        ("VIBROSCOPE_STEPS", "1e9"),
        ("VIBROSCOPE_ORIGINS", "http://a.example/x"),
        ("VIBROSCOPE_ADDRESS", "a b"),
        ("VIBROSCOPE_ADDRESS", "..."),
        ("VIBROSCOPE_ADDRESS", "a" * 64),
        ("VIBROSCOPE_ADDRESS", "[::1]"),
        ("VIBROSCOPE_ADDRESS", "1::2::3"),
        ("VIBROSCOPE_CACHE_DIR", __file__),
        ("VIBROSCOPE_LOG_FORMAT", "xml"),
        ("VIBROSCOPE_PROXIED", "true"),
        ("BOKEH_SECRET_KEY", "short"),
    ],
)
def test_an_invalid_variable_is_named(variable, text):
    with pytest.raises(ValueError, match=variable):
        from_environment({variable: text})


@pytest.mark.parametrize(
    ("address", "host"),
    [
        ("127.0.0.1", "127.0.0.1"),
        ("Local-1.example", "local-1.example"),
        ("::", "[::]"),
        ("0:0:0::1", "[::1]"),
    ],
)
def test_an_address_is_written_as_browsers_write_it(address, host):
    assert from_environment({}, given={"address": address}).host == host


def test_all_errors_come_in_one_line_without_secrets():
    with pytest.raises(ValueError, match="not 7 characters") as caught:
        from_environment({"VIBROSCOPE_PORT": "x", "BOKEH_SECRET_KEY": "hunter2"})
    assert "VIBROSCOPE_PORT" in str(caught.value)
    assert "hunter2" not in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "secret_key" not in repr(Settings())


def test_an_invalid_setting_ends_the_command_with_status_2(monkeypatch, capsys):
    monkeypatch.setenv("VIBROSCOPE_SESSIONS", "many")
    status, _, error = run_command(capsys, "serve")
    assert (status, error.count("\n")) == (2, 1)
    assert "VIBROSCOPE_SESSIONS must be a whole number from 1" in error


def test_help_names_every_variable_and_a_misspelt_one_is_found():
    for name in Settings.__dataclass_fields__:
        assert variable_of(name) in describe()
    assert unknown_variables({"VIBROSCOPE_PROT": "1", "VIBROSCOPE_BROWSER": "/x", "PATH": "/"}) == ["VIBROSCOPE_PROT"]


def test_each_server_gets_a_key_of_its_own():
    assert from_environment({}).secret_key != from_environment({}).secret_key
