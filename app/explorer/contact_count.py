"""The contacts of a solution in the window of the figures: one count for all that names one. No panel import."""

import numpy as np
from vibroscope.engine import counted, percent

SAME_INSTANT = 1e-6  # relative: columns of figures have single precision


def contact_count(left: np.ndarray, right: np.ndarray, length: float, rigid: bool) -> str:
    """The impacts and contacts in a window, in words, and which of the contacts its ends cut.

    Parameters
    ----------
    left, right : (n,) ndarray
        Intervals in contact within the window, from its start; an impact of the reference has no length.
    length : float
        Of the window, in the same unit.
    rigid : bool
        Whether they are those of the reference.
    """
    struck = (left == right) & rigid
    lasting = ~struck
    first, last = lasting & (left <= 0.0), lasting & np.isclose(right, length, rtol=SAME_INSTANT)
    cuts = [("from start to end", first & last), ("from the start on", first & ~last), ("until the end", last & ~first)]
    cut = ", ".join(f"{'one ' if lasting.sum() > 1 else ''}{words}" for words, which in cuts if which.any())
    contacts = counted(int(lasting.sum()), "permanent contact" if rigid else "contact")
    contacts += f" ({cut})" if cut else ""
    impacts = counted(int(struck.sum()), "impact")
    return contacts if not rigid else f"{impacts} and {contacts}" if lasting.any() else impacts


def contact_share(left: np.ndarray, right: np.ndarray, length: float) -> str:
    """The share of the window in contact, in words."""
    return percent(float((right - left).sum()) / length)
