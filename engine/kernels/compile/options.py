"""The one place that decides how kernels are compiled and where the machine code is kept.

Numba keys its cache by the source of the cached function alone: an edit in another file that this function calls
would go unnoticed and give old numbers. So the cache folder carries a digest of all kernel sources in its name.
"""

import atexit
import functools
import hashlib
import os
import shutil
import tempfile
from pathlib import Path

import numba
import platformdirs

from .code_cache import kept

_SOURCES = Path(__file__).parent
_FOLDERS_KEPT = 4  # a developer hops between a few versions; older machine code is dropped


def source_digest(folder: Path = _SOURCES) -> str:
    """Digest of every Python source below a folder, 12 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


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
    # Numba passes over a read-only cache without a word and compiles anew, so a read-only image needs a copy.
    # The files are pickles: the copy must be a folder nobody else can write to, hence mkdtemp.
    copy = Path(tempfile.mkdtemp(prefix="vibroscope-kernels-"))
    atexit.register(shutil.rmtree, copy, ignore_errors=True)
    if os.access(folder, os.R_OK | os.X_OK):
        shutil.copytree(folder, copy, dirs_exist_ok=True)
    return copy


numba.config.CACHE_DIR = str(_kernel_folder())

# Of fast-math only the fusing of a product and a sum, which rounds once in place of twice. The rest would delete the
# checks for NaN and reorder the sums that decide an event.
# error_model="numpy" lets a division by zero give inf, as the kernels expect, without a branch at each division.
exact = functools.partial(kept, nogil=True, error_model="numpy")  # for sums whose rounding is known
jit = functools.partial(exact, fastmath={"contract"})
# Kernels that make no array. Without _nrt Numba counts references to every array that passes from function to function,
# by locked instructions that took half the time of a march; their arrays belong to the caller, who outlives the call.
bare = functools.partial(jit, _nrt=False)
inlined = functools.partial(bare, forceinline=True)
# Functions that give views of an array: part of their caller before it is compiled, so that no array passes between.
spliced = functools.partial(bare, inline="always")
