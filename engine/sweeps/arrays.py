"""The arrays of a store: each chunk of a study one Zarr chunk, compressed, with a checksum, and always a file."""

import contextlib

import numpy as np

from .batches import Chunk
from .variables import StudyArray, Variable

LEVEL = 1  # of zstd: sections of periodic motion shrink a lot, those of chaotic motion hardly, at any level
DAMAGE = (ValueError, RuntimeError, OSError)  # what the checksum, the decompressor and the disk raise
# A chunk of nothing but fill values becomes a file, too: a chunk without a file is missing.
EVERY_CHUNK = {"write_empty_chunks": True}


def open_array(group, name: str):
    """The array of this name; None if there is none that can be opened."""
    try:
        return group[name]
    except (KeyError, *DAMAGE):
        return None


def create_array(group, name: str, variable: Variable, lengths: dict[str, int], sides: tuple[int, ...]) -> None:
    """Create an array of nothing but missing values, in chunks of so many cells along each axis of the grid."""
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


def write_array(group, name: str, item: StudyArray) -> None:
    """Write an array of the study in one piece, unless the same is there already."""
    values = np.asarray(item.values)
    found = open_array(group, name)
    if found is not None:
        with contextlib.suppress(*DAMAGE):
            if np.array_equal(found[...], values, equal_nan=True):
                return
    how = {"dimension_names": item.dims, "attributes": item.attributes} | _codecs()
    group.create_array(name, data=values, chunks=tuple(max(1, n) for n in values.shape), overwrite=True, **how)


def chunk_exists(array, chunk: Chunk) -> bool:
    """Whether the file of a chunk is there."""
    from zarr.core.sync import sync

    index = tuple(part.start // side for part, side in zip(chunk, array.chunks, strict=False))
    key = array.metadata.encode_chunk_key(index + (0,) * (array.ndim - len(index)))
    return sync((array.store_path / key).exists())


def _codecs() -> dict[str, object]:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return {"compressors": [ZstdCodec(level=LEVEL), Crc32cCodec()], "config": EVERY_CHUNK}
