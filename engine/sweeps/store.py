"""Results on disk or in a bucket: a Zarr group that grows chunk by chunk and that ``xarray.open_zarr`` reads.

Each chunk of a study is one Zarr chunk in every variable, so that chunks are written side by side without a lock. A
file appears whole or not at all (Zarr renames it into place; so does an object store), and each carries a CRC-32C, so
that a truncated or changed one is an error when it is read, by whatever reader, never a number. ``status`` is written
last: where it stands, the chunk is complete. Of what is written only the attributes of the group, with the date and
the cost, differ from run to run.

`benchmarks/stores.py` measures this against one npz file a chunk. That is three times as fast to write, but a chunk is
seconds of work, so that neither is seen; and to open npz files as one labelled Dataset, one machine has to read and
write all of them once more, which costs more than is saved.
"""

import contextlib
import errno
import fcntl
import math
import os
import shutil
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..result import Cancelled
from . import provenance
from .chunks import Chunk
from .study import MISSING, Study, Variable, Whole

if TYPE_CHECKING:
    import xarray

LEVEL = 1  # of zstd: sections of periodic motion shrink a lot, those of chaotic motion hardly, at any level
DAMAGE = (ValueError, RuntimeError, OSError)  # what the checksum, the decompressor and the disk raise
POLL = 0.1  # seconds
# A chunk of nothing but fill values, too, becomes a file: one that is not there is missing.
_EVERY_CHUNK = {"write_empty_chunks": True}
SPACE = 1.05  # of the uncompressed size must be free


