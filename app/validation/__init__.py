"""Other people's numbers: published cases of ``assets/validation/cases.toml``, solved here and compared."""

from .cases import PublishedCase, PublishedFigure, cases
from .outcome import ComparedFigure, as_dict, validate

__all__ = ["ComparedFigure", "PublishedCase", "PublishedFigure", "as_dict", "cases", "validate"]
