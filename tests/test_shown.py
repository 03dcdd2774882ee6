"""The outputs and figures that pages of the documentation show are those of the present program."""

import importlib.util
import re

import matplotlib as mpl
import numpy as np
import pytest

from tests.displayed import ROOT

spec = importlib.util.spec_from_file_location("shown", ROOT / "docs/shown.py")
shown = importlib.util.module_from_spec(spec)
spec.loader.exec_module(shown)

TIMES = re.compile(r"^(solved in) .*", re.MULTILINE)
BLOCKS = [(page, block) for page in shown.pages() for block in shown.BLOCK.finditer(page.read_text())]


@pytest.mark.parametrize(("page", "block"), BLOCKS, ids=[f"{page.stem}-{k}" for k, (page, _) in enumerate(BLOCKS)])
def test_an_output_is_that_of_the_command(page, block):
    assert TIMES.sub(r"\1", block["output"]) == TIMES.sub(r"\1", shown.shown(block))


def test_pages_show_outputs_and_all_figures():
    assert {"start.md", "choosing.md"} <= {page.name for page in shown.pages()}
    texts = "".join(page.read_text() for page in shown.pages())
    assert all(f"](figures/{name}.svg)" in texts for name in shown.DRAWN)


@pytest.mark.parametrize("name", shown.DRAWN)
def test_a_figure_is_what_its_script_draws(name, tmp_path):
    """Its numbers to half a point; the letters are those of the same version of matplotlib."""
    with mpl.rc_context():
        mpl.use("agg")
        drawn = shown.draw(name, tmp_path).read_text()
    kept, drawn = (re.findall(r' d="([^"]*)"', text) for text in ((shown.FIGURES / f"{name}.svg").read_text(), drawn))
    assert len(kept) == len(drawn) > 10
    numbers = [[np.array(re.findall(r"-?\d+\.?\d*", path), float) for path in paths] for paths in (kept, drawn)]
    assert all(len(a) == len(b) and np.allclose(a, b, atol=0.5) for a, b in zip(*numbers, strict=True))
