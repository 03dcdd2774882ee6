"""The one place that decides how kernels are compiled and where their machine code is cached.

Numba keys its cache by the source of the cached function alone: an edit in another file that this function calls
would go unnoticed and give old numbers (numba issue 1833). So the name of the cache folder holds a digest of all
kernel sources. It is a digest of their bytes, since it is needed at every start and must cost next to nothing.

A kernel as Python calls it, and as other kernels do.

For Python a function becomes machine code, with a wrapper that takes Python's objects. Other kernels need neither: what
they call becomes part of their own code. So for them a function is kept as LLVM has read it, and it is optimised and
translated once, together with all that Python calls with it. By itself Numba does that for each function on its own,
again within each that calls it, and wraps each for Python.

Both kinds are compiled apart, so that the bits of a kernel do not depend on which was asked for first. Only machine
code is cached.
"""

import atexit
import functools
import os
import shutil
import tempfile
from pathlib import Path

import numba
import platformdirs
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.types import unliteral
from vibroscope.engine.kernels.compile.code_cache import Cache, source_digest


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


_FOLDERS_KEPT = 4  # a developer switches between a few versions; older machine code is dropped


def cache_root() -> Path:
    """Folder for everything kept between runs: ``VIBROSCOPE_CACHE_DIR`` or the user's cache folder."""
    return Path(os.environ.get("VIBROSCOPE_CACHE_DIR") or platformdirs.user_cache_dir("vibroscope"))


def _kernel_folder() -> Path:
    root = cache_root()
    folder = root / f"kernels-{source_digest()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        return _private_copy(folder)
    older = sorted(root.glob("kernels-*"), key=lambda path: path.stat().st_mtime, reverse=True)[_FOLDERS_KEPT:]
    for stale in older:
        if stale != folder:
            shutil.rmtree(stale, ignore_errors=True)
    return folder


def _private_copy(folder: Path) -> Path:
    # Numba ignores a read-only cache without a message and compiles anew, so a read-only image needs a copy.
    # The files are pickles: nobody else may write to the copy, hence mkdtemp.
    copy = Path(tempfile.mkdtemp(prefix="vibroscope-kernels-"))
    atexit.register(shutil.rmtree, copy, ignore_errors=True)
    if os.access(folder, os.R_OK | os.X_OK):
        shutil.copytree(folder, copy, dirs_exist_ok=True)
    return copy


numba.config.CACHE_DIR = str(_kernel_folder())


def _compiled(function, **options):
    """The kernel of a function; the function itself where Numba is switched off."""
    return function if numba.config.DISABLE_JIT else Kernel(function, **options)


# error_model="numpy": a division by zero gives inf, as the kernels expect, without a branch at each division.
# nogil: the kernels of one session must not stop the other sessions of the process.
# fastmath=False: a function for which it is not given inherits that of the function that happens to call it first in
# the process that compiles it, so that its last bits would depend on the order of calls. Inlining (forceinline) is
# inherited on purpose: what an event loop calls becomes part of it, which halves its time.
jit_uncontracted = functools.partial(_compiled, nogil=True, error_model="numpy", fastmath=False)

# Of fast-math only "contract", which fuses a product and a sum and rounds once instead of twice. The other options
# would delete the checks for NaN and reorder the sums that decide an event.
jit = functools.partial(jit_uncontracted, fastmath={"contract"})

# Kernels that allocate nothing. With reference counting (_nrt) Numba counts references to each array that passes from
# function to function, by locked instructions that take half of the time of an event loop.
jit_no_alloc = functools.partial(jit, _nrt=False)

# The same, inlined by LLVM (forceinline), or by Numba before type inference (inline="always"): the latter for functions
# that return views, so that no array passes between functions.
jit_inlined = functools.partial(jit_no_alloc, forceinline=True)
jit_spliced = functools.partial(jit_no_alloc, inline="always")


def variant(*values):
    """Give a function that is made anew for some values a name with these in it; beneath the compiling decorator.

    The name of machine code holds the name of the function, the types of its arguments, and a number of the process
    that compiled it. Two processes give the same number to different functions; where one name stands for two of them,
    a third process that loads both runs the first in place of the second.
    """

    def name(function):
        function.__qualname__ += "_" + "_".join(map(str, values))
        return function

    return name


def uncompiled(kernel):
    """The Python function of a kernel, for calls that are not worth compiling."""
    return getattr(kernel, "py_func", kernel)
