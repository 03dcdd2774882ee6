"""Where the files beside the code lie: scenes, styles, the page, shipped diagrams."""

from __future__ import annotations

from functools import cache
from pathlib import Path

ASSETS = Path(__file__).resolve().parent.parent / "assets"
_VIEWS = Path(__file__).resolve().parent / "views"


@cache
def asset(name: str) -> str:
    """The text of one file in ``assets``."""
    return (ASSETS / name).read_text(encoding="utf-8")


def style(*names: str) -> str:
    """Style sheets of ``assets/style``, one after the other."""
    return "\n".join(asset(f"style/{name}.css") for name in names)


@cache
def script(*names: str) -> str:
    """Scripts of ``app/views``, one after the other: one module, since a module of the page can import no file."""
    return "\n".join((_VIEWS / f"{name}.js").read_text(encoding="utf-8") for name in names)
