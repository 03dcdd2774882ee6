"""The system in physical units, field by field: masses, springs, dampers, clearance, excitation. No panel import.

The setting holds the numbers of the model. A physical number that is typed changes the entry that describes the
setting's system (`engine.physical`), which is converted again; only what differs by that is set, so that all other
numbers keep their last digit.
"""

import math
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.field_units import ShownField, typed_units
from vibroscope.app.explorer.parameters import (
    DESCRIBED_BY,
    EXCITATION_FIELDS,
    FIELDS,
    FORM_FIELDS,
    SECOND_STOP_FIELDS,
    START_FIELDS,
)
from vibroscope.app.explorer.reading import read_number
from vibroscope.app.explorer.state import Setting, slider_range
from vibroscope.app.runtime.number_text import plain_unit, print_value
from vibroscope.engine import QUANTITIES, UNIT_SYSTEMS, System, Units
from vibroscope.engine.excitation import HELD
from vibroscope.engine.law_table import critical_damping
from vibroscope.engine.physical import EITHER, KEYS, NOT_AT_A_WALL, OF_BASE, physical_entry, system_of_physical

_NAMED = {  # by the name in `KEYS`: symbol, and the quantity whose units may be typed
    "mass1_kg": ("m₁", "mass"),
    "mass2_kg": ("m₂", "mass"),
    "stiffness1_N_per_m": ("k₁", "stiffness"),
    "stiffness2_N_per_m": ("k₂", "stiffness"),
    "frequency1_Hz": ("f₁", "frequency"),
    "frequency2_Hz": ("f₂", "frequency"),
    "damping1_ratio": ("d₁", "share"),
    "damping2_ratio": ("d₂", "share"),
    "damping1_Ns_per_m": ("c₁", "damping"),
    "damping2_Ns_per_m": ("c₂", "damping"),
    "joint_damping_ratio": ("d₃", "share"),
    "clearance_mm": ("g₀", "displacement"),
    "clearance2_mm": ("g₂", "displacement"),
    "base_amplitude_mm": ("A", "displacement"),
    "base_velocity_mm_per_s": ("AΩ", "velocity"),
    "base_acceleration_m_per_s2": ("AΩ²", "acceleration"),
    "base_acceleration_g": ("AΩ²", "acceleration"),
    "base_phase_rad": ("φ", "angle"),
    "force1_N": ("F₁", "force"),
    "force1_phase_rad": ("φ₁", "angle"),
    "force2_N": ("F₂", "force"),
    "force2_phase_rad": ("φ₂", "angle"),
    "constant1_N": ("P₁", "force"),
    "constant2_N": ("P₂", "force"),
    "length_mm": ("A", "displacement"),
}
PHYSICAL_FIELDS = tuple(_NAMED)
# What is chosen where a number of several forms is given in one of them: of a field, its choice.
FORMS: dict[str, dict[str, str]] = {
    "base_amplitude_mm": {"held": "displacement"},
    "base_velocity_mm_per_s": {"held": "velocity"},
    "base_acceleration_m_per_s2": {"held": "acceleration", "acceleration_form": "metres"},
    "base_acceleration_g": {"held": "acceleration", "acceleration_form": "g"},
}
for _field, _forms in zip(FORM_FIELDS[:-1], EITHER[:-1], strict=True):  # of springs and dampers
    FORMS |= {name: {_field: choice} for name, choice in zip(_forms, FIELDS[_field].choices, strict=True)}
_BASE = tuple(OF_BASE)
CONTACT_OF_SYSTEM = {"stiffness": "system", "damper": "restitution"}  # of a system that comes without K and D
_CARRIED = (*START_FIELDS, "K", "D")  # what keeps its physical value where the units change
_ROUNDING = 1e-12
_SAME = 1e-9  # relative: closer lengths are one, printed and read again
_NEAR = 2e-14  # relative: what some conversions of a number in turn add up to
FAR = 10.0  # times the unit of length, or as many times less: a base that moves so far does not go with it
# What numbers without dimension are counted in.
_DEFINING = ("mass1_kg", "stiffness1_N_per_m", "frequency1_Hz", "length_mm", *_BASE)
_OF_TONNES = ("mass", "stiffness", "damping")  # quantities whose unit is that of the unit system; lengths are in mm
_LEAST = 1e-12  # of what is more than 0


