"""Comparison, recommendation, search, sweep and fit of systems that rest, never touch, never part, or meet a wall."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    FREE_PERIODS,
    ComparisonQuestion,
    Excitation,
    Newmark,
    PlaneStudy,
    Reference,
    System,
    attractors,
    compare,
    fit,
    motion,
    print_statement,
    simulate,
    sweep,
    synthetic_measurement,
    verdict,
    with_located_steps,
)
from vibroscope.engine.contact import equal_restitution_damping
from vibroscope.engine.law_table import ratio_of_restitution
from vibroscope.engine.recommendation.search import recommend

from tests.recommended import question

WALL = System(wall=True, d1=0.05, restitution=0.7, clearance=0.8)
HELD = System(wall=True, clearance=-60.0)  # a preload that never opens
APART = System(clearance=1000.0)
FREE = System(d3=None, clearance=0.2, excitation=Excitation(base=0.0))
PENALTY = Newmark(700.0, 6.0, 500)


# ---------------------------------------------------------------------------------------------------------- comparison


def test_a_wall_has_no_joint_damping_to_blame_or_to_list():
    found = compare(ComparisonQuestion(WALL, 1.3, PENALTY))
    assert found.part_names == tuple(found.difference.parts) == ("time_step", "regularisation")
    words = verdict(found)
    assert "joint damping" not in {each.changed for each in words.alone.choices}
    assert "joint damping" not in " ".join(words.details)
    measured = compare(ComparisonQuestion(System(), 1.08, PENALTY))
    assert "joint_damping" in measured.difference.parts


def test_an_elastic_contact_needs_no_damping_and_no_sign():
    assert str(ratio_of_restitution(1.0)) == "0.0"
    elastic = compare(ComparisonQuestion(replace(WALL, restitution=1.0), 1.3, replace(PENALTY, damping=0.0)))
    words = verdict(elastic)
    methods = [each.method for each in words.alone.changes if each.method]
    assert len(methods) == len(set(methods))
    assert "D = -0" not in " ".join(words.details)


def test_a_free_vibration_is_compared_from_its_start_and_blames_a_damper_that_does_not_rebound_as_asked():
    start = {"initial": (0.5, 1.0, 0.5, -1.0), "periods": FREE_PERIODS, "keep": FREE_PERIODS}
    found = compare(ComparisonQuestion(FREE, 1.3, PENALTY, **start))
    words = verdict(found)
    assert words.headline.startswith("Nothing drives the bodies: in the first 2 periods T")
    assert words.blame == tuple(words.change) == ("D",)
    as_asked = replace(PENALTY, damping=words.change["D"])
    better = compare(ComparisonQuestion(FREE, 1.3, as_asked, **start))
    assert better.total == words.left < found.total / 2
    assert verdict(better).blame == ()
    parts = found.parts
    np.testing.assert_allclose(parts.time_step + parts.regularisation, parts.total, atol=1e-12)
    assert found.difference.measure == "displacements"
    assert found.difference.total == found.total > 0


def test_a_body_that_a_preload_holds_at_a_wall_has_no_relative_difference():
    found = compare(ComparisonQuestion(HELD, 1.3, PENALTY))
    words = verdict(found)
    assert words.agree == "unknown"
    assert words.headline.startswith("The bodies stay in contact all the time. The reference does not move")
    assert "off by 0.086 (rms" in words.headline
    given_way = found.parts.total[0]  # of body 1; the wall does not move
    assert np.sqrt(np.mean(given_way**2)) == pytest.approx(0.086, rel=0.01)
    assert np.mean(given_way) == pytest.approx(60 / 701, rel=1e-3)  # of the preload, by spring and K in series


@pytest.mark.parametrize("system", [HELD, System(clearance=-0.5)], ids=["wall", "two"])
def test_a_preload_without_excitation_has_no_relative_difference(system):
    still = replace(system, excitation=Excitation(base=0.0))
    words = verdict(compare(ComparisonQuestion(still, 1.3, PENALTY, periods=FREE_PERIODS, keep=FREE_PERIODS)))
    assert "not known" not in words.headline
    assert words.headline.startswith("The bodies stay in contact all the time. The reference does not move")


@pytest.mark.parametrize("system", [APART, System(clearance=-60.0)], ids=["apart", "joined"])
def test_where_nothing_meets_nothing_is_said_of_rebounds(system):
    assert not [
        line
        for line in verdict(compare(ComparisonQuestion(system, 1.3, PENALTY))).details
        if "speed at which they meet" in line
    ]


def test_a_spring_that_gives_way_is_to_blame_where_the_bodies_never_part():
    found = verdict(compare(ComparisonQuestion(System(clearance=-60.0), 1.3, replace(PENALTY, stiffness=20.0))))
    words = print_statement(found.headline)
    assert "K is to blame, since its spring gives way under the force that presses the bodies together" in words
    assert not any(wrong in words for wrong in ("rebounds", "errors that cancel", "too soft"))
    assert found.change["K"] > 20.0


# ------------------------------------------------------------------------------------------------- searches and studies


@pytest.mark.parametrize(
    ("system", "words"),
    [(APART, "Nothing touches"), (FREE, "Nothing drives"), (HELD, "Body 1 rests against the wall")],
    ids=["apart", "free", "held"],
)
def test_there_is_nothing_to_recommend_where_k_and_d_do_nothing(system, words):
    one, many = recommend(question(system, 1.3)), recommend(question(system, [1.2, 1.4]))
    assert words in one.reason
    assert words in many.reason
    assert one.best is many.best is None
    assert many.left_out == (1.2, 1.4)


def test_all_starts_of_a_free_vibration_come_to_the_same_rest():
    for method in (Reference(), PENALTY):
        (found,) = attractors(FREE, 1.3, method, starts=6)
        assert found.share == 1.0
    assert motion(FREE, 1.3, Reference()).reason.startswith("nothing drives the bodies")


def test_a_plane_of_a_system_at_rest_has_no_error_to_divide():
    found = sweep(PlaneStudy(FREE, Newmark(1, 1, 100), 1.3, K=[100.0, 700.0], D=[3.0, 6.0], transient=10, sample=4))
    assert (found["error"].values == 0).all()
    held = sweep(PlaneStudy(HELD, Newmark(1, 1, 500), 1.3, K=[100.0, 700.0], D=[3.0, 6.0], transient=10, sample=4))
    assert np.isinf(held["error"].values).all()


def test_a_fit_takes_the_constants_that_the_system_has():
    measured = synthetic_measurement(WALL, 1.3, periods=2, noise=0.0)
    found = fit(WALL, 1.3, measured)
    assert list(found.values) == ["restitution", "d1", "zero1"]
    assert found.values["restitution"] == pytest.approx(0.7, abs=1e-4)
    with pytest.raises(ValueError, match="cannot fit d2: a wall has no such number"):
        fit(WALL, 1.3, measured, names=["d2"])


def test_a_joint_damping_that_was_never_measured_stays_so_where_the_motion_does_not_show_it():
    drive = Excitation(base=0.0, force1=1.0, force1_phase=0.4, force2=-0.7, force2_phase=1.9, constant1=0.1)
    two = System(1.0, 0.03, 0.03, mu=1.0, d3=None, clearance=0.3, excitation=drive)
    found = fit(two, 1.3, synthetic_measurement(two, 1.3, periods=2, noise=0.0), names=["restitution", "d3"])
    assert found.system.d3 is None
    assert found.values["d3"] == two.derived_joint_damping


# ------------------------------------------------------------------------------------------------------ today's system


METHODS = (Reference(), Reference("derived", threshold=0.0), PENALTY, with_located_steps(PENALTY), PENALTY.limit)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_defaults_written_out_are_todays_system_bit_for_bit(method):
    written = System(2.41, 0.0033, 0.0120, 1.80, 0.0330, 0.5, clearance=0.0, wall=False, excitation=Excitation(1.0))
    one, two = (simulate(each, 1.08, method, periods=30, keep=30) for each in (System(), written))
    assert written == System()
    np.testing.assert_array_equal(one.section, two.section)
    np.testing.assert_array_equal(one.contacts, two.contacts)
    signs = replace(written, clearance=-0.0, excitation=Excitation(1.0, -0.0, -0.0, 0.0, -0.0, 0.0, -0.0, -0.0))
    np.testing.assert_array_equal(simulate(signs, 1.08, method, periods=30, keep=30).section, one.section)


def test_a_mass_ratio_that_is_given_is_the_one_that_follows():
    paper = System()
    given = System.from_mass_ratio(paper.mass_ratio)
    assert given.kappa3 == pytest.approx(paper.kappa3, rel=1e-15)
    one, two = (simulate(each, 2.76, PENALTY, periods=5, keep=5) for each in (paper, given))
    np.testing.assert_allclose(two.section, one.section, rtol=1e-9)


def test_a_clearance_that_shrinks_brings_the_motion_back_in_proportion():
    """Penalty contact is continuous in the clearance: a hundredth of it leaves about a hundredth of the difference."""
    sections = [
        simulate(System(clearance=g), 2.76, PENALTY.limit, periods=1, keep=1).section for g in (0.0, 1e-6, 1e-8)
    ]
    far, near = (np.abs(section - sections[0]).max() for section in sections[1:])
    assert 0 < near <= far / 50


def test_a_reference_that_is_at_rest_whenever_a_period_ends_is_compared():
    """A preloaded stop: its section is a point without size, and the elastic penalty solution does not repeat."""
    system = System(wall=True, d1=0.0, clearance=-0.45, restitution=0.7, excitation=Excitation(base=1.0))
    found = compare(ComparisonQuestion(system, 0.727, Newmark(70, 0, 1250)))
    assert found.statistics.size == 0.0
    assert found.statistics.total == np.inf
    assert found.difference.measure == "displacements"
    assert np.isfinite(found.difference.total)


def test_a_free_vibration_that_comes_to_rest_is_split_as_it_is_compared():
    """At equal restitution nothing is left of a wrong one; the runs of the parts rest in the end, too."""
    load = Excitation(base=0.0, constant1=1.0)
    system = System(wall=True, d1=0.02, clearance=0.3, restitution=0.55, excitation=load)
    damping = equal_restitution_damping(system, 220.0)
    start = {"initial": (-0.3, 0.0, 0.0, 0.0), "periods": FREE_PERIODS, "keep": FREE_PERIODS}
    found = compare(ComparisonQuestion(system, 1.0, Newmark(220.0, damping, 8000), **start))
    parts, of_step = found.split(), found.split_time_step()
    assert parts.in_step
    assert found.parts.relative(parts.wrong_restitution) < 1e-3
    assert found.parts.relative(of_step.status) < 0.05 * found.total
