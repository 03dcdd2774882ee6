"""Entry in physical units: masses, springs, dampers, clearance and excitation as on a data sheet, converted once.

    [physical]
    mass1_kg = 25.0
    stiffness1_N_per_m = 98696.0        # or frequency1_Hz
    damping1_ratio = 0.07               # or damping1_Ns_per_m
    wall = true                         # or mass2_kg, stiffness2_N_per_m, damping2_ratio
    clearance_mm = 0.5
    base_acceleration_m_per_s2 = 1.0    # or base_acceleration_g, base_velocity_mm_per_s, base_amplitude_mm, force1_N, …
    frequency_Hz = 10.0                 # of the excitation

The unit is part of each name, so that no number can be meant in another one. ω₁ = √(k₁/m₁) gives the unit of time, m₁
that of mass. A body may be without a spring, k = 0; beside a wall the entry may then say nothing of it. Of a body 1
without one the unit of time ``time_s`` = 1/ω₁ may be given, or follows from the problem: ω₁ is 2π ``frequency_Hz``;
where that is not given, the natural frequency of body 2, if it has a spring; or else √(a/L) of the acceleration a that
the forces on body 1, or the base, give it, and of the length L that displacements are counted in, 1 mm where the entry
has none. What is given of the base is held where the frequency changes (:class:`.excitation.Excitation`). Lengths are
counted in base amplitudes where ``base_amplitude_mm`` is given, otherwise in ``length_mm``; where that is not given
either, in the amplitude that the base has at ``frequency_Hz``, or would have at ω₁; where it does not move, in the
largest static displacement F/k₁ of the forces on body 1, or else in the clearance.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from vibroscope.engine.arguments import flag, shown
from vibroscope.engine.excitation import AMPLITUDE_RANGE, HELD, PHASE_RANGE, Excitation
from vibroscope.engine.fields import Range
from vibroscope.engine.law_table import critical_damping
from vibroscope.engine.model import (
    CLEARANCE_RANGE,
    ETA_RANGE,
    FACTOR_RANGE,
    MASS_RATIO_RANGE,
    RATIO_RANGE,
    SECOND_STOP,
    System,
)
from vibroscope.engine.units import BASE_AMPLITUDE_RANGE, M1_RANGE, OMEGA1_RANGE, Units, written
from vibroscope.engine.wording import end_text

_LARGE = 1e15
_LENGTH_MM = 1.0  # that the unit of time is found with where an entry has no length


class PhysicalSystem(NamedTuple):
    """The result of reading a physical entry: the system, its units, η if it is given, and the forms of its numbers.

    ``forms``: of the numbers that may be given in several forms, the names of those that are not in the first.
    """

    system: System
    units: Units
    eta: float | None
    forms: tuple[str, ...] = ()


class PhysicalNumber(NamedTuple):
    """A number of an entry: what it means, its unit, what it may be beside any others, and what is taken without it.

    ``default``: a number, or in words what follows where none is taken.
    """

    meaning: str
    unit: str
    allowed: Range
    default: float | str = 0.0


WALL = "wall"  # the only entry that is no number
NEEDED = "must be given"
_ABOVE_ZERO, _FROM_ZERO, _ANY = Range(0, _LARGE, open_low=True), Range(0, _LARGE), Range(-_LARGE, _LARGE)
_BELOW_ONE, _PHASE, _LENGTH = Range(0, 1, open_high=True), Range(*PHASE_RANGE), Range(*BASE_AMPLITUDE_RANGE)
KEYS = {
    "mass1_kg": PhysicalNumber("mass of body 1", "kg", Range(*M1_RANGE), NEEDED),
    "mass2_kg": PhysicalNumber("mass of body 2", "kg", _ABOVE_ZERO, f"{NEEDED}, unless {WALL} = true"),
    "stiffness1_N_per_m": PhysicalNumber(
        "spring between body 1 and the base; 0: none", "N/m", _FROM_ZERO, f"{NEEDED}; 0 where {WALL} = true"
    ),
    "stiffness2_N_per_m": PhysicalNumber(
        "spring between body 2 and the base; 0: none", "N/m", _FROM_ZERO, f"{NEEDED}, unless {WALL} = true"
    ),
    "frequency1_Hz": PhysicalNumber(
        "natural frequency of body 1, in place of its spring", "Hz", _ABOVE_ZERO, "of the spring"
    ),
    "frequency2_Hz": PhysicalNumber(
        "natural frequency of body 2, in place of its spring", "Hz", _ABOVE_ZERO, "of the spring"
    ),
    "damping1_ratio": PhysicalNumber("damping ratio of body 1", "", _BELOW_ONE),
    "damping2_ratio": PhysicalNumber("damping ratio of body 2", "", _BELOW_ONE),
    "damping1_Ns_per_m": PhysicalNumber(
        "damper between body 1 and the base, in place of the ratio", "N·s/m", _FROM_ZERO, "of the ratio"
    ),
    "damping2_Ns_per_m": PhysicalNumber(
        "damper between body 2 and the base, in place of the ratio", "N·s/m", _FROM_ZERO, "of the ratio"
    ),
    "joint_damping_ratio": PhysicalNumber(
        "damping ratio of the joined bodies, if it was measured", "", _BELOW_ONE, "of both dampers"
    ),
    "restitution": PhysicalNumber("coefficient of restitution", "", Range(0, 1), System.restitution),
    "clearance_mm": PhysicalNumber("gap at rest with relaxed springs; negative: preload", "mm", _ANY),
    "clearance2_mm": PhysicalNumber(
        "gap at rest of a second stop on the other side, with relaxed springs", "mm", _ANY, "no second stop"
    ),
    "restitution2": PhysicalNumber("restitution of the second stop", "", Range(0, 1), "of the first stop"),
    "stiffness_factor2": PhysicalNumber("K of the second stop over that of the first", "", Range(*FACTOR_RANGE), "1"),
    "damping_factor2": PhysicalNumber("D of the second stop over that of the first", "", Range(*FACTOR_RANGE), "1"),
    "base_amplitude_mm": PhysicalNumber("amplitude of the base's displacement, held over the frequency", "mm", _LENGTH),
    "base_velocity_mm_per_s": PhysicalNumber(
        "amplitude of the base's velocity, held over the frequency", "mm/s", _FROM_ZERO, "of the amplitude"
    ),
    "base_acceleration_m_per_s2": PhysicalNumber(
        "amplitude of the base's acceleration, held over the frequency",
        "m/s²",
        _FROM_ZERO,
        "of the amplitude",
    ),
    "base_acceleration_g": PhysicalNumber(
        "amplitude of the base's acceleration, in multiples of 9.80665 m/s²", "g", _FROM_ZERO, "of the amplitude"
    ),
    "base_phase_rad": PhysicalNumber("phase of the base's displacement", "rad", _PHASE),
    "force1_N": PhysicalNumber("amplitude of the force on body 1", "N", _ANY),
    "force1_phase_rad": PhysicalNumber("phase of the force on body 1", "rad", _PHASE),
    "force2_N": PhysicalNumber("amplitude of the force on body 2", "N", _ANY),
    "force2_phase_rad": PhysicalNumber("phase of the force on body 2", "rad", _PHASE),
    "constant1_N": PhysicalNumber("constant force on body 1; positive towards body 2", "N", _ANY),
    "constant2_N": PhysicalNumber("constant force on body 2; positive away from body 1", "N", _ANY),
    "frequency_Hz": PhysicalNumber("frequency of the excitation", "Hz", _ABOVE_ZERO, "the option --eta"),
    "length_mm": PhysicalNumber(
        "the length that displacements are counted in; not beside base_amplitude_mm",
        "mm",
        _LENGTH,
        "of the base, forces or clearance",
    ),
    "time_s": PhysicalNumber(
        "the time that is counted in, where body 1 has no spring",
        "s",
        Range(1 / OMEGA1_RANGE[1], 1 / OMEGA1_RANGE[0]),
        "of the excitation, or of forces and length",
    ),
}
_BODY_2 = ("mass2_kg", "stiffness2_N_per_m", "frequency2_Hz", "damping2_ratio", "damping2_Ns_per_m")
NOT_AT_A_WALL = (*_BODY_2, "joint_damping_ratio", "force2_N", "force2_phase_rad", "constant2_N")
EITHER = (  # the same number in several forms, of which an entry gives one
    ("stiffness1_N_per_m", "frequency1_Hz"),
    ("stiffness2_N_per_m", "frequency2_Hz"),
    ("damping1_ratio", "damping1_Ns_per_m"),
    ("damping2_ratio", "damping2_Ns_per_m"),
    ("base_amplitude_mm", "base_velocity_mm_per_s", "base_acceleration_m_per_s2", "base_acceleration_g"),
)
_OF_BASE, _SPRINGS = EITHER[-1], EITHER[:2]
G = 9.80665  # m/s²
# Of each form of the base's amplitude: what is held, and the unit in SI units.
OF_BASE = dict(zip(_OF_BASE, [(HELD[0], 1e-3), (HELD[1], 1e-3), (HELD[2], 1.0), (HELD[2], G)], strict=True))
_BY_DAMPER = ("damping1_ratio", "damping2_ratio")
_SWINGS = "so that the body can swing"


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

    Examples
    --------
    >>> from vibroscope.engine import system_of_physical
    >>> sheet = {"mass1_kg": 25.0, "stiffness1_N_per_m": 98696.0, "wall": True, "clearance_mm": 0.5}
    >>> system, units, eta, _ = system_of_physical(sheet | {"base_acceleration_m_per_s2": 1.0, "frequency_Hz": 10.0})
    >>> print(f"{eta:.3f} {system.clearance:.3f} {units.model('stiffness', 5.76e7):.0f}")
    1.000 1.974 584
    """
    wall = flag(WALL, entry.get(WALL, False))
    given = {name: value for name, value in entry.items() if name != WALL}
    given = _with_masses(given)
    _check_form(given, wall)
    given = {name: value for name, value in given.items() if value != 0 or name not in _OF_BASE}  # 0: it stands still
    for name, value in given.items():
        given[name] = _checked(name, value, KEYS[name].allowed)
    m1 = given["mass1_kg"]
    is_free = not (given.get("stiffness1_N_per_m") or "frequency1_Hz" in given)
    if is_free:
        omega1 = _unit_of_time(given, m1)
        k1 = m1 * omega1**2
        beside = f"beside a unit of time of {1 / omega1:.6g} s"
    else:
        if "time_s" in given:
            raise ValueError("gives time_s beside a spring: time is counted in sqrt(m1/k1), leave it out")
        k1 = _stiffness(given, 1, m1, OMEGA1_RANGE, f"beside mass1_kg = {m1:g}")
        omega1 = math.sqrt(k1 / m1)
        beside = f"beside body 1 at {omega1 / (2 * math.pi):.6g} Hz"
    eta = _eta(given, omega1, beside)
    form, base = _base(given)
    held = OF_BASE[form][0]
    length = _length(given, k1, omega1)
    units = Units(omega1, m1, 1e3 * length)
    own = {"d1": _damping_ratio(given, 1, m1, k1, beside if is_free else _SWINGS), "wall": wall}
    own["restitution"] = _number(given, "restitution")
    if is_free:
        own["spring1"] = 0.0
    if not wall:
        m2 = _checked("mass2_kg", given["mass2_kg"], _scaled(MASS_RATIO_RANGE, m1), f"beside mass1_kg = {m1:g}")
        own |= {"kappa": 0.0, "mu": m2 / m1}
        k2, why = m2 * omega1**2, f"beside a unit of time of {1 / omega1:.6g} s"
        if given.get("stiffness2_N_per_m") != 0:
            k2, why = _stiffness(given, 2, m2, tuple(end * omega1 for end in RATIO_RANGE), beside), _SWINGS
            own["kappa"] = math.sqrt(k2 / m2) / omega1
        own["d2"] = _damping_ratio(given, 2, m2, k2, why)
        own["d3"] = given.get("joint_damping_ratio")
    in_lengths = f"where lengths are counted in {1e3 * length:.6g} mm"
    force = 1.0 / (k1 * length)
    drive = {name: force * _number(given, f"{name}_N") for name in ("force1", "force2", "constant1", "constant2")}
    for name in drive:
        _check_given(given, f"{name}_N", _scaled(AMPLITUDE_RANGE, k1 * length), in_lengths)
    for name in ("clearance_mm", "clearance2_mm"):
        _check_given(given, name, _scaled(CLEARANCE_RANGE, 1e3 * length), in_lengths)
    if "clearance2_mm" in given:
        own["clearance2"] = 1e-3 * given["clearance2_mm"] / length
    own |= {name: given[name] for name in SECOND_STOP if name in given}
    phases = {name: _number(given, f"{name}_rad") for name in ("base_phase", "force1_phase", "force2_phase")}
    unit = length * omega1 ** HELD.index(held)
    _check_given(given, form, _scaled((0.0, AMPLITUDE_RANGE[1]), unit / OF_BASE[form][1]), in_lengths)
    excitation = Excitation(base=base / unit, **phases, **drive, held=held)
    clearance = 1e-3 * _number(given, "clearance_mm") / length
    return PhysicalSystem(System(**own, clearance=clearance, excitation=excitation), units, eta, _forms(given))


