"""How many of many like examples are tried: a seventh by `make test` and `make check`, all by `make release`.

`tests/conftest.py` says which before any test is imported. Those that are tried are spread by the golden section: in a
grid of cases, such as that of integrators and laws, they lie in all rows and in all columns, however long these are.
"""

import math

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
divisor = 7


def share(count):
    """How many of so many examples are tried; at least one."""
    return max(1, count // divisor)


def every(cases):
    """The cases that are tried, the first among them."""
    return [case for i, case in enumerate(cases) if i * GOLDEN % 1.0 < 1.0 / divisor]
