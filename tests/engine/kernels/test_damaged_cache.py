"""The cache of compiled code: found again, never run when it is damaged, done without where the disk is full."""

import random
import resource

import numba
import pytest
from vibroscope.engine.kernels.compile.options import Kernel

NAMES = "twice", "thrice"


def twice(x):
    return 2.0 * x


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def thrice(x):
    return 3.0 * x


def is_cached(plain=twice):
    """Whether the code was found, once the function has been called anew, as a new process would."""
    function = Kernel(plain)
    assert function(3.5) == plain(3.5)
    return bool(function.stats.cache_hits)


def files(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_it_is_found_again(folder):
    assert not is_cached()
    assert is_cached()


@pytest.mark.parametrize("number", range(8))
def test_a_damaged_file_counts_as_missing_and_is_written_anew(folder, number):
    chance = random.Random(number)
    is_cached()
    path = files(folder)[number % 2]  # the index, and the code
    content = bytearray(path.read_bytes())
    at = chance.randrange(len(content))
    if number < 4:
        content[at] ^= 1 << chance.randrange(8)
    else:
        del content[at:]
    path.write_bytes(content)
    assert not is_cached()
    assert is_cached()


def test_the_code_of_another_function_is_not_run(folder):
    """Files that were exchanged once ran each other's function: their digests were of the content alone."""
    is_cached(twice), is_cached(thrice)
    codes = [next(path for path in files(folder) if name in path.name and path.suffix == ".nbc") for name in NAMES]
    contents = [path.read_bytes() for path in codes]
    for path, content in zip(codes, reversed(contents), strict=True):
        path.write_bytes(content)
    for plain in (twice, thrice):
        assert not is_cached(plain)  # which also compares what it returns
        assert is_cached(plain)


def test_a_lost_file_is_written_anew(folder):
    for number in range(2):
        is_cached()
        files(folder)[number].unlink()
        assert not is_cached()
    assert is_cached()


def test_where_nothing_can_be_written_it_is_compiled_each_time(folder):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, hard))  # as on a full disk
    try:
        assert not is_cached()
        assert not is_cached()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not is_cached()
    assert is_cached()