class Store:
    """One study's result at a path, at a URL that fsspec knows, or in memory.

    Parameters
    ----------
    target : str, Path or None
        A folder; ``protocol://…``; None for memory.
    group : str
        Part of it: rounds of a refined study are results of their own.
    """

    def __init__(self, target: str | Path | None, group: str = "") -> None:
        self.target, self.group = target, group
        self.folder = _folder(target)
        self._root = _open(target, self.folder)
        self._arrays: dict[str, object] = {}

    def part(self, group: str) -> "Store":
        """A result below this one."""
        part = object.__new__(Store)
        part.target, part.group, part.folder, part._root, part._arrays = self.target, group, self.folder, self._root, {}
        return part

    @property
    def shared(self) -> bool:
        """Whether another machine reaches the result by the same name."""
        return self.target is not None and self.folder is None

    # -- the frame: what is there before any cell -----------------------------------------------------------------

    def claim(self, study: Study) -> None:
        """Make the place that of a study, or find that it is, from an earlier run.

        Raises
        ------
        ValueError
            If something else lies there: another study, one of another engine, or no study at all.
        OSError
            If nothing can be written there.
        """
        import zarr

        found = self.attributes()
        if found is None:
            self._refuse_what_is_not_ours()
            with _errors_of(self.target):
                zarr.create_group(self._root, path=self.group, attributes=provenance.origin(study))
        elif found.get("key") != study.key:
            raise ValueError(_difference(self.target, found, study))
        elif self.folder is not None and not self.group:
            for rest in self.folder.rglob("*.partial"):  # of a process that was killed while it wrote
                rest.unlink(missing_ok=True)

    def frame(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Have every array in place; the sides of the chunks, which are those of the first run, not those asked for.

        An array whose description was lost is made anew, so that its chunks, and with them all, count as missing.
        """
        group = self._opened_group()
        with _errors_of(self.target):
            status = _array_of(group, "status")
            if status is not None:
                sides = tuple(status.chunks[: len(study.axes)])
            for name, item in study.whole.items():
                self._keep(group, name, item)
            for name, variable in study.variables.items():  # status is the last of them
                if _array_of(group, name) is None:
                    _make(group, name, variable, study.lengths, sides)
            self._consolidate()
        self.opened(study)
        return sides

    def opened(self, study: Study) -> "Store":
        """The same store, ready to read and write chunks of the study whose arrays it holds."""
        group = self._opened_group()
        self._arrays = {name: group[name].with_config(_EVERY_CHUNK) for name in study.variables}
        return self

    def keep(self, arrays: dict[str, Whole]) -> None:
        """Have these arrays in the result; what is there already stays untouched."""
        group = self._opened_group()
        with _errors_of(self.target):
            for name, item in arrays.items():
                self._keep(group, name, item)

    def _keep(self, group, name: str, item: Whole) -> None:
        values = np.asarray(item.values)
        found = _array_of(group, name)
        if found is not None:
            with contextlib.suppress(*DAMAGE):
                if np.array_equal(found[...], values, equal_nan=True):
                    return
        how = {"dimension_names": item.dims, "attributes": item.attributes} | _codecs()
        group.create_array(name, data=values, chunks=tuple(max(1, n) for n in values.shape), overwrite=True, **how)

    def _opened_group(self):
        import zarr

        return zarr.open_group(self._root, path=self.group, mode="r+", use_consolidated=False)

    def attributes(self) -> dict[str, object] | None:
        """The attributes of the result that lies there; None if there is none."""
        import zarr

        try:
            group = zarr.open_group(self._root, path=self.group, mode="r", use_consolidated=False)
        except FileNotFoundError:
            return None
        except ValueError as problem:
            raise ValueError(f"{self.target} is damaged ({problem}): delete it, or give another place") from None
        return dict(group.attrs)

    def _refuse_what_is_not_ours(self) -> None:
        if self.group or self.folder is None or not self.folder.exists():
            return
        if not self.folder.is_dir() or any(self.folder.iterdir()):
            raise ValueError(f"{self.target} exists and is no result of a sweep: give a new place")

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
        if SPACE * size > free:
            raise OSError(
                errno.ENOSPC,
                f"the result takes up to {size / 1e9:.3g} GB and {free / 1e9:.3g} GB are free at {above}: "
                "sweep fewer cells, keep a smaller sample, or give another place",
            )

    @contextlib.contextmanager
    def locked(self, *, wait: bool = False, cancelled: Callable[[], bool] | None = None) -> Iterator[None]:
        """Hold the folder for this process; the system lets go of it however the process ends.

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
        with _errors_of(self.target):
            self.folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(self.folder, os.O_RDONLY)
        try:
            while not _lock(handle):
                if not wait:
                    text = f"another process works on {self.target}: wait for it, or give another place"
                    raise BlockingIOError(errno.EAGAIN, text)
                if cancelled is not None and cancelled():
                    raise Cancelled
                time.sleep(POLL)
            yield
        finally:
            os.close(handle)

    # -- chunks ---------------------------------------------------------------------------------------------------

    def read(self, chunk: Chunk) -> dict[str, np.ndarray] | None:
        """What a chunk holds; None if it is missing, incomplete or damaged."""
        found = {}
        try:
            for name in ("status", *self._arrays):
                array = self._arrays[name]
                found[name] = np.asarray(array[chunk])
                if name == "status" and (found[name] == MISSING).any():
                    return None
                if not _is_there(array, chunk):  # a file that is gone would read as nan
                    return None
        except DAMAGE:
            return None
        return found

    def write(self, chunk: Chunk, values: dict[str, np.ndarray]) -> None:
        """Write a chunk.

        Raises
        ------
        OSError
            If the disk is full or gone.
        """
        with _errors_of(self.target):
            for name in self._arrays:
                if name != "status":
                    self._arrays[name][chunk] = values[name]
            self._arrays["status"][chunk] = values["status"]

    def finish(self, account: dict[str, object]) -> None:
        """Say that the result is complete, when and at what cost."""
        with _errors_of(self.target):
            self._opened_group().attrs.update(account)
            self._consolidate()

    def _consolidate(self) -> None:
        # xarray looks for the metadata in one piece, and would warn each user if it had to gather them
        if self.group:
            return  # a round of a refined study is read by this class alone
        import zarr

        with _errors_of(self.target), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
            zarr.consolidate_metadata(self._root)

    def dataset(self) -> "xarray.Dataset":
        """The result, read lazily."""
        import xarray

        return xarray.open_zarr(self._root, group=self.group or None, chunks=None, consolidated=not self.group)


def _lock(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _codecs() -> dict[str, object]:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return {"compressors": [ZstdCodec(level=LEVEL), Crc32cCodec()], "config": _EVERY_CHUNK}


def _make(group, name: str, variable: Variable, lengths: dict[str, int], sides: tuple[int, ...]) -> None:
    shape = tuple(lengths[dim] for dim in variable.dims)
    group.create_array(
        name,
        shape=shape,
        chunks=sides + shape[len(sides) :],
        dtype=variable.dtype,
        fill_value=variable.fill,
        dimension_names=variable.dims,
        attributes=variable.attributes,
        overwrite=True,
        **_codecs(),
    )


def _array_of(group, name: str):
    """The array of this name; None if there is none that can be opened."""
    try:
        return group[name]
    except (KeyError, *DAMAGE):
        return None


def _is_there(array, chunk: Chunk) -> bool:
    from zarr.core.sync import sync

    index = tuple(part.start // side for part, side in zip(chunk, array.chunks, strict=False))
    key = array.metadata.encode_chunk_key(index + (0,) * (array.ndim - len(index)))
    return sync((array.store_path / key).exists())


def _folder(target: str | Path | None) -> Path | None:
    if target is None:
        return None
    text = str(target)
    if text.startswith("file://"):
        return Path(text.removeprefix("file://"))
    return None if "://" in text else Path(text)


def _open(target: str | Path | None, folder: Path | None):
    from zarr.storage import FsspecStore, LocalStore, MemoryStore

    if target is None:
        return MemoryStore()
    if folder is not None:
        return LocalStore(folder)
    try:
        return FsspecStore.from_url(str(target))
    except (ImportError, ValueError) as problem:
        raise ValueError(f"{target} cannot be opened: {problem}") from None


def _difference(target: object, found: dict, study: Study) -> str:
    if "key" not in found:
        return f"{target} is a Zarr group but no result of a sweep: give a new place"
    wanted = provenance.origin(study)
    if found.get("engine_digest") != wanted["engine_digest"]:
        return (
            f"{target} was computed by another engine ({found.get('engine_version')}, {found.get('engine_digest')}; "
            f"this is {wanted['engine_version']}, {wanted['engine_digest']}): delete it, or give another place"
        )
    names = [name for name, value in wanted.items() if name not in ("key", "complete") and found.get(name) != value]
    return f"{target} holds another study (another {', '.join(names) or 'axis'}): delete it, or give another place"


@contextlib.contextmanager
def _errors_of(target: object) -> Iterator[None]:
    """Errors of the disk in one line that says what to do."""
    try:
        yield
    except OSError as problem:
        if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            advice = "the chunks that are complete are kept; make room and give the same command again"
        else:
            advice = "give a place that can be written"
        raise OSError(problem.errno, f"{target}: {problem.strerror or problem}; {advice}") from problem
