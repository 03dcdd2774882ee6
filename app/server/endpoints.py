"""The HTTP endpoints beside the websocket and the static files."""

import hmac
import ipaddress
import logging
import re

from tornado.web import RequestHandler
from vibroscope.app.page.files import template
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.settings import current_settings

# Headers of proxies: X-Forwarded-For, Via, X-Real-Ip, CF-Connecting-IP, True-Client-IP, Fastly-Client-IP, CDN-Loop …
_OF_PROXY = re.compile(r"forward|^via$|real-ip|client-ip|connecting-ip|^cf-|cdn-|proxy|original", re.IGNORECASE)


class Page(RequestHandler):
    """The page."""

    def get(self) -> None:
        """Send the page with the token of a session, or the reason why nobody is admitted."""
        admission = self.application.settings["admission"]
        self.set_header("Cache-Control", "no-store")  # the token is for one browser
        self.set_header("Content-Type", "text/html; charset=utf-8")
        reason = admission.refusal()
        if reason:
            metrics.REFUSED.add("session")
            logs.event("refused", logging.WARNING, what="page", reason=reason, address=self.request.remote_ip)
            self.set_status(503)
            self.set_header("Retry-After", "60")
            self.write(template("shared/refused.html").replace("REASON", reason))
            return
        self.write(admission.page(plain=self.request.method == "GET" and not self.request.query))

    def head(self) -> None:
        """Send the same headers."""
        self.get()


class UnreadableAddress(RequestHandler):
    """The answer to every address that contains a control character."""

    def prepare(self) -> None:
        """Answer whatever the method is."""
        self.set_status(400)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("This address cannot be read: it holds a control character.\n")


class Liveness(RequestHandler):
    """Whether the server answers; Panel's own endpoint can be asked to build a whole session."""

    def get(self) -> None:
        """Answer with one word; with 503 while the server stops, so that a proxy sends no more visitors."""
        if self.application.settings["admission"].stopping:
            self.set_status(503)
        self.write("alive\n")


class Metrics(RequestHandler):
    """The metrics, for requests from this machine or with the token."""

    def get(self) -> None:
        """Send everything that `app.runtime.metrics` counts."""
        if not (self._has_token() or self._is_local()):
            self.send_error(404)
            return
        self.set_header("Content-Type", "text/plain; version=0.0.4; charset=utf-8")
        self.write(metrics.exposition())

    def _has_token(self) -> bool:
        token = current_settings().metrics_token
        given = self.request.headers.get("Authorization", "")
        return bool(token) and hmac.compare_digest(given.encode(), f"Bearer {token}".encode())

    def _is_local(self) -> bool:
        """Return whether the request comes from this machine and not through a proxy on it.

        A proxy names itself or its client in a header, each in one of its own, or asks for the public name of the page.
        """
        proxied = any(_OF_PROXY.search(name) for name in self.request.headers)
        host = self.request.host_name.strip("[]")
        return not proxied and all(map(_is_loopback, (self.request.remote_ip, host)))


def _is_loopback(host: str | None) -> bool:
    """Whether a name or address is this machine's own."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:  # a Unix socket has no address
        return False


def log_answer(handler: RequestHandler) -> None:
    """Count and log an answered request; Tornado calls this at the end of each."""
    status = handler.get_status()
    metrics.REQUESTS.add(str(status))
    level = logging.ERROR if status >= 500 and status != 503 else logging.DEBUG
    request = handler.request
    details = {"status": status, "path": request.path, "address": request.remote_ip, "seconds": request.request_time()}
    logs.event("answered", level, **details)
