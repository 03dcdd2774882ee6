"""The tables of a solver in one array.

A call from Python takes each array that it is given apart. A solver has ten to twenty, which together take as long as
tens of periods of the motion; folded they are one. Their shapes do not change from run to run, so a kernel finds them
at places that the compiler knows.
"""

import math

import numpy as np

from .options import spliced

LANES = 8  # numbers in a line of the cache and in the longest vector, which is loaded from one line at once


def room(size: int) -> np.ndarray:
    """Zeros, (size,), that begin where a line of the cache does."""
    wider = np.zeros(size + LANES - 1)
    begin = -wider.ctypes.data // wider.itemsize % LANES
    return wider[begin : begin + size]


def fold(values) -> np.ndarray:
    """All numbers and arrays of a nested tuple, one after the other, as one array of float64."""
    leaves = [np.ravel(leaf) for leaf in _leaves(values)]
    return np.concatenate(leaves, out=room(sum(map(len, leaves))))


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
