"""Results on disk or in a bucket: a Zarr group that grows chunk by chunk and that ``xarray.open_zarr`` reads.

Each chunk of a study is one Zarr chunk in every variable, so that chunks are written side by side without a lock. A
file appears whole or not at all (Zarr renames it into place; so does an object store), and each chunk carries a
CRC-32C, so that a truncated or changed one is an error when it is read, by whatever reader, never a number. Its seal in
the manifest (:mod:`.store_location`) is written last: where it agrees, the chunk is complete and in its place. All
other files follow from the study and are written anew where they differ, so that no damaged description is ever read.
Of what is written only the attributes of the group, with the date and the cost, and the manifest's copy of them differ
from run to run.

`benchmarks/stores.py` measures this against one npz file a chunk. That is three times as fast to write, but a chunk is
seconds of work, so that neither is seen; and to open npz files as one labelled Dataset, one machine has to read and
write all of them once more, which costs more than is saved.

The arrays of a store as files: each chunk of a study one Zarr chunk, compressed, with a checksum.
"""

import itertools
import warnings
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.sweeps import batches, store_location
from vibroscope.engine.sweeps.batches import Chunk, Progress, chunks
from vibroscope.engine.sweeps.store_location import StoreLocation
from vibroscope.engine.sweeps.study import Study
from vibroscope.engine.sweeps.variables import StudyArray, Variable

if TYPE_CHECKING:
    import xarray


DAMAGE = (ValueError, RuntimeError, OSError)  # what the checksum, the decompressor and the disk raise
# A chunk of nothing but fill values becomes a file, too: nan then keeps its bits, which the manifest holds a digest of.
EVERY_CHUNK = {"write_empty_chunks": True}


def study_files(
    study: Study, sides: tuple[int, ...], attributes: Mapping[str, object], more: Mapping[str, StudyArray]
) -> dict[str, bytes]:
    """Every file of a store but the chunks of its variables, as Zarr writes them.

    They follow from the study, so that a file that is lost or changed can be found and written anew.

    Parameters
    ----------
    study : Study
    sides : tuple of int
        Of the chunks, along each axis of the grid.
    attributes : mapping
        Of the group.
    more : mapping of str to StudyArray
        Arrays beside those of the study: its conclusions.
    """
    import zarr
    from zarr.storage import MemoryStore

    files: dict[str, object] = {}
    root = MemoryStore(files)
    group = zarr.create_group(root, attributes=dict(attributes))
    for name, item in (study.arrays | dict(more)).items():
        _write_array(group, name, item)
    for name, variable in study.variables.items():
        _create_array(group, name, variable, study.lengths, sides)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
        zarr.consolidate_metadata(root)  # xarray looks for it, and would warn each user if it had to collect it
    return {name: content.to_bytes() for name, content in files.items()}


def open_arrays(root, group: str, names: Iterable[str]) -> dict[str, object]:
    """Arrays of a store by their names, ready to read and write chunks."""
    import zarr

    paths = {name: f"{group}/{name}" if group else name for name in names}
    return {name: zarr.open_array(root, path=path).with_config(EVERY_CHUNK) for name, path in paths.items()}


