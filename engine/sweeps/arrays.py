"""The arrays of a store: each chunk of a study one Zarr chunk, compressed, with a checksum, and always a file."""

import contextlib

import numpy as np

from .chunks import Chunk
from .variables import Variable, Whole

LEVEL = 1  # of zstd: sections of periodic motion shrink a lot, those of chaotic motion hardly, at any level
DAMAGE = (ValueError, RuntimeError, OSError)  # what the checksum, the decompressor and the disk raise
# A chunk of nothing but fill values, too, becomes a file: one that is not there is missing.
EVERY_CHUNK = {"write_empty_chunks": True}


def array_of(group, name: str):
    """The array of this name; None if there is none that can be opened."""
    try:
        return group[name]
    except (KeyError, *DAMAGE):
        return None


def make(group, name: str, variable: Variable, lengths: dict[str, int], sides: tuple[int, ...]) -> None:
    """Have an array of nothing but missing values."""
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


def keep(group, name: str, item: Whole) -> None:
    """Have an array in one piece; what is there already stays untouched."""
    values = np.asarray(item.values)
    found = array_of(group, name)
    if found is not None:
        with contextlib.suppress(*DAMAGE):
            if np.array_equal(found[...], values, equal_nan=True):
                return
    how = {"dimension_names": item.dims, "attributes": item.attributes} | _codecs()
    group.create_array(name, data=values, chunks=tuple(max(1, n) for n in values.shape), overwrite=True, **how)


def is_there(array, chunk: Chunk) -> bool:
    """Whether the file of a chunk is there."""
    from zarr.core.sync import sync

    index = tuple(part.start // side for part, side in zip(chunk, array.chunks, strict=False))
    key = array.metadata.encode_chunk_key(index + (0,) * (array.ndim - len(index)))
    return sync((array.store_path / key).exists())


def _codecs() -> dict[str, object]:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return {"compressors": [ZstdCodec(level=LEVEL), Crc32cCodec()], "config": EVERY_CHUNK}
