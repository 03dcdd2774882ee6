"""The documentation as a site: it builds without a warning, its links lead somewhere, and it needs no other host.

Its pages can be read on a phone in the dark, and their formulas are typeset.
"""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from vibroscope import engine
from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.explorer.presets import scenes, shelf
from vibroscope.engine.sweeps import variables

from tests.served import ROOT
from tests.share import share
from tests.ui.axe import AXE, serious

LOADED = {("script", "src"), ("link", "href"), ("img", "src"), ("object", "data"), ("source", "srcset")}


class Links(HTMLParser):
    """The addresses that a page links to and loads, its anchors, and what its own scripts say."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.anchors, self.scripts, self.tag = [], [], set(), "", ""
        self.feed(text)

    def handle_data(self, data):
        self.scripts += data if self.tag == "script" else ""

    def handle_endtag(self, tag):
        self.tag = ""

    def handle_starttag(self, tag, attrs):
        self.tag = tag
        for name, value in attrs:
            if name == "id":
                self.anchors.add(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)
            elif (tag, name) in LOADED and not (tag == "link" and dict(attrs).get("rel") in ("index", "search")):
                self.loaded.append(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build it, the doctrees beside it; the gallery computes a share of its entries."""
    folder = tmp_path_factory.mktemp("site")
    computed = f"gallery_computed={share(len(scenes()) + len(shelf()))}"
    strict = ["--fail-on-warning", "--keep-going", "--quiet"]
    call = [sys.executable, "-m", "sphinx", *strict, "--define", computed, "docs", str(folder)]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {path.relative_to(folder).as_posix(): Links(path.read_text()) for path in folder.rglob("*.html")}, folder


def target_of(page, link):
    """Path in the site and anchor of a link on a page."""
    file, _, anchor = unquote(link).partition("#")
    parts = [*Path(page).parent.parts, *Path(file).parts] if file else Path(page).parts
    path = []
    for part in parts:
        path = path[:-1] if part == ".." else [*path, part]
    return "/".join(path), anchor


def test_every_link_and_every_file_of_the_site_exists(site):
    pages, folder = site
    dead = []
    for page, found in pages.items():
        for link in (*found.links, *found.loaded):
            if re.match(r"[a-z]+:", link):
                continue
            path, anchor = target_of(page, link.partition("?")[0])
            if not (folder / path).is_file() or (anchor and path in pages and anchor not in pages[path].anchors):
                dead.append((page, link))
    assert len(pages) > 20
    assert not dead


def test_the_site_loads_nothing_from_another_host(site):
    pages, folder = site
    loaded = [link for found in pages.values() for link in found.loaded if not link.startswith("data:")]
    assert loaded
    assert not [link for link in loaded if "//" in link]
    assert not [page for page, found in pages.items() if re.search("https?://", found.scripts)]
    styles = [path.read_text() for path in folder.rglob("*.css")]
    assert styles
    assert not [found for text in styles for found in re.findall(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//", text)]


def test_it_can_be_searched(site):
    assert "newmark" in (site[1] / "searchindex.js").read_text()


def test_each_term_of_the_page_leads_to_a_section(site):
    pages, _ = site
    for entry in glossary():
        page, _, anchor = entry.read.partition("#")
        assert not anchor or anchor in pages[page].anchors, entry


def test_the_reference_names_everything_that_is_public(site):
    anchors = site[0]["reference/python.html"].anchors
    assert not [name for name in engine.__all__ if f"vibroscope.engine.{name}" not in anchors]


def test_the_reference_names_every_variable_of_a_store(site):
    text = (site[1] / "reference/files.html").read_text()
    tables = (variables.MOTION, variables.EXPONENT, variables.ERRORS, variables.SOLUTIONS, variables.REFERENCE)
    names = {name for table in (*tables, variables.IMPACT_PHASE, variables.MOTIONS_REACHED) for name in table}
    assert not [name for name in names if f">{name}<" not in text]


@pytest.mark.parametrize("name", ["index", "glossary", "theory/model"])
def test_a_page_can_be_read_on_a_phone_in_the_dark(site, windows, name):
    page = windows(390, 844, scheme="dark").new_page()
    page.goto((site[1] / f"{name}.html").as_uri())
    page.evaluate(AXE)
    assert serious(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    shade = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/[\\d.]+/g).slice(0, 3)")
    assert max(float(part) for part in shade) < 64
    page.close()


@pytest.mark.parametrize("width", [1440, 390])
def test_a_formula_is_typeset_with_its_number_in_sight(site, windows, width):
    page = windows(width, 844).new_page()
    page.goto((site[1] / "theory/penalty.html").as_uri())
    shown = page.evaluate("""[...document.querySelectorAll('.formula')].map(one => {
        const [math, own, number] = [one.querySelector('math'), one, one.querySelector('.formula-number')]
            .map(part => part?.getBoundingClientRect())
        return [math.width > 20 && math.height > 10, !number || (number.left > own.left && number.right <= innerWidth)]
    })""")
    assert len(shown) > 5
    assert all(all(one) for one in shown)
    if width > 1000:
        outputs = "[...document.querySelectorAll('article pre')]"
        assert page.evaluate(f"{outputs}.filter(one => one.scrollWidth > one.clientWidth + 1).length") == 0
    page.close()
