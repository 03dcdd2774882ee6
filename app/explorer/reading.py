"""From text to a setting: all texts are accepted, or none is.

Every value from outside (address, typed text, slider, uploaded file, forged message) arrives as text and passes through
`read_setting`. No panel import.
"""

import math
import re
from collections.abc import Mapping
from inspect import signature

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.parameters import FIELDS, range_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import LONGEST_NUMBER, print_number, quote
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import end_text, simulate
from vibroscope.engine.methods import STEPS_RANGE

_PERIODS = signature(simulate).parameters["periods"].default

# A number as a person writes one. Stricter than float(), which also accepts "nan", "inf", "1_000", the digits of other
# scripts, and text of any length.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?", re.ASCII)


def read_setting(texts: Mapping[str, object], base: Setting | None = None) -> Setting:
    """The setting ``base`` (the default one if None) with the values of ``texts``; raises `Refused` at the first fault.

    Names that are no parameter are ignored.
    """
    setting = read_setting_at_any_cost(texts, base)
    _check_cost(setting)
    return setting


def read_setting_at_any_cost(texts: Mapping[str, object], base: Setting | None = None) -> Setting:
    """Do as `read_setting`, even for a setting that this server would not run, so that all servers offer the same."""
    setting = (base or Setting())._replace(**read_values(texts))
    if "D" in texts and "damper" not in texts:  # what is given stays
        setting = setting._replace(damper="typed")
    if "K" in texts and "stiffness" not in texts:
        setting = setting._replace(stiffness="typed")
    if setting.bodies == "wall":  # it does not move
        setting = setting._replace(coordinate="xi1", start_xi2=0.0, start_v2=0.0)
    if any(setting.start_numbers):
        setting = setting._replace(zero_start="rest")
    setting = _with_one_status(setting, texts)
    _check_combination(setting)
    if setting.follows_step:
        setting = setting._replace(K=_stiffness_of_step(setting, texts))
    if setting.follows_system:
        setting = setting._replace(K=setting.stiffness_of_system)
    if setting.finds_damping:
        setting = setting._replace(D=_damping_of_restitution(setting, texts))
    _check_damper(setting, texts)
    given = (name for name in texts if name in ("start_xi1", "start_xi2"))
    _check_gap(setting, "start_xi1" if setting.bodies == "wall" else next(given, "start_xi2"))
    return setting


def _with_one_status(setting: Setting, given: Mapping[str, object]) -> Setting:
    """The setting with a contact status that goes with what was chosen last.

    Located steps have no other status, and an explicit integrator only that from the start. What is given stays; two
    statuses that are given and do not go together raise `Refused`.
    """
    if setting.located == "yes" and setting.status != "start":
        if {"located", "status"} <= given.keys():
            raise Refused("status", "status must be start where contact changes are located within the step, not end.")
        setting = setting._replace(**({"located": "no"} if "status" in given else {"status": "start"}))
    try:
        _ = setting.penalty
    except ValueError as error:
        free = {"located": "no", "status": "start"}
        setting = setting._replace(**{name: value for name, value in free.items() if name not in given})
        try:
            _ = setting.penalty
        except ValueError:
            raise Refused("status" if setting.located == "no" else "located", f"{error}.") from None
    return setting


def read_values(texts: Mapping[str, object]) -> dict[str, float | int | str]:
    """The value of each parameter in ``texts``, checked one by one; raises `Refused` at the first bad one."""
    return {name: _read_value(name, text) for name, text in texts.items() if name in FIELDS}


def _read_value(name: str, text: object) -> float | int | str:
    field = FIELDS[name]
    if field.choices:
        return read_choice(name, text, list(field.choices))
    return read_number(name, text, field.bounds, field.whole)


def _check_cost(setting: Setting) -> None:
    """Raise `Refused` where a run takes more time steps than the server allows (``VIBROSCOPE_STEPS``).

    Studies need no such check: their number of cells and their time limit are fixed.
    """
    asked, granted = setting.steps * _PERIODS, current_settings().steps
    if asked > granted:
        raise Refused(
            "steps",
            f"That is {setting.steps:,} steps × {_PERIODS:,} periods = {asked:,} steps, and this server does "
            f"{granted:,} for one request: take fewer steps, or run Vibroscope on your own machine.",
        )


def _check_combination(setting: Setting) -> None:
    """Raise `Refused` where values that are valid one by one give no system together."""
    try:
        _ = setting.system
    except ValueError as error:
        raise _refused_system(setting, error) from None


