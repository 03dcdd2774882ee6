"""What results look like in a session of Python: one line each, and a table in a notebook."""

import numpy as np
import pytest
from vibroscope.engine import Measurement, Newmark, Record, Reference, System, motion, run_cells, simulate, steady
from vibroscope.engine.cells import Cells
from vibroscope.engine.continuation.branch import Branch
from vibroscope.engine.continuation.point_curve import PointCurve
from vibroscope.engine.motions.search import Attractor
from vibroscope.engine.recommendation.question import Recommendation, SettingQuestion
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial
from vibroscope.engine.sweeps.basin_study import BasinDifference

SYSTEM, ETA = System(), 2.76


@pytest.fixture(scope="module")
def found():
    return motion(SYSTEM, ETA, Reference())


def test_a_run_and_its_motion(found):
    run = simulate(SYSTEM, ETA, Reference(), periods=200, keep=5, record=Record(periods=1, per_period=50))
    assert repr(run.impacts).startswith(f"Impacts({len(run.impacts)}, closing at")
    assert repr(run.trajectory).startswith(f"Trajectory({len(run.trajectory.time)} samples, tau from")
    assert repr(found).startswith("Motion(periodic, period")
    assert "impacts_per_period" in found._repr_html_()
    assert repr(Attractor(found, 0.25, np.zeros(4))).startswith("Attractor(0.25 of the starts: Motion(")
    assert repr(steady(SYSTEM, ETA, Reference())).startswith("Steady(period")


def test_studies_and_measurements():
    cells = run_cells(Cells(SYSTEM, np.array([ETA, ETA]), Reference()), transient=20, sample=4)
    assert repr(cells) == "CellResults(2 cells, 2 ok, 4 periods kept)"
    measured = Measurement(np.arange(3.0), np.zeros((2, 3)), None, "relative")
    assert repr(measured) == "Measurement(3 samples over tau = 2, relative)"
    difference = BasinDifference(np.zeros((2, 2), bool), 0.25, 0.01, np.eye(2, 3, dtype=bool))
    assert repr(difference) == "BasinDifference(25.00 ± 1.00 % of the starts; 2 and 3 motions, 2 in both)"


def test_branches_curves_and_recommendations():
    curve = PointCurve("fold", "eta", "K", 1, np.zeros((5, 2)), (), ("a", "b"))
    assert repr(curve) == "PointCurve(fold of period 1 over eta and K: 5 points, 0 meetings)"
    branch = Branch("eta", 1, np.ones(2), np.zeros((2, 4)), np.zeros((2, 4), complex), (), (), ("a", "b"))
    assert branch._repr_html_().startswith("<p>Branch(period 1 over eta")
    trial = Trial(NewmarkSetting(1000.0, 5.0, 400), 0.01, 0.02, 400.0)
    asked = SettingQuestion(SYSTEM, ETA)
    best = Recommendation(question=asked, eta=ETA, met=True, best=trial, ranges={}, front=(trial,))
    assert repr(best) == f"Recommendation({Newmark(1000.0, 5.0, 400)} for a tolerance of 0.05, met)"
    assert "error 0.02" in best._repr_html_()
