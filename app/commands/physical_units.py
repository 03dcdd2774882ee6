"""``--units``: the results of a command in the units of an FE input file as well."""

import argparse
import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.app.explorer.method_words import force_text, has_peak_force
from vibroscope.engine import QUANTITIES, UNIT_SYSTEMS, Method, Response, Units, written

if TYPE_CHECKING:  # `vibroscope simulate` does without, and it imports the whole description of motions
    from vibroscope.engine import Motion


def add_units_option(command: argparse.ArgumentParser) -> None:
    """Add ``--units``, for :func:`wanted_units`."""
    command.add_argument(
        "--units",
        nargs="?",
        const="si",
        choices=(*UNIT_SYSTEMS, "none"),
        help="also in physical units: si (m, kg, s, N; the default, also without this option where the system file "
        "has units of its own) or mm-t-s (mm, t, s, N), counted in the system file's omega1, m1 and base amplitude "
        "(without one 1 1/s, 1 kg, 1.07 mm)",
    )


def wanted_units(options: argparse.Namespace) -> Units | None:
    """The units to print in; None with ``none``, and by default where the numbers of the system have no dimension."""
    own = options.file.units
    chosen = options.units or ("none" if own == Units() else "si")
    return None if chosen == "none" else replace(own, system=chosen)


def physical_part(units: Units | None, eta: float, method: Method, **more: object) -> dict:
    """The part "physical" of the JSON of a result: units, settings and ``more``; none without units."""
    if units is None:
        return {}
    return {"physical": {"units": unit_names(units, method), "settings": units.settings(eta, method), **more}}


def physical_run(units: Units, response: Response) -> dict:
    """The section, impacts and contacts of the kept periods of a run, as JSON, in those units."""
    impacts = units.impacts(response.impacts)
    return {
        "section": _section(units, response.section),
        "impacts": np.column_stack([impacts.time, impacts.closing_speed]),
        "impulses": impacts.impulse,
        "contacts": units.physical("time", response.contacts),
    }


def physical_motion(units: Units, motion: "Motion") -> dict:
    """A motion as JSON: section, closing speeds, peak force, impulse and energy per period; None if not known.

    Impacts have an impulse and no peak force: it is None, too, where there is no other contact.
    """
    quantities = {"peak_force": "force", "impulse": "impulse", "energy_lost": "energy", "energy_created": "energy"}
    if not has_peak_force(motion):
        del quantities["peak_force"]
    return {
        "peak_force": None,
        "section": _section(units, motion.section),
        "closing_speeds": units.physical("velocity", motion.closing_speeds),
        **{name: units.physical(quantity, getattr(motion, name)) for name, quantity in quantities.items()},
    }


def settings_text(units: Units, eta: float, method: Method) -> str:
    """The settings for an FE input file in one line."""
    names = {
        "stiffness": ("stiffness", "contact_stiffness"),
        "damping": ("damper", "contact_damping"),
        "time_step": ("time step", "time"),
        "period": ("period", "time"),
    }
    return _line(units.of_contact(method), names, units.settings(eta, method))


def motion_text(units: Units, eta: float, motion: "Motion", method: Method) -> str:
    """Force, impulse and energy of a motion in one line, as far as they are known."""
    force = force_text(units, eta, motion, method).replace("·", ".")
    names = {
        "impulse": ("impulse", "impulse"),
        "energy_lost": ("energy lost in a period", "energy"),
        "energy_created": ("energy created by the time step", "energy"),
    }
    if "impulse" in force:
        del names["impulse"]
    return ", ".join(text for text in (force, _line(units, names, physical_motion(units, motion))) if text)


def unit_names(units: Units, method: Method) -> dict[str, str]:
    """The unit of each quantity, for JSON; stiffness and damping are those of the contact of a method."""
    names = {quantity: units.of_contact(method).unit(quantity) for quantity in QUANTITIES}
    return names | {name: names.pop(f"contact_{name}") for name in ("stiffness", "damping")}


def _line(units: Units, names: dict[str, tuple[str, str]], values: dict) -> str:
    """Name, number and unit of each of the ``values`` that is known, which are in these units already."""
    return ", ".join(
        f"{text} {written(values[name])} {units.unit(quantity).replace('·', '.')}"
        for name, (text, quantity) in names.items()
        if values.get(name) is not None and math.isfinite(values[name])
    )


def _section(units: Units, section: np.ndarray) -> np.ndarray:
    scale = [units.factor(quantity) for quantity in ("displacement", "velocity") * 2]
    return section * scale if len(section) else section
