"""What the table of contact laws says of each is what its force and its formula do."""

import math

import numpy as np
import pytest
from vibroscope.engine import CONTACT_LAWS, LAWS_BY_RESTITUTION, ExactPenalty, Newmark, System, TimeStepping
from vibroscope.engine.contact import contact_frequency, spring_duration, spring_energy
from vibroscope.engine.drivers.law_driven import by_steps
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.contact_law import LAWS as NUMBERS
from vibroscope.engine.kernels.equations.contact_law import ContactLaw, law_force
from vibroscope.engine.law_table import LAW_NUMBERS, LAWS, formula_damper, laws_with, numbers_of

from tests.law_numbers import law_numbers
from tests.naive_laws import force

K, DEPTH = 700.0, 0.013
LINEAR = [law for law in CONTACT_LAWS if LAWS[law].exponent == 1.0 and not LAWS[law].takes_stiffening]


def force_of(law, gain=0.0, exponent=1.5, penetration=0.02, speed=0.0, stiffening=4.0):
    law = ContactLaw(CONTACT_LAWS.index(law), K, exponent, penetration, stiffening, gain, 0.0)
    return law_force(law, gain, DEPTH, speed)


def test_the_table_has_every_law_of_the_kernels():
    assert len(LAWS) == len(NUMBERS)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_the_spring_of_a_law_has_its_exponent(law):
    for n in (LAWS[law].exponent, 2.2) if LAWS[law].takes_exponent else (LAWS[law].exponent,):
        twin = force(ExactPenalty(K, 0.0, law, **law_numbers(law, n)), 0.0, DEPTH, 0.0)
        assert force_of(law, exponent=n) == pytest.approx(twin)
        assert twin == pytest.approx(K * DEPTH**n)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_a_law_takes_the_penetration_that_its_force_depends_on(law):
    given = {force_of(law, 3.0, LAWS[law].exponent, penetration, 0.1) for penetration in (0.01, 0.02)}
    assert (len(given) == 2) == bool(LAWS[law].penetration)
    given = {force_of(law, 3.0, LAWS[law].exponent, 0.01, 0.1, stiffening) for stiffening in (2.0, 3.0)}
    assert (len(given) == 2) == LAWS[law].takes_stiffening


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_the_damper_of_a_law_that_jumps_acts_at_touch(law):
    numbers = ContactLaw(CONTACT_LAWS.index(law), K, LAWS[law].exponent, 0.02, 4.0, 3.0, 0.0)
    touch = law_force(numbers, 3.0, 1e-12, 0.1)
    assert touch == pytest.approx(0.3 if LAWS[law].jumps else 0.0, abs=1e-3)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_a_law_without_a_formula_needs_its_damping(law):
    if law in LAWS_BY_RESTITUTION:
        gain, by_speed = formula_damper(law, 0.6, K, 0.7, LAWS[law].exponent)
        assert gain > 0.0
        assert by_speed == LAWS[law].relative
        assert ExactPenalty(K, None, law, **law_numbers(law)).damping is None
    else:
        with pytest.raises(ValueError, match="D = None"):
            ExactPenalty(K, None, law, **law_numbers(law))


@pytest.mark.parametrize("law", LINEAR)
def test_a_linear_law_has_the_duration_and_the_energy_of_a_linear_spring(law):
    system = System()
    for method in (ExactPenalty(K, 2.0, law), TimeStepping(K, 2.0, 500, law=law)):
        assert method.spring_exponent == parameters_of(system, 1.3, method).exponent == 1.0
        assert spring_duration(system.mass_share, method, 2.0) == pytest.approx(math.pi / contact_frequency(system, K))
        np.testing.assert_allclose(spring_energy(method, np.array([-DEPTH, DEPTH])), [0.5 * K * DEPTH**2, 0.0])


def test_numbers_and_defaults_are_those_of_the_methods():
    assert laws_with("penetration") == ("impact", "bilinear")
    for law in CONTACT_LAWS:
        own = numbers_of(law)
        method = ExactPenalty(K, 2.0, law, **law_numbers(law))
        assert method.exponent == own.get("exponent", method.exponent)
        for name in set(LAW_NUMBERS) - own.keys():
            with pytest.raises(ValueError, match=f"{name} = 2.*is no number of the law {law!r}"):
                ExactPenalty(K, 2.0, law, **law_numbers(law) | {name: 2.0})


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_newmark_takes_the_laws_that_the_table_says(law):
    if LAWS[law].newmark:
        assert Newmark(K, 2.0, 500, law=law).spring_exponent == 1.0
    else:
        with pytest.raises(ValueError, match="stepped by TimeStepping"):
            Newmark(K, 2.0, 500, law=law)


def test_closed_form_is_what_is_not_integrated_by_steps():
    methods = {law: ExactPenalty(K, 2.0, law, **law_numbers(law)) for law in CONTACT_LAWS}
    assert [by_steps(method) for method in methods.values()] == [not law.closed_form for law in LAWS.values()]
