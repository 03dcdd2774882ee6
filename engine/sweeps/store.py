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
from typing import TYPE_CHECKING

import numpy as np

from . import arrays, provenance
from .chunks import Chunk
from .place import Place
from .study import Study
from .variables import MISSING, Whole

if TYPE_CHECKING:
    import xarray


class Store:
    """One study's result at a place.

    Parameters
    ----------
    place : Place
    group : str
        Part of it: rounds of a refined study are results of their own.
    """

    def __init__(self, place: Place, group: str = "") -> None:
        self.place, self.group = place, group
        self._arrays: dict[str, object] = {}

    def part(self, group: str) -> "Store":
        """A result below this one."""
        return Store(self.place, group)

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
            if not self.group:
                self.place.refuse_what_is_not_ours()
            with self.place.errors():
                zarr.create_group(self.place.root, path=self.group, attributes=provenance.origin(study))
        elif found.get("key") != study.key:
            raise ValueError(_difference(self.place.target, found, study))
        elif self.place.folder is not None and not self.group:
            for rest in self.place.folder.rglob("*.partial"):  # of a process that was killed while it wrote
                rest.unlink(missing_ok=True)

    def frame(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Have every array in place; the sides of the chunks, which are those of the first run, not those asked for.

        An array whose description was lost is made anew, so that its chunks, and with them all, count as missing.
        """
        group = self._opened_group()
        with self.place.errors():
            status = arrays.array_of(group, "status")
            if status is not None:
                sides = tuple(status.chunks[: len(study.axes)])
            for name, item in study.whole.items():
                arrays.keep(group, name, item)
            for name, variable in study.variables.items():  # status is the last of them
                if arrays.array_of(group, name) is None:
                    arrays.make(group, name, variable, study.lengths, sides)
            self._consolidate()
        self.opened(study)
        return sides

    def opened(self, study: Study) -> "Store":
        """The same store, ready to read and write chunks of the study whose arrays it holds."""
        group = self._opened_group()
        self._arrays = {name: group[name].with_config(arrays.EVERY_CHUNK) for name in study.variables}
        return self

    def keep(self, pieces: dict[str, Whole]) -> None:
        """Have these arrays in the result; what is there already stays untouched."""
        group = self._opened_group()
        with self.place.errors():
            for name, item in pieces.items():
                arrays.keep(group, name, item)

    def _opened_group(self):
        import zarr

        return zarr.open_group(self.place.root, path=self.group, mode="r+", use_consolidated=False)

    def attributes(self) -> dict[str, object] | None:
        """The attributes of the result that lies there; None if there is none."""
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
        """What a chunk holds; None if it is missing, incomplete or damaged."""
        found = {}
        try:
            for name in ("status", *self._arrays):
                array = self._arrays[name]
                found[name] = np.asarray(array[chunk])
                if name == "status" and (found[name] == MISSING).any():
                    return None
                if not arrays.is_there(array, chunk):  # a file that is gone would read as nan
                    return None
        except arrays.DAMAGE:
            return None
        return found

    def write(self, chunk: Chunk, values: dict[str, np.ndarray]) -> None:
        """Write a chunk.

        Raises
        ------
        OSError
            If the disk is full or gone.
        """
        with self.place.errors():
            for name in self._arrays:
                if name != "status":
                    self._arrays[name][chunk] = values[name]
            self._arrays["status"][chunk] = values["status"]

    def finish(self, account: dict[str, object]) -> None:
        """Say that the result is complete, when and at what cost."""
        with self.place.errors():
            self._opened_group().attrs.update(account)
            self._consolidate()

    def _consolidate(self) -> None:
        # xarray looks for the metadata in one piece, and would warn each user if it had to gather them
        if self.group:
            return  # a round of a refined study is read by this class alone
        import zarr

        with self.place.errors(), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
            zarr.consolidate_metadata(self.place.root)

    def dataset(self) -> "xarray.Dataset":
        """The result, read lazily."""
        import xarray

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
