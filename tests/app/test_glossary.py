"""The glossary of the page is one: Help shows it, the page knows it, and no word opens two entries."""

import json
from collections import Counter

from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.page.help.tab import Help, glossary_rows

from .fakes import FakeHost


def test_no_word_opens_two_entries():
    words = Counter(word.lower() for entry in glossary() for word in entry.opens)
    assert [word for word, count in words.items() if count > 1] == []
    heads = [entry.head for entry in glossary()]
    assert len(set(heads)) == len(heads)
    assert all(entry.text and entry.opens for entry in glossary())


def test_help_shows_every_entry():
    text = Help(FakeHost()).build().object
    assert glossary_rows() in text
    assert "GLOSSARY" not in text
    assert text.count('<th scope="row">') == len(glossary()) > 20
    first = glossary()[0]
    assert json.loads(json.dumps(glossary()))[0] == [first.head, first.text, list(first.opens), first.read]