# ---- from a system to the setting ------------------------------------------------------------------------------------


def values_of_system(
    system: System, units: Units | None = None, eta: float | None = None, forms: Sequence[str] = ()
) -> dict[str, float | str]:
    """The values of the setting that describe a system, with the units that its numbers are counted in.

    ``forms``: see `engine.PhysicalSystem`.
    """
    kind = "wall" if system.wall else "pendulums" if system.mu is None else "two"
    values: dict[str, float | str] = {"bodies": kind, "stops": "two" if system.two_stops else "one"}
    values |= {name: getattr(system, name) for name in DESCRIBED_BY[kind] if getattr(system, name) is not None}
    if kind == "two":  # whose d3 need not be known
        values["joint_damping"] = "derived" if system.d3 is None else "table"
    if system.two_stops:
        values |= {name: getattr(system, name) for name in SECOND_STOP_FIELDS}
        values["restitution2"] = system.second_restitution
    values |= {name: getattr(system.excitation, name) for name in EXCITATION_FIELDS}
    if units is not None:
        values |= {"omega1": units.omega1, "m1": units.m1, "amplitude": units.base_amplitude}
        values |= {name: FIELDS[name].default for name in FORM_FIELDS}
    for name in (*forms, *_of_free_bodies(system)):
        values |= FORMS[name]
    return values if eta is None else values | {"eta": eta}


def _of_free_bodies(system: System) -> tuple[str, ...]:
    """The forms of the numbers of bodies without a spring."""
    springs = {1: system.spring1, 2: 1.0 if system.wall else system.kappa}
    names = "stiffness{}_N_per_m", "damping{}_Ns_per_m"
    return tuple(name.format(body) for body, spring in springs.items() if not spring for name in names)


# ---- how the fields are shown ----------------------------------------------------------------------------------------


def physical_field(name: str, units: str = "si") -> ShownField:
    """How the physical number ``name`` of `PHYSICAL_FIELDS` is shown in a unit system, and what may be typed for it."""
    (symbol, quantity), (meaning, unit, *_) = _NAMED[name], KEYS[name]
    typed, factor = typed_units(quantity, unit), 1.0
    if units == "mm-t-s" and quantity in _OF_TONNES:
        unit = QUANTITIES[quantity].units[list(UNIT_SYSTEMS).index(units)]
        factor = 1.0 / typed[plain_unit(unit)]
        typed |= {"": 1.0 / factor}
    return ShownField(symbol, meaning, unit, factor, typed)


def physical_bounds(name: str) -> tuple[float, float]:
    """Smallest and largest number that may be typed."""
    allowed = KEYS[name].allowed
    low = 0.0 if name in _BASE else _LEAST if allowed.open_low else allowed.low  # a base at rest has the amplitude 0
    return low, math.nextafter(allowed.high, 0.0) if allowed.open_high else allowed.high


def physical_numbers(setting: Setting) -> dict[str, float]:
    """Every number of `PHYSICAL_FIELDS` that applies to the system of the setting."""
    entry = physical_entry(setting.system, setting.own_units, setting.eta)
    without = NOT_AT_A_WALL if setting.bodies == "wall" else ()
    without += ("clearance2_mm",) if setting.stops == "one" else ()
    found = dict.fromkeys((name for name in PHYSICAL_FIELDS if name not in without), 0.0)
    found |= {name: value for name, value in entry.items() if name in found}
    for body in ("1", "2") if setting.bodies != "wall" else ("1",):
        mass, stiffness = entry[f"mass{body}_kg"], entry[f"stiffness{body}_N_per_m"]
        found[f"frequency{body}_Hz"] = math.sqrt(stiffness / mass) / (2 * math.pi)
        if stiffness:  # else the entry has the damper itself
            found[f"damping{body}_Ns_per_m"] = 2 * entry[f"damping{body}_ratio"] * critical_damping(stiffness, mass)
    omega, amplitude = 2 * math.pi * entry["frequency_Hz"], setting.system.excitation.base_amplitude(setting.eta)
    for name, (held, unit) in OF_BASE.items():
        found[name] = 1e-3 * abs(amplitude) * setting.amplitude * omega ** HELD.index(held) / unit
    shown = next(name for name in _BASE if is_shown(name, setting))
    given = physical_entry(setting.system, setting.own_units, setting.eta, (shown,)).get(shown, 0.0)
    found[shown] = given  # to its last digit
    if setting.bodies != "wall":
        found["joint_damping_ratio"] = setting.system.joint_damping(setting.joint_damping)
    if setting.base:
        del found["length_mm"]
    return found


