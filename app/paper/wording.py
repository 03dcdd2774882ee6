"""Numbers in the sentences of a finding."""

_LEAST = 1e-4  # the smallest share that is printed


def cycle_text(periods: int) -> str:
    """A cycle of so many periods; 0 is no cycle."""
    return {0: "no cycle", 1: "one period", 2: "two periods"}.get(periods, f"{periods} periods")


def count_text(number: float, noun: str) -> str:
    """A number and its noun, which takes a plural s unless the number is 1."""
    return f"{number:g} {noun}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """Two digits, three from 10 % on; the space before the sign does not break."""
    return f"{100 * share:.{3 if share >= 0.1 else 2}g}\u00a0%" if share >= _LEAST else "less than 0.01\u00a0%"
