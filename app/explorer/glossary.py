"""The words and symbols of the page, each explained once: ``assets/glossary.toml``."""

import tomllib
from functools import cache
from typing import NamedTuple

from vibroscope.app.runtime.files import asset


class Entry(NamedTuple):
    """One entry: its head, what it means, the words on the page that open it, and where the documentation says more."""

    head: str
    text: str
    opens: tuple[str, ...]
    read: str


@cache
def glossary() -> tuple[Entry, ...]:
    """All entries, in the order of Help."""
    tables = tomllib.loads(asset("glossary.toml"))
    entries = tables["symbol"] + tables["entry"]
    return tuple(Entry(one["head"], one["text"], tuple(one["opens"]), one["read"]) for one in entries)
