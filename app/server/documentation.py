"""The documentation under ``/docs``: the site that `make docs` builds and a wheel carries.

In a working copy in which it is not built, the links to its pages lead to their texts.
"""

from __future__ import annotations

from pathlib import Path

from tornado.web import RedirectHandler, RequestHandler
from vibroscope.app.page.files import template
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.server.static_files import StaticFile

SITE = Path(str(ASSETS / "site"))
SOURCES = SITE.parents[1] / "docs"  # of a working copy


class NotBuilt(RequestHandler):
    """The answer where the documentation was not built: the text of a page, or how to build them all."""

    def initialize(self, sources: Path) -> None:
        """``sources``: the folder of the texts, which need not be there."""
        self._texts = {
            path.relative_to(sources).with_suffix("").as_posix(): path for path in sorted(sources.rglob("*.md"))
        }

    def get(self, page: str | None = None) -> None:
        """Write the text of a page, named as in the site."""
        text = self._texts.get((page or "index").removesuffix(".html").removesuffix("/") or "index")
        if text is None:
            self.set_status(404)
            said = "The documentation has not been built here. Run “make docs”, then start the explorer again."
            self.write(template("shared/refused.html").replace("REASON", said))
        else:
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.write(text.read_bytes())


def documentation_routes(site: Path = SITE, sources: Path = SOURCES) -> list[tuple]:
    """The routes to a site in this folder, or to the texts of its pages."""
    if not (site / "index.html").is_file():
        return [(r"/docs(?:/(.*))?", NotBuilt, {"sources": sources})]
    files = {"path": str(site), "default_filename": "index.html"}
    return [(r"/docs", RedirectHandler, {"url": "docs/"}), (r"/docs/(.*)", StaticFile, files)]
