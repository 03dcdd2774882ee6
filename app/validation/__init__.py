"""Other people's numbers: published cases of ``assets/validation/cases.toml``, solved here and compared."""

from vibroscope.app.validation.cases import PublishedCase, PublishedFigure, cases
from vibroscope.app.validation.outcome import ComparedFigure, as_dict, validate

__all__ = ["ComparedFigure", "PublishedCase", "PublishedFigure", "as_dict", "cases", "validate"]
