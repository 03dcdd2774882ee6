"""Coordinates of the kernels and of the user: (ξ₁, ξ₁′, g, g′) and (ξ₁, ξ₁′, ξ₂, ξ₂′), with the gap g = g₀ + ξ₂ − ξ₁.

At a wall the kernels see the body as body 2 and the wall as body 1 (:mod:`..parameters`): the user's ξ₁ is −ξ₂ of the
kernels, whose ξ₁ is zero. With w = 1 there and w = 0 for two bodies (the field ``wall``) one formula serves both. Of
a second stop they see the mirrored system, whose ξ are the negative of the user's: ``sign`` is −1 there, else 1. The
functions take numbers or arrays, and whatever has the fields ``wall``, ``clearance`` and ``sign``.
"""

from vibroscope.engine.kernels.compile.options import jit_inlined


@jit_inlined
def displacements(p, x1, v1, gap, rate):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ as the user counts them."""
    x2, v2 = p.sign * (x1 + (gap - p.clearance)), p.sign * (v1 + rate)
    x1, v1 = p.sign * x1, p.sign * v1
    return x1 - p.wall * x2, v1 - p.wall * v2, x2 - p.wall * x2, v2 - p.wall * v2


@jit_inlined
def users_displacements(p, x1, v1, x2, v2):
    """The same from the displacements of both of the kernels' bodies: by their difference it would round once more."""
    x1, v1, x2, v2 = p.sign * x1, p.sign * v1, p.sign * x2, p.sign * v2
    return x1 - p.wall * x2, v1 - p.wall * v2, x2 - p.wall * x2, v2 - p.wall * v2


@jit_inlined
def contact_coordinates(p, x1, v1, x2, v2):
    """(ξ₁, ξ₁′, g, g′) as kernels count them."""
    x1, v1, x2, v2 = p.sign * x1, p.sign * v1, p.sign * x2, p.sign * v2
    x2, v2 = x2 - p.wall * (x1 + x2), v2 - p.wall * (v1 + v2)
    x1, v1 = x1 - p.wall * x1, v1 - p.wall * v1
    return x1, v1, p.clearance + (x2 - x1), v2 - v1
