"""Verdict, parts and motions never contradict each other: random settings of random systems, 300 before a release."""

import math
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.commands import compare as command
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import describe, explain
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore.result import Findings, Interpretation, Result
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import (
    Comparison,
    ComparisonQuestion,
    Newmark,
    System,
    TimeStepping,
    compare,
    percent,
    repetition,
    verdict,
    with_located_steps,
)
from vibroscope.engine.divergence.tolerances import APART, NEARLY, SAME_CURVE, TIE

from tests.share import every, share

# short runs: what is said must agree with the numbers, whatever these are
RUN = {"periods": 50, "keep": 16}


def random_settings(count, seed):
    """Systems, η and Newmark's numbers over the ranges that the explorer has, from soft contacts to stiff ones."""
    rng = np.random.default_rng(seed)
    while count:
        kappa = rng.uniform(1.3, 4)
        system = System(
            kappa=kappa,
            kappa3=rng.uniform(1.05, kappa - 0.05),
            d1=rng.uniform(0.002, 0.05),
            d2=rng.uniform(0.002, 0.05),
            d3=rng.uniform(0.002, 0.08),
            restitution=rng.uniform(0.2, 0.9),
        )
        method = Newmark(
            float(f"{10 ** rng.uniform(2, 5):.3g}"),
            float(f"{10 ** rng.uniform(-0.5, 1.7):.3g}"),
            int(10 ** rng.uniform(2, 3.5)),
            located=rng.random() < 0.1,
        )
        yield system, rng.uniform(0.6, 3.8), method
        count -= 1


def difference_with(change, case):
    """The difference, from the start of the run, with the steps or the status that a verdict proposes."""
    system, eta, method = case
    if "status" in change:
        method = TimeStepping(method.stiffness, method.damping, method.steps, status=change["status"])
    else:
        numbers = {name: value for name, value in change.items() if name != "located"}
        method = replace(method, **numbers)
        method = with_located_steps(method) if change.get("located") else method
    return compare(ComparisonQuestion(system, eta, method, **RUN)).difference.total


def contradictions(case):
    """What the words say that the numbers do not."""
    comparison = compare(ComparisonQuestion(*case, **RUN))
    if comparison.parts is None:
        return []
    comparison = comparison.decided()
    if not np.isfinite(comparison.difference.total):
        return []
    found, difference = verdict(comparison), comparison.difference
    headline, faults = found.headline, []
    reference, penalty = comparison.reference, comparison.penalty

    def check(holds, fault):
        if not holds:
            faults.append((case, fault, headline))

    check(percent(difference.total) in headline, "the total of the bars is not in the headline")
    check("nan" not in headline + " ".join(found.details), "a number that is none")
    check(not re.search(r"\de[+-]?\d", headline + " ".join(found.details)), "a number with an exponent")
    check(found.reference is reference and found.penalty is penalty, "other motions than the comparison's")

    another = "different but valid" in headline
    in_kind = penalty.near_period == reference.near_period
    check(another or in_kind or repetition(penalty) in headline, "a difference in kind is not mentioned")
    check(not in_kind or "in kind" not in headline, "a difference in kind that there is none")
    check(found.agree != "yes" or (in_kind and difference.total <= 0.1), "they agree although they do not")

    if found.alone is None:
        return faults
    check(found.blame or not found.change, "a change of what is not to blame")
    if found.blame:
        check(found.left < difference.total and found.left <= APART * TIE, "a cure that leaves no less")
        largest = "joint damping" not in found.blame or difference.largest == "joint_damping"
        check(largest, "the joint damping is to blame, whose part is not the largest")
        check(percent(found.left) in headline, "the cure's remainder is not in the headline")
        least = max(found.alone.changes[0].robust, difference.chance, SAME_CURVE)
        check(found.together or found.left <= 1.3 * TIE * least, "another cure is better")
        if set(found.blame) <= {"status", "steps"} and found.change and difference.measure == "displacements":
            claimed = found.left == pytest.approx(difference_with(found.change, case), rel=NEARLY - 1)
            check(claimed, "the change leaves another difference than the verdict says")
    table = command.part_rows(comparison, None)
    shares = [difference.amount, *map(percent, difference.parts.values())]
    check([text.partition(" (")[0] for _, text in table] == shares, "other digits in the table")
    return faults


