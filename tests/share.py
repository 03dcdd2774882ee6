"""How many of many like examples are tried: all by `make test`, with ``--in-process`` (`make check`) the first quarter.

`tests/conftest.py` says which before any test is imported.
"""

QUARTER = 4
divisor = 1


def share(count):
    """Of so many examples, how many are tried."""
    return max(1, count // divisor)


def every(cases):
    """Of these cases, those that are tried: spread over all of them."""
    return list(cases)[::divisor]
