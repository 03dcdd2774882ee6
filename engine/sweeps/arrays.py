"""The arrays of a store as files: each chunk of a study one Zarr chunk, compressed, with a checksum."""

import warnings
from collections.abc import Iterable, Mapping

import numpy as np
from vibroscope.engine.sweeps.batches import Chunk
from vibroscope.engine.sweeps.study import Study
from vibroscope.engine.sweeps.variables import StudyArray, Variable

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
