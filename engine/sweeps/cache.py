"""Studies kept between runs for the explorer: each under its key, the least recently used dropped first.

The key holds every number and the digest of the engine's code, so that no study of another engine is ever found. One
that was cancelled goes on where it was when it is asked for again. Of several processes that want the same study one
computes it, and the others wait for it. Where the study grows, nobody waits: the others compute it in memory.

The bifurcation diagrams that the explorer opens with: shipped for the default system, else computed once and kept.

A shipped one is a single npz file, which is read in milliseconds when the page opens; what reads a labelled result
takes half a second to import.
"""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from vibroscope import assets
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.code_cache import cache_root
from vibroscope.engine.methods import JOINT_DAMPINGS, Reference
from vibroscope.engine.model import System
from vibroscope.engine.result import Cancelled
from vibroscope.engine.sweeps.batches import ProgressCallback
from vibroscope.engine.sweeps.codes import MISSING
from vibroscope.engine.sweeps.eta_study import EtaStudy
from vibroscope.engine.sweeps.growth import RunOptions, grow, run, store_values
from vibroscope.engine.sweeps.store_location import StoreLocation
from vibroscope.engine.sweeps.study import Study

if TYPE_CHECKING:
    import xarray


BYTES_KEPT = 500_000_000
DEAR = 1.0  # s: a picture that takes longer to compute is written, which takes some tenths
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
    *_, dataset = _read_through(study, RunOptions(**options, wait=True), lambda how: [run(study, how).load()])
    return dataset


def grow_cached(study: Study, options: RunOptions) -> Iterator[dict[str, np.ndarray]]:
    """The values of each partial result of a study that grows in the cache (see `grow`).

    While another is at work on the entry, it grows in memory: a server may run both in one thread, where the one that
    waits would stand in the way of the other.
    """
    return _read_through(study, options, lambda how: (partial.values() for partial in grow(study, how)))


def grow_picture(
    study: Study, options: RunOptions, known: Mapping[str, np.ndarray] | None = None
) -> Iterator[dict[str, np.ndarray]]:
    """The values of each partial result of a picture, which grows in memory, coarse cells first (see `grow`).

    A complete one that took longer than `DEAR` is kept in the cache, and read from there where another process asks.
    """
    study.check()
    if known is None or (known["status"] == MISSING).any():
        kept = _kept_values(study)
        if kept is not None:
            yield kept
            return
    for partial in grow(study, options, picture=True, known=known):
        yield partial.values()
    if partial.progress.seconds < DEAR:
        return
    with contextlib.suppress(OSError, ValueError, KeyError):  # as in `_read_through`
        folder = _folder(study)
        store_values(study, partial.values(), replace(options, out=folder))
        drop_oldest(folder.parent, spare=folder)


def _kept_values(study: Study) -> dict[str, np.ndarray] | None:
    """The values of a study that is complete in the cache; None if it is not, or another process is at work on it."""
    if not _folder(study).exists():
        return None
    try:
        *_, values = grow_cached(study, RunOptions(cancelled=lambda: True))  # reads, but computes nothing
    except Cancelled:
        return None
    return values


def _folder(study: Study) -> Path:
    return cache_root() / "studies" / study.key


def _read_through(study: Study, options: RunOptions, results: Callable[[RunOptions], Iterable[Read]]) -> Iterator[Read]:
    """Read results of the study from the cache, or from memory where there can be no cache."""
    study.check()
    folder = _folder(study)
    cached = replace(options, out=folder)
    with contextlib.suppress(OSError, KeyError):  # a full, read-only, held or dropped entry costs time, not the result
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
        with contextlib.suppress(OSError), StoreLocation(entry).lock():  # not one that a process is at work on
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


SHIPPED = Path(str(files(assets))) / "diagrams"
GRID = np.round(np.arange(0.5, 4.0 + 1e-9, 0.0025), 4)  # 1,401 values of η; the paper's four are among them


@dataclass(frozen=True)
class Diagram:
    """Bifurcation diagram from rest.

    Attributes
    ----------
    eta : (n,) ndarray
    displacement : (2, n, sample) ndarray of float32
        ξ₁ and ξ₂ at τ ≡ 0 mod T; nan in rows whose run ended early.
    """

    eta: np.ndarray
    displacement: np.ndarray


def diagram_study(system: System, method: Reference) -> EtaStudy:
    """The study that the diagram is made of; its key changes with any number and any code that goes in."""
    return EtaStudy(system, method, float(GRID[0]), transient=2000, sample=50, values=GRID)


def diagram(
    system: System, method: Reference, *, progress: ProgressCallback | None = None, cancelled: Poll | None = None
) -> Diagram:
    """The bifurcation diagram over GRID: shipped, or cached, or computed now and cached.

    Parameters
    ----------
    progress : callable, optional
        Called with a `Progress`; only where the diagram is not shipped.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true; what is complete is kept for the next time.
    """
    study = diagram_study(system, method)
    return shipped_diagram(system, method) or _diagram_of(cached_dataset(study, progress=progress, cancelled=cancelled))


def shipped_diagram(system: System, method: Reference) -> Diagram | None:
    """The shipped diagram; None if none is shipped for this system, or if it is of another engine."""
    return load_diagram(shipped_path(method), diagram_study(system, method).key)


def _diagram_of(found) -> Diagram:
    points = np.stack([found[name].values for name in ("xi1", "xi2")])
    return Diagram(found["eta"].values, points.astype(np.float32))


def shipped_path(method: Reference) -> Path:
    """The file with the diagram of the default system in the source tree."""
    return SHIPPED / f"{method.joint_damping}.npz"


def ship_diagrams() -> list[Path]:
    """Compute the diagrams of the default system and put them into the source tree; returns their paths."""
    paths = []
    for kind in JOINT_DAMPINGS:
        study, path = diagram_study(System(), Reference(kind)), shipped_path(Reference(kind))
        save_diagram(path, study.key, _diagram_of(run(study, RunOptions())))
        paths.append(path)
    return paths


def load_diagram(path: Path, key: str) -> Diagram | None:
    """The diagram in a file; None if the file is missing, damaged, or holds another one."""
    try:
        # opened here, since numpy leaves a damaged file open
        with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
            if str(content["key"]) != key:
                return None
            return Diagram(content["eta"], content["displacement"])
    except Exception:  # a damaged file has zipfile, zlib and numpy raise what they please
        return None


def save_diagram(path: Path, key: str, result: Diagram) -> None:
    """Write a diagram whole or not at all.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, unfinished = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, key=np.array(key), eta=result.eta, displacement=result.displacement)
        Path(unfinished).chmod(0o644)  # as any other file; a temporary one is its owner's alone
        os.replace(unfinished, path)
    except BaseException:
        Path(unfinished).unlink(missing_ok=True)
        raise
