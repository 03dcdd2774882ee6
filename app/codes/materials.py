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