def is_shown(name: str, setting: Setting) -> bool:
    """Whether a number that has several forms is shown in this one, which is that in which it was given."""
    return all(getattr(setting, field) == choice for field, choice in FORMS.get(name, {}).items())


def _entry(setting: Setting) -> dict[str, float | bool]:
    """The entry that describes the setting's system, each number in the form that is shown: so it stays."""
    forms = [name for name in FORMS if is_shown(name, setting)]
    return physical_entry(setting.system, setting.own_units, setting.eta, forms)


# ---- what a person enters --------------------------------------------------------------------------------------------


class _Converted(NamedTuple):
    values: dict[str, float | str]
    system: System
    units: Units


def entered(texts: Mapping[str, object], setting: Setting) -> dict[str, object]:
    """``texts`` for `app.explorer.reading.read_setting`, with what follows where a person changes the system.

    A physical number becomes those of the model; another kind of system takes over what the present one has.

    Raises
    ------
    Refused
        If the physical numbers give no system.
    """
    typed = {name: text for name, text in texts.items() if name in PHYSICAL_FIELDS}
    rest: dict[str, object] = {name: text for name, text in texts.items() if name not in typed}
    if typed:
        return _printed(_of_physical(typed, setting)) | rest
    if "eta" in rest and (follows := _unit_of_length_at(rest["eta"], setting)):
        return _printed(follows) | rest
    if rest.get("held") in HELD and "base" not in rest:  # the same motion, whatever is held of it
        change = HELD.index(rest["held"]) - HELD.index(setting.held)
        return {"base": print_value(float(f"{setting.base * setting.eta**change:.15g}"))} | rest
    if rest.get("stops") == "two" and setting.stops == "one":
        return _printed(_of_second_stop(setting)) | rest
    if isinstance(texts.get("bodies"), str) and texts["bodies"] != setting.bodies:
        return _printed(_of_other_bodies(texts["bodies"], setting)) | _new_contact(setting) | rest
    return rest


def _unit_of_length_at(eta: object, setting: Setting) -> dict[str, float | str]:
    """What follows where the base moves by far more or less than the unit of length at another frequency.

    The unit becomes the base's amplitude there, as if what is held of it had been typed after the frequency. Otherwise
    numbers that are no part of the system, as the separation speed ε, would be of a motion that is not shown.
    """
    if setting.scale is None or not setting.base or not isinstance(eta, str):
        return {}
    try:
        there = setting._replace(eta=read_number("eta", eta, FIELDS["eta"].bounds, whole=False))
    except Refused:
        return {}  # refused where it is read
    if 1 / FAR <= abs(there.system.excitation.base_amplitude(there.eta)) <= FAR:
        return {}
    held = next(name for name in _BASE if is_shown(name, there))
    try:
        return _of_physical({held: print_value(physical_numbers(there)[held])}, there)
    except Refused:
        return {}


def _new_contact(setting: Setting) -> dict[str, str]:
    """K and D of a system of one's own follow from it until they are typed: those of a scene are not meant for it."""
    return dict(CONTACT_OF_SYSTEM) if setting.bodies == "pendulums" else {}


def _printed(values: Mapping[str, float | str]) -> dict[str, str]:
    return {name: print_value(value) for name, value in values.items()}


def _of_second_stop(setting: Setting) -> dict[str, float]:
    """A second stop like the first one; where that has no clearance, so far off that there is one unit of play."""
    clearance = setting.clearance if setting.clearance > 0 else 1.0 - setting.clearance
    factors = {name: FIELDS[name].default for name in SECOND_STOP_FIELDS[2:]}
    return {"clearance2": clearance, "restitution2": setting.restitution} | factors


