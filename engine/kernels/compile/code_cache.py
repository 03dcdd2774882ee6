"""A cache of machine code that survives damaged files and full disks.

Numba's own cache raises whatever the disk raises, so that a kernel fails where a file is damaged or the disk is full,
and it would run machine code in which a bit has flipped. Here each file begins with a digest of its content: a file
that does not match its digest counts as missing, and code that cannot be written is compiled anew at the next start.
"""

import contextlib
import hashlib
import pickle
from pathlib import Path

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

_DIGEST = hashlib.sha256
_LENGTH = _DIGEST().digest_size


def cache_safe(function, **options):
    """Compile a function by Numba and cache its machine code."""
    dispatcher = numba.njit(function, **options)
    dispatcher._cache = _Cache(function)
    return dispatcher


class _Cache(FunctionCache):
    """The machine code of one function."""

    def __init__(self, function):
        super().__init__(function)
        # No time stamp of the source, which a copy changes: the name of the folder identifies the sources.
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, source_stamp=None)

    def save_overload(self, sig, data):
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
        return pickle.loads(data) if _DIGEST(data).digest() == digest else None

    def _write(self, path, content):
        data = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(_DIGEST(data).digest() + data)
