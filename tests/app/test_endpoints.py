"""HTTP endpoints: security headers, what is served and what is not, metrics, and the cost of a page request."""

import asyncio
import socket
import urllib.request

import pytest
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application
from vibroscope.app.server.endpoints import Metrics
from vibroscope.app.server.security import HEADERS

from tests.browserless import get
from tests.waiting import PATIENCE


def run(steps):
    return asyncio.run(asyncio.wait_for(steps, PATIENCE))


def test_every_answer_carries_the_headers(server):
    pages = "/", "/nothing", "/docs/", "/docs/start.html", "/docs/no"
    for path in (*pages, "/static/js/bokeh.min.js", "/liveness", "/speed/work-precision.svg"):
        headers = run(get(server.url + path)).headers
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
        assert "unsafe-eval" not in headers["Content-Security-Policy"]
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert "Server" not in headers


@pytest.mark.parametrize("request_line", ["GET", "GET / HTTP/1.1\r\nContent-Length: x", "GET / HTTP/1.1\r\n: x"])
def test_a_request_that_cannot_be_read_is_refused_with_the_headers(server, request_line):
    with socket.create_connection(("127.0.0.1", server.port), 20) as connection:
        connection.sendall(f"{request_line}\r\n\r\n".encode())
        answer = b"".join(iter(lambda: connection.recv(4096), b"")).decode()
    head, _, body = answer.partition("\r\n\r\n")
    status, *lines = head.split("\r\n")
    assert status == "HTTP/1.1 400 Bad Request"
    assert not body
    assert dict(line.split(": ", 1) for line in lines) == HEADERS | {"Content-Length": "0"}


def test_endpoints_that_the_page_does_not_need_are_not_served(server):
    for path in (
        "/autoload.js?bokeh-autoload-element=x",
        "/metadata",
        "/components/this/x/_css/y",
        "/admin",
        "/index.html",
    ):
        assert run(get(server.url + path)).code == 404, path


@pytest.mark.parametrize(
    "path", ["/%00", "/static/%00", "/speed/x%00.svg", "/components/%0A", "/liveness%7f", "/%1F/ws"]
)
def test_an_address_with_a_control_character_is_refused_in_words(server, path):
    for method in ("GET", "HEAD", "DELETE"):
        answer = run(get(server.url + path, method=method))
        assert answer.code == 400
        assert (b"cannot be read" in answer.body) == (method != "HEAD")
        assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]


def test_metrics_are_served_to_this_machine_alone(server):
    assert run(get(f"{server.url}/metrics")).code == 200
    for name in ("X-Forwarded-For", "X-Real-IP", "Via", "Forwarded", "CF-Connecting-IP", "True-Client-IP", "CDN-Loop"):
        assert run(get(f"{server.url}/metrics", headers={name: "127.0.0.1"})).code == 404, name


def test_metrics_are_for_requests_by_a_name_of_this_machine():
    """Who comes through a proxy that names nobody asks for the public name."""

    async def steps():
        (sock,) = bind_sockets(0, "127.0.0.1")
        listener, url = HTTPServer(Application([("/metrics", Metrics)])), f"http://127.0.0.1:{sock.getsockname()[1]}"
        listener.add_sockets([sock])
        names = "localhost", "[::1]:5006", "vibroscope.example"
        found = [(await get(f"{url}/metrics", headers={"Host": name})).code for name in names]
        listener.stop()
        return found

    assert run(steps()) == [200, 200, 404]


def test_a_page_request_is_cheap_and_builds_no_session(server):
    held, before = server.metric("vibroscope_sessions "), server.cpu()
    for _ in range(50):
        urllib.request.urlopen(server.url).close()
    assert (server.cpu() - before) / 50 < 0.02
    assert server.metric("vibroscope_sessions ") <= held
