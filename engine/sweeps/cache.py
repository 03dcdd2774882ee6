"""Studies kept between runs for the explorer: each under its key, the least recently used dropped first.

The key holds every number and a digest of the engine's sources, so that no study of another engine is ever found. One
that was cancelled goes on where it was when it is asked for again. Of several processes that want the same study one
computes it, and the others wait for it.
"""

import contextlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..drivers.code_cache import cache_root
from .place import Place
from .progress import Hook
from .runner import Run, run
from .study import Study

if TYPE_CHECKING:
    import xarray

BYTES_KEPT = 500_000_000


def kept(
    study: Study, *, progress: Hook | None = None, cancelled: Callable[[], bool] | None = None
) -> "xarray.Dataset":
    """The result of a study in memory, from the cache as far as it is there.

    Raises
    ------
    ValueError
        If a number is out of range.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept for the next time.
    """
    study.check()
    folder = cache_root() / "studies" / study.key
    with contextlib.suppress(OSError, KeyError):  # a full, read-only or just dropped entry costs time, not the result
        return _from(folder, study, progress, cancelled)
    return run(study, Run(progress=progress, cancelled=cancelled)).load()


def _from(folder: Path, study: Study, progress, cancelled) -> "xarray.Dataset":
    how = Run(folder, progress=progress, cancelled=cancelled, wait=True)
    try:
        found = run(study, how).load()
    except ValueError:  # the study was checked, so that it is the entry which is damaged
        _drop(folder)
        found = run(study, how).load()
    os.utime(folder)  # used just now
    drop_oldest(folder.parent, spare=folder)
    return found


def drop_oldest(root: Path, *, spare: Path | None = None, most: int | None = None) -> None:
    """Drop studies, the least recently used first, until at most so many bytes are kept.

    Parameters
    ----------
    root : Path
    spare : Path, optional
        An entry that stays.
    most : int, optional
        `BYTES_KEPT`, if not given.
    """
    entries = []
    for entry in root.iterdir():
        with contextlib.suppress(OSError):
            entries.append((entry.stat().st_mtime, entry, _size(entry)))
    total = sum(size for _, _, size in entries)
    for _, entry, size in sorted(entries):
        if total <= (BYTES_KEPT if most is None else most):
            return
        if entry == spare:
            continue
        with contextlib.suppress(OSError), Place(entry).locked():  # not one that a process is at work on
            _drop(entry)
            total -= size


def _size(folder: Path) -> int:
    size = 0
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):
            size += path.stat().st_size
    return size


def _drop(folder: Path) -> None:
    # renamed first: nobody must find half of it
    away = folder.with_name(f".dropped-{os.getpid()}-{folder.name}")
    folder.rename(away)
    shutil.rmtree(away, ignore_errors=True)