def _of_other_bodies(kind: str, setting: Setting) -> dict[str, float | str]:
    """The numbers that the other kind of system takes over, where both describe the same quantity."""
    system = setting.system
    if kind == "two":
        return {"joint_damping": "derived", "spring1": 1.0} | ({} if system.wall else {"mass_ratio": system.mass_ratio})
    if kind == "wall":
        return {}
    usual = Setting()
    low, high = sorted((1.0, setting.kappa))
    kappa3 = setting.kappa3 if system.wall else system.kappa3
    fits = low < kappa3 < high
    return {"joint_damping": "table"} | ({"kappa3": kappa3} if fits else {"kappa": usual.kappa, "kappa3": usual.kappa3})


def _of_physical(typed: Mapping[str, object], setting: Setting) -> dict[str, float | str]:
    """The typed numbers, and those that follow from them.

    What is seen and not typed stays. Where it would leave its range because what all is counted in has changed, it
    keeps its number without dimension instead.
    """
    name = next(iter(typed))
    numbers = {each: read_number(each, text, physical_bounds(each), whole=False) for each, text in typed.items()}
    before = _convert(_entry(setting), setting, name)
    try:
        after = _convert(_changed(_entry(setting), setting, numbers), setting, name)
    except Refused as refused:
        try:
            after = _convert(_in_another_way(numbers, setting, name), setting, name)
        except (Refused, ValueError):
            raise refused from None
    changed = {each: value for each, value in after.values.items() if value != before.values.get(each)}
    for each in typed:
        changed |= {field: form for field, form in FORMS.get(each, {}).items() if getattr(setting, field) != form}
    changed |= {field: form for name in _of_free_bodies(after.system) for field, form in FORMS[name].items()}
    return changed | (_carried(setting, before.units, after) if before.units != after.units else {})


def _changed(entry: dict[str, float | bool], setting: Setting, numbers: Mapping[str, float]) -> dict[str, float | bool]:
    """The entry with what was typed; a body that loses its spring keeps its damper and the unit of time.

    Where the base does not move, and no length was typed to count in, it is that of a file with the same numbers: so
    is the parting speed ε, which is counted in it.
    """
    usual = _length_of_file(entry) or FIELDS["amplitude"].default
    of_file = math.isclose(entry.get("length_mm", 0.0), usual, rel_tol=_SAME)
    for body in (1, 2):
        if numbers.get(f"stiffness{body}_N_per_m") == 0:
            damper = f"damping{body}_Ns_per_m"
            entry |= {damper: physical_numbers(setting)[damper]} | ({"time_s": 1 / setting.omega1} if body == 1 else {})
            entry.pop(f"damping{body}_ratio", None)
    if numbers.get("stiffness1_N_per_m") or "frequency1_Hz" in numbers:
        entry.pop("time_s", None)
    for name, value in numbers.items():
        for other in next((forms for forms in EITHER if name in forms), ()):
            entry.pop(other, None)
        entry[name] = value
        if name in _BASE and value == 0:
            del entry[name]
            entry.setdefault("length_mm", setting.amplitude)
            of_file = True
        elif name in _BASE:
            entry.pop("length_mm", None)
    if of_file and "length_mm" in entry and "length_mm" not in numbers:
        entry["length_mm"] = _length_of_file(entry) or entry["length_mm"]
    return entry


def _length_of_file(entry: Mapping[str, float | bool]) -> float:
    """The length in mm that a file with these numbers alone counts in; 0 if the base moves or there is none."""
    try:
        units = system_of_physical({name: value for name, value in entry.items() if name != "length_mm"}).units
    except ValueError:
        return 0.0
    return 0.0 if any(entry.get(name) for name in _BASE) else units.base_amplitude


