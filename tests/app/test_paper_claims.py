"""The paper's claims: each check finds what is known, and fails where the claim does not hold."""

import json
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.page.paper.figures import draw
from vibroscope.app.paper import CLAIMS, as_dict, plane_claims, reference_claims
from vibroscope.app.paper.claims import SYSTEM, VISIBLE_SCATTER, is_cancelled, section_size
from vibroscope.engine import Cancelled, ExactPenalty, Newmark, Reference, simulate


@pytest.fixture(scope="module")
def findings():
    return {key: claim.find() for key, claim in CLAIMS.items()}


def test_every_figure_that_shows_a_result_is_remade():
    assert {claim.figure for claim in CLAIMS.values()} == {3, 4, 6, *range(9, 15)}
    assert list(CLAIMS)[:5] == ["3", "4A", "4B", "4C", "4D"]


@pytest.mark.parametrize("key", CLAIMS)
def test_a_claim_is_as_known(findings, key):
    finding = findings[key]
    assert finding.agrees == CLAIMS[key].holds, finding.result
    assert finding.result
    assert finding.agrees or finding.reason


def test_every_finding_is_json(findings):
    rows = [as_dict(CLAIMS[key], finding) for key, finding in findings.items()]
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows


@pytest.mark.parametrize("key", CLAIMS)
def test_a_finding_is_drawn(findings, key):
    plot = draw(findings[key].picture, f"paper{key}")
    assert plot.name == f"paper{key}"
    assert plot.renderers
    assert plot.x_range.start < plot.x_range.end
    assert plot.y_range.start < plot.y_range.end


@pytest.mark.parametrize(
    ("key", "scene"),
    [
        ("4A", "C"),
        ("4C", "A"),
        ("4D", "C"),
        ("6A", "C"),
        ("6B", "A"),
        ("9A", "9B"),
        ("9B", "9A"),
        ("10A", "10B"),
        ("10B", "10A"),
        ("13A", "10B"),
        ("13B", "14A"),
        ("14A", "10B"),
    ],
)
def test_a_check_fails_where_the_claim_does_not_hold(key, scene):
    assert not CLAIMS[key].check(scenes()[scene].setting).agrees


def test_the_check_of_the_step_agrees_where_the_step_does_no_harm():
    assert CLAIMS["14D"].check(scenes()["10B"].setting).agrees


def test_a_diagram_without_irregular_motion_does_not_agree(monkeypatch):
    true = reference_claims.diagram(SYSTEM, Reference())
    flat = replace(true, displacement=true.displacement[:, :, :1].repeat(50, axis=2))
    monkeypatch.setattr(reference_claims, "diagram", lambda *_: flat)
    assert not CLAIMS["3"].find().agrees


@pytest.mark.parametrize(
    ("key", "change"), [("11", {"regular": True}), ("12", {"steps": 99.0}), ("12", {"steps": 9.0})]
)
def test_planes_of_one_kind_do_not_agree(monkeypatch, key, change):
    cells = plane_claims.plane_cells()
    alike = {name: np.full_like(getattr(cells, name), value) for name, value in change.items()}
    monkeypatch.setattr(plane_claims, "plane_cells", lambda: cells._replace(**alike))
    assert not CLAIMS[key].find().agrees


def test_cells_of_the_planes_are_what_single_runs_are(findings):
    regions, sudden = findings["11"].picture, findings["12"].picture
    rng = np.random.default_rng(1)
    for row, column in zip(rng.integers(0, 19, 12), rng.integers(0, 22, 12), strict=True):
        K, D = regions.stiffness[column], regions.damping[row]
        free = simulate(SYSTEM, 2.76, ExactPenalty(K, D))
        stepped = simulate(SYSTEM, 2.76, Newmark(K, D, 2000))
        spread = [run.section[:, 2].std() / section_size(run.section) for run in (free, stepped)]
        longest = np.diff(stepped.contacts, axis=1).max() / stepped.period * 2000
        wanted = 0 if spread[0] > VISIBLE_SCATTER else 1 if spread[1] > VISIBLE_SCATTER else 2
        assert regions.kind[row, column] == wanted
        assert sudden.kind[row, column] == (0 if spread[0] > VISIBLE_SCATTER else 2 if round(longest, 6) < 30 else 1)


def test_an_example_of_ours_does_not_count_as_agreeing():
    assert [key for key, claim in CLAIMS.items() if claim.example] == ["10A", "10B", "10C", "13A", "13B"]
    finding = CLAIMS["10B"].find()
    row = as_dict(CLAIMS["10B"], finding)
    assert (row["verdict"], row["agrees"], row["known_to_agree"]) == ("shown by example", False, False)
    assert CLAIMS["10B"].verdict(replace(finding, agrees=False)) == "differs"


def test_the_planes_can_be_cancelled():
    token = is_cancelled.set(lambda: True)
    try:
        with pytest.raises(Cancelled):
            plane_claims.plane_cells.__wrapped__()  # another test may have left its result
    finally:
        is_cancelled.reset(token)
