"""Security headers of every answer, from the page to a 404.

An output transform sets them, which is Tornado's own door for what leaves an application, since the answers come from a
dozen handlers of three libraries. A request that Tornado refuses before there is a handler gets them from
`connections.Stream`, and the proxy's own answers from ``deploy/nginx.conf``.

The policy allows no other host and no ``eval``. Bokeh needs inline scripts and styles (it does not support nonces), and
Panel loads the code of components as ``blob:``.

Under which names browsers may reach the server, checked before anything else is done for a request.

Tornado and Bokeh accept a websocket whose Origin equals its Host, so that a name which somebody points at this machine
(DNS rebinding) would be as good as the server's own. Hence the Host of every request must be one that the server was
given, and the Origin of every websocket, too.
"""

import logging
from urllib.parse import urlsplit

from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.routing import Matcher
from tornado.web import OutputTransform, RequestHandler
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import TokenBucket
from vibroscope.app.runtime.settings import Settings

_DEFAULT_PORTS = {"http": ":80", "https": ":443"}
_LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
_MOST_CHARACTERS = 100  # of a name that is logged
_log_rate = TokenBucket(rate=1, burst=10)


def without_default_port(host: str) -> str:
    """Return a host in the form in which hosts are compared: browsers omit the port of the scheme."""
    for port in _DEFAULT_PORTS.values():
        host = host.removesuffix(port)
    return host


def allowed_origins(chosen: Settings, port: int) -> frozenset[str]:
    """Return the hosts from whose pages browsers may open a websocket."""
    hosts = chosen.origins or (f"{chosen.host}:{port}", f"localhost:{port}")
    return frozenset(map(without_default_port, hosts))


def allowed_hosts(chosen: Settings, port: int) -> frozenset[str]:
    """Return the hosts that a request may name: the origins, and this machine for health checks and metrics."""
    return allowed_origins(chosen, port) | {without_default_port(f"{name}:{port}") for name in _LOOPBACK}


def is_allowed_origin(request: HTTPServerRequest, origins: frozenset[str]) -> bool:
    """Return whether the websocket comes from a page of one of the origins; one that is refused is logged."""
    origin = request.headers.get("Origin", "")
    try:
        parts = urlsplit(origin)
    except ValueError:  # an address with half a bracket
        parts = urlsplit("")
    host = parts.netloc.lower().removesuffix(_DEFAULT_PORTS.get(parts.scheme, ":"))
    if parts.scheme in _DEFAULT_PORTS and host in origins:
        return True
    log_refused("origin", request, origin=origin[:_MOST_CHARACTERS])
    return False


def log_refused(what: str, request: HTTPServerRequest, **details: object) -> None:
    """Count a refused request and log it, at most so many a second."""
    metrics.REFUSED.add(what)
    if _log_rate.take():
        logs.event("refused", logging.WARNING, what=what, address=request.remote_ip, **details)


class OtherHost(Matcher):
    """Matches requests that name a host which is not the server's."""

    def __init__(self, hosts: frozenset[str]) -> None:
        self._hosts = hosts

    def match(self, request: HTTPServerRequest) -> dict | None:
        """See `tornado.routing.Matcher`."""
        named = request.headers.get_list("Host")
        known = len(named) == 1 and without_default_port(named[0].strip().lower()) in self._hosts
        return None if known else {}


class Misdirected(RequestHandler):
    """The answer to a request that names a host which is not the server's."""

    def prepare(self) -> None:
        """Answer whatever the method is."""
        log_refused("host", self.request, host=self.request.headers.get("Host", "")[:_MOST_CHARACTERS])
        self.set_status(421)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(
            "This server does not answer under this name.\n"
            "Who runs it gives the names in VIBROSCOPE_ORIGINS (or --origin), as in the browser's address bar.\n"
        )


POLICY = {
    "default-src": "'none'",
    "script-src": "'self' 'unsafe-inline' blob:",
    "style-src": "'self' 'unsafe-inline'",
    "connect-src": "'self'",
    "img-src": "'self' data: blob:",
    "font-src": "'self' data:",
    "object-src": "'none'",
    "base-uri": "'self'",
    "form-action": "'none'",
    "frame-ancestors": "'none'",
}
HEADERS = {
    "Content-Security-Policy": "; ".join(f"{name} {sources}" for name, sources in POLICY.items()),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",  # for browsers that do not support frame-ancestors
    "Referrer-Policy": "no-referrer",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class SecurityHeaders(OutputTransform):
    """Adds the headers and removes the one that names the server's version."""

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """See `tornado.web.OutputTransform`."""
        for name, value in HEADERS.items():
            headers[name] = value
        headers.pop("Server", None)
        return status_code, headers, chunk