def chunk_file(array, chunk: Chunk) -> str:
    """The file that holds a chunk, in the folder of its array."""
    index = tuple(part.start // side for part, side in zip(chunk, array.chunks, strict=False))
    return array.metadata.encode_chunk_key(index + (0,) * (array.ndim - len(index)))


def _create_array(group, name: str, variable: Variable, lengths: dict[str, int], sides: tuple[int, ...]) -> None:
    shape = tuple(lengths[dim] for dim in variable.dims)
    group.create_array(
        name,
        shape=shape,
        chunks=sides + shape[len(sides) :],
        dtype=variable.dtype,
        fill_value=variable.fill,
        dimension_names=variable.dims,
        attributes=variable.attributes,
        **_codecs(),
    )


def _write_array(group, name: str, item: StudyArray) -> None:
    values = np.asarray(item.values)
    how = {"dimension_names": item.dims, "attributes": item.attributes} | _codecs()
    group.create_array(name, data=values, chunks=tuple(max(1, n) for n in values.shape), **how)


def _codecs() -> dict[str, object]:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    # sections of periodic motion shrink a lot, those of chaotic motion hardly, at any level
    return {"compressors": [ZstdCodec(level=1), Crc32cCodec()], "config": EVERY_CHUNK}


GROUP = "zarr.json"  # the description of the group, with those of all arrays


class Store:
    """One study's results at a place.

    Parameters
    ----------
    place : StoreLocation
    group : str
        Part of it: rounds of a refined study are results of their own.

    Attributes
    ----------
    key : str
        Of the study, once the place is that of one.
    """

    def __init__(self, location: StoreLocation, group: str = "") -> None:
        self.location, self.group = location, group
        self._arrays: dict[str, object] = {}
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="store")
        self._writing: Future | None = None

    def part(self, name: str) -> "Store":
        """Results in a group below this one."""
        return Store(self.location, name)

    # -- what is there before any cell ----------------------------------------------------------------------------

    def claim(self, study: Study) -> None:
        """Make the place that of a study, or check that it is, from an earlier run.

        Raises
        ------
        ValueError
            If there is something else: another study, one of another engine, one without a manifest, or no study at
            all.
        OSError
            If nothing can be written there.
        """
        self.key, found = study.key, self.read_manifest()
        first = tuple(slice(0, 1) for _ in study.axes)
        if found is None and store_location.sealed_key(self._read(store_location.seal_file(first))) != study.key:
            self._refuse_without_manifest()
        if found is None:  # a new place; or one whose manifest is lost, but each chunk has its seal
            found = store_location.StudyManifest(batches.origin(study))
        elif found.origin["key"] != study.key:
            raise ValueError(_difference(self.location.target, found.origin, study))
        if not self.group:
            self.location.remove_partial_files()
        self._manifest = found
        self._write(store_location.STUDY, found.as_bytes())

    def _refuse_without_manifest(self) -> None:
        """Raise a ValueError unless the place is empty; a group below that of the study is the study's own."""
        if self.group:
            return
        if self._read(store_location.STUDY) is not None:
            raise ValueError(
                f"{self._name(store_location.STUDY)} is damaged: delete {self.location.target}, or give another place"
            )
        if b'"engine_digest"' in (self._read(GROUP) or b""):
            raise ValueError(
                f"{self.location.target} has no {store_location.STUDY}, either lost or not yet written "
                "when it was computed, so that nothing says whether its numbers are whole: delete it, or give another "
                "place"
            )
        if self._read(GROUP) is not None:
            raise ValueError(f"{self.location.target} is a Zarr group but no result of a sweep: give a new place")
        self.location.refuse_foreign_files()

    def create(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Write every file that is missing or differs; returns the sides of the chunks: those of the first run."""
        self._study, found = study, self._manifest
        found.sides = found.sides or list(sides)
        found.shape, found.variables = list(study.shape), list(study.variables)
        files = self._files({}, {})
        if found.account:
            del files[GROUP]  # which `finish` wrote anew, with the conclusions, and so it does again
        self._write_files(files)
        self.open(study, self.key)
        return self._sides

    def open(self, study: Study, key: str) -> "Store":
        """Make the store ready to read and write chunks of a study with this key, or of a part of it."""
        self.key = key
        self._arrays = open_arrays(self.location.root, self.group, study.variables)
        return self

    @property
    def _sides(self) -> tuple[int, ...]:
        return tuple(self._manifest.sides)

    def _files(self, account: Mapping, conclusions: Mapping[str, StudyArray]) -> dict[str, bytes]:
        return study_files(self._study, self._sides, self._manifest.origin | account, conclusions)

    def _write_files(self, files: Mapping[str, bytes]) -> None:
        """Write those files that differ, and then the manifest."""
        for name, content in files.items():
            self._write(name, content)
        self._manifest.files |= {name: store_location.digest(content) for name, content in files.items()}
        self._write(store_location.STUDY, self._manifest.as_bytes())

    def read_manifest(self) -> store_location.StudyManifest | None:
        """The manifest of the study at this place; None if there is none, or if it is damaged."""
        return store_location.read_manifest(self._read(store_location.STUDY))

    def path(self, name: str) -> str:
        """The name of one of its files at the place."""
        return f"{self.group}/{name}" if self.group else name

    def _name(self, name: str) -> str:
        return f"{self.location.target}/{self.path(name)}"

    def _read(self, name: str) -> bytes | None:
        return self.location.read(self.path(name))

    def _write(self, name: str, content: bytes) -> None:
        self.location.write(self.path(name), content)

    # -- chunks ---------------------------------------------------------------------------------------------------

    def read(self, chunk: Chunk) -> dict[str, np.ndarray] | None:
        """The variables of a chunk; None if it is missing, incomplete, damaged, or another one's."""
        sealed = self._seal(chunk)
        if sealed is None:
            return None
        found = {}
        for name in self._arrays:
            found[name] = self._numbers(name, chunk)
            if found[name] is None or store_location.numbers_digest(found[name]) != sealed.get(name):
                return None
        return found

    def _seal(self, chunk: Chunk) -> dict[str, str] | None:
        return store_location.read_seal(self._read(store_location.seal_file(chunk)), self.key, chunk)

    def _chunk_file(self, name: str, chunk: Chunk) -> str:
        return f"{name}/{chunk_file(self._arrays[name], chunk)}"

    def _numbers(self, name: str, chunk: Chunk) -> np.ndarray | None:
        """The numbers of one variable; None where its file is missing, for which Zarr gives fill values, or damaged."""
        if not self.location.exists(self.path(self._chunk_file(name, chunk))):
            return None
        try:
            return np.asarray(self._arrays[name][chunk])
        except DAMAGE:
            return None

    def write(self, chunk: Chunk, values: dict[str, np.ndarray]) -> None:
        """Write a chunk in the background, once the one before is written; `flush` waits for it.

        Raises
        ------
        OSError
            If the one before could not be written, since the disk is full or gone.
        """
        self.flush()
        self._writing = self._writer.submit(self.write_now, chunk, values)

    def write_now(self, chunk: Chunk, values: dict[str, np.ndarray]) -> None:
        """Write a chunk, and then its seal.

        Raises
        ------
        OSError
            If the disk is full or gone.
        """
        values = {name: np.asarray(values[name], array.dtype) for name, array in self._arrays.items()}
        with self.location.readable_errors():
            for name, array in self._arrays.items():
                array[chunk] = values[name]
            self._write(store_location.seal_file(chunk), store_location.seal(self.key, chunk, values))

    def flush(self) -> None:
        """Wait until the last chunk is written.

        Raises
        ------
        OSError
            If it could not be.
        """
        if self._writing is not None:
            self._writing.result()

    def close(self) -> None:
        """Wait until nothing is written any more."""
        self._writer.shutdown()

    # -- the whole ------------------------------------------------------------------------------------------------

    def values(self) -> dict[str, np.ndarray]:
        """All variables, read into memory."""
        self.flush()
        return {name: np.asarray(array[...]) for name, array in self._arrays.items()}

    def finish(self, progress: Progress, where: str) -> None:
        """Write what follows from all cells, and that the results are complete, when and at what cost."""
        self.flush()
        account = self._manifest.account or batches.account(progress, where)
        files = self._files(account, self._study.conclusions(self._arrays))
        self._manifest.account = account
        self._write_files(files)

    def dataset(self) -> "xarray.Dataset":
        """The results as a labelled dataset, read lazily."""
        import xarray

        self.flush()
        return xarray.open_zarr(self.location.root, group=self.group or None, chunks=None, consolidated=True)

    # -- damage ---------------------------------------------------------------------------------------------------

    def damaged_files(self) -> list[str]:
        """The files that are missing or damaged, without the chunks: those that the manifest holds a digest of."""
        found = self.read_manifest()
        if found is None:
            return [store_location.STUDY]
        contents = ((name, self._read(name), expected) for name, expected in found.files.items())
        return [
            name
            for name, content, expected in contents
            if content is None or store_location.digest(content) != expected
        ]

    def damaged_chunks(self) -> Iterator[str]:
        """The files of chunks and their seals that are missing or damaged; none of chunks not computed yet."""
        found, unreadable = self.read_manifest(), self.damaged_files()
        if found is None or not found.sides:
            return
        self.key = found.origin["key"]
        readable = [name for name in found.variables if f"{name}/{GROUP}" not in unreadable]
        self._arrays = open_arrays(self.location.root, self.group, readable)
        for chunk in chunks(tuple(found.shape), tuple(found.sides)):
            sealed, file = self._seal(chunk), store_location.seal_file(chunk)
            if sealed is None and (found.account or self.location.exists(self.path(file))):
                yield file
            for name in self._arrays if sealed else ():
                numbers = self._numbers(name, chunk)
                if numbers is None or store_location.numbers_digest(numbers) != sealed.get(name):
                    yield self._chunk_file(name, chunk)

    def own_files(self) -> set[str]:
        """The files that a store holds once it is complete; those of chunks if their arrays can be read."""
        found = self.read_manifest()
        if found is None or not found.sides:
            return {store_location.STUDY}
        whole = list(chunks(tuple(found.shape), tuple(found.sides)))
        of_chunks = (self._chunk_file(name, chunk) for name in self._arrays for chunk in whole)
        return {store_location.STUDY, *found.files, *map(store_location.seal_file, whole), *of_chunks}


def check_store(target: str | Path) -> tuple[list[str], bool]:
    """The files in the result of a sweep that are missing, damaged or not its own, and whether the sweep is finished.

    Raises
    ------
    ValueError
        If there is no result of a sweep at this place.
    """
    location = StoreLocation(target)
    nowhere = location.folder is not None and not location.folder.is_dir()  # reading would make it
    if nowhere or (location.read(GROUP) is None and location.read(store_location.STUDY) is None):
        raise ValueError(f"{target} is no result of a sweep")
    rounds = (f"round-{level}" for level in itertools.count())
    refined = itertools.takewhile(lambda group: location.read(f"{group}/{store_location.STUDY}") is not None, rounds)
    found, own = [], set()
    for store in (Store(location, group) for group in ("", *refined)):
        names = dict.fromkeys([*store.damaged_files(), *store.damaged_chunks()])
        found += [store.path(name) for name in names]
        own |= {store.path(name) for name in store.own_files()}
    if not any(name.endswith(store_location.STUDY) for name in found):  # without it, no one knows what is its own
        unread = tuple(name.removesuffix(GROUP) for name in found if name.endswith(f"/{GROUP}"))  # arrays
        found += [name for name in location.files() if name not in own and not name.startswith(unread)]
    found = list(dict.fromkeys(found))
    whole = Store(location).read_manifest()
    return found, bool(whole and whole.account)


def _difference(target: object, found: dict, study: Study) -> str:
    wanted = batches.origin(study)
    if found.get("engine_digest") != wanted["engine_digest"]:
        return (
            f"{target} was computed by another engine ({found.get('engine_version')}, {found.get('engine_digest')}; "
            f"this is {wanted['engine_version']}, {wanted['engine_digest']}): delete it, or give another place"
        )
    names = [name for name, value in wanted.items() if name not in ("key", "complete") and found.get(name) != value]
    return f"{target} holds another study (another {', '.join(names) or 'axis'}): delete it, or give another place"
