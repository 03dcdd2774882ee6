"""Scripts and styles: compressed, and kept by browsers for ever where the address holds a digest of the content.

The documentation under ``/docs``: the site that `make docs` builds and a wheel carries.

In a working copy in which it is not built, the links to its pages lead to their texts.
"""

import asyncio
import gzip
import hashlib
import re
from contextlib import suppress
from functools import cache
from pathlib import Path

import brotli
from tornado.web import HTTPError, RedirectHandler, RequestHandler, StaticFileHandler
from vibroscope.app.page.files import template, version
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.server import libraries
from vibroscope.engine import cache_root

_TEXT = re.compile(r"\.(?:css|html|js|json|mjs|svg)$")
_ENCODINGS = "br", "gzip"  # the smaller first; browsers take the first over TLS and on their own machine only
_SECONDS = 365 * 24 * 3600
_LARGE = 100_000  # bytes: less takes milliseconds, and each version of the page has other modules


class StaticFile(StaticFileHandler):
    """A file of a library. Texts are compressed, to a fifth of their size."""

    of_one_content = False  # whether every address, and not only one with a version, holds a digest of the content

    def set_extra_headers(self, path: str) -> None:
        """See `tornado.web.StaticFileHandler`."""
        self.set_header("Vary", "Accept-Encoding")
        if self.of_one_content or self.get_query_argument("v", ""):
            self.set_header("Cache-Control", f"public, max-age={_SECONDS}, immutable")

    async def get(self, path: str, include_body: bool = True) -> None:
        """Send the file."""
        wanted = self.get_absolute_path(self.root, self.parse_url_path(path))
        encoding = _encoding(self.request.headers.get("Accept-Encoding", ""))
        if encoding is None or not _TEXT.search(wanted) or "Range" in self.request.headers:
            await super().get(path, include_body)
            return
        self.path = self.parse_url_path(path)
        self.absolute_path = self.validate_absolute_path(self.root, wanted)
        if self.absolute_path is None:
            return
        self.modified = self.get_modified_time()
        self.set_headers()
        self.set_header("Content-Encoding", encoding)
        self.set_header("Etag", f'{self.compute_etag()[:-1]}-{encoding}"')
        if self.check_etag_header():
            self.set_status(304)
            return
        body = await asyncio.to_thread(self.compressed, self.absolute_path, encoding)
        self.set_header("Content-Length", len(body))
        if include_body:
            self.write(body)

    @classmethod
    def whole(cls, path: str) -> bytes:
        """The content of a file."""
        return Path(path).read_bytes()

    @classmethod
    @cache
    def compressed(cls, path: str, encoding: str) -> bytes:
        """The compressed content of a file."""
        data = cls.whole(path)
        return brotli_of(data) if encoding == "br" else gzip.compress(data, compresslevel=9, mtime=0)


class Libraries(StaticFile):
    """The script of `app.server.libraries`, which is in no file."""

    of_one_content = True

    @classmethod
    def get_absolute_path(cls, root: str, path: str) -> str:
        """See `tornado.web.StaticFileHandler`."""
        return f"{root}/{path}"

    def validate_absolute_path(self, root: str, absolute_path: str) -> str:
        """See `tornado.web.StaticFileHandler`; 404 to a page of another version."""
        if absolute_path != libraries.address():
            raise HTTPError(404)
        return absolute_path

    @classmethod
    def whole(cls, path: str) -> bytes:
        """See `StaticFile`."""
        return libraries.script()

    @classmethod
    def get_content(cls, abspath: str, start: int | None = None, end: int | None = None) -> bytes:
        """See `tornado.web.StaticFileHandler`."""
        return libraries.script()[start:end]

    @classmethod
    def get_content_version(cls, abspath: str) -> str:
        """See `tornado.web.StaticFileHandler`."""
        return abspath

    def get_content_size(self) -> int:
        """See `tornado.web.StaticFileHandler`."""
        return len(libraries.script())

    def get_modified_time(self) -> None:
        """See `tornado.web.StaticFileHandler`."""


class Module(StaticFile):
    """A module of the page, at an address with the digest of all of them."""

    of_one_content = True

    async def get(self, digest: str, path: str, include_body: bool = True) -> None:
        """Send it; 404 to a page of another version, which must not get modules of this one."""
        if digest != version():
            raise HTTPError(404)
        await super().get(path, include_body)

    async def head(self, digest: str, path: str) -> None:
        """Send the same headers."""
        await self.get(digest, path, include_body=False)


def _encoding(accepted: str) -> str | None:
    """The best encoding that a browser accepts."""
    refused = r"\s*;\s*q=0(?:\.0*)?\s*(?:,|$)"
    return next((name for name in _ENCODINGS if re.search(rf"\b{name}\b(?!{refused})", accepted)), None)


def brotli_of(data: bytes) -> bytes:
    """Compressed; a large file as the cache folder has it, or anew: Bokeh's script takes two seconds."""
    if len(data) < _LARGE:
        return brotli.compress(data)
    kept = cache_root() / "compressed" / f"{hashlib.sha256(data).hexdigest()[:16]}.br"
    with suppress(OSError, brotli.error):
        found = kept.read_bytes()
        if brotli.decompress(found) == data:  # not half written or damaged
            return found
    made = brotli.compress(data)
    with suppress(OSError):  # the folder may be read-only, the disk full
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(made)
    return made


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
