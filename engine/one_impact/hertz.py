"""Hertz' contact of two elastic bodies with round surfaces: its K from materials and radii.

The force is Kδ^1.5 with

    K = 4/3 E* √R,    1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂,    1/R = 1/R₁ + 1/R₂

(Johnson, Contact Mechanics (1985), section 4.2; Goldsmith, Impact (1960), section 4.2). A plane has the radius inf.
"""

import math
from typing import NamedTuple

from vibroscope.engine.checks import require

MODULUS_RANGE = (0.0, 1e15)
POISSON_RANGE = (-1.0, 0.5)


class Material(NamedTuple):
    """An isotropic elastic material."""

    modulus: float  # E in Pa
    poisson: float  # ν
    title: str = ""
    source: str = ""


def hertz_stiffness(first: Material, second: Material, radius1: float, radius2: float = math.inf) -> float:
    """Return K of the force Kδ^1.5, in N/m^1.5 of moduli in Pa and radii in m.

    Parameters
    ----------
    first, second : Material
    radius1, radius2 : float
        Of the surfaces, positive; inf of a plane, at most one of them.

    Raises
    ------
    ValueError
        If a number is out of range.

    Examples
    --------
    >>> from vibroscope.engine import Material, hertz_stiffness
    >>> steel = Material(210e9, 0.3)
    >>> f"{hertz_stiffness(steel, steel, 0.01):.3g}"
    '1.54e+10'
    """
    compliance = 0.0
    for body in (first, second):
        modulus = require("E", body.modulus, *MODULUS_RANGE, "give Young's modulus in Pa", open_low=True)
        poisson = require("nu", body.poisson, *POISSON_RANGE, "give Poisson's ratio", open_low=True)
        compliance += (1.0 - poisson**2) / modulus
    curvature = 0.0
    for radius in (radius1, radius2):
        if not radius > 0.0:
            raise ValueError(f"radius = {radius:g} is not positive: give a radius in m, or inf of a plane")
        curvature += 1.0 / radius
    if curvature == 0.0:
        raise ValueError("two planes touch in no point: give a radius of at least one of them")
    return 4.0 / (3.0 * compliance * math.sqrt(curvature))
