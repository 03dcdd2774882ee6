"""A page's token is valid for some minutes, whatever happens to the time of day meanwhile."""

import json

import pytest
from bokeh.util import token as bokeh_token
from bokeh.util.token import generate_jwt_token, generate_session_id
from vibroscope.app.server import admission
from vibroscope.app.server.admission import TOKEN_SECONDS, is_valid_token, make_token

KEY, OTHER = b"k" * 48, b"o" * 48
DAY = 24 * 3600
SESSION = generate_session_id(secret_key=KEY, signed=True)


@pytest.fixture
def clocks(monkeypatch):
    """The monotonic clock and the time of day, in seconds; a test sets them."""
    now = {"monotonic": 1000.0, "time": 1.8e9}
    for name in now:
        monkeypatch.setattr(admission.time, name, lambda name=name: now[name])
    return now


@pytest.mark.parametrize("jump", [-400 * DAY, 0, 400 * DAY])
def test_a_token_ages_by_the_monotonic_clock(clocks, jump):
    token = make_token(SESSION, KEY)
    clocks["time"] += jump
    assert is_valid_token(token, KEY)
    clocks["monotonic"] += TOKEN_SECONDS - 1
    assert is_valid_token(token, KEY)
    clocks["monotonic"] += 2
    assert not is_valid_token(token, KEY)


def test_a_token_of_another_replica_ages_by_the_time_of_day(clocks, monkeypatch):
    token = make_token(SESSION, KEY)
    made = json.loads(bokeh_token._base64_decode(token.split(".")[0]))["session_expiry"] - TOKEN_SECONDS
    monkeypatch.setattr(admission, "PROCESS", "another")
    clocks["monotonic"] = 0
    for age, valid in ((0, True), (TOKEN_SECONDS - 2, True), (TOKEN_SECONDS + 2, False)):
        clocks["time"] = made + age
        assert is_valid_token(token, KEY) == valid


def test_what_this_server_did_not_sign_is_no_token(clocks):
    token = make_token(SESSION, KEY)
    plain = generate_jwt_token(SESSION, secret_key=KEY, signed=True)  # signed, but without an age
    for forged in ("", "x", token[:-1], token.split(".")[0], plain, make_token(SESSION, OTHER)):
        assert not is_valid_token(forged, KEY)
