"""The results of a study in memory: arrays over the whole grid."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.sweeps import provenance
from vibroscope.engine.sweeps.batches import Batch
from vibroscope.engine.sweeps.codes import MISSING
from vibroscope.engine.sweeps.progress import Progress
from vibroscope.engine.sweeps.study import Study

if TYPE_CHECKING:
    import xarray


def empty_values(study: Study) -> dict[str, np.ndarray]:
    """The variables of a study of which no cell is known."""
    lengths = study.lengths
    return {
        name: np.full(tuple(lengths[dim] for dim in variable.dims), variable.fill, variable.dtype)
        for name, variable in study.variables.items()
    }


class Memory:
    """One study's results; the same methods as `Store`.

    Parameters
    ----------
    values : mapping of str to ndarray, optional
        The variables that an earlier run of the same study left.
    """

    def __init__(self, values: Mapping[str, np.ndarray] | None = None) -> None:
        self._values = {name: array.copy() for name, array in (values or {}).items()}
        self._account: dict[str, object] = {}

    def claim(self, study: Study) -> None:
        """Make these results those of a study."""
        self._claimed = study

    def create(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Create every array that is missing; returns the sides of the chunks."""
        self._study = study  # a refined study: with all its cells, which were not known when it was claimed
        self._values = self._values or empty_values(study)
        return sides

    def part(self, name: str) -> "Memory":
        """Results that are a part of these: a round of refinement."""
        return Memory()

    def read(self, batch: Batch) -> dict[str, np.ndarray] | None:
        """The variables of a batch; None if any of its cells is missing."""
        if (self._values["status"][batch] == MISSING).any():
            return None
        return {name: array[batch] for name, array in self._values.items()}

    def write(self, batch: Batch, values: dict[str, np.ndarray]) -> None:
        """Take the variables of a batch."""
        for name, array in self._values.items():
            array[batch] = values[name]

    @property
    def known(self) -> np.ndarray:
        """Whether each cell is known, in the shape of the grid."""
        known = self._values["status"] != MISSING
        return known.all(axis=tuple(range(len(self._study.shape), known.ndim)))

    def values(self) -> dict[str, np.ndarray]:
        """Copies of all variables."""
        return {name: array.copy() for name, array in self._values.items()}

    def finish(self, progress: Progress, where: str) -> None:
        """Note that the results are complete, when and at what cost."""
        self._account = provenance.account(progress, where)

    def dataset(self) -> "xarray.Dataset":
        """The results as a labelled dataset."""
        import xarray

        study, values = self._study, self._values
        arrays = study.arrays | study.conclusions(values)
        found = {name: (item.dims, np.asarray(item.values), item.attributes) for name, item in arrays.items()}
        for name, variable in study.variables.items():
            found[name] = (variable.dims, values[name], variable.attributes)
        return xarray.Dataset(found, attrs=provenance.origin(self._claimed) | self._account)

    def close(self) -> None:
        """Nothing is open."""
