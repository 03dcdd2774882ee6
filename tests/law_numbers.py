"""Numbers of contact laws for tests: those that the table of laws asks for, so that a new law needs no entry here."""

from vibroscope.engine import HHT, Bathe, HHTInterpolated, NewmarkBeta
from vibroscope.engine.law_table import LAWS, numbers_of

SKIPPED = [  # integrator, status and law of methods that skip steps, of each kind of step and of piece one
    (HHT(0.0), "start", "kelvin-voigt"),
    (NewmarkBeta(), "start", "cut"),
    (HHTInterpolated(), "end", "kelvin-voigt"),
    (Bathe(0.5), "end", "cut"),
    (HHTInterpolated(), "end", "jankowski"),
    (Bathe(0.5), "start", "limited"),
    (NewmarkBeta(), "end", "compression"),
    (HHTInterpolated(), "end", "bilinear"),
    (Bathe(0.5), "start", "bilinear"),
]


def law_numbers(law, exponent=None, penetration=0.02):
    """What a law takes beside K and D: an exponent other than its default if one is given, and others."""
    chosen = {"exponent": exponent or LAWS[law].exponent, "penetration": penetration, "stiffening": 4.0}
    return {name: chosen[name] for name in numbers_of(law)}
