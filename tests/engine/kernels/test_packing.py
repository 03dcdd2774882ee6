"""Packed arrays hold what a NamedTuple holds, compiled or not."""

from typing import NamedTuple

import numba
import numpy as np
from vibroscope.engine.kernels.compile.packing import LANES, Layout
from vibroscope.engine.kernels.compile.views import shaped


class Inner(NamedTuple):
    number: float
    row: np.ndarray
    matrix: np.ndarray
    pairs: tuple


class Outer(NamedTuple):
    flag: bool
    count: int
    inner: Inner
    last: float


LAYOUT = Layout(Outer, inner=Layout(Inner, row=(3,), matrix=(2, 4), pairs=(3, 2)))
PAIRS = (1.0, 2.0), (3.0, 4.0), (5.0, 6.0)
VALUE = Outer(True, 7, Inner(0.5, np.arange(3.0), np.arange(8.0).reshape(2, 4), PAIRS), -1.5)
unpack, write = LAYOUT.unpack, LAYOUT.write
write_some = LAYOUT.writer("count", "inner")


@numba.njit
def copy_and_change(packed, other):
    value = unpack(packed)
    write(other, value)
    value.inner.matrix[1, 2] = 100.0  # arrays are views
    write_some(packed, value.count + 1, value.inner)


def test_what_is_packed_is_read_again():
    packed = LAYOUT.pack(VALUE)
    found = LAYOUT.read(packed)
    assert packed.size == LAYOUT.size == 1 + 1 + (1 + 3 + 8 + 6) + 1
    assert (bool(found.flag), found.count, found.inner.number, found.last) == (True, 7, 0.5, -1.5)
    np.testing.assert_array_equal(found.inner.row, VALUE.inner.row)
    np.testing.assert_array_equal(found.inner.matrix, VALUE.inner.matrix)
    assert found.inner.pairs == PAIRS


def test_compiled_functions_read_and_write_the_same():
    packed, copy = LAYOUT.pack(VALUE), LAYOUT.zeros()
    copy_and_change(packed, copy)
    np.testing.assert_array_equal(copy, LAYOUT.pack(VALUE))
    found = LAYOUT.read(packed)
    assert (found.count, found.inner.matrix[1, 2], found.last) == (8, 100.0, -1.5)


def test_fields_lie_where_the_layout_says():
    packed = LAYOUT.pack(VALUE)
    assert packed[LAYOUT.begin("last")] == -1.5
    assert packed[LAYOUT.begin("inner")] == 0.5


def test_a_packed_array_begins_with_a_cache_line():
    assert LAYOUT.zeros().ctypes.data % (8 * LANES) == 0


@numba.njit
def parts_of_view(flat, rows):
    """Of a view of ``rows`` rows: along each dimension a slice, and what is left of the array that it looks at."""
    view = shaped(flat[2:], (rows, 2, 4))
    view[1, 0, 3] = -1.0
    return view[:, 1, 2].copy(), view[rows - 1, :, 0].copy(), view[0].copy(), view.shape


def test_views_are_those_of_reshape():
    flat, other = np.arange(26.0), np.arange(26.0)
    view = other[2:].reshape(3, 2, 4)
    *parts, shape = parts_of_view(flat, 3)
    *wanted, _ = parts_of_view.py_func(other, 3)
    assert shape == view.shape
    for part, same, direct in zip(parts, wanted, (view[:, 1, 2], view[2, :, 0], view[0]), strict=True):
        np.testing.assert_array_equal(part, same)
        np.testing.assert_array_equal(part, direct)
    np.testing.assert_array_equal(flat, other)
    assert flat[2 + 8 + 3] == -1.0