@pytest.mark.parametrize(
    ("count", "evidence"),
    [
        pytest.param(12, False, id="described"),
        pytest.param(300, False, id="many described", marks=pytest.mark.release),
        pytest.param(12, True, id="with evidence"),
    ],
)
def test_words_and_numbers_agree_for_random_settings_of_random_systems(count, evidence, monkeypatch):
    """As their kept periods show them, and, fewer, with the runs that decide what the motions are."""
    if not evidence:
        monkeypatch.setattr(Comparison, "decided", lambda comparison, *_: comparison)
    with ThreadPoolExecutor(2) as pool:
        cases = random_settings(share(count), seed=1)
        faults = [fault for each in pool.map(contradictions, cases) for fault in each]
    assert not faults, f"{len(faults)} faults, such as {faults[:3]}"


SHOWN = [(12000.0, 18.0, 2000), (100.0, 50.0, 2000), (2500.0, 8.0, 400)]


@pytest.mark.parametrize(("eta", "numbers"), every([(eta, each) for each in SHOWN for eta in (1.08, 2.76, 1.7, 3.25)]))
def test_bars_lines_and_verdict_of_the_page_share_numbers_and_words(eta, numbers):
    setting = Setting(eta=eta, **dict(zip(("K", "D", "steps"), numbers, strict=True)))
    runs = compute_runs(setting, cache=Cache(4))
    found, explanation, view = describe(runs), explain(runs), Findings()
    view.show(Interpretation(Result(setting, {}, found), explanation))
    comparison = compare(ComparisonQuestion(setting.system, eta, setting.penalty)).decided()
    assert {name: text for name, *_, text in view.content["bars"]} == {
        "total": percent(comparison.difference.total),
        **{name: percent(value) for name, value in comparison.difference.parts.items()},
    }
    assert view.content["bars"][0][-1] in explanation.headline
    for name in ("reference", "penalty"):
        described = getattr(comparison, name)
        line = view.content[name]
        assert line.lower().startswith(repetition(described).lower())
        assert f"{percent(described.contact_share)} of the time" in line
        in_details = " ".join(explanation.details)
        assert percent(described.contact_share) in in_details


def test_a_share_beside_its_limit_shows_on_which_side_it_lies():
    assert percent(0.01, beside=0.01) == "1 %"
    assert percent(0.01004, beside=0.01) == "1.004 %"
    assert percent(0.00996, beside=0.01) == "0.996 %"
    assert percent(0.77, beside=0.05) == "77 %"


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (1.0, "100 %"),
        (1.76, "176 %"),
        (9.876, "988 %"),
        (12.34, "more than 1000 %"),
        (0.996, "100 %"),
        (1.2e-6, "0.00012 %"),
        (0, "0 %"),
    ],
)
def test_no_share_has_an_exponent_or_more_digits_elsewhere(share, text):
    assert percent(share) == text


def test_a_scattered_motion_has_the_kind_of_its_limit_everywhere():
    """The section nearly repeats after two periods, by chance; without a time step, after one."""
    comparison = compare(ComparisonQuestion(System(), 2.76, Newmark(12000, 18, 2000)))
    assert comparison.penalty.near_period != 1
    decided = comparison.decided()
    assert repetition(decided.penalty).startswith("repeats every period, blurred by the time step (±")
    assert decided.penalty.near_period == comparison.with_evidence().penalty.near_period == 1
    assert "every 2 periods" not in verdict(comparison).headline


def test_what_is_decided_is_not_decided_again():
    comparison = compare(ComparisonQuestion(System(), 2.76, Newmark(12000, 18, 2000))).decided()
    assert comparison.decided().penalty is comparison.penalty
    assert math.isfinite(comparison.with_evidence().penalty.lyapunov)
    assert replace(comparison).difference == comparison.difference
