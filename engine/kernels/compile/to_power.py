"""A power that compiled code computes where it is needed and nowhere else.

LLVM takes a power, ``x**n``, for as cheap as a product. So it does not branch around one: whatever has a power in one
of its cases computes it in all of them, which takes twice the time of a whole step. A call of the C library's function
stays where it is written. It gives the same bits.
"""

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic, overload

_REAL = ir.DoubleType()


@intrinsic
def _library_pow(typing_context, base, exponent):
    def generate(context, builder, signature, arguments):
        function = get_or_insert_function(builder.module, ir.FunctionType(_REAL, [_REAL, _REAL]), "pow")
        return builder.call(function, arguments)

    return types.float64(types.float64, types.float64), generate


def to_power(base, exponent):
    """baseᵉˣᵖᵒⁿᵉⁿᵗ of two floats."""
    return base**exponent


@overload(to_power)
def _to_power_compiled(base, exponent):
    return lambda base, exponent: _library_pow(base, exponent)