def _in_another_way(numbers: Mapping[str, float], setting: Setting, name: str) -> dict[str, float | bool]:
    """The entry where other numbers follow what was typed, lest they leave their ranges.

    Of a mass m₂ the spring; of what numbers are counted in, all: the system is the same without dimension.

    Raises
    ------
    ValueError
        If there is no such entry.
    """
    if name == "mass2_kg":
        return _changed(_entry(setting._replace(spring2_form="frequency")), setting, numbers)
    if name not in _DEFINING or numbers.get("stiffness1_N_per_m") == 0:
        raise ValueError(name)
    given = _changed(_entry(setting), setting, numbers)
    mass, length = given["mass1_kg"], given.get("length_mm", setting.amplitude)
    form = next((each for each in _BASE if each in given), None)
    if form is not None and "length_mm" not in given:
        held, unit = OF_BASE[form]
        length = 1e3 * unit * given[form] / (setting.eta * setting.omega1) ** HELD.index(held)
    spring = given.get("stiffness1_N_per_m") or mass * (2 * math.pi * given["frequency1_Hz"]) ** 2
    return physical_entry(setting.system, Units(math.sqrt(spring / mass), mass, length), setting.eta)


def _convert(entry: Mapping[str, float | bool], setting: Setting, name: str) -> _Converted:
    try:
        system, units, eta, _ = system_of_physical(_with_frequency(entry, setting))
    except ValueError as error:
        raise Refused(name, f"{_in_symbols(str(error))}.") from None
    values = values_of_system(system, units, eta)
    for kept in ("bodies", "held", *FORM_FIELDS):  # what is typed says its form itself
        del values[kept]
    values.pop("joint_damping", None)  # typing a number does not change what d₃ is
    if setting.bodies == "pendulums":
        if system.has_free_body:
            raise Refused(name, "Pendulums have springs, or gravity in their place: choose two bodies.")
        if system.kappa == 1:
            raise Refused(name, "Equal frequencies leave the mass ratio open, which pendulums have from theirs: "
                          "choose two bodies, or other frequencies.")  # fmt: skip
        del values["mass_ratio"]
        values["kappa3"] = system.kappa3
    values = {name: value if isinstance(value, str) else _converted(value) for name, value in values.items()}
    return _Converted(values, system, units)


def _converted(value: float) -> float:
    """A number without the digits that conversions add: what is that near to a short one is meant to be it."""
    short = float(f"{value:.12g}")
    return short if abs(short - value) <= _NEAR * abs(value) else float(f"{value:.15g}")


def _in_symbols(text: str) -> str:
    """An error of `system_of_physical` with the symbols of the fields in place of the names of the entries."""
    return re.sub(r"\w+", lambda word: _NAMED.get(word[0], word)[0], text)


def _with_frequency(entry: Mapping[str, float | bool], setting: Setting) -> dict[str, float | bool]:
    """The entry with the frequency of the excitation; where its slider would not reach it, with that of the same η."""
    bare = {name: value for name, value in entry.items() if name not in ("frequency_Hz", *_BASE)}
    bare.setdefault("length_mm", setting.amplitude)
    system, units, *_ = system_of_physical(bare)
    eta = 2 * math.pi * entry["frequency_Hz"] / units.omega1
    if _is_covered("eta", eta, system) or not _is_covered("eta", setting.eta, setting.system):
        return dict(entry)
    return {**entry, "frequency_Hz": setting.eta * units.omega1 / (2 * math.pi)}


def _carried(setting: Setting, before: Units, after: _Converted) -> dict[str, float | str]:
    """The numbers that keep their physical value: the start, and K and D unless K would leave its slider."""
    found = {}
    for name in _CARRIED:
        earlier, later = (units.of_contact(setting.penalty) for units in (before, after.units))
        ratio = earlier.factor(FIELDS[name].quantity) / later.factor(FIELDS[name].quantity)
        if abs(ratio - 1) > _ROUNDING and getattr(setting, name):
            found[name] = float(f"{getattr(setting, name) * ratio:.12g}")
    if not _is_covered("K", found.get("K", setting.K), after.system):
        found.pop("K", None), found.pop("D", None)
    kept = {"K": "stiffness", "D": "damper"}  # which a number that is given would end
    return found | {choice: getattr(setting, choice) for name, choice in kept.items() if name in found}


def _is_covered(name: str, value: float, system: System) -> bool:
    low, high = slider_range(name, system)
    return low <= value <= high
