"""Views of a packed array in more dimensions, without a call.

Numba's ``reshape`` calls a C function that finds out whether numbers must be copied, for each of the fifteen views that
a call of an event loop makes. A slice of a packed array is contiguous: nothing has to be found out.
"""

import numpy as np
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_borrowed
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array


def shaped(flat: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """A contiguous array, (n,), as one of a shape that holds n numbers; compiled code does not check that it does."""
    return flat.reshape(shape)


@type_callable(shaped)
def _type(context):
    def typer(flat, shape):
        if isinstance(flat, types.Array) and flat.ndim == 1 and flat.layout == "C":
            return types.Array(flat.dtype, len(shape), "C")
        return None

    return typer


@lower_builtin(shaped, types.Array, types.BaseTuple)
def _lower(context, builder, signature, arguments):
    source, found = make_array(signature.args[0])(context, builder, arguments[0]), signature.return_type
    out, lengths = make_array(found)(context, builder), cgutils.unpack_tuple(builder, arguments[1])
    strides, stride = [], source.itemsize
    for length in reversed(lengths):
        strides.insert(0, stride)
        stride = builder.mul(stride, length)
    populate_array(out, source.data, lengths, strides, source.itemsize, source.meminfo, source.parent)
    return impl_ret_borrowed(context, builder, found, out._getvalue())
