"""The cache of the kernels' machine code: its folder, the digest of its sources, and its functions."""

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path

import numba
from numba.core import event
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target
from vibroscope.engine import kernels
from vibroscope.engine.kernels.compile.options import cache_root
from vibroscope.engine.kernels.compile.options import source_digest as source_digest

_KERNELS = f"{__package__.rpartition('.')[0]}.kernels."


def complete_mark(sources: Path = Path(kernels.__file__).parent) -> Path:
    """The file that exists once all kernels are compiled for this processor, by this Numba and Python.

    Numba finds machine code again by the place of its ``sources``: another checkout has its own.
    """
    target = cpu_target.target_context.codegen().magic_tuple()
    versions = repr((numba.__version__, sys.version_info[:3], target, str(sources)))
    return _folder() / f"complete-{hashlib.sha256(versions.encode()).hexdigest()[:12]}"


def is_cache_private() -> bool:
    """Whether this process has a copy of the cache folder, since the folder itself cannot be written."""
    return _folder().parent != cache_root()


def compilable_functions() -> set[str]:
    """Names of the functions of the kernels that Numba compiles; those that it inlines before that are left out."""
    return {
        _name(value)
        for name, module in list(sys.modules.items())
        if name.startswith(_KERNELS)
        for value in vars(module).values()
        if isinstance(value, Dispatcher) and value.targetoptions.get("inline") != "always"
    }


class CompileListener(event.Listener):
    """Calls ``act`` with the name of each function of the kernels that this process has compiled, within a block."""

    def __init__(self, act: Callable[[str], None]) -> None:
        self._act = act

    def on_start(self, event) -> None:
        """See `numba.core.event.Listener`."""

    def on_end(self, event) -> None:
        """See `numba.core.event.Listener`."""
        function = event.data["dispatcher"]
        if isinstance(function, Dispatcher) and function.py_func.__module__.startswith(_KERNELS):
            self._act(_name(function))

    def __enter__(self) -> "CompileListener":
        event.register("numba:compile", self)
        return self

    def __exit__(self, *error: object) -> None:
        event.unregister("numba:compile", self)


def _name(function: Dispatcher) -> str:
    return f"{function.py_func.__module__}.{function.py_func.__qualname__}"


def _folder() -> Path:
    return Path(numba.config.CACHE_DIR)
