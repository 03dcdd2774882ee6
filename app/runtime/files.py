"""The data files of the package: scenes, shipped figures and diagrams, 60-digit solutions."""

from functools import cache
from importlib.resources import files

from vibroscope import assets

ASSETS = files(assets)


@cache
def asset(name: str) -> str:
    """Return the text of one file in ``assets``."""
    return (ASSETS / name).read_text(encoding="utf-8")
