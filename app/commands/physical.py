"""``--units``: what a command prints, once more in the units of an FE input file."""

import argparse

from vibroscope.app.commands.options import units_of
from vibroscope.engine import Method, Motion, Response, Units


def add_units_option(command: argparse.ArgumentParser) -> None:
    """``--units``, for :func:`wanted_units`."""
    command.add_argument(
        "--units",
        action="store_true",
        help="also in physical units, those of the system file (default omega1 1 1/s, m1 1 kg, base 1.07 mm)",
    )


def wanted_units(options: argparse.Namespace) -> Units | None:
    """The units, if they are asked for."""
    return units_of(options) if options.units else None


def run_in(units: Units, response: Response) -> dict:
    """A run: settings, and the section, impacts and contacts of the kept periods in mm, mm/s, N·s and s."""
    impacts = units.impacts(response.impacts)
    return {
        "settings": units.settings(response.eta, response.method),
        "section": _section(units, response.section),
        "impacts": [list(row) for row in zip(impacts.time.tolist(), impacts.closing_speed.tolist(), strict=True)],
        "impulses": impacts.impulse.tolist(),
        "contacts": units.physical("time", response.contacts).tolist(),
    }


def motion_in(units: Units, found: Motion) -> dict:
    """A motion: section, closing speeds, peak force, and impulse and energy lost per period; None if not known."""
    known = {
        "peak_force": ("force", found.peak_force),
        "impulse": ("impulse", found.impulse),
        "energy_lost": ("energy", found.energy_lost),
    }
    return {
        "section": _section(units, found.section),
        "closing_speeds": units.physical("velocity", found.closing_speeds).tolist(),
        **{name: _known(units.physical(quantity, value)) for name, (quantity, value) in known.items()},
    }


def settings_text(units: Units, eta: float, method: Method) -> str:
    """One line for people: what goes into the FE input file."""
    numbers = units.settings(eta, method)
    said = {
        "stiffness": "stiffness {:.4g} N/m",
        "damping": "damper {:.4g} N.s/m",
        "time_step": "time step {:.4g} s",
        "period": "period {:.4g} s",
    }
    return ", ".join(text.format(numbers[name]) for name, text in said.items() if name in numbers)


def motion_text(units: Units, found: Motion) -> str:
    """One line for people: force, impulse and energy of a motion, as far as they are known."""
    numbers = motion_in(units, found)
    said = {
        "peak_force": "peak force {:.4g} N",
        "impulse": "impulse {:.4g} N.s",
        "energy_lost": "energy lost {:.4g} J each period",
    }
    return ", ".join(text.format(numbers[name]) for name, text in said.items() if numbers[name] is not None)


def _section(units: Units, section) -> list:
    scale = [units.factor(quantity) for quantity in ("displacement", "velocity") * 2]
    return (section * scale).tolist() if len(section) else []


def _known(value: float) -> float | None:
    return value if abs(value) < float("inf") else None
