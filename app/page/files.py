"""Templates, style sheets and scripts; each lies beside the Python module that uses it.

Scripts are modules that the server sends (`app.server.static_files.Module`). Their addresses hold a digest of them all,
so that a browser keeps them for good and modules of two versions never meet.
"""

import hashlib
from functools import cache
from importlib.resources import files
from pathlib import Path

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


def address_of(name: str) -> str:
    """Where the page finds a module such as ``shared/compat``, relative to its own address."""
    return f"static/page/{version()}/{name}.js"


def esm(name: str) -> str:
    """The module of a component, as Panel takes it: a text, which brings the module that draws the component.

    Panel gives the text an address of its own, against which a browser resolves no other one.
    """
    found = f'await import(new URL("{address_of(name)}", document.baseURI))'
    return f"const {{ render }} = {found};\nexport {{ render }};\n"


@cache
def modules() -> dict[str, Path]:
    """Each module of the page, by its name."""
    folder = folder_of_modules()
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.js"))}


def folder_of_modules() -> Path:
    """Where they lie."""
    return Path(str(_PAGE))


@cache
def version() -> str:
    """Digest of all modules of the page."""
    digest = hashlib.sha256()
    for name, path in modules().items():
        digest.update(b"\0".join((name.encode(), path.read_bytes(), b"")))
    return digest.hexdigest()[:12]
