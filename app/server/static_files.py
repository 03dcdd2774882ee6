"""Scripts and styles: compressed, and kept by browsers for ever where the address holds a digest of the content."""

from __future__ import annotations

import asyncio
import gzip
import re
from functools import cache
from pathlib import Path

from tornado.web import HTTPError, StaticFileHandler
from vibroscope.app.page.files import version

_TEXT = re.compile(r"\.(?:css|html|js|json|mjs|svg)$")
_GZIP = re.compile(r"\bgzip\b(?!\s*;\s*q=0(?:\.0*)?\s*(?:,|$))")
_SECONDS = 365 * 24 * 3600


class StaticFile(StaticFileHandler):
    """A file of a library. Texts are compressed once in the life of the process, to a quarter of their size."""

    def set_extra_headers(self, path: str) -> None:
        """See `tornado.web.StaticFileHandler`."""
        self.set_header("Vary", "Accept-Encoding")
        if self.is_of_one_content():
            self.set_header("Cache-Control", f"public, max-age={_SECONDS}, immutable")

    def is_of_one_content(self) -> bool:
        """Whether the address holds a digest of the content."""
        return bool(self.get_query_argument("v", ""))

    async def get(self, path: str, include_body: bool = True) -> None:
        """Send the file."""
        wanted = self.get_absolute_path(self.root, self.parse_url_path(path))
        accepted = self.request.headers.get("Accept-Encoding", "")
        if not (_GZIP.search(accepted) and _TEXT.search(wanted)) or "Range" in self.request.headers:
            await super().get(path, include_body)
            return
        self.path = self.parse_url_path(path)
        self.absolute_path = self.validate_absolute_path(self.root, wanted)
        if self.absolute_path is None:
            return
        self.modified = self.get_modified_time()
        self.set_headers()
        self.set_header("Content-Encoding", "gzip")
        self.set_header("Etag", f'{self.compute_etag()[:-1]}-gzip"')
        if self.check_etag_header():
            self.set_status(304)
            return
        body = await asyncio.to_thread(_compressed, self.absolute_path)
        self.set_header("Content-Length", len(body))
        if include_body:
            self.write(body)


class Module(StaticFile):
    """A module of the page, at an address with the digest of all of them."""

    def is_of_one_content(self) -> bool:
        """See `StaticFile`."""
        return True

    async def get(self, digest: str, path: str, include_body: bool = True) -> None:
        """Send it; 404 to a page of another version, which must not get modules of this one."""
        if digest != version():
            raise HTTPError(404)
        await super().get(path, include_body)

    async def head(self, digest: str, path: str) -> None:
        """Send the same headers."""
        await self.get(digest, path, include_body=False)


@cache
def _compressed(path: str) -> bytes:
    return gzip.compress(Path(path).read_bytes(), compresslevel=9, mtime=0)
