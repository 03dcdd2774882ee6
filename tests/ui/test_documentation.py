"""The documentation on a phone in the dark: a site of its pages that compute nothing, built as by `make docs`."""

import subprocess
import sys

import pytest

from tests.served import ROOT
from tests.ui.axe import AXE, serious

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
    page = windows(390, 844, scheme="dark").new_page()
    page.goto((site / f"{name}.html").as_uri())
    page.evaluate(AXE)
    assert serious(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    shade = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/[\\d.]+/g).slice(0, 3)")
    assert max(float(part) for part in shade) < 64
    page.close()


@pytest.mark.parametrize("width", [1440, 390])
def test_a_formula_is_typeset_with_its_number_in_sight(site, windows, width):
    page = windows(width, 844).new_page()
    page.goto((site / "theory/penalty.html").as_uri())
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
