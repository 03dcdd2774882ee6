"""Other people's numbers: published cases of ``assets/validation/cases.toml``, solved here and compared."""

from .cases import Case, Quantity, cases
from .outcome import ComparedFigure, as_dict, validate

__all__ = ["Case", "ComparedFigure", "Quantity", "as_dict", "cases", "validate"]
