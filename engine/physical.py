"""Entry in physical units: masses, springs, dampers, clearance and excitation as on a data sheet, converted once.

    [physical]
    mass1_kg = 25.0
    stiffness1_N_per_m = 98696.0        # or frequency1_Hz
    damping1_ratio = 0.07               # or damping1_Ns_per_m
    wall = true                         # or mass2_kg, stiffness2_N_per_m, damping2_ratio
    clearance_mm = 0.5
    base_acceleration_m_per_s2 = 1.0    # or base_amplitude_mm, force1_N, …
    frequency_Hz = 10.0                 # of the excitation

The unit is part of each name, so that no number can be meant in another one. ω₁ = √(k₁/m₁) gives the unit of time, m₁
that of mass. Lengths are counted in base amplitudes where the base moves, otherwise in ``length_mm``; where that is not
given either, in the largest static displacement F/k₁ of the forces on body 1, or else in the clearance.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

from .model import Excitation, System, check_eta, flag, require
from .units import BASE_AMPLITUDE_RANGE, M1_RANGE, OMEGA1_RANGE, Units

_LEAST, _LARGE = 1e-30, 1e15  # what follows from such numbers is neither 0 nor infinite
_GIVE = "give a number in the unit that its name ends with"


class PhysicalSystem(NamedTuple):
    """What a physical entry describes: the system, the units that its numbers are counted in, and η if it is given."""

    system: System
    units: Units
    eta: float | None


class _Range(NamedTuple):
    low: float
    high: float


_ABOVE_ZERO, _FROM_ZERO, _ANY = _Range(_LEAST, _LARGE), _Range(0, _LARGE), _Range(-_LARGE, _LARGE)
# by name: what it means, and what is allowed
KEYS = {
    "mass1_kg": ("mass of body 1", _ABOVE_ZERO),
    "mass2_kg": ("mass of body 2", _ABOVE_ZERO),
    "stiffness1_N_per_m": ("spring between body 1 and the base", _ABOVE_ZERO),
    "stiffness2_N_per_m": ("spring between body 2 and the base", _ABOVE_ZERO),
    "frequency1_Hz": ("natural frequency of body 1, in place of its spring", _ABOVE_ZERO),
    "frequency2_Hz": ("natural frequency of body 2, in place of its spring", _ABOVE_ZERO),
    "damping1_ratio": ("damping ratio of body 1", _FROM_ZERO),
    "damping2_ratio": ("damping ratio of body 2", _FROM_ZERO),
    "damping1_Ns_per_m": ("damper between body 1 and the base, in place of the ratio", _FROM_ZERO),
    "damping2_Ns_per_m": ("damper between body 2 and the base, in place of the ratio", _FROM_ZERO),
    "joint_damping_ratio": ("damping ratio of the joined bodies, if it was measured", _FROM_ZERO),
    "restitution": ("coefficient of restitution", _Range(0, 1)),
    "clearance_mm": ("gap at rest with relaxed springs; negative: preload", _ANY),
    "base_amplitude_mm": ("amplitude of the base", _ABOVE_ZERO),
    "base_acceleration_m_per_s2": ("amplitude of the base's acceleration, in place of the former", _ABOVE_ZERO),
    "base_phase_rad": ("phase of the base's displacement", _ANY),
    "force1_N": ("amplitude of the force on body 1", _ANY),
    "force1_phase_rad": ("its phase", _ANY),
    "force2_N": ("amplitude of the force on body 2", _ANY),
    "force2_phase_rad": ("its phase", _ANY),
    "constant1_N": ("constant force on body 1; positive towards body 2", _ANY),
    "constant2_N": ("constant force on body 2; positive away from body 1", _ANY),
    "frequency_Hz": ("frequency of the excitation", _ABOVE_ZERO),
    "length_mm": ("the length that displacements are counted in; not where the base moves", _ABOVE_ZERO),
}
WALL = "wall"  # the only entry that is no number
_BODY_2 = ("mass2_kg", "stiffness2_N_per_m", "frequency2_Hz", "damping2_ratio", "damping2_Ns_per_m")
_NOT_AT_A_WALL = (*_BODY_2, "joint_damping_ratio", "force2_N", "force2_phase_rad", "constant2_N")
EITHER = (  # the same number in two forms, of which an entry gives one
    ("stiffness1_N_per_m", "frequency1_Hz"),
    ("stiffness2_N_per_m", "frequency2_Hz"),
    ("damping1_ratio", "damping1_Ns_per_m"),
    ("damping2_ratio", "damping2_Ns_per_m"),
    ("base_amplitude_mm", "base_acceleration_m_per_s2"),
)


def system_of_physical(entry: Mapping[str, float | bool]) -> PhysicalSystem:
    """Convert an entry in physical units.

    Parameters
    ----------
    entry : mapping
        Numbers by the names in `KEYS`, and ``wall``, a flag.

    Raises
    ------
    ValueError
        If a number is missing, out of range, given twice in different forms, or has no place beside the others.
    """
    wall = flag(WALL, entry.get(WALL, False))
    given = {name: value for name, value in entry.items() if name != WALL}
    _check_form(given, wall)
    for name, value in given.items():
        allowed = KEYS[name][1]
        given[name] = require(name, value, allowed.low, allowed.high, _GIVE)
    m1 = given["mass1_kg"]
    k1 = _stiffness(given, 1, m1)
    frequency = given.get("frequency_Hz")
    base = _base_amplitude(given, frequency)
    length = _length(given, k1, base)
    units = _units(m1, k1, length)
    omega1 = units.omega1
    eta = None if frequency is None else check_eta(2 * math.pi * frequency / omega1)
    force = 1.0 / (k1 * length)
    own = {"d1": _damping_ratio(given, 1, m1, k1), "wall": wall}
    if not wall:
        m2 = given["mass2_kg"]
        k2 = _stiffness(given, 2, m2)
        own |= {"kappa": math.sqrt(k2 / m2) / omega1, "mu": m2 / m1, "d2": _damping_ratio(given, 2, m2, k2)}
        own["d3"] = given.get("joint_damping_ratio")
    if "restitution" in given:
        own["restitution"] = given["restitution"]
    drive = {name: force * given.get(f"{name}_N", 0.0) for name in ("force1", "force2", "constant1", "constant2")}
    phases = {name: given.get(f"{name}_rad", 0.0) for name in ("base_phase", "force1_phase", "force2_phase")}
    excitation = Excitation(base=1.0 if base > 0 else 0.0, **phases, **drive)
    clearance = 1e-3 * given.get("clearance_mm", 0.0) / length
    return PhysicalSystem(System(**own, clearance=clearance, excitation=excitation), units, eta)


def physical_entry(system: System, units: Units, eta: float | None = None) -> dict[str, float | bool]:
    """The same in the other direction: the entry that describes a system; only what is not zero by default."""
    m1, omega1, length = units.m1, units.omega1, 1e-3 * units.base_amplitude
    k1, drive = m1 * omega1**2, system.excitation
    entry: dict[str, float | bool] = {"mass1_kg": m1, "stiffness1_N_per_m": k1, "damping1_ratio": system.d1}
    if system.wall:
        entry[WALL] = True
    else:
        m2 = m1 * system.mass_ratio
        entry |= {"mass2_kg": m2, "stiffness2_N_per_m": m2 * (system.kappa * omega1) ** 2}
        entry["damping2_ratio"] = system.d2
        if system.d3 is not None:
            entry["joint_damping_ratio"] = system.d3
    entry |= {"restitution": system.restitution, "clearance_mm": system.clearance * units.base_amplitude}
    if drive.base:
        entry["base_amplitude_mm"] = abs(drive.base) * units.base_amplitude
        entry["base_phase_rad"] = drive.base_phase + (math.pi if drive.base < 0 else 0.0)
    else:
        entry["length_mm"] = units.base_amplitude
    for name in ("force1", "force2", "constant1", "constant2"):
        entry[f"{name}_N"] = getattr(drive, name) * k1 * length
    for name in ("force1_phase", "force2_phase"):
        entry[f"{name}_rad"] = getattr(drive, name)
    if eta is not None:
        entry["frequency_Hz"] = eta * omega1 / (2 * math.pi)
    needed = ("mass1_kg", "stiffness1_N_per_m", "damping1_ratio", "damping2_ratio", "restitution", "clearance_mm")
    return {name: value for name, value in entry.items() if value or name in needed}


def _check_form(given: dict, wall: bool) -> None:
    """What must be there, what must not, and what may be given in one form only."""
    for one, other in EITHER:
        if one in given and other in given:
            raise ValueError(f"gives both {one} and {other}: one follows from the other, leave one out")
    if wall:
        idle = [name for name in _NOT_AT_A_WALL if name in given]
        if idle:
            raise ValueError(f"gives wall = true and {', '.join(idle)}: a wall has no such number, leave one out")
    elif "mass2_kg" not in given:
        raise ValueError("gives neither mass2_kg nor wall = true: say what body 1 may touch")
    needed = ["mass1_kg", ("stiffness1_N_per_m", "frequency1_Hz")]
    needed += [] if wall else [("stiffness2_N_per_m", "frequency2_Hz")]
    for names in needed:
        names = (names,) if isinstance(names, str) else names
        if not any(name in given for name in names):
            raise ValueError(f"{' or '.join(names)} is missing: a physical entry needs it")
    if "length_mm" in given and any(name in given for name in EITHER[-1]):
        raise ValueError("gives length_mm although the base moves: lengths are counted in its amplitude, leave it out")


def _stiffness(given: dict, body: int, mass: float) -> float:
    frequency = given.get(f"frequency{body}_Hz")
    return given[f"stiffness{body}_N_per_m"] if frequency is None else mass * (2 * math.pi * frequency) ** 2


def _damping_ratio(given: dict, body: int, mass: float, stiffness: float) -> float:
    damper = given.get(f"damping{body}_Ns_per_m")
    ratio = given.get(f"damping{body}_ratio", 0.0) if damper is None else damper / (2 * math.sqrt(stiffness * mass))
    if not ratio < 1:
        raise ValueError(f"body {body} has the damping ratio {ratio:.4g}, outside [0, 1): give a weaker damper")
    return ratio


def _units(m1: float, k1: float, length: float) -> Units:
    """What the numbers are counted in, with a length in m; refused in the words of the entry."""
    omega1, millimetres = math.sqrt(k1 / m1), 1e3 * length
    require("mass1_kg", m1, *M1_RANGE, "give a mass of body 1 within this range")
    require("sqrt(spring/mass) of body 1", omega1, *OMEGA1_RANGE, "give another mass, spring or frequency1_Hz")
    advice = "give a base, length_mm, force or clearance of another size"
    require("the length that is counted in, in mm,", millimetres, *BASE_AMPLITUDE_RANGE, advice)
    return Units(omega1, m1, millimetres)


def _base_amplitude(given: dict, frequency: float | None) -> float:
    """Amplitude of the base in m; 0 if it does not move."""
    acceleration = given.get("base_acceleration_m_per_s2")
    if acceleration is None:
        return 1e-3 * given.get("base_amplitude_mm", 0.0)
    if frequency is None:
        raise ValueError("base_acceleration_m_per_s2 needs frequency_Hz, from which the amplitude follows: give it")
    return acceleration / (2 * math.pi * frequency) ** 2


def _length(given: dict, k1: float, base: float) -> float:
    """The length that displacements are counted in, in m."""
    if base > 0:
        return base
    if "length_mm" in given:
        return 1e-3 * given["length_mm"]
    forces = [abs(given.get(name, 0.0)) for name in ("force1_N", "constant1_N", "force2_N", "constant2_N")]
    length = max(forces) / k1 or 1e-3 * abs(given.get("clearance_mm", 0.0))
    if length == 0:
        raise ValueError("nothing moves the bodies and there is no clearance to count lengths in: give length_mm")
    return length