def _forms(given: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the numbers that are not in their first form; what is held of the base belongs to the excitation."""
    held_by_name = _OF_BASE[:-1]
    return tuple(name for forms in EITHER for name in forms[1:] if name in given and name not in held_by_name)


def physical_entry(
    system: System, units: Units, eta: float | None = None, forms: Sequence[str] = ()
) -> dict[str, float | bool]:
    """The physical entry that describes a system, without the numbers that are zero by default.

    ``forms``: names of numbers that are to be in this form instead of the first; see :class:`PhysicalSystem`.
    """
    m1, omega1, length = units.m1, units.omega1, 1e-3 * units.base_amplitude
    k1, drive = m1 * omega1**2, system.excitation
    entry: dict[str, float | bool] = {"mass1_kg": m1, "stiffness1_N_per_m": system.spring1 * k1}
    if system.spring1:
        entry["damping1_ratio"] = system.d1 / math.sqrt(system.spring1)
    else:
        forms = [name for name in forms if name not in ("frequency1_Hz", "damping1_Ns_per_m")]
        entry |= {"damping1_Ns_per_m": 2 * system.d1 * m1 * omega1, "time_s": 1 / omega1}
    if system.wall:
        entry[WALL] = True
    else:
        m2 = m1 * system.mass_ratio
        entry |= {"mass2_kg": m2, "stiffness2_N_per_m": m2 * (system.kappa * omega1) ** 2}
        if system.kappa:
            entry["damping2_ratio"] = system.d2
        else:
            forms = [name for name in forms if name not in ("frequency2_Hz", "damping2_Ns_per_m")]
            entry["damping2_Ns_per_m"] = 2 * system.d2 * m2 * omega1
        if system.d3 is not None:
            entry["joint_damping_ratio"] = system.d3
    entry |= {"restitution": system.restitution, "clearance_mm": system.clearance * units.base_amplitude}
    if system.two_stops:
        entry["clearance2_mm"] = system.clearance2 * units.base_amplitude
        usual = {"restitution2": None, "stiffness_factor2": 1.0, "damping_factor2": 1.0}
        entry |= {name: getattr(system, name) for name in SECOND_STOP if getattr(system, name) != usual[name]}
    if drive.base:
        form = _form_of_base(drive, forms)
        entry[form] = abs(drive.base) * length * omega1**drive.power / OF_BASE[form][1]
        entry["base_phase_rad"] = drive.base_phase + (math.pi if drive.base < 0 else 0.0)
    if not drive.base or drive.power:
        entry["length_mm"] = units.base_amplitude
    for name in ("force1", "force2", "constant1", "constant2"):
        entry[f"{name}_N"] = getattr(drive, name) * k1 * length
    for name in ("force1_phase", "force2_phase"):
        entry[f"{name}_rad"] = getattr(drive, name)
    if eta is not None:
        entry["frequency_Hz"] = eta * omega1 / (2 * math.pi)
    needed = ("mass1_kg", "stiffness1_N_per_m", "stiffness2_N_per_m", "damping1_ratio", "damping2_ratio")
    needed += ("restitution", "clearance_mm", "clearance2_mm", "restitution2")
    return {
        _in_form(name, forms): _converted(name, entry, forms)
        for name, value in entry.items()
        if value or name in needed
    }


def held_text(excitation: Excitation, units: Units | None = None, forms: Sequence[str] = ()) -> str:
    """What of the base keeps its amplitude where the frequency changes, as "base acceleration 4 m/s²".

    Empty if the base does not move; without ``units`` without the number; ``forms`` as in :func:`physical_entry`.
    """
    if not excitation.base:
        return ""
    words = f"base {excitation.held}"
    if units is None:
        return words
    form = _form_of_base(excitation, forms)
    size = replace(units, system="si").physical(excitation.held, abs(excitation.base)) / OF_BASE[form][1]
    return f"{words} {written(size)} {KEYS[form].unit}"


def _form_of_base(excitation: Excitation, forms: Sequence[str]) -> str:
    """The name of the number of the base in an entry."""
    if excitation.held == HELD[2] and _OF_BASE[-1] in forms:
        return _OF_BASE[-1]
    return next(name for name, (held, _) in OF_BASE.items() if held == excitation.held)


def _in_form(name: str, forms: Sequence[str]) -> str:
    """The name of a number in the form that is asked for."""
    other = next((pair[1] for pair in EITHER[:-1] if pair[0] == name), name)
    return other if other in forms else name


def _converted(name: str, entry: Mapping[str, float | bool], forms: Sequence[str]) -> float | bool:
    """A number of an entry in the form that is asked for."""
    value = entry[name]
    if _in_form(name, forms) == name:
        return value
    body = next(letter for letter in name if letter.isdigit())
    mass, stiffness = entry[f"mass{body}_kg"], entry[f"stiffness{body}_N_per_m"]
    if name in _BY_DAMPER:
        return 2 * value * critical_damping(stiffness, mass)
    return math.sqrt(stiffness / mass) / (2 * math.pi)


def _with_masses(given: dict) -> dict:
    """The numbers with each mass that follows from the spring and the natural frequency, m = k/ω²."""
    found = dict(given)
    for body in (1, 2):
        mass, (spring, frequency) = f"mass{body}_kg", _SPRINGS[body - 1]
        if spring in given and frequency in given:
            if mass in given:
                raise ValueError(
                    f"gives {mass}, {spring} and {frequency}: one follows from the two others, leave one out"
                )
            stiffness, hertz = (_checked(name, given[name], KEYS[name].allowed) for name in (spring, frequency))
            found[mass] = stiffness / (2 * math.pi * hertz) ** 2
            del found[frequency]
    return found


def _check_form(given: dict, wall: bool) -> None:
    """Check that all needed numbers are there, none that does not apply, and none in two forms."""
    for forms in EITHER:
        several = [name for name in forms if name in given]
        if len(several) > 1:
            both = " and ".join(several[:2])
            raise ValueError(f"gives both {both}: one follows from the other, leave one out")
    if wall:
        refuse_body_2(NOT_AT_A_WALL, given)
    elif "mass2_kg" not in given:
        raise ValueError("gives neither mass2_kg nor wall = true: say what body 1 may touch")
    needed = ["mass1_kg", *([] if wall else _SPRINGS)]
    for names in needed:
        names = (names,) if isinstance(names, str) else names
        if not any(name in given for name in names):
            none = ", 0 where the body has no spring" if len(names) > 1 else ""
            raise ValueError(f"{' or '.join(names)} is missing: a physical entry needs it{none}")
    if "length_mm" in given and given.get("base_amplitude_mm"):
        raise ValueError("gives length_mm although the base moves: lengths are counted in its amplitude, leave it out")


def refuse_body_2(names: Iterable[str], given: Mapping) -> None:
    """Raise a ValueError if any of the names of body 2 is given beside a wall."""
    idle = [name for name in names if name in given]
    if idle:
        raise ValueError(f"gives wall = true and {', '.join(idle)}: a wall has no such number, leave one out")


def _checked(name: str, value: float, allowed: Range, beside: str = "") -> float:
    """``value`` as float; raises ValueError that names the entry, its unit, and what it may be ``beside`` others."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not allowed.holds(number):
        words = f"{name} must be {allowed.words(KEYS[name].unit)}{beside and f' {beside}'}"
        raise ValueError(f"{words}; {end_text(number) if math.isfinite(number) else shown(value)} was given")
    return number


def _number(given: dict, name: str) -> float:
    return given.get(name, KEYS[name].default)


def _check_given(given: dict, name: str, allowed: Range, beside: str) -> None:
    if name in given:
        _checked(name, given[name], allowed, beside)


def _scaled(ends: tuple[float, float], unit: float) -> Range:
    return Range(ends[0] * unit, ends[1] * unit)


def _unit_of_time(given: dict, mass: float) -> float:
    """ω₁ in 1/s where body 1 has no spring: of the excitation, or √(a/L)."""
    if "time_s" in given:
        return 1 / given["time_s"]
    if "frequency_Hz" in given:
        return 2 * math.pi * _checked("frequency_Hz", given["frequency_Hz"], _scaled(OMEGA1_RANGE, 0.5 / math.pi))
    mass2 = given.get("mass2_kg", 0.0)
    omega2 = 2 * math.pi * given.get("frequency2_Hz", 0.0) or (
        math.sqrt(given.get("stiffness2_N_per_m", 0.0) / mass2) if mass2 else 0.0
    )
    if Range(*OMEGA1_RANGE).holds(omega2):
        return omega2
    form, base = _base(given)
    force = max(abs(given.get(name, 0.0)) for name in ("force1_N", "constant1_N"))
    acceleration = force / mass or (base if HELD.index(OF_BASE[form][0]) == 2 else 0.0)
    lengths = (given.get(name, 0.0) for name in ("length_mm", "base_amplitude_mm", "clearance_mm"))
    length = 1e-3 * next((abs(each) for each in lengths if each), _LENGTH_MM)
    omega1 = math.sqrt(acceleration / length)
    if not Range(*OMEGA1_RANGE).holds(omega1):
        raise ValueError(
            "time_s is missing: time of a body without a spring is counted in it, in 1/frequency_Hz or in the root of "
            f"a length over an acceleration; here that gives {f'{1 / omega1:.3g} s' if omega1 else 'nothing'}"
        )
    return omega1


def _stiffness(given: dict, body: int, mass: float, ends: tuple[float, float], beside: str) -> float:
    """kᵢ in N/m of a body whose ωᵢ lies between these ends in 1/s, given by its spring or its frequency."""
    spring, frequency = f"stiffness{body}_N_per_m", f"frequency{body}_Hz"
    if frequency in given:
        return mass * (2 * math.pi * _checked(frequency, given[frequency], _scaled(ends, 0.5 / math.pi), beside)) ** 2
    return _checked(spring, given[spring], Range(*(mass * end**2 for end in ends)), beside)


def _eta(given: dict, omega1: float, beside: str) -> float | None:
    if "frequency_Hz" not in given:
        return None
    _checked("frequency_Hz", given["frequency_Hz"], _scaled(ETA_RANGE, omega1 / (2 * math.pi)), beside)
    return 2 * math.pi * given["frequency_Hz"] / omega1


def _damping_ratio(given: dict, body: int, mass: float, stiffness: float, why: str) -> float:
    """dᵢ; of a body without a spring ``stiffness`` is m ω₁²."""
    if given.get(f"damping{body}_ratio") and why != _SWINGS:
        raise ValueError(
            f"gives damping{body}_ratio of a body without a spring: give stiffness{body}_N_per_m or "
            f"frequency{body}_Hz, or its damper, damping{body}_Ns_per_m"
        )
    name, critical = f"damping{body}_Ns_per_m", 2 * critical_damping(stiffness, mass)
    if name not in given:
        return _number(given, f"damping{body}_ratio")
    return _checked(name, given[name], Range(0, critical, open_high=True), why) / critical


def _base(given: dict) -> tuple[str, float]:
    """The form in which the base's motion is given, and its amplitude in SI units; 0 if it does not move."""
    form = next((name for name in _OF_BASE if name in given), _OF_BASE[0])
    return form, OF_BASE[form][1] * _number(given, form)


def _length(given: dict, k1: float, omega1: float) -> float:
    """The length that displacements are counted in, in m."""
    form, base = _base(given)
    power = HELD.index(OF_BASE[form][0])
    if "length_mm" in given:
        return 1e-3 * given["length_mm"]
    if base > 0:
        at = f"at frequency_Hz = {given['frequency_Hz']:g}" if "frequency_Hz" in given else "at the frequency of body 1"
        omega = 2 * math.pi * given["frequency_Hz"] if "frequency_Hz" in given else omega1
        allowed = _scaled(BASE_AMPLITUDE_RANGE, 1e-3 * omega**power / OF_BASE[form][1])
        _checked(form, given[form], allowed, at if power else "")
        return base / omega**power
    forces = [abs(given.get(name, 0.0)) for name in ("force1_N", "constant1_N", "force2_N", "constant2_N")]
    length = max(forces) / k1 or 1e-3 * abs(given.get("clearance_mm", 0.0))
    if length == 0:
        raise ValueError("nothing moves the bodies and there is no clearance to count lengths in: give length_mm")
    if not _LENGTH.holds(1e3 * length):
        raise ValueError(
            f"length_mm is missing: forces and clearance would count lengths in {1e3 * length:.3g} mm; give it, "
            f"{_LENGTH.words('mm')}"
        )
    return length
