"""The folder or URL of a store: whether there is room, and which process works on it.

The manifest of a store: digests of its numbers and its files, by which damage is found.

A checksum within a chunk does not show that the chunk is another one's, and none protects a description. So the folder
`FOLDER` of a store holds a manifest: one file of the study (`StudyManifest`), and one for each chunk, its *seal*, with
digests of the numbers of all variables. A seal is written last: where it agrees, the chunk is complete and in place.
Seals are files of their own, so that chunks are written side by side, by several machines, without a lock.

The folder lies in that of an array, where no reader of Zarr looks for further arrays.
"""

import contextlib
import errno
import fcntl
import hashlib
import json
import math
import os
import shutil
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.result import Cancelled
from vibroscope.engine.sweeps.batches import Chunk
from vibroscope.engine.sweeps.study import Study

FOLDER = "status/manifest"
STUDY = f"{FOLDER}/study.json"


@dataclass
class StudyManifest:
    """The description of a store, with a digest of its own.

    Attributes
    ----------
    origin : dict
        `provenance.origin` of the first run, with the key of the study.
    account : dict
        `provenance.account` of the run that finished the study; empty until then.
    shape, sides : list of int
        Of the grid and of its chunks, along each axis; empty until the arrays exist.
    variables : list of str
    files : dict
        Digest of every file but the chunks of the variables.
    """

    origin: dict
    account: dict = field(default_factory=dict)
    shape: list = field(default_factory=list)
    sides: list = field(default_factory=list)
    variables: list = field(default_factory=list)
    files: dict = field(default_factory=dict)

    def as_bytes(self) -> bytes:
        """The content of its file."""
        return _json({"digest": digest(_json(asdict(self))), "manifest": asdict(self)})


def read_manifest(content: bytes | None) -> StudyManifest | None:
    """The manifest in a file; None if the file is missing or damaged."""
    found = _parsed(content)
    try:
        manifest = StudyManifest(**found.get("manifest"))
    except TypeError:
        return None
    return manifest if found.get("digest") == digest(_json(asdict(manifest))) else None


def seal_file(chunk: Chunk) -> str:
    """The file with the seal of a chunk: named by its first cell, so that it does not depend on the sides."""
    return f"{FOLDER}/{'.'.join(str(part.start) for part in chunk)}.json"


def seal(key: str, chunk: Chunk, values: Mapping[str, np.ndarray]) -> bytes:
    """The content of the file with the seal of a chunk: study, cells, digests of the numbers, and one of all this."""
    content = _place(key, chunk) | {"numbers": {name: numbers_digest(array) for name, array in values.items()}}
    return _json(content | {"digest": digest(_json(content))})


def read_seal(content: bytes | None, key: str, chunk: Chunk) -> dict[str, str] | None:
    """The digests of a chunk's numbers by variable; None if its seal is missing, damaged or another one's."""
    found = _whole(content)
    numbers = found.pop("numbers", None)
    return numbers if isinstance(numbers, dict) and found == _place(key, chunk) else None


def sealed_key(content: bytes | None) -> str | None:
    """The key of the study that a seal belongs to; None if it is missing or damaged."""
    return _whole(content).get("key")


def numbers_digest(array: np.ndarray) -> str:
    """Digest of an array's numbers, bit by bit, and of its shape and type."""
    array = np.asarray(array)
    array = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    return digest(f"{array.dtype.str} {array.shape}".encode() + array.tobytes())


def digest(content: bytes) -> str:
    """Digest of bytes."""
    return hashlib.sha256(content).hexdigest()


def _place(key: str, chunk: Chunk) -> dict[str, object]:
    return {"key": key, "cells": [[part.start, part.stop] for part in chunk]}


def _whole(content: bytes | None) -> dict:
    """What a seal says, without its own digest; empty if it is missing or damaged."""
    found = _parsed(content)
    own = found.pop("digest", None)
    return found if own == digest(_json(found)) else {}


def _parsed(content: bytes | None) -> dict:
    try:
        found = json.loads(content or b"")
    except ValueError:
        return {}
    return found if isinstance(found, dict) and _json(found) == content else {}


def _json(content: object) -> bytes:
    return json.dumps(content, indent=1, ensure_ascii=False).encode()


