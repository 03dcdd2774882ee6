"""Studies kept between runs for the explorer: each under its key, the least recently used dropped first.

The key holds every number and the digest of the engine's code, so that no study of another engine is ever found. One
that was cancelled goes on where it was when it is asked for again. Of several processes that want the same study one
computes it, and the others wait for it.
"""

import contextlib
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..drivers.code_cache import cache_root
from .growth import RunOptions, grow, run
from .place import Place
from .study import Study

if TYPE_CHECKING:
    import xarray

BYTES_KEPT = 500_000_000
Read = TypeVar("Read")


def cached_dataset(study: Study, **options) -> "xarray.Dataset":
    """The result of a study in memory, from the cache as far as it is there.

    Parameters
    ----------
    study : Study
    **options
        ``progress`` and ``cancelled`` of `RunOptions`.

    Raises
    ------
    ValueError
        If a number is out of range.
    Cancelled
        If ``cancelled`` returned true; what is complete is kept for the next time.
    """
    *_, dataset = _read_through(study, RunOptions(**options), lambda how: [run(study, how).load()])
    return dataset


def grow_cached(study: Study, options: RunOptions) -> Iterator[dict[str, np.ndarray]]:
    """The values of each partial result of a study that grows in the cache (see `grow`)."""
    return _read_through(study, options, lambda how: (partial.values() for partial in grow(study, how)))


def _read_through(study: Study, options: RunOptions, results: Callable[[RunOptions], Iterable[Read]]) -> Iterator[Read]:
    """What ``results`` reads of the study in the cache, or, where there can be no cache, in memory."""
    study.check()
    folder = cache_root() / "studies" / study.key
    cached = replace(options, out=folder, wait=True)
    with contextlib.suppress(OSError, KeyError):  # a full, read-only or just dropped entry costs time, not the result
        try:
            yield from results(cached)
        except ValueError:  # the study was checked, so that it is the entry which is damaged
            _drop(folder)
            yield from results(cached)
        with contextlib.suppress(OSError):
            os.utime(folder)  # used just now
            drop_oldest(folder.parent, spare=folder)
        return
    yield from results(options)


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
        with contextlib.suppress(OSError), Place(entry).lock():  # not one that a process is at work on
            _drop(entry)
            total -= size


def _size(folder: Path) -> int:
    size = 0
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):
            size += path.stat().st_size
    return size


def _drop(folder: Path) -> None:
    # renamed first: no process must find half of it
    away = folder.with_name(f".dropped-{os.getpid()}-{folder.name}")
    folder.rename(away)
    shutil.rmtree(away, ignore_errors=True)
