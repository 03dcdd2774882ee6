"""The tools of the snapshots: each fault of a page is found, and each difference from a baseline."""

import io

import numpy as np
import pytest
from PIL import Image

from tests.ui import snapshots as module
from tests.ui.snapshots import Snapshots, compare, opened
from tests.ui.snapshots_page import data, faults, read
from tests.ui.snapshots_report import Report
from tests.ui.test_snapshots import (
    COVER,
    look,  # noqa: F401 - a fixture
    steady,
)

FIGURE = "const plot = Bokeh.documents[0].get_model_by_name('displacement'); const here = {sync: false};"
BREAKS = {  # the reported fault: code that causes it, code that removes it
    "displacement has no data": (
        "window.kept = plot.renderers.filter(({visible}) => visible); "
        "for (const one of kept) one.setv({visible: false}, here)",
        "for (const one of kept) one.setv({visible: true}, here)",
    ),
    "displacement is empty: its data add": (
        "plot.y_range.setv({start: 1e6, end: 2e6}, here)",
        "plot.y_range.setv({start: -8, end: 6}, here)",
    ),
    "displacement has an axis without a label": (
        "window.kept = plot.left[0].axis_label; plot.left[0].setv({axis_label: null}, here)",
        "plot.left[0].setv({axis_label: window.kept}, here)",
    ),
    "displacement has an axis without a unit: 'x'": (
        "plot.left[0].setv({axis_label: 'x'}, here)",
        "plot.left[0].setv({axis_label: window.kept}, here)",
    ),
    "lie over each other": (
        "plot.below[0].setv({axis_label_standoff: -14}, here)",
        "plot.below[0].setv({axis_label_standoff: 3}, here)",
    ),
    "cut off": (
        "window.kept = plot.title.text; plot.title.setv({text: 'displacements'.repeat(30)}, here)",
        "plot.title.setv({text: window.kept}, here)",
    ),
}


def test_measured_times_are_covered_where_they_stand_and_nothing_while_they_are_folded(look):  # noqa: F811
    page = look("scene-a", "phone").page
    assert covered(page) == 0
    page.locator("details.further summary").click()
    shown = page.locator(".chip dd").filter(visible=True)
    assert covered(page) == pytest.approx(40 * shown.first.bounding_box()["height"] * shown.count(), rel=0.1)


def covered(page):
    """Pixels of the cover, in rows of at least ten."""
    picture = np.array(opened(steady(page)), int)
    grey = (picture == [int(COVER[i : i + 2], 16) for i in (1, 3, 5)]).all(axis=2)
    return int(sum(row.sum() for row in grey if row.sum() >= 10))


def test_an_empty_figure_a_lost_unit_and_texts_over_each_other_are_found(look):  # noqa: F811
    explorer = look("units", "desktop")
    page = explorer.page
    assert faults(read(page), physical=True) == []
    before = data(read(page))
    for fault, (broken, mended) in BREAKS.items():
        page.evaluate(f"{{ {FIGURE} {broken} }}")
        explorer.settle()
        found = read(page)
        reported = faults(found, physical=True)
        assert any(fault in line for line in reported), (fault, reported)
        page.evaluate(f"{{ {FIGURE} {mended} }}")
        explorer.settle()
        assert faults(read(page), physical=True) == [], fault
    assert list(compare(before, data(read(page)))) == []
    page.evaluate(
        "() => document.querySelector('body').append(Object.assign(document.createElement('p'), "
        "{textContent: 'in the way', style: 'position: fixed; margin: 0; top: 14px; left: 20px'}))"
    )
    assert any("in the way" in line for line in faults(read(page), physical=True))


HERE = {"browser": "1", "letters": "a", "numbers": "0"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "FOLDER", tmp_path / "tests" / "snapshots")
    monkeypatch.setattr(module, "REPORT", Report(tmp_path / "tests" / "results" / "index.html"))
    module.FOLDER.mkdir(parents=True)
    return module.FOLDER


def picture(colour):
    buffer = io.BytesIO()
    Image.new("RGB", (20, 10), colour).save(buffer, "PNG")
    return buffer.getvalue()


def test_a_missing_and_an_outdated_baseline_fail(folder):
    assert "no baseline x.json" in Snapshots(False, HERE).check_data("x", {"a": 1})[0]
    assert "no baseline x.webp" in Snapshots(False, HERE).check_picture("x", picture("red"))[0]
    Snapshots(True, HERE).check_picture("old", picture("red"))
    assert "no test asks for old.webp" in Snapshots(False, HERE).check_files({"x.webp"})[0]
    Snapshots(True, HERE).check_files({"x.webp"})
    assert Snapshots(False, HERE).check_files({"x.webp"}) == []


def test_a_picture_must_be_equal_where_browser_letters_and_arithmetic_are_and_similar_elsewhere(folder):
    Snapshots(True, HERE).check_picture("x", picture((200, 0, 0)))
    assert Snapshots(False, HERE).check_picture("x", picture((200, 0, 0))) == []
    assert "200 pixels differ, by up to 1" in Snapshots(False, HERE).check_picture("x", picture((201, 0, 0)))[0]
    for other in ({"browser": "2"}, {"letters": "b"}):
        elsewhere = Snapshots(False, HERE | other)
        assert elsewhere.check_picture("x", picture((202, 0, 0))) == []
        assert "pixels differ" in elsewhere.check_picture("x", picture((0, 200, 0)))[0]
        assert elsewhere.loose == ["x", "x"]
    arithmetic = Snapshots(False, HERE | {"numbers": "1"})
    assert arithmetic.check_picture("x", picture((201, 0, 0))) != []
    assert arithmetic.loose == []
    assert arithmetic.check_picture("x", picture((201, 0, 0)), irregular=True) == []
    assert arithmetic.loose == ["x"]


def test_what_differs_is_shown_in_one_file(folder):
    renewing, comparing = Snapshots(True, HERE), Snapshots(False, HERE)
    renewing.check_picture("x", picture("red"))
    renewing.check_data("y", {"labels": ["x / mm"], "box": [1, 2]})
    assert "tests/results/index.html#x" in comparing.check_picture("x", picture("blue"))[0]
    assert ".labels[0]: was 'x / mm', is 'x'" in comparing.check_data("y", {"labels": ["x"], "box": [1, 2]})[0]
    shown = (folder.parent / "results" / "index.html").read_text()
    assert all(title in shown for title in ("was", "is", "difference"))
    assert shown.count("<section") == 2


def test_data_that_changed_are_named():
    old = {"axes": ["λ"], "box": [10, 20], "t": [1.0, 2.0]}
    assert list(compare(old, old | {"axes": [""]})) != []
    assert list(compare(old, old | {"t": []})) != []
    assert list(compare(old, old | {"t": [1.0, 2.1]})) != []
    assert list(compare(old, old | {"t": [1.0, 2.0001]})) == []
    assert list(compare(old, old | {"box": [11, 20]})) != []
    assert list(compare(old, old | {"box": [11, 20]}, loose=4)) == []
