"""The documentation under /docs."""

import asyncio
import re

import pytest
from tornado.httpclient import AsyncHTTPClient
from tornado.httpserver import HTTPServer
from tornado.testing import bind_unused_port
from tornado.web import Application
from vibroscope.app.page.help.tab import Help
from vibroscope.app.server.static_files import SOURCES, documentation_routes


@pytest.fixture
def site(tmp_path):
    (tmp_path / "theory").mkdir()
    (tmp_path / "index.html").write_text("the first page")
    (tmp_path / "theory/model.html").write_text("the model")
    return tmp_path


def answers(site, *paths, sources=SOURCES):
    """Status and text for each path, from a server with these routes alone."""

    async def ask():
        taken, port = bind_unused_port()
        server = HTTPServer(Application(documentation_routes(site, sources)))
        server.add_socket(taken)
        client = AsyncHTTPClient(force_instance=True)
        try:
            found = [await client.fetch(f"http://127.0.0.1:{port}{path}", raise_error=False) for path in paths]
        finally:
            client.close()
            server.stop()
            await server.close_all_connections()
        return [(answer.code, answer.body.decode(errors="replace")) for answer in found]

    return asyncio.run(ask())


def test_a_site_is_served_with_its_first_page(site):
    assert answers(site, "/docs", "/docs/", "/docs/theory/model.html") == [
        (200, "the first page"),
        (200, "the first page"),
        (200, "the model"),
    ]


def test_nothing_outside_the_site_is_served(site):
    (site.parent / "secret.html").write_text("secret")
    outside = "/docs/../secret.html", "/docs/%2e%2e/secret.html", "/docs//etc/passwd", "/docs/no"
    for code, text in answers(site, *outside):
        assert code in (403, 404)
        assert "secret" not in text


def test_without_a_site_the_answer_says_how_to_build_it(tmp_path):
    ((code, text),) = answers(tmp_path, "/docs/theory/model.html", sources=tmp_path / "none")
    assert code == 404
    assert "make docs" in text


def test_without_a_site_the_links_of_help_lead_to_the_texts_of_its_pages(tmp_path):
    links = sorted(set(re.findall(r'href="(docs/[\w./-]*)', Help(None).build().object)))
    assert {"docs/", "docs/start.html"} < set(links)
    for link, (code, text) in zip(links, answers(tmp_path, *(f"/{link}" for link in links)), strict=True):
        assert code == 200, link
        assert "\n# " in f"\n{text}", link
