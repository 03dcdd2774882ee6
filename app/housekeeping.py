"""The cache folder, kept within its bound: sweeps that were not used for the longest go first."""

from __future__ import annotations

import logging
import shutil
import time
from pathlib import Path

from app import logs
from engine import cache_root

_YOUNG = 3600.0  # what was written within the hour may be in use


def bound_cache(megabytes: int, root: Path | None = None) -> int:
    """Remove kept sweeps, oldest first, until the folder holds no more than ``megabytes``; returns how many went."""
    studies = sorted(_studies(root or cache_root()), key=_age)
    total = sum(_size(path) for path in studies)
    removed = 0
    for path in studies:
        if total <= megabytes * 1e6 or time.time() - _age(path) < _YOUNG:
            break
        total -= _size(path)
        shutil.rmtree(path, ignore_errors=True)
        removed += 1
    if removed:
        logs.event("cache bounded", logging.INFO, removed=removed, megabytes=total / 1e6)
    return removed


def _studies(root: Path) -> list[Path]:
    try:
        return [path for path in (root / "studies").iterdir() if path.is_dir() and not path.is_symlink()]
    except OSError:
        return []


def _files(path: Path) -> list:
    found = []
    for file in path.rglob("*"):
        try:
            found.append(file.lstat())
        except OSError:  # went meanwhile
            continue
    return found


def _size(path: Path) -> int:
    return sum(file.st_size for file in _files(path))


def _age(path: Path) -> float:
    return max((file.st_mtime for file in _files(path)), default=0.0)
