"""The numbers and properties of each contact law beside K and D; engine, command line and page read this table.

The force of each is in :mod:`.kernels.equations.contact_law`, the formula of its damper in :mod:`.laws`.
"""

from typing import NamedTuple

HERTZ = 1.5
NEEDED = None  # in place of the default of a number that must be given


class Law(NamedTuple):
    """Properties of a contact law; those of a linear law that is integrated by steps are the defaults."""

    exponent: float = 1.0  # n of its spring's force Kδⁿ; the default where the law takes n
    takes_exponent: bool = False
    takes_penetration: bool = False  # from which on its damper acts in full
    by_restitution: bool = False  # whether a formula gives its damper where D is left out
    relative: bool = False  # whether its damper is a factor of the spring's force, h = 2D/K, instead of c = 2D
    closed_form: bool = False  # piecewise linear, with its pieces in drivers/law_driven.py
    graded: bool = False  # whether its damper is c δ^((n − 1)/2) v
    jumps: bool = False  # whether its damper acts in full as soon as the bodies touch
    newmark: bool = False  # taken by `Newmark`, too


_RATIO = Law(HERTZ, takes_exponent=True, by_restitution=True, relative=True)
LAWS = {
    "kelvin-voigt": Law(closed_form=True, jumps=True, newmark=True),
    "cut": Law(closed_form=True, jumps=True, newmark=True),
    "limited": Law(closed_form=True),
    "compression": Law(closed_form=True, jumps=True),
    "hunt-crossley": _RATIO,
    "lankarani-nikravesh": _RATIO,
    "flores": _RATIO,
    "jankowski": Law(HERTZ, by_restitution=True, graded=True),
    "constant-restitution": Law(HERTZ, takes_exponent=True, by_restitution=True, graded=True),
    "impact": Law(HERTZ, takes_exponent=True, takes_penetration=True),
}
LAWS_BY_RESTITUTION = tuple(name for name, law in LAWS.items() if law.by_restitution)
CONTACT_LAWS = tuple(LAWS)
RATIO_LAWS = tuple(name for name, law in LAWS.items() if law.relative)
NEWMARK_LAWS = tuple(name for name, law in LAWS.items() if law.newmark)


def numbers_of(law: str) -> dict[str, float | None]:
    """The numbers that a law takes beside K and D, by their names in `ExactPenalty`, each with its default."""
    own = LAWS[law]
    numbers = {"exponent": own.exponent} if own.takes_exponent else {}
    return numbers | {"penetration": NEEDED} if own.takes_penetration else numbers


def powers_of(law: str, exponent: float) -> tuple[float, float]:
    """The powers of the penetration δ in the spring's force Kδⁿ and in the damper's, of a law with this exponent n.

    A law that takes no exponent has its own n, whatever is given.
    """
    own = LAWS[law]
    n = exponent if own.takes_exponent else own.exponent
    return n, n if own.relative else (n - 1.0) / 2.0 if own.graded else 0.0


def laws_with(number: str) -> tuple[str, ...]:
    """The laws that take a number, "exponent" or "penetration"."""
    return tuple(law for law in LAWS if number in numbers_of(law))
