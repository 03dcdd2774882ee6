"""Numbers as they appear in sentences: percentages, counts with their noun, periods of recurrence."""


def percent(fraction: float) -> str:
    """A fraction in per cent with two digits; rounding errors count as zero."""
    if fraction < 1e-7:
        return "0 %"
    return f"{100 * fraction:.2g} %" if fraction < 0.995 else f"{100 * fraction:.0f} %"


def counted(count: float, noun: str) -> str:
    """A count with its noun in the singular or plural, such as "1 period" or "2.5 contacts"."""
    return f"{count:.3g} {noun}{'' if count == 1 else 's'}"


def every(periods: int) -> str:
    """How often something recurs: "every period" or "every 2 periods"."""
    return "every period" if periods == 1 else f"every {periods} periods"
