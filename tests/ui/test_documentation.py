"""The documentation on a phone in the dark: a site of its pages that compute nothing, built as by `make docs`."""

import subprocess
import sys

import pytest

from tests.served import ROOT

from .axe import AXE, serious

LEFT_OUT = "examples,extra,figures,gallery.md,notebook.ipynb,reference"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Its folder."""
    folder = tmp_path_factory.mktemp("site")
    call = [sys.executable, "-m", "sphinx", "-Q", "-D", f"exclude_patterns={LEFT_OUT}", "docs", str(folder)]
    subprocess.run(call, cwd=ROOT, check=True, capture_output=True, timeout=300)
    return folder


@pytest.mark.parametrize("name", ["index", "glossary", "theory/model"])
def test_a_page_can_be_read_on_a_phone_in_the_dark(site, windows, name):
    page = windows(390, 844, color_scheme="dark").new_page()
    page.goto((site / f"{name}.html").as_uri())
    page.evaluate(AXE)
    assert serious(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    shade = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/[\\d.]+/g).slice(0, 3)")
    assert max(float(part) for part in shade) < 64
    page.close()


@pytest.mark.parametrize(("width", "gap"), [(1440, True), (390, False)])
def test_the_number_of_a_formula_is_beside_it(site, windows, width, gap):
    """Within the column on a screen; on a phone without the gap that would put it out of sight."""
    page = windows(width).new_page()
    page.goto((site / "theory/penalty.html").as_uri())
    gaps = page.evaluate("[...document.querySelectorAll('.formula-gap')].map(one => one.offsetWidth > 0)")
    assert set(gaps) == {gap}
    if gap:
        outputs = "[...document.querySelectorAll('article pre')]"
        assert page.evaluate(f"{outputs}.filter(one => one.scrollWidth > one.clientWidth + 1).length") == 0
    page.close()
