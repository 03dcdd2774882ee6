"""Other people's numbers: published cases of ``assets/validation/cases.toml``, solved here and compared."""

from .cases import Case, Quantity, cases
from .outcome import Comparison, as_dict, validate

__all__ = ["Case", "Comparison", "Quantity", "as_dict", "cases", "validate"]
