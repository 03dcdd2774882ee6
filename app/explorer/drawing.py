"""The drawing of the system, with bodies, clearance and base in one scale, and the same in words. No panel import."""

import math

from vibroscope.app.explorer.state import Setting
from vibroscope.engine import written

HEADS = {"pendulums": "The pendulums on their base", "two": "The bodies on their base", "wall": "The body and the wall"}


def drawing(setting: Setting) -> dict:
    """The system to scale, lengths without dimension.

    Returns
    -------
    dict
        ``kind``: one of the choices of `Explorer.bodies`. ``head``: a title. ``clearance``: gap with relaxed springs;
        ``clearance2``: that of the second stop, None if there is none.
        ``separate``: ξ₁ and ξ₂ of the static equilibrium without contact, or with it where there is no other.
        ``share``: how much of an overlap the first spring takes up. ``springs``: whether each body has one.
        ``mass``: m₂/m₁. ``base``, ``phase``: of the base motion base · cos(ητ + phase).
    """
    system = setting.system
    apart = system.separate_rest
    return {
        "kind": setting.bodies,
        "head": HEADS[setting.bodies],
        "clearance": system.clearance,
        "clearance2": system.clearance2,
        "separate": list(apart if math.isfinite(apart[0]) and not system.held_pull else system.rest[::2]),
        "share": system.stiffness_share,
        "springs": [system.spring1 > 0.0, system.wall or system.kappa > 0.0],
        "mass": 1.0 if system.wall else system.mass_ratio,
        "base": system.excitation.base_amplitude(setting.eta),
        "phase": system.excitation.base_phase,
    }


def drawing_in_words(setting: Setting) -> str:
    """The drawing in words, for screen readers."""
    system, clearance = setting.system, setting.clearance
    size = _length(abs(clearance), setting)
    apart = f"{size} apart" if clearance > 0 else f"pressed together by {size}" if clearance < 0 else "touching at rest"
    stop = "a second wall" if system.wall else "a second stop"
    second = f"; {stop} on the other side leaves {_length(system.play, setting)} of play" if system.two_stops else ""
    if system.wall:
        return f"A body {'on' if system.spring1 else 'without'} a spring and a wall, {apart}{second}."
    free = " and ".join(("the first", "the second")[i] for i, k in enumerate((system.spring1, system.kappa)) if not k)
    two = f"Two bodies, {free} without a spring" if free else "Two bodies on springs"
    what = "Two pendulums" if setting.bodies == "pendulums" else two
    return f"{what}, {apart}{second}; the second has {written(system.mass_ratio, 3)} times the mass of the first."


def _length(value: float, setting: Setting) -> str:
    if setting.scale is None:
        return (
            f"{written(value)} {'base amplitudes' if setting.base and setting.held == 'displacement' else 'lengths A'}"
        )
    return setting.scale.text("displacement", value)
