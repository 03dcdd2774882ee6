"""Templates, style sheets and scripts, which lie beside the Python of what they belong to."""

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
    """Style sheets such as ``shared/page``, one after the other."""
    return "\n".join((_PAGE / f"{name}.css").read_text(encoding="utf-8") for name in names)


@cache
def script(*names: str) -> str:
    """Scripts such as ``shared/dom`` as one module, since a module of the page can import no file."""
    return "\n".join((_PAGE / f"{name}.js").read_text(encoding="utf-8") for name in names)
