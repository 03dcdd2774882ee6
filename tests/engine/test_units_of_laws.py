"""K and D of laws that are not linear, in physical units: the unit of length must never change a physical result.

The system is run with dimensions by SciPy, which knows nothing of the units of the model, and by the program in two
units of length.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vibroscope.engine import (
    CONTACT_LAWS,
    ExactPenalty,
    TimeStepping,
    Units,
    motion,
    system_of_physical,
)

MASS, STIFFNESS, GAP, FORCE, FREQUENCY = 25.0, 98696.0, 0.5e-3, 25.0, 10.0  # kg, N/m, m, N, Hz
SHEET = {"mass1_kg": MASS, "stiffness1_N_per_m": STIFFNESS, "damping1_ratio": 0.07, "wall": True, "clearance_mm": 0.5}
SHEET |= {"restitution": 0.5, "force1_N": FORCE, "frequency_Hz": FREQUENCY}
PENETRATION = 2e-5  # m
# K in N/mⁿ and c in N·s/m^(m + 1) of each law, as a data sheet or another code has them, and n and m.
SHEETS = {
    "hunt-crossley": (1e9, 3e9, 1.5, 1.5),
    "lankarani-nikravesh": (1e9, 2e9, 1.5, 1.5),
    "flores": (2e10, 5e10, 1.8, 1.8),
    "jankowski": (1e9, 3e4, 1.5, 0.25),
    "constant-restitution": (1e9, 3e4, 1.5, 0.25),
    "impact": (1e12, 3e3, 2.2, 0.0),
}


def force_of(law: str, k: float, c: float, n: float, m: float, depth: float, rate: float) -> float:
    """The force of a law with dimensions, from its publication."""
    if depth <= 0:
        return 0.0
    if law == "jankowski":
        rate = max(rate, 0.0)
    if law == "impact":
        x = min(depth / PENETRATION, 1.0)
        return max(0.0, k * depth**n + c * x * x * (3 - 2 * x) * rate)
    return k * depth**n + c * depth**m * rate


def peak_with_dimensions(law: str) -> float:
    """Largest contact force of the settled motion in N, integrated in m, kg and s."""
    k, c, n, m = SHEETS[law]
    damper, omega = 2 * 0.07 * math.sqrt(STIFFNESS * MASS), 2 * math.pi * FREQUENCY

    def contact(x, v):
        return force_of(law, k, c, n, m, x - GAP, v)

    def rates(t, state):
        x, v = state
        return v, (FORCE * math.cos(omega * t) - STIFFNESS * x - damper * v - contact(x, v)) / MASS

    run = solve_ivp(rates, (0, 4.0), (0.0, 0.0), "LSODA", rtol=1e-9, atol=1e-13, max_step=5e-4)
    late = run.t > 3.7
    return max(contact(x, v) for x, v in run.y.T[late])


def method_of(law: str, units: Units) -> ExactPenalty:
    """The law with these numbers, in the numbers of the model."""
    k, c, n, _ = SHEETS[law]
    scale = replace(units, law=law, exponent=n)
    more = {"penetration": units.model("displacement", PENETRATION)} if law == "impact" else {}
    stiffness, damping = scale.model("contact_stiffness", k), scale.model("contact_damping", c)
    return ExactPenalty(stiffness, damping, law, n, **more)


@pytest.mark.parametrize("law", SHEETS)
def test_the_unit_of_length_changes_no_physical_result(law):
    """The force in N is that of the run with dimensions, whatever length displacements are counted in."""
    peaks = []
    for length in (1.0, 1000.0):  # mm
        system, units, eta, _ = system_of_physical(SHEET | {"length_mm": length})
        found = motion(system, eta, method_of(law, units))
        peaks.append(units.physical("force", found.peak_force))
    expected = peak_with_dimensions(law)
    assert peaks == pytest.approx([expected] * 2, rel=2e-4)


def test_a_hertz_contact_of_one_giganewton_per_metre_to_the_power_of_one_and_a_half():
    """395.33 N for K = 1e9 N/m^1.5 with Hunt and Crossley's damper for e = 0.5, by a run with dimensions elsewhere."""
    for length in (1.0, 1000.0):
        system, units, eta, _ = system_of_physical(SHEET | {"length_mm": length})
        stiffness = replace(units, law="hunt-crossley").model("contact_stiffness", 1e9)
        found = motion(system, eta, ExactPenalty(stiffness, None, "hunt-crossley"))
        assert units.physical("force", found.peak_force) == pytest.approx(395.33, abs=0.01)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_both_systems_of_units_describe_the_same_contact(law):
    """Force over lengthⁿ in N and mm is that in N and m times 1000⁻ⁿ; there and back, the number stays."""
    n = 2.2
    for system in ("si", "mm-t-s"):
        units = Units(62.8, 25.0, 0.25, system, law, n)
        for name in ("contact_stiffness", "contact_damping"):
            assert units.model(name, units.physical(name, 7.0)) == pytest.approx(7.0, rel=1e-14)
    si, small = (Units(62.8, 25.0, 0.25, system, law, n) for system in ("si", "mm-t-s"))
    for name in ("contact_stiffness", "contact_damping"):
        power = float(si.unit(name).rpartition("^")[2]) if "^" in si.unit(name) else 1.0
        assert small.factor(name) == pytest.approx(si.factor(name) * 1e3**-power, rel=1e-14)
        assert small.unit(name) == si.unit(name).replace("/m", "/mm")


def test_settings_are_those_of_the_law():
    """What an input file gets of a method: K of the law's own spring."""
    units = Units(omega1=62.8, m1=25.0, base_amplitude=1.07)
    method = TimeStepping(1000, 8, 500, law="impact", exponent=2.2, penetration=0.01)
    found = units.settings(1.0, method)
    own = 25.0 * 62.8**2
    assert found["stiffness"] == pytest.approx(1000 * own * 1.07e-3**-1.2)
    assert found["damping"] == pytest.approx(2 * 8 * 25.0 * 62.8)  # force per speed
    assert np.isclose(
        units.settings(1.0, replace(method, law="cut", exponent=1.5, penetration=None))["stiffness"], 1000 * own
    )
