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

import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from . import arrays, provenance
from .batches import Chunk
from .codes import MISSING
from .place import Place
from .progress import Progress
from .study import Study

if TYPE_CHECKING:
    import xarray


class Store:
    """One study's results at a place.

    Parameters
    ----------
    place : Place
    group : str
        Part of it: rounds of a refined study are results of their own.
    """

    def __init__(self, place: Place, group: str = "") -> None:
        self.place, self.group = place, group
        self._arrays: dict[str, object] = {}
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="store")
        self._writing: Future | None = None

    def part(self, name: str) -> "Store":
        """Results in a group below this one."""
        return Store(self.place, name)

    # -- what is there before any cell ----------------------------------------------------------------------------

    def claim(self, study: Study) -> None:
        """Make the place that of a study, or check that it is, from an earlier run.

        Raises
        ------
        ValueError
            If there is something else: another study, one of another engine, or no study at all.
        OSError
            If nothing can be written there.
        """
        import zarr

        self._study = study
        found = self.attributes()
        if found is None:
            if not self.group:
                self.place.refuse_foreign_files()
            with self.place.readable_errors():
                zarr.create_group(self.place.root, path=self.group, attributes=provenance.origin(study))
        elif found.get("key") != study.key:
            raise ValueError(_difference(self.place.target, found, study))
        elif not self.group:
            self.place.remove_partial_files()

    def create(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Create every array that is missing; returns the sides of the chunks: those of the first run.

        An array whose description was lost is made anew, so that its chunks, and with them all, count as missing.
        """
        group = self._open_group()
        with self.place.readable_errors():
            status = arrays.open_array(group, "status")
            if status is not None:
                sides = tuple(status.chunks[: len(study.axes)])
            for name, item in study.arrays.items():
                arrays.write_array(group, name, item)
            for name, variable in study.variables.items():  # status is the last of them
                if arrays.open_array(group, name) is None:
                    arrays.create_array(group, name, variable, study.lengths, sides)
            self._consolidate()
        self.open(study)
        return sides

    def open(self, study: Study) -> "Store":
        """Make the store ready to read and write chunks of a study whose arrays it holds."""
        self._study, group = study, self._open_group()
        self._arrays = {name: group[name].with_config(arrays.EVERY_CHUNK) for name in study.variables}
        return self

    def _open_group(self):
        import zarr

        return zarr.open_group(self.place.root, path=self.group, mode="r+", use_consolidated=False)

    def attributes(self) -> dict[str, object] | None:
        """The attributes of the results at this place; None if there are none."""
        import zarr

        try:
            group = zarr.open_group(self.place.root, path=self.group, mode="r", use_consolidated=False)
        except FileNotFoundError:
            return None
        except ValueError as problem:
            raise ValueError(f"{self.place.target} is damaged ({problem}): delete it, or give another place") from None
        return dict(group.attrs)

    # -- chunks ---------------------------------------------------------------------------------------------------

    def read(self, chunk: Chunk) -> dict[str, np.ndarray] | None:
        """The variables of a chunk; None if it is missing, incomplete or damaged."""
        found = {}
        try:
            for name in ("status", *self._arrays):
                array = self._arrays[name]
                found[name] = np.asarray(array[chunk])
                if name == "status" and (found[name] == MISSING).any():
                    return None
                if not arrays.chunk_exists(array, chunk):  # a file that is gone would read as nan
                    return None
        except arrays.DAMAGE:
            return None
        return found

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
        """Write a chunk.

        Raises
        ------
        OSError
            If the disk is full or gone.
        """
        with self.place.readable_errors():
            for name in self._arrays:
                if name != "status":
                    self._arrays[name][chunk] = values[name]
            self._arrays["status"][chunk] = values["status"]

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
        conclusions = self._study.conclusions(self._arrays)
        group = self._open_group()
        with self.place.readable_errors():
            for name, item in conclusions.items():
                arrays.write_array(group, name, item)
            if not group.attrs["complete"]:
                group.attrs.update(provenance.account(progress, where))
                self._consolidate()

    def _consolidate(self) -> None:
        # xarray looks for the metadata in one piece, and would warn each user if it had to collect them
        if self.group:
            return  # a round of a refined study is read by this class alone
        import zarr

        with self.place.readable_errors(), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
            zarr.consolidate_metadata(self.place.root)

    def dataset(self) -> "xarray.Dataset":
        """The results as a labelled dataset, read lazily."""
        import xarray

        self.flush()
        return xarray.open_zarr(self.place.root, group=self.group or None, chunks=None, consolidated=not self.group)


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
