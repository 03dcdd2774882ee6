"""Whoever names another host than the server's, or comes from another page, gets nothing; with TLS and a port, too."""

import http.client
import json

import pytest

from tests.served import served
from tests.waiting import PATIENCE

ORIGINS = "example.org,shaken.example:8443"


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    log = tmp_path_factory.mktemp("hosts") / "log.txt"
    with served(log, VIBROSCOPE_LOG_FORMAT="json", VIBROSCOPE_ORIGINS=ORIGINS) as server:
        yield server
    lines = [json.loads(line) for line in log.read_text().splitlines() if line.startswith("{")]
    refused = [line for line in lines if line["event"] == "refused"]
    assert refused
    assert {(line["level"], line["address"]) for line in refused} == {("warning", "127.0.0.1")}
    assert not [line for line in lines if "traceback" in line or line["level"] == "error"]


def ask(server, path, host, headers=()):
    """Status and text of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    try:
        connection.putrequest("GET", path, skip_host=True)
        for name, value in [*(("Host", each) for each in host), *headers]:
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.read().decode() if answer.status != 101 else ""
    finally:
        connection.close()


def knock(server, host, origin, *more):
    """Status of an attempt to open a websocket with a valid token."""
    _, page = ask(server, "/", ["example.org"])
    token = page.partition('"token":"')[2].partition('"')[0]
    assert token
    headers = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Protocol": f"bokeh, {token}",
    }
    headers |= {} if origin is None else {"Origin": origin}
    return ask(server, "/ws", [host], [*headers.items(), *more])[0]


@pytest.mark.parametrize("path", ["/", "/ws", "/metrics", "/liveness", "/static/js/bokeh.min.js", "/favicon.ico"])
@pytest.mark.parametrize("host", [["evil.example"], ["example.org.evil.example"], ["example.org:5"], ["a", "b"]])
def test_another_host_gets_nothing(server, path, host):
    status, text = ask(server, path, host)
    assert status in (400, 421)  # two hosts: Tornado's own refusal
    assert "token" not in text


def test_the_refusal_says_what_to_do_and_its_log_does_not_name_another_client(server):
    status, text = ask(server, "/", ["evil.example"], [("X-Forwarded-For", "203.0.113.7")])  # the fixture reads the log
    assert status == 421
    assert "VIBROSCOPE_ORIGINS" in text


@pytest.mark.parametrize("host", ["example.org", "EXAMPLE.org:443", "example.org:80", "shaken.example:8443"])
def test_its_own_names_are_served(server, host):
    assert ask(server, "/", [host])[0] == 200


def test_health_checks_and_metrics_are_served_on_this_machine(server):
    for path in ("/liveness", "/metrics"):
        assert ask(server, path, [f"127.0.0.1:{server.port}"])[0] == 200


@pytest.mark.parametrize(
    ("host", "origin", "more"),
    [
        ("evil.example", "http://evil.example", ()),
        ("example.org", "http://evil.example", ()),
        ("example.org", "http://evil.example", [("Sec-Fetch-Site", "same-origin")]),
        ("example.org", "https://shaken.example", ()),
        ("example.org", "https://example.org:8443", ()),
        ("example.org", "null", ()),
        ("example.org", "file://example.org", ()),
        ("example.org", "http://[::1", ()),
        ("example.org", None, ()),
    ],
)
def test_a_websocket_from_another_page_is_refused(server, host, origin, more):
    assert knock(server, host, origin, *more) in (403, 421)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("example.org", "https://example.org"),
        ("example.org", "http://example.org"),
        ("shaken.example:8443", "https://shaken.example:8443"),
    ],
)
def test_a_websocket_from_its_own_page_is_opened(server, host, origin):
    assert knock(server, host, origin) == 101
