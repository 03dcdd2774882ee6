"""How many of many like examples are tried: all by `make test`, with ``--in-process`` (`make check`) one in seven.

`tests/conftest.py` says which before any test is imported. Seven is a prime number: in a grid of cases, such as that of
integrators and laws, every seventh case is in another row and in another column.
"""

IN_PROCESS = 7
divisor = 1


def share(count):
    """How many of so many examples are tried; at least one."""
    return max(1, count // divisor)


def every(cases):
    """The cases that are tried, spread over all of them."""
    return list(cases)[::divisor]
