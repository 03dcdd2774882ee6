"""What a first visit loads: scripts and document are compressed, and scripts are kept where a digest names them."""

import asyncio
import gzip
import html
import json
import re
import urllib.error
import urllib.request
from urllib.parse import urljoin

import brotli
import pytest
from vibroscope.app.page.files import modules
from vibroscope.app.server import libraries, static_files

from tests.browserless import Client
from tests.waiting import PATIENCE


def get(url, **headers):
    """Status, headers and body."""
    headers = {name.replace("_", "-"): value for name, value in headers.items()}
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=PATIENCE) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as answer:
        with answer:
            return answer.status, answer.headers, answer.read()


@pytest.fixture(scope="module")
def page(server):
    return get(server.url)[2].decode()


@pytest.fixture(scope="module")
def scripts(server, page):
    found = re.findall(r'(?:<script[^>]* src|"modulepreload" href)="([^"]+)"', page)
    return [f"{server.url}/{address}" for address in found]


UNPACK = {"gzip": (gzip.decompress, 480_000), "br": (brotli.decompress, 370_000)}


@pytest.mark.parametrize(("accepted", "encoding"), [("gzip", "gzip"), ("gzip, br", "br"), ("br;q=0, gzip", "gzip")])
def test_every_script_is_compressed_and_kept_for_ever(scripts, accepted, encoding):
    (unpacked, most), sizes = UNPACK[encoding], {}
    for url in scripts:
        (_, plain, content), (_, packed, body) = get(url), get(url, Accept_Encoding=accepted)
        assert "Content-Encoding" not in plain
        assert packed["Content-Encoding"] == encoding
        assert unpacked(body) == content
        assert int(packed["Content-Length"]) == len(body)
        assert packed["Content-Type"].endswith("javascript")
        for headers in (plain, packed):
            assert headers["Cache-Control"] == "public, max-age=31536000, immutable"
            assert headers["Vary"] == "Accept-Encoding"
            assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert plain["Etag"] != packed["Etag"]
        sizes[url] = len(body)
    assert len(sizes) >= 3
    assert sum(sizes.values()) < most


def test_of_the_libraries_comes_what_the_page_uses(scripts):
    (url,) = (url for url in scripts if "/static/libraries/" in url)
    text = get(url)[2].decode()
    for name in libraries.MODELS.values():
        assert f".{name}=" in text
    assert "Copyright (c) Anaconda" in text
    assert len(text) < 60_000
    assert get(re.sub("[0-9a-f]{12}", 12 * "0", url))[0] == 404


@pytest.mark.parametrize("text", ["", '"a": function _(e){},\n', '({\n}, "a", {}, {});});\n'])
def test_a_bundle_of_another_form_is_refused(text, tmp_path, monkeypatch):
    (tmp_path / "panel.min.js").write_text(text)
    monkeypatch.setattr(libraries, "DIST_DIR", tmp_path)
    with pytest.raises(RuntimeError, match=r"panel\.min\.js is no table of modules: install"):
        libraries.script.__wrapped__()


def test_what_is_kept_compressed_is_read_unless_it_is_damaged(tmp_path, monkeypatch):
    monkeypatch.setattr(static_files, "cache_root", lambda: tmp_path)
    data = b"const a = 1;\n" * 10_000
    assert brotli.decompress(static_files.brotli_of(data[:1000])) == data[:1000]
    assert not list(tmp_path.rglob("*.br"))
    packed = static_files.brotli_of(data)
    (kept,) = tmp_path.rglob("*.br")
    for damaged in (packed, b"", packed[:-5], brotli.compress(b"other")):
        kept.write_bytes(damaged)
        assert brotli.decompress(static_files.brotli_of(data)) == data
        assert kept.read_bytes() == packed
    monkeypatch.setattr(static_files.brotli, "compress", lambda data: b"anew")
    assert static_files.brotli_of(data) == packed
    monkeypatch.setattr(static_files, "cache_root", lambda: kept)  # no folder: it cannot be written
    assert static_files.brotli_of(data) == b"anew"


