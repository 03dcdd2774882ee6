"""Units that people type behind a number, on the page and on the command line. Imports nothing of the engine."""

import math
import re
from collections.abc import Mapping

# What one of each is worth in the SI unit of its quantity; as `number_text.plain_unit` writes them.
TYPED_UNITS = {
    "frequency": {"Hz": 1.0, "kHz": 1e3, "rad/s": 0.5 / math.pi, "1/s": 0.5 / math.pi},
    "angular_frequency": {"1/s": 1.0, "rad/s": 1.0, "Hz": 2 * math.pi, "kHz": 2e3 * math.pi},
    "stiffness": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "kN/mm": 1e6},
    "damping": {"Ns/m": 1.0, "kg/s": 1.0, "kNs/m": 1e3, "Ns/mm": 1e3, "kNs/mm": 1e6},
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "displacement": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "area": {"m²": 1.0, "m2": 1.0, "m^2": 1.0, "cm²": 1e-4, "cm2": 1e-4, "mm²": 1e-6, "mm2": 1e-6, "mm^2": 1e-6},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3},
    "acceleration": {
        "m/s²": 1.0,
        "m/s2": 1.0,
        "m/s^2": 1.0,
        "mm/s²": 1e-3,
        "mm/s2": 1e-3,
        "mm/s^2": 1e-3,
        "g": 9.80665,
    },
    "angle": {"rad": 1.0, "°": math.pi / 180, "deg": math.pi / 180},
    "share": {"": 1.0, "%": 0.01},
}
TYPED_UNITS |= {f"contact_{name}": TYPED_UNITS[name] for name in ("stiffness", "damping")}
_PER_LENGTH = re.compile(r"(.+/)(m|mm)")
_OF_LAW = re.compile(r"[kM]?Ns?/m?m\^[0-9.]+")  # of a contact law that is not linear


def sizes(quantity: str, one: float, power: float = 0.0) -> dict[str, float]:
    """The factor of each unit of a quantity to the unit that is ``one`` SI unit.

    ``power``: of K and D of a contact law that is not linear, the power of length by which they are divided beyond a
    stiffness and a damper: 0.5 of a Hertz spring, in N/m^1.5.
    """
    units = TYPED_UNITS[quantity]
    if power:
        found = [(match, size) for unit, size in units.items() if (match := _PER_LENGTH.fullmatch(unit))]
        units = {
            f"{match[1]}{match[2]}^{1.0 + power:.6g}": size * TYPED_UNITS["displacement"][match[2]] ** -power
            for match, size in found
        }
    return {unit: size / one for unit, size in units.items()}


def scaled(number: float, size: float) -> float:
    """A typed number in another unit, without the digits that rounding adds: 0.3 of 1e-3 is 0.0003."""
    return number if size == 1 else float(f"{number * size:.15g}")


def seconds_of(unit: str) -> float | None:
    """A typed unit of time in seconds; None if it is none."""
    return TYPED_UNITS["time"].get(unit)


def is_unit(unit: str) -> bool:
    """Whether what is typed after a number is a unit of some quantity."""
    return bool(unit) and (any(unit in units for units in TYPED_UNITS.values()) or bool(_OF_LAW.fullmatch(unit)))


def list_units(units: Mapping[str, float]) -> str:
    """The units for a refusal."""
    return ", ".join(unit for unit in units if unit)


def steps_of_time(period: float, seconds: float) -> int:
    """The fewest steps in a period of at most a time each."""
    return math.ceil(period / seconds * (1 - 1e-9))
