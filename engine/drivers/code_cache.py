"""Where the machine code of the kernels is cached, and what it is the code of."""

from ..kernels.compile.options import cache_root, source_digest

__all__ = ["cache_root", "source_digest"]
