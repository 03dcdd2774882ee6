"""What moves, by name and with the evidence: periodic, quasi-periodic or chaotic."""

from .description import Kind, Motion, describe
from .result import Response
from .section import repeats_after

__all__ = ["Kind", "Motion", "motion", "repeats_after"]


def motion(response: Response) -> Motion:
    """Describe the kept periods of a response.

    Raises
    ------
    ValueError
        If the run ended early.
    """
    if not response.ok:
        raise ValueError(f"the run ended as {response.status}: {response.message}")
    return describe(response)
