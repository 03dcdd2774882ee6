"""The table of materials, read from ``assets/materials.toml``, for the stiffness of Hertz' contact."""

import tomllib
from functools import cache

from vibroscope.app.runtime.files import asset
from vibroscope.engine import Material


@cache
def materials() -> dict[str, Material]:
    """Elastic constants by the name of the material, each with its source."""
    rows = tomllib.loads(asset("materials.toml"))
    return {name: Material(row["E_GPa"] * 1e9, row["nu"], row["title"], row["source"]) for name, row in rows.items()}


def material(name: str) -> Material:
    """The material with this name; raises ValueError with the known ones."""
    if name not in materials():
        raise ValueError(f"unknown material {name[:40]!r}; known: {', '.join(materials())}")
    return materials()[name]
