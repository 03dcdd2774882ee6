"""Packed arrays: all numbers and tables of a solver, one after the other, in one array of float64.

A call from Python unboxes each array argument on its own. A solver has ten to twenty of them, which together take as
long as tens of periods of the motion; packed they are one argument. The layout does not change from run to run, so the
compiler knows where each number lies.

A layout is generated from a NamedTuple: nobody writes an offset by hand.
"""

import math
from typing import NamedTuple

import numba
import numpy as np
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.views import shaped

LANES = 8  # numbers in a cache line and in the longest vector register


def aligned_zeros(size: int) -> np.ndarray:
    """Zeros, (size,), that begin at the beginning of a cache line."""
    wider = np.zeros(size + LANES - 1)
    begin = -wider.ctypes.data // wider.itemsize % LANES
    return wider[begin : begin + size]


def _nested_reading(shape: tuple[int, ...], at: int) -> str:
    """The text of a nested tuple of numbers that lie one after the other."""
    if not shape:
        return f"packed[{at}]"
    parts = (_nested_reading(shape[1:], at + i * math.prod(shape[1:])) for i in range(shape[0]))
    return f"({', '.join(parts)},)"


def _subscripts(shape: tuple[int, ...]) -> list[str]:
    """The texts of the subscripts of all numbers of a nested tuple, in their order."""
    return ["".join(f"[{i}]" for i in each) for each in np.ndindex(shape)]


class Layout:
    """Where the fields of a NamedTuple lie in a packed array, and the compiled functions that read and write them.

    Parameters
    ----------
    kind : type
        A NamedTuple. Fields annotated float, int or bool take one number each; ``np.ndarray`` and ``tuple``, nested if
        it has more dimensions, as many as its shape says; a nested NamedTuple what its own layout says.
    **fields : tuple of int, or Layout
        The shape of each array or tuple and the layout of each nested NamedTuple, by name.

    Attributes
    ----------
    size : int
        Numbers in a packed array.
    unpack : compiled function
        ``unpack(packed)`` returns the NamedTuple; its arrays are views of the packed one.
    write : compiled function
        ``write(packed, value)`` copies a NamedTuple into the packed array.
    """

    def __init__(self, kind: type[NamedTuple], /, **fields):
        self.kind = kind
        self.fields = fields
        self.size = sum(self._length(name) for name in kind._fields)
        self.unpack = self._generate("packed", [f"return {self._reading(0)}"])
        self.write = self._generate("packed, value", self._writing("value", 0))

    def zeros(self) -> np.ndarray:
        """A packed array of zeros."""
        return aligned_zeros(self.size)

    def read(self, packed: np.ndarray) -> NamedTuple:
        """As ``unpack``, from Python."""
        return uncompiled(self.unpack)(packed)

    def pack(self, value: NamedTuple) -> np.ndarray:
        """A packed array that holds a NamedTuple."""
        packed = self.zeros()
        uncompiled(self.write)(packed, value)
        return packed

    def writer(self, *names: str):
        """A compiled function (packed, *values) that writes the fields of these names alone."""
        lines = [line for name in names for line in self._writing_field(name, name, self.begin(name))]
        return self._generate(", ".join(("packed", *names)), lines)

    def begin(self, name: str) -> int:
        """Where a field begins."""
        names = self.kind._fields
        return sum(self._length(other) for other in names[: names.index(name)])

    def _length(self, name: str) -> int:
        field = self.fields.get(name, ())
        return field.size if isinstance(field, Layout) else math.prod(field)

    def _reading(self, at: int) -> str:
        values = []
        for name in self.kind._fields:
            values.append(self._reading_field(name, at))
            at += self._length(name)
        return f"{self.kind.__name__}({', '.join(values)})"

    def _reading_field(self, name: str, at: int) -> str:
        field, end = self.fields.get(name), at + self._length(name)
        if isinstance(field, Layout):
            return field._reading(at)
        if self.kind.__annotations__[name] is tuple:
            return _nested_reading(field, at)
        if field is not None:
            part = f"packed[{at}:{end}]"
            return f"shaped({part}, {field})" if len(field) > 1 else part
        conversion = {bool: "packed[{}] > 0.0", int: "int(packed[{}])"}
        return conversion.get(self.kind.__annotations__[name], "packed[{}]").format(at)

    def _writing(self, value: str, at: int) -> list[str]:
        lines = []
        for name in self.kind._fields:
            lines += self._writing_field(name, f"{value}.{name}", at)
            at += self._length(name)
        return lines

    def _writing_field(self, name: str, value: str, at: int) -> list[str]:
        field, end = self.fields.get(name), at + self._length(name)
        if isinstance(field, Layout):
            return field._writing(value, at)
        if self.kind.__annotations__[name] is tuple:
            return [f"packed[{at + i}] = {value}{each}" for i, each in enumerate(_subscripts(field))]
        if field is not None:
            # number by number: for arrays Numba compiles what says that their shapes differ, for a second each
            flat = f"{value}.ravel()" if len(field) > 1 else value
            return [f"flat = {flat}", f"for i in range({end - at}):", f"    packed[{at} + i] = flat[i]"]
        return [f"packed[{at}] = {value}"]

    def _generate(self, arguments: str, lines: list[str]):
        # Not cached by itself: with inline="always" it becomes part of the cached functions that call it.
        names = dict(self._kinds()) | {"shaped": shaped}
        body = "\n    ".join(lines)
        exec(f"def generated({arguments}):\n    {body}\n", names)
        return numba.njit(names["generated"], inline="always")

    def _kinds(self):
        yield self.kind.__name__, self.kind
        for field in self.fields.values():
            if isinstance(field, Layout):
                yield from field._kinds()
