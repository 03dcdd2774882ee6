"""The tables of a solver in one array.

A call from Python takes each array that it is given apart. A solver has ten to twenty, which together take as long as
tens of periods of the motion; folded they are one. Their shapes do not change from run to run, so a kernel finds them
at places that the compiler knows.
"""

import math

import numpy as np

from .jit import spliced


def fold(values) -> np.ndarray:
    """All numbers and arrays of a nested tuple, one after the other, as one array of float64."""
    return np.concatenate([np.ravel(leaf) for leaf in _leaves(values)], dtype=float)


def _leaves(values):
    for value in values:
        if isinstance(value, tuple):
            yield from _leaves(value)
        else:
            yield value


def viewers(*shapes: tuple[int, ...]):
    """For leaves of these shapes, in the order in which they were folded, functions that give them back as views.

    The shape of a number is ().
    """
    ends = np.cumsum([math.prod(shape) for shape in shapes]).tolist()
    return tuple(_viewer(end - math.prod(shape), end, shape) for end, shape in zip(ends, shapes, strict=True))


def _viewer(begin, end, shape):
    if shape == ():

        @spliced
        def view(folded):
            return folded[begin]
    elif len(shape) == 1:

        @spliced
        def view(folded):
            return folded[begin:end]
    else:

        @spliced
        def view(folded):
            return folded[begin:end].reshape(shape)

    return view
