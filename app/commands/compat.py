"""What the command line leaves out of Numba's start, which takes most of the time of a short run.

The parts use private or undocumented names of Numba and do nothing where a version has others
(`tests/app/test_start_of_commands.py`). With them ``vibroscope simulate`` takes a seventh less processor time.
"""

import contextlib
import functools
import sys
from importlib import import_module


@functools.cache
def shorten_start() -> None:
    """Leave out what no kernel uses. To be called before the engine is imported."""
    for leave_out in (leave_out_blas, leave_out_repeated_checks, leave_out_compiler):
        with contextlib.suppress(ImportError, AttributeError):
            leave_out()


def leave_out_blas() -> None:
    """Let Numba find no BLAS, which it would import from SciPy.

    Numba looks for it when this undocumented module is imported. SciPy itself stays usable.
    """
    if "scipy.linalg" not in sys.modules:
        sys.modules["scipy.linalg"] = None  # whose import then fails, as where SciPy is not installed
        try:
            import_module("numba.np.arraymath")
        finally:
            del sys.modules["scipy.linalg"]


def leave_out_repeated_checks() -> None:
    """Check once for each cache folder, and not for each of 170 kernels, that it can be written."""
    locator, checked = import_module("numba.core.caching")._CacheLocator, set()
    check = locator.ensure_cache_path

    def check_once(self) -> None:
        if (path := self.get_cache_path()) not in checked:
            check(self)
            checked.add(path)

    locator.ensure_cache_path = check_once


def leave_out_compiler() -> None:
    """Load machine code without the tables of all that Numba can compile.

    A compilation sets them up itself, when it begins. Machine code needs the functions that count references alone.
    """
    cache = import_module("numba.core.caching").FunctionCache
    runtime = import_module("numba.core.runtime").rtsys
    load = cache._load_overload

    def load_overload(self, sig, target_context):
        runtime.initialize(target_context)
        return load(self, sig, target_context)

    cache.load_overload = load_overload
