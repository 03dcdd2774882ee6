"""The place of ``vibroscope branch --out``: a Zarr group of the branches so far, and what the search goes on with."""

import contextlib
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from vibroscope.engine import Branch, branches_dataset
from vibroscope.engine.sweeps.store_location import StoreLocation

_SEARCH = "search"  # the folder in that of the group which `search_branches` keeps its branches in


class KeptBranches:
    """Branches at a place, a folder or a URL; a search into a folder goes on where it was stopped or killed."""

    def __init__(self, target: str) -> None:
        self._location = StoreLocation(target)

    @property
    def search_folder(self) -> Path | None:
        """The folder in which the search keeps the branches that it has followed."""
        return self._location.folder and self._location.folder / _SEARCH

    @contextlib.contextmanager
    def held(self) -> Iterator["KeptBranches"]:
        """Hold the place for this process.

        Raises
        ------
        ValueError
            If there is something else.
        BlockingIOError
            If another process holds it.
        """
        folder = self._location.folder
        known = folder is None or not folder.exists() or self.search_folder.exists()
        if not known and (not folder.is_dir() or any(folder.iterdir())):
            raise ValueError(f"{folder} exists and is no result of such a search: give a new place")
        with self._location.lock():
            if folder is not None:
                import zarr

                zarr.open_group(self._location.root, path=_SEARCH, mode="a")  # Zarr warns of folders that are no groups
            yield self

    def write(self, found: Sequence[Branch], over: str, *, complete: bool) -> None:
        """Write the branches over a number in place of those before; there may be none."""
        with self._location.readable_errors():
            for path in self._location.folder.iterdir() if self._location.folder else ():
                if path.name != _SEARCH:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            dataset = branches_dataset(found, over).assign_attrs(complete=int(complete))
            dataset.to_zarr(self._location.root, mode="a" if self._location.folder else "w", consolidated=False)
