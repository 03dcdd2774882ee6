"""A cache of machine code that survives damaged files and full disks.

Numba's own cache raises whatever the disk raises, so that a kernel fails where a file is damaged or the disk is full,
and it would run machine code in which a bit has flipped, or that of another function whose file stands in its place.
Here each file begins with a digest of its name, of the kernels' sources and of its content: a file that does not match
its digest counts as missing, and code that cannot be written is compiled anew at the next start.
"""

import contextlib
import functools
import hashlib
import pickle
from pathlib import Path

from numba.core.caching import FunctionCache, IndexDataCacheFile

_KERNELS = Path(__file__).parents[1]
_LENGTH = hashlib.sha256().digest_size


def source_digest(folder: Path = _KERNELS) -> str:
    """Digest of every Python source below a folder, 12 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


@functools.cache
def _own_sources() -> bytes:
    return source_digest().encode()


def _digest(path: str, data: bytes) -> bytes:
    """Digest of a file that holds these data: of its package and name, of the sources, and of the data.

    Numba's name of the folder is that of the package and a digest of where it is installed. The latter is left out, so
    that the code of one installation serves another one with the same sources.
    """
    package = Path(path).parent.name.rpartition("_")[0]
    place = f"{package}/{Path(path).name}".encode()
    return hashlib.sha256(b"\0".join((place, _own_sources(), data))).digest()


class Cache(FunctionCache):
    """The machine code of one function."""

    def __init__(self, function):
        super().__init__(function)
        # No time stamp of the source, which a copy changes: the name of the folder identifies the sources.
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, source_stamp=None)

    def save_overload(self, sig, data):
        """Save machine code, if the disk lets it; see `numba.core.caching.FunctionCache`."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


class _Files(IndexDataCacheFile):
    """An index, and one file for each signature; each holds a digest and the content that it belongs to."""

    def _load_index(self):
        version, entries = self._read(self._index_path) or (None, {})
        return entries if version == self._version else {}

    def _save_index(self, overloads):
        self._write(self._index_path, (self._version, overloads))

    def _load_data(self, name):
        return self._read(self._data_path(name))

    def _save_data(self, name, data):
        self._write(self._data_path(name), data)

    def _read(self, path):
        try:
            content = Path(path).read_bytes()
        except OSError:
            return None
        digest, data = content[:_LENGTH], content[_LENGTH:]
        if _digest(path, data) != digest:
            return None
        return pickle.loads(data)

    def _write(self, path, content):
        data = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(_digest(path, data) + data)
