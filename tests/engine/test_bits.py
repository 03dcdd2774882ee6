"""The paper's motions have the bits that they had before a system could have a clearance, a wall or forces.

The table was made with the commit 194499f, the last one without, for the processor "znver4" with glibc. Elsewhere the
same commit makes another table: the C library may round sine and cosine differently, and for another processor the
compiler fuses other products with sums. Bodies without a spring changed the rounding of the reference and of Newmark's
step, by up to 1e-13 in four periods: these columns were made anew with them.
"""

import hashlib
import platform

import llvmlite.binding
import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Newmark, Reference, System, simulate

SCENES = {  # η, K, D, steps of the paper's motions
    "A": (1.08, 2500.0, 8.0, 2000),
    "B": (1.70, 12000.0, 18.0, 8000),
    "C": (2.76, 12000.0, 18.0, 8000),
    "D": (3.25, 12000.0, 18.0, 8000),
}
BITS = {
    "A": ("b90b2334d62a5d62", "c1e78e389ae7501e", "9389c2d5465c4ab8", "0cb7051a09c27799"),
    "B": ("b314fc29f19015f1", "5432e710c00a6893", "2412ac40b972e2bb", "84a04c8c1f7084a9"),
    "C": ("0f956714021e1df4", "7c0da24cae2d400e", "4b0882e7cfea4922", "04dc4b4b6c1d23ba"),
    "D": ("4ff2ea0fb15f4a12", "96abf1e5af04a5ec", "6b686abee1d604b0", "af8274b334c55762"),
}
MADE_HERE = (llvmlite.binding.get_host_cpu_name(), platform.libc_ver()[0]) == ("znver4", "glibc")


def bits(system, eta, method):
    """Digest of sections and contacts of the first 30 periods."""
    found = simulate(system, eta, method, periods=30, keep=30)
    columns = (found.section, found.contacts)
    return hashlib.sha256(b"".join(np.ascontiguousarray(each).tobytes() for each in columns)).hexdigest()[:16]


@pytest.mark.skipif(not MADE_HERE, reason="the table was made with another C library or processor")
@pytest.mark.parametrize("clearance", [0.0, -0.0])
@pytest.mark.parametrize("name", SCENES)
def test_no_clearance_gives_the_bits_of_the_solvers_without_one(name, clearance):
    eta, stiffness, damping, steps = SCENES[name]
    penalty = stiffness, damping, steps
    methods = Reference(), ExactPenalty(stiffness, damping), Newmark(*penalty), Newmark(*penalty, every_step=True)
    assert tuple(bits(System(clearance=clearance), eta, method) for method in methods) == BITS[name]


@pytest.mark.parametrize("clearance", [1e-300, -1e-300, 1e-16, -1e-16, 1e-12, -1e-12])
@pytest.mark.parametrize("name", SCENES)
def test_a_clearance_that_vanishes_joins_on_to_none(name, clearance):
    """In the first two periods, where rounding grows to 1e-10; a gap g lets a chatter end later by √g at most."""
    eta, stiffness, damping, steps = SCENES[name]
    for method in (Reference(), ExactPenalty(stiffness, damping), Newmark(stiffness, damping, steps)):
        none, tiny = (simulate(System(clearance=g), eta, method, periods=2, keep=2) for g in (0.0, clearance))
        difference = np.abs(tiny.section - none.section).max()
        assert difference <= 1e-10 + 2 * np.sqrt(abs(clearance)), (method, difference)
