"""Which numbers may vary: what the motions of a method and a system do not have is refused."""

from vibroscope.engine.methods import METHOD_NUMBERS, Method
from vibroscope.engine.model import SECOND_STOP, System


def check_has(method: Method, name: str, system: System) -> None:
    """Refuse a number that is to vary and has no effect, by its symbol or as of :class:`System`.

    Raises
    ------
    ValueError
        If the method does not have it, or there is no second stop to have it.
    """
    if name in (*METHOD_NUMBERS, "threshold") and name not in method.numbers:
        raise ValueError(f"the {method.name} method has no {name}: give another number or solver")
    if name in ("restitution", "restitution2") and not method.rigid:
        raise ValueError(f"the {method.name} method has no impact law and so no {name}: give D in its place")
    if name in SECOND_STOP[1:] and method.rigid:
        raise ValueError(f"the {method.name} method has no K and D, and so no {name}: give another solver")
    if name in SECOND_STOP and not system.two_stops:
        raise ValueError(f"{name}: there is no second stop; give its clearance, too")
