"""The glossary of the page is one: Help shows it, the page knows it, and no word opens two entries."""

import json
from collections import Counter

import pytest
from vibroscope.app.explorer.field_units import unit_of
from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.help.tab import Help, glossary_rows

from tests.app.fakes import FakeHost
from tests.served import ROOT


def test_no_word_opens_two_entries():
    words = Counter(word.lower() for entry in glossary() for word in entry.opens)
    assert [word for word, count in words.items() if count > 1] == []
    heads = [entry.head for entry in glossary()]
    assert len(set(heads)) == len(heads)
    assert all(entry.text and entry.opens for entry in glossary())


def test_the_unit_of_the_damper_is_one():
    """Beside the number, in Help, in the glossary and in the table of symbols."""
    unit = unit_of("contact_damping", Setting())
    assert any(f"a multiple of {unit}, D = c/({unit})" in entry.text for entry in glossary() if entry.head == "D")
    assert f"{unit} for dampings" in (ROOT / "app/page/help/help.html").read_text()
    assert f"| 1; {unit} | `damping`" in (ROOT / "docs/theory/symbols.md").read_text()


def test_help_shows_every_entry():
    text = Help(FakeHost()).build().object
    assert glossary_rows() in text
    assert "GLOSSARY" not in text
    assert text.count('<th scope="row">') == len(glossary()) > 20
    first = glossary()[0]
    assert json.loads(json.dumps(glossary()))[0] == [first.head, first.text, list(first.opens), first.read]


@pytest.mark.parametrize(
    "path",
    [
        "assets/glossary.toml",
        "assets/scenes.toml",
        "app/page/help/help.html",
        "app/page/header/exercises.js",
        "app/page/header/tour.js",
        "README.md",
    ],
)
def test_what_the_time_step_makes_of_a_section_has_one_word(path):
    """It is blurred; "scatter" is the name of a column and of a number in Python alone."""
    of_the_page = (ROOT / path).read_text(encoding="utf-8").partition("[code]")[0]  # of the glossary
    assert "scatter" not in of_the_page.lower()
