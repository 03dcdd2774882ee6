"""Templates, style sheets and scripts; each lies beside the Python module that uses it."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from vibroscope.app import page

_PAGE = files(page)


@cache
def template(name: str) -> str:
    """The text of an HTML file, such as ``shared/page.html``."""
    return (_PAGE / name).read_text(encoding="utf-8")


@cache
def style(*names: str) -> str:
    """Style sheets such as ``shared/page``, concatenated."""
    return "\n".join((_PAGE / f"{name}.css").read_text(encoding="utf-8") for name in names)


@cache
def script(*names: str) -> str:
    """Scripts such as ``shared/dom``, concatenated to one module: a module of the page cannot import files."""
    return "\n".join((_PAGE / f"{name}.js").read_text(encoding="utf-8") for name in names)
