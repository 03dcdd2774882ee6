"""Coordinates of the kernels and of the user: (ξ₁, ξ₁′, g, g′) and (ξ₁, ξ₁′, ξ₂, ξ₂′), with the gap g = g₀ + ξ₂ − ξ₁.

At a wall the kernels see the body as body 2 and the wall as body 1 (:mod:`..parameters`): (0, 0, g, g′) with
g = g₀ − ξ₁. Both functions take whatever has the fields ``wall`` and ``clearance``, and numbers or arrays.
"""

from ..compile.options import jit_inlined


@jit_inlined
def displacements(p, x1, v1, gap, rate):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ as the user counts them."""
    if p.wall:
        return p.clearance - gap, -rate, 0.0, 0.0
    return x1, v1, x1 + (gap - p.clearance), v1 + rate


@jit_inlined
def contact_coordinates(p, x1, v1, x2, v2):
    """(ξ₁, ξ₁′, g, g′) as kernels count them."""
    if p.wall:
        return 0.0, 0.0, p.clearance - x1, -v1
    return x1, v1, p.clearance + (x2 - x1), v2 - v1