class StoreLocation:
    """The folder or URL of one store.

    Parameters
    ----------
    target : str or Path
        A folder, or ``protocol://…``, a URL that fsspec knows.

    Attributes
    ----------
    folder : Path or None
        None for a URL.
    root : zarr.abc.store.Store
        What Zarr writes to.
    """

    def __init__(self, target: str | Path) -> None:
        self.target = target
        self.folder = _folder(str(target))
        self.root = _root(target, self.folder)

    @property
    def shared(self) -> bool:
        """Whether another machine reaches it by the same name."""
        return self.folder is None

    def check_space(self, study: Study) -> None:
        """Refuse what cannot be written, before work starts.

        Raises
        ------
        OSError
            If the folder cannot be written, or the disk is too small for the whole result.
        """
        if self.folder is None:
            return
        above = next(path for path in (self.folder, *self.folder.absolute().parents) if path.exists())
        if not os.access(above, os.W_OK):
            raise PermissionError(errno.EACCES, f"{above} cannot be written: give another place", str(above))
        size = sum(
            math.prod(study.lengths[dim] for dim in variable.dims) * np.dtype(variable.dtype).itemsize
            for variable in study.variables.values()
        )
        free = shutil.disk_usage(above).free
        if 1.05 * size > free:  # of the uncompressed size
            raise OSError(
                errno.ENOSPC,
                f"the result takes up to {size / 1e9:.3g} GB and {free / 1e9:.3g} GB are free at {above}: "
                "sweep fewer cells, keep a smaller sample, or give another place",
            )

    def read(self, name: str) -> bytes | None:
        """The bytes of a file; None if it is not there."""
        from zarr.core.buffer import default_buffer_prototype
        from zarr.core.sync import sync

        found = sync(self.root.get(name, default_buffer_prototype()))
        return None if found is None else found.to_bytes()

    def exists(self, name: str) -> bool:
        """Whether there is anything of this name, be it a file or a folder."""
        from zarr.core.sync import sync

        return sync(self.root.exists(name)) if self.folder is None else os.path.lexists(self.folder / name)

    def files(self) -> list[str]:
        """The names of all files in the folder but those that are being written; none of a URL."""
        if self.folder is None:
            return []
        found = (path for path in self.folder.rglob("*") if path.is_symlink() or not path.is_dir())
        return sorted(str(path.relative_to(self.folder)) for path in found if path.suffix != ".partial")

    def write(self, name: str, content: bytes) -> None:
        """Write a file, whole or not at all, unless it holds these bytes already."""
        from zarr.core.buffer.cpu import Buffer
        from zarr.core.sync import sync

        with self.readable_errors():
            if self.read(name) != content:
                sync(self.root.set(name, Buffer.from_bytes(content)))

    def refuse_foreign_files(self) -> None:
        """Raise a ValueError if the folder holds any file but what a run left that was killed at its very start."""
        if self.folder is None or not self.folder.exists():
            return
        found = (path for path in self.folder.rglob("*") if not path.is_dir())
        if not self.folder.is_dir() or any(not path.match(f"{FOLDER}/*.partial") for path in found):
            raise ValueError(f"{self.target} exists and is no result of a sweep: give a new place")

    def remove_partial_files(self) -> None:
        """Remove what a process left that was killed while it wrote."""
        if self.folder is not None:
            for path in self.folder.rglob("*.partial"):
                path.unlink(missing_ok=True)

    @contextlib.contextmanager
    def lock(self, *, wait: bool = False, cancelled: Poll | None = None) -> Iterator[None]:
        """Hold the folder for this process; the system releases it however the process ends.

        Raises
        ------
        BlockingIOError
            If another process holds it and ``wait`` is false.
        Cancelled
            If ``cancelled`` returned true while it waited.
        """
        if self.folder is None:
            yield
            return
        with self.readable_errors():
            self.folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(self.folder, os.O_RDONLY)
        try:
            while not _try_lock(handle):
                if not wait:
                    text = f"another process works on {self.target}: wait for it, or give another place"
                    raise BlockingIOError(errno.EAGAIN, text)
                if cancelled is not None and cancelled():
                    raise Cancelled
                time.sleep(0.1)
            yield
        finally:
            os.close(handle)

    @contextlib.contextmanager
    def readable_errors(self) -> Iterator[None]:
        """Raise errors of the disk with one line that says what to do."""
        try:
            yield
        except OSError as problem:
            if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                advice = "the chunks that are complete are kept; make room and give the same command again"
            else:
                advice = "give a place that can be written"
            raise OSError(problem.errno, f"{self.target}: {problem.strerror or problem}; {advice}") from problem


def _try_lock(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _folder(target: str) -> Path | None:
    if target.startswith("file://"):
        return Path(target.removeprefix("file://"))
    return None if "://" in target else Path(target)


def _root(target: str | Path, folder: Path | None):
    from zarr.storage import FsspecStore, LocalStore

    if folder is not None:
        return LocalStore(folder)
    try:
        return FsspecStore.from_url(str(target))
    except (ImportError, ValueError) as problem:
        raise ValueError(f"{target} cannot be opened: {problem}") from None
