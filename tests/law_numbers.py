"""Numbers of contact laws for tests: those that the table of laws asks for, so that a new law needs no entry here."""

from vibroscope.engine.law_table import LAWS, numbers_of


def law_numbers(law, exponent=None, penetration=0.02):
    """What a law takes beside K and D: an exponent other than its default if one is given, and others."""
    chosen = {"exponent": exponent or LAWS[law].exponent, "penetration": penetration, "stiffening": 4.0}
    return {name: chosen[name] for name in numbers_of(law)}
