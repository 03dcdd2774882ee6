"""The manifest of a store: digests of its numbers and its files, by which damage is found.

A checksum within a chunk does not show that the chunk is another one's, and none protects a description. So the folder
`FOLDER` of a store holds a manifest: one file of the study (`StudyManifest`), and one for each chunk, its *seal*, with
digests of the numbers of all variables. A seal is written last: where it agrees, the chunk is complete and in place.
Seals are files of their own, so that chunks are written side by side, by several machines, without a lock.

The folder lies in that of an array, where no reader of Zarr looks for further arrays.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

import numpy as np
from vibroscope.engine.sweeps.batches import Chunk

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
