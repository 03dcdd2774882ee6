"""The table of symbols: whatever letter the displayed formulas of the theory use has a row."""

import re
from pathlib import Path

import pytest

from tests.displayed import BLOCK, TAG
from tests.tex import plain

THEORY = Path(__file__).parents[1] / "docs/theory"
PAGES = [page for page in THEORY.glob("*.md") if page.name not in ("symbols.md", "index.md")]
# A Greek letter, or a Latin one that is no part of a word, with its accent and index.
INDEX = "(?:_[A-Za-z](?![A-Za-z])|[₀-₉ᵢⱼₘₙₓₛₑᵤ∞]+)"
SYMBOL = re.compile(
    rf"[Α-ωϕ][\u0302-\u0304]?{INDEX}?"
    rf"|(?<![A-Za-z])[A-Za-z](?:[\u0302-\u0304]{INDEX}?|{INDEX}|(?![A-Za-z\u0302-\u0308]))"
)
COMMON = {*"πdijΣxO"}  # of all mathematics


def symbols_in(text):
    """Without which body it is: ξ₁ and ξᵢ are one symbol."""
    return {re.sub("[₁₂₃₄ᵢⱼ]+", "ᵢ", symbol) for symbol in SYMBOL.findall(text)}


def table():
    rows = re.findall(r"^\| (.*?) \|", (THEORY / "symbols.md").read_text(), re.MULTILINE)
    return symbols_in(" ".join(rows))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_symbol_of_a_formula_has_a_row(page):
    shown = [TAG.sub("", tex) for tex in BLOCK.findall(page.read_text())]
    formulas = "\n".join(plain(re.sub(r"\\text\{[^}]*\}", " ", tex)) for tex in shown)
    used = symbols_in(formulas)
    assert used or not shown
    known = table() | COMMON
    assert not {symbol for symbol in used - known if symbol.rstrip("ᵢ") not in known}
