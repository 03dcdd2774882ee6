"""The documentation under ``/docs``: the site that `make docs` builds and a wheel carries, or how to build it."""

from __future__ import annotations

from pathlib import Path

from tornado.web import RedirectHandler, RequestHandler
from vibroscope.app.page.files import template
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.server.static_files import StaticFile

SITE = Path(str(ASSETS / "site"))


class NotBuilt(RequestHandler):
    """The answer where the documentation was not built."""

    def get(self) -> None:
        """Say how to build it."""
        self.set_status(404)
        said = "The documentation has not been built here. Run “make docs”, then start the explorer again."
        self.write(template("shared/refused.html").replace("REASON", said))


def documentation_routes(site: Path = SITE) -> list[tuple]:
    """The routes to a site in this folder."""
    if not (site / "index.html").is_file():
        return [(r"/docs(?:/.*)?", NotBuilt)]
    files = {"path": str(site), "default_filename": "index.html"}
    return [(r"/docs", RedirectHandler, {"url": "docs/"}), (r"/docs/(.*)", StaticFile, files)]
