"""Sweeps, the tabs that show them, and single runs say the same of a motion: random settings of random systems."""

import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.panel import kind_text
from vibroscope.app.page.study.plane import statements as plane_statements
from vibroscope.app.page.study.time_step import statements as step_statements
from vibroscope.app.studies import bifurcation, plane, time_step
from vibroscope.engine import (
    COORDINATES,
    HHT,
    Cells,
    ComparisonQuestion,
    ExactPenalty,
    Kind,
    Newmark,
    Reference,
    System,
    TimeStepping,
    compare,
    motion,
    repetition,
    run_cells,
    simulate,
    sweep,
)
from vibroscope.engine.motions.words import of_section
from vibroscope.engine.sweeps import CellKind, EtaStudy, PlaneStudy, StepStudy, judge_runs, kind_words

from tests.share import every

TRANSIENT, SAMPLE = 104, 16
RUN = {"periods": TRANSIENT + SAMPLE, "keep": SAMPLE}
METHODS = {
    "reference": Reference(),
    "exact": ExactPenalty(1.0, 1.0),
    "Newmark": Newmark(1.0, 1.0, 100),
    "HHT": TimeStepping(1.0, 1.0, 100, HHT()),
    "Newmark, located": Newmark(1.0, 1.0, 100, located=True),
}
SCATTERED = Setting(eta=2.76, K=12000.0, D=18.0, steps=2000)


def random_cells(method, count, seed):
    """Systems, η and numbers of the method over the ranges of the explorer, from soft contacts to stiff ones."""
    rng = np.random.default_rng(seed)
    systems = []
    for _ in range(count):
        kappa = rng.uniform(1.3, 4)
        dampings = dict(zip(("d1", "d2", "d3"), rng.uniform(0.002, 0.08, 3), strict=True))
        kappa3, restitution = rng.uniform(1.05, kappa - 0.05), rng.uniform(0.2, 0.9)
        systems.append(System(kappa=kappa, kappa3=kappa3, restitution=restitution, **dampings))
    own = {}
    if not method.rigid:
        own = {"stiffness": 10 ** rng.uniform(2, 5, count), "damping": 10 ** rng.uniform(-0.5, 1.7, count)}
    if method.has_step:
        own["steps"] = (10 ** rng.uniform(2, 3.5, count)).astype(int)
    return Cells(systems, rng.uniform(0.6, 3.8, count), method, **own)


def single(system, eta, method):
    """The run of a cell by itself, described."""
    run = simulate(system, eta, method, **RUN)
    return motion(run) if run.ok else None


def assert_same(period, near, section, found):
    """A cell has the periods and the words of the single run."""
    assert (period, near) == (found.period, found.near_period)
    assert kind_words(CellKind.UNKNOWN, period, near, section) == of_section(repetition(found), period, has_step=True)


@pytest.mark.parametrize("name", METHODS)
def test_cells_have_the_periods_and_the_words_of_single_runs(name):
    cells = random_cells(METHODS[name], 40, seed=1)
    found = run_cells(cells, transient=TRANSIENT, sample=SAMPLE)
    nearly = 0
    for i in range(len(cells)):
        described = single(cells.system_of(i), cells.eta[i], cells.method_of(i))
        assert found.ok[i] == (described is not None)
        if described:
            assert_same(int(found.period[i]), int(found.near_period[i]), found.section[i], described)
            nearly += described.near_period != described.period
    assert nearly >= 3  # sections that come near to repeating themselves are among them


def test_studies_have_the_periods_and_the_words_of_single_runs():
    """Those of the diagram, of both sides of the plane, and with fixed and with located steps."""
    cells = random_cells(METHODS["Newmark"], 3, seed=2)
    for i in range(len(cells)):
        system, eta, method = cells.system_of(i), float(cells.eta[i]), cells.method_of(i)
        of = {"method": method, "eta": eta, "transient": TRANSIENT, "sample": SAMPLE}
        diagram = EtaStudy(system, **of, values=[eta, eta + 0.1], coordinates=COORDINATES).compute()
        found = single(system, eta, method)
        section = np.stack([diagram[name][0] for name in COORDINATES], axis=1)
        assert_same(int(diagram["period"][0]), int(diagram["near_period"][0]), section, found)
        one = PlaneStudy(system, **of, K=[method.stiffness], D=[method.damping], only=SHOWN).compute()
        both = StepStudy(system, **of, steps=[method.steps]).compute()
        cases = [
            (found, one["period"][0, 0], one["near_period"][0, 0]),
            (single(system, eta, method.limit), one["exact_period"][0, 0], one["exact_near_period"][0, 0]),
            (found, both["period"][0, 0], both["near_period"][0, 0]),
        ]
        for described, *periods in cases:
            assert periods == [described.period, described.near_period]


SHOWN = ("period", "near_period", "exact_period", "exact_near_period")


def judgements(cells, chosen=None, transient=1000):
    """Number, kind and words of each cell, and the words of the single motion, without amounts."""
    chosen = np.arange(len(cells)) if chosen is None else np.array(chosen)
    kinds = judge_runs(cells.at(chosen), transient=transient, sample=48)
    for i, kind, period in zip(chosen.tolist(), kinds["kind"].tolist(), kinds["kind_period"].tolist(), strict=True):
        found = motion(cells.system_of(i), cells.eta[i], cells.method_of(i))
        in_words = {Kind.UNDECIDED: kind_words(CellKind.UNDECIDED, 0), Kind.DIVERGED: "ended early"}
        yield i, kind, kind_words(kind, period), in_words.get(found.type, re.sub(r" \(±.*\)", "", repetition(found)))


