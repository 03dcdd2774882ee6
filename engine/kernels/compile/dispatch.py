"""A kernel as Python calls it, and as other kernels do.

For Python a function becomes machine code, with a wrapper that takes Python's objects. Other kernels need neither: what
they call becomes part of their own code. So for them a function is kept as LLVM has read it, and it is optimised and
translated once, together with all that Python calls with it. By itself Numba does that for each function on its own,
again within each that calls it, and wraps each for Python.

Both kinds are compiled apart, so that the bits of a kernel do not depend on which was asked for first. Only machine
code is cached.
"""

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.types import unliteral
from vibroscope.engine.kernels.compile.code_cache import Cache


class Kernel(CPUDispatcher):
    """A function that Numba compiles for Python, with its machine code cached, or for other kernels.

    Parameters
    ----------
    function : callable
    **options
        Of `numba.njit`.
    """

    def __init__(self, function, **options):
        options = {"nopython": True, "boundscheck": None, "no_cfunc_wrapper": True, **options}
        super().__init__(function, targetoptions=options)
        self._cache = Cache(function)
        self._inside = CPUDispatcher(
            function, targetoptions={**options, "no_cpython_wrapper": True}, pipeline_class=_InsideCompiler
        )

    def get_call_template(self, args, kws):
        """How a kernel calls it; see `numba.core.dispatcher.Dispatcher`.

        For a number that is a constant where it is called it is not compiled once more: LLVM sees the constant as well.
        """
        _, args = self.fold_argument_types(args, kws)
        return self._inside.get_call_template(tuple(map(unliteral, args)), {})

    def get_overload(self, sig):
        """What a kernel calls; see `numba.core.dispatcher.Dispatcher`."""
        return self._inside.get_overload(sig)


class _InsideCompiler(Compiler):
    """Numba's compiler up to the code that other kernels include."""

    def __init__(self, typing_context, target_context, library, *rest):
        super().__init__(typing_context, target_context, _InsideCode(target_context.codegen(), "inside"), *rest)


class _InsideCode(JITCodeLibrary):
    """Code that is neither optimised as a whole nor translated: it can only be linked."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name):
        """No address."""
        return 0

    @property
    def codegen(self):
        """Where Numba puts what a function needs of Python; kernels need nothing."""
        return _NoEnvironment


class _NoEnvironment:
    @staticmethod
    def set_env(name, environment):
        """See `numba.core.codegen.JITCPUCodegen`."""