def test_style_sheets_of_the_models_are_fetched_with_the_page(server, page):
    styles = re.findall(r'<link rel="stylesheet" media="not all" href="([^"]+)">', page.partition("</head>")[0])
    assert len(styles) >= 3
    for address in styles:
        status, headers, _ = get(f"{server.url}/{html.unescape(address)}")
        assert (status, headers["Content-Type"]) == (200, "text/css")
        assert "immutable" in headers["Cache-Control"]


def test_a_script_that_the_browser_has_is_not_sent_again(scripts):
    etag = get(scripts[0], Accept_Encoding="gzip")[1]["Etag"]
    status, _, body = get(scripts[0], Accept_Encoding="gzip", If_None_Match=etag)
    assert (status, body) == (304, b"")


def test_who_cannot_read_it_gets_it_as_it_is(server, scripts):
    for accepted in ("identity", "gzip;q=0", "br;q=0, gzip; q=0.0"):
        assert "Content-Encoding" not in get(scripts[0], Accept_Encoding=accepted)[1]
    assert get(scripts[0], Accept_Encoding="gzip", Range="bytes=0-9")[0] == 206
    _, icon, _ = get(f"{server.url}/static/extensions/panel/images/apple-touch-icon.png", Accept_Encoding="gzip")
    assert "Content-Encoding" not in icon
    assert "immutable" not in icon.get("Cache-Control", "")  # no digest names it


@pytest.fixture
def folder(scripts):
    """Address of the page's modules."""
    return next(url for url in scripts if url.endswith("/shared/dom.js")).removesuffix("/shared/dom.js")


def test_every_module_imports_modules_that_are_served(folder):
    for name, path in modules().items():
        text = get(f"{folder}/{name}.js")[2].decode()
        assert text == path.read_text()
        for other in re.findall(r'^(?:import|\}) .*from "([^"]+)"', text, re.MULTILINE):
            assert other.startswith(("./", "../"))
            assert get(urljoin(f"{folder}/{name}.js", other))[0] == 200


def test_a_page_of_another_version_gets_no_module_of_this_one(folder):
    another = re.sub("/[0-9a-f]{12}$", "/" + 12 * "0", folder)
    assert get(f"{another}/shared/dom.js", Accept_Encoding="gzip")[0] == 404


@pytest.mark.parametrize("path", ["files.py", "shared/page.css", "shared/dom.js/", "../server/server.py", "none.js"])
def test_nothing_but_modules_lies_beside_them(folder, path):
    assert get(f"{folder}/{path}", Accept_Encoding="gzip")[0] == 404


@pytest.mark.parametrize("path", ["static/js/none.js", "static/../server.py", "static/%2e%2e/%2e%2e/settings.py"])
def test_nothing_else_is_served(server, path):
    assert get(f"{server.url}/{path}", Accept_Encoding="gzip")[0] in (403, 404)


def test_the_page_can_be_read_before_its_scripts_have_come(page):
    head, body = page.split("<body>")
    scripts = re.findall(r"<script[^>]*>", head)
    assert len([script for script in scripts if "src=" in script]) >= 3
    for script in scripts:
        waits = "src=" in script and "defer" not in script and 'type="module"' not in script
        assert not waits, "a script that is not deferred keeps the page white"
    assert "Bokeh.set_log_level" not in head or '<script type="module">' in head
    assert body.index("Loading the page") < body.index("data-root-id")


def test_the_document_is_compressed_and_what_follows_is_not(server):
    """Counted message by message: what follows may have come before the document is read, on a busy machine."""
    inflated = []

    class Watched(Client):
        async def connect(self, *options):
            await super().connect(*options)
            packed = self.socket.protocol._decompressor
            inflate = packed.decompress

            def watched(data):
                text = inflate(data)
                inflated.append((len(data), len(text)))
                return text

            packed.decompress = watched
            return self

    async def steps():
        async with Watched(server.url, compression={}) as client:
            parts = [part for part in inflated if part[1] > 10_000]  # of the document, its buffers among them
            inflated.clear()
            await client.ready()
            await client.set(1, eta="1.3")
            return client.socket.headers["Sec-Websocket-Extensions"], len(json.dumps(client.document)), parts

    extensions, size, parts = asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert "permessage-deflate" in extensions
    assert max(held for _, held in parts) > size / 2 > 100_000
    assert all(sent < held / 3 for sent, held in parts)
    assert inflated == []