def alone(rng):
    restitution, d1 = rng.uniform(0.2, 0.9), rng.uniform(0.002, 0.08)
    return System(wall=True, clearance=rng.uniform(-0.5, 2), restitution=restitution, d1=d1)


def between_stops(rng):
    return replace(alone(rng), clearance=rng.uniform(0.2, 1.5), clearance2=rng.uniform(0.2, 1.5))


@pytest.mark.parametrize("shape", [None, alone, between_stops])
@pytest.mark.parametrize("name", ["Newmark", "HHT", "reference", "exact"])
def test_the_judge_of_many_cells_says_what_it_says_of_a_single_motion(name, shape):
    """Undecided cells included."""
    slow = shape is between_stops  # every step is taken there, and every event by itself
    count = 60 if not slow else 2 if METHODS[name].has_step else 20
    cells = random_cells(METHODS[name], count, seed=6)
    if shape:
        rng = np.random.default_rng(6)
        cells = replace(cells, system=[shape(rng) for _ in range(count)])
    found = list(judgements(cells, every(range(count))))
    assert [row for row in found if row[2] != row[3]] == []
    kinds = [kind for _, kind, _, _ in found]
    assert kinds.count(CellKind.UNDECIDED) <= 0.2 * len(found)
    assert kinds.count(CellKind.ARTEFACT) >= 0.2 * len(found) or not METHODS[name].has_step or slow


@pytest.mark.parametrize(
    ("seed", "count", "cell"),
    every(
        [
            (107, 24, 20),  # its scatter ends between 1,500 and 4,000 periods
            (101, 24, 22),  # its cycle of 128 periods is longer than the sample of the cell
            (105, 24, 19),  # motions of one and of two periods coexist without a time step, within its band
            (6, 80, 5),  # its scatter is a transient of some 3,000 periods, of which rounding decides the length
            (111, 24, 0),  # without a time step a multiplier is -0.997, so that the cycle seemed to have two periods
        ]
    ),
)
@pytest.mark.parametrize("transient", [450, 1000])
def test_a_cell_is_judged_by_the_periods_that_a_single_motion_is_judged_by(seed, count, cell, transient):
    cells = random_cells(METHODS["Newmark"], count, seed=seed)
    ((_, _, said, of_single),) = judgements(cells, [cell], transient)
    assert said == of_single


@pytest.mark.parametrize("method", [Newmark(100, 5, 200), ExactPenalty(100, 5)], ids=["Newmark", "exact"])
@pytest.mark.parametrize(("d1", "eta"), every([(0.0033, 1.3), (0.0033, 0.7), (0.001, 1.3), (0.0003, 0.7)]))
def test_a_linear_motion_after_a_short_transient_has_the_period_of_its_excitation(d1, eta, method):
    """Nothing touches; the free vibration has not died away when the sample begins, and returns after its own time."""
    cells = Cells(System(clearance=1000.0, d1=d1), [eta], method)
    assert run_cells(cells, transient=30, sample=50).period == 0
    kinds = judge_runs(cells, transient=30, sample=50)
    assert (kinds["kind"][0], kinds["kind_period"][0]) == (CellKind.PERIODIC, 1)


@pytest.mark.parametrize(("eta", "steps"), every([(2.76, 2000), (2.76, 8000), (2.2, 2000), (3.25, 2000), (1.08, 500)]))
def test_a_study_over_the_step_has_the_errors_of_single_comparisons(eta, steps):
    """All but the first of the same periods: scatter comes in bursts, and other periods have another error."""
    study = sweep(StepStudy(System(), Newmark(12000.0, 18.0, 2000), eta, steps=[steps], transient=2000, sample=50))
    found = compare(ComparisonQuestion(System(), eta, Newmark(12000.0, 18.0, steps)))
    errors = [float(study[f"error{part}"][0, 0]) for part in ("", "_time_step", "_regularisation")]
    assert errors == pytest.approx([found.total, found.time_step, found.regularisation], rel=0.05)


def test_the_tabs_say_of_a_scattered_motion_what_a_single_run_says(monkeypatch, tmp_path):
    """Its section nearly repeats itself after two periods, by chance; without a time step, after one."""
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(plane, "COUNT", 1)
    monkeypatch.setattr(time_step, "STEPS", (2000,))
    said = re.sub(r" \(±.*\)", "", repetition(motion(SCATTERED.system, 2.76, SCATTERED.penalty)))
    assert said == "repeats every period, blurred by the time step"
    ends = (11999.0, 12001.0), (17.999, 18.001)
    plain, judged = (
        list(plane.grow_plane(plane.PlaneQuestion(SCATTERED.system, 2.76, 2000, False, False, *ends, which), None, no))
        for which in (False, True)
    )
    assert judged[-1].share == 1
    assert plane_statements(SCATTERED, judged[-1])[0][1].startswith(said)
    assert "kind not judged" in plane_statements(SCATTERED, plain[-1])[0][1]
    question = time_step.StepQuestion(SCATTERED.system, 2.76, SCATTERED.penalty)
    assert step_statements(SCATTERED, list(time_step.grow_step(question, None, no))[-1])[0][1].startswith(said)
    asked = bifurcation.DiagramQuestion(SCATTERED.system, SCATTERED.penalty, "rest", (2.75, 2.76), count=2)
    text = kind_text(list(bifurcation.grow_diagram(asked, None, no))[-1], 1)
    assert re.fullmatch(rf"{said} \(±0\.\d+ in ξ₂\)", text)


def no():
    return False