def _stiffness_of_step(setting: Setting, given: Mapping[str, object]) -> float:
    """K as it follows from the step; raises `Refused` for what was given last where that is out of range."""
    K = setting.stiffness_of_step
    low, high = FIELDS["K"].bounds
    if not low <= K <= high:
        name = next((name for name in ("steps", "eta", "step_scale") if name in given), "stiffness")
        raise Refused(name, f"K must be from {end_text(low)} to {end_text(high)}, not s m/Δτ² = {K:.3g}.")
    return K


def _damping_of_restitution(setting: Setting, given: Mapping[str, object]) -> float:
    """D as it follows from the restitution; raises `Refused` for what was given last where no D gives it."""
    try:
        return setting.damping_of_restitution
    except ValueError as error:
        raise Refused("restitution" if "restitution" in given else "damper", f"{error}.") from None


def _check_damper(setting: Setting, given: Mapping[str, object]) -> None:
    """Raise `Refused` for what was given last where the damper's formula has no value for the restitution."""
    try:
        _ = setting.damping
    except ValueError as error:
        raise Refused("restitution" if "restitution" in given else "damper", f"{error}.") from None


def _refused_system(setting: Setting, error: ValueError) -> Refused:
    name = str(error).partition(" ")[0]
    if setting.bodies != "pendulums" or name == "clearance":
        return Refused(name if name in FIELDS else "bodies", f"{error}.")
    return Refused(
        "kappa3",
        f"kappa3 must lie between 1 and kappa = {setting.kappa:g}, not {setting.kappa3:g}: the natural frequency "
        "of the joined pendulums lies between those of the separate ones, and the mass ratio follows from it.",
    )


def _check_gap(setting: Setting, name: str) -> None:
    """Raise `Refused` for the parameter ``name`` where the bodies would overlap at the start."""
    system = setting.system
    if setting.from_rest or not system.overlap_of(setting.initial):
        return
    symbol, number = "ξ", print_number
    if setting.scale is not None:
        symbol, number = "x", lambda value: setting.scale.text("displacement", value, 6)
    first, second, clearance = map(number, (setting.start_xi1, setting.start_xi2, setting.clearance))
    may = "the bodies may touch, but not overlap"
    apart = setting.start_xi1 - setting.start_xi2
    if setting.stops == "two" and apart < -setting.clearance2:
        difference = f"{symbol}₁(0)" if setting.bodies == "wall" else f"{symbol}₁(0) − {symbol}₂(0)"
        least = f"minus the clearance of the second stop, {number(-setting.clearance2)}"
        raise Refused(name, f"{difference} must be at least {least}, not {number(apart)}: at the start {may}.")
    if setting.bodies == "wall":
        raise Refused(
            name, f"{symbol}₁(0) must be at most the clearance, {clearance}, not {first}: at the start {may}."
        )
    most = f"{symbol}₂(0)" + (f" plus the clearance, {clearance}" if setting.clearance else "")
    raise Refused(
        name,
        f"{symbol}₁(0) must be at most {most}, not {first} with {second}: at the start {may}. "
        f"Set {symbol}{'₂' if name == 'start_xi1' else '₁'}(0) first.",
    )


def most_steps() -> int:
    """The largest number of steps per period that this server computes."""
    return min(STEPS_RANGE[1], current_settings().steps // _PERIODS)


def read_choice(name: str, text: object, choices: list[str]) -> str:
    """``text`` if it is one of the ``choices`` for ``name``; raises `Refused` otherwise."""
    if not isinstance(text, str) or text not in choices:
        raise Refused(name, f"{name} must be {' or '.join(choices)}, not {quote(text)}.")
    return text


def read_number(name: str, text: object, bounds: tuple[float, float], whole: bool) -> float | int:
    """The number that ``text`` gives for ``name``; raises `Refused` if it gives none within ``bounds``."""
    low, high = bounds
    kind = "a whole number" if whole else "a number"
    refusal = Refused(name, f"{name} must be {kind} from {range_text(bounds)}, not {quote(text)}.")
    if not isinstance(text, str) or len(text) > LONGEST_NUMBER or not _NUMBER.fullmatch(text.strip()):
        raise refusal
    value = float(text)
    if not (math.isfinite(value) and low <= value <= high) or (whole and value != int(value)):
        raise refusal
    return int(value) if whole else value
