"""The page as it looks and as it is built: every tab and scene, on a desk and on a phone, light and dark.

Each is held against its baseline (`snapshots.py`), searched for what is wrong whoever looks (`snapshots_page.py`), and
for what shuts people out (axe).
"""

import hashlib
import io
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image
from vibroscope.app.explorer.scenes import scenes
from vibroscope.engine import Newmark, System, simulate

from . import snapshots as module
from .conftest import wait_until
from .snapshots import FOLDER, Snapshots, compare
from .snapshots_page import AFRESH, data, faults, read
from .snapshots_report import Report
from .test_page import AXE, serious
from .test_studies import complete

STUDY = "eta=2.76&K=12000&D=18&steps=2000"


class View(NamedTuple):
    """What is looked at."""

    query: str
    irregular: str = ""  # columns that a chaotic motion decides, as a pattern of "figure/source.column"
    measured: bool = False  # it shows times
    height: int = 900  # of a window on a desk that shows all there is to compare


# Scenes whose penalty motion the last bit of K decides, and how two of the scenes are looked at.
SCATTERED = ("10C", "14A", "14B", "14C")
MORE = {"C": "&frame=absolute", "D": "&joint_damping=derived&coordinate=xi1"}


def of_scenes():
    """Each scene but those that set what another has set before."""
    views, seen = {}, set()
    for key, scene in scenes().items():
        query = f"?eta={scene.eta:g}&K={scene.K:g}&D={scene.D:g}&steps={scene.steps}"
        if query not in seen:
            irregular = "." if key == "B" else "penalty" if key in SCATTERED else ""
            views[f"scene-{key.lower()}"] = View(query + MORE.get(key, ""), irregular)
        seen.add(query)
    return views


VIEWS = of_scenes() | {
    "units": View("?eta=1.08&K=2500&D=8&steps=2000&units=physical&omega1=20&m1=3&amplitude=2.5"),
    "diverged": View("?eta=2.76&K=100000&D=100&steps=100"),
    "refused": View("?eta=nan"),
    # A system that no other test sweeps: the other directions, once computed, are drawn in grey.
    "bifurcation": View(f"?tab=bifurcation&{STUDY}&d1=0.0034", r"\.value|_periods"),
    "plane": View(f"?tab=plane&{STUDY}", r"\.image|_diverged"),
    "step": View(f"?tab=step&{STUDY}", r"_fixed\.(xi2|v2|size)|spread_located\.size"),
    "speed": View(f"?tab=speed&{STUDY}", measured=True),
    "paper": View("?tab=paper", r"paper(3|4B|6B|10C|11|12|13.|14[ABC])/", height=3700),
    "help": View("?tab=help", height=2200),
}
DEVICES = {"desk": {"width": 1440}, "phone": {"width": 390, "height": 844, "has_touch": True, "is_mobile": True}}
SCHEMES = ("light", "dark")
TALLEST = 4000  # px of a picture
# η and T/Δτ. Products are fused with sums as the compiler sees fit: another processor, or kernels compiled in another
# order, give other last bits.
CHAOTIC = ((1.7, 8000), (2.76, 2000), (2.76, 4000), (2.76, 6000))


@pytest.fixture(scope="session")
def snapshots(request, browser):
    return Snapshots(request.config.getoption("--renew-snapshots"), drawn_by(browser))


def drawn_by(browser):
    """What pictures depend on beside the page: the browser, its letters, and the last bits of chaotic numbers."""
    page = browser.new_page(device_scale_factor=1)
    page.set_content("<p style='font: 15px Arial, sans-serif'>ξ₂′ Vibroscope</p><b style='font: 13px serif'>η 2.76</b>")
    letters = page.screenshot()
    page.close()
    sections = [
        simulate(System(), eta, Newmark(stiffness=12000, damping=18, steps=steps)).section for eta, steps in CHAOTIC
    ]
    return {"browser": browser.version, "letters": short(letters), "numbers": short(np.concatenate(sections))}


def short(content):
    return hashlib.sha256(content).hexdigest()[:16]


def at_rest(explorer, view):
    """Wait until all is there that comes by itself."""
    page = explorer.page
    page.mouse.move(0, 0)
    if "tab=paper" in view.query:
        for _ in range(2):  # cards ask when they are seen, and those above them grow as they are answered
            page.wait_for_timeout(400)
            wait_until(lambda: page.evaluate(SEEN_AND_OPEN) == 0, 200, "the claims in view")
    elif "tab=" not in view.query:
        explorer.until(DIAGRAM_FITS, 120)
        explorer.explained()
    elif "tab=help" not in view.query:
        complete(explorer, 200)
    explorer.settle()
    return explorer


# It is drawn anew for each size of its frame.
DIAGRAM_FITS = """(() => {
  const plot = Bokeh.documents[0].get_model_by_name("diagram");
  const [height, width] = plot.renderers[0].data_source.get_column("image")[0].shape;
  return height === plot.inner_height && width === plot.inner_width;
})()"""
SEEN_AND_OPEN = """() => {
  const found = [];
  const walk = (node) => {
    if (node.matches?.("article.claim") && node.getAttribute("aria-busy") === "true"
        && node.getBoundingClientRect().top < innerHeight + 120) found.push(node);
    for (const child of [...(node.shadowRoot?.children ?? []), ...node.children]) walk(child);
  };
  walk(document.body);
  return found.length;
}"""


@pytest.fixture
def look(visit):
    """Open a view with all that comes by itself; on a phone, in a window as tall as the page."""

    def open_view(name, device):
        view = VIEWS[name]
        options = {"height": view.height} | DEVICES[device]
        explorer = at_rest(visit(view.query, **options), view)
        if device == "phone":
            high, tall = 0, options["height"]
            while high < tall:  # in a higher window the panel of the sliders is higher, and so is the page
                high, page = tall, explorer.page
                page.set_viewport_size({"width": options["width"], "height": high})
                at_rest(explorer, view)
                if view.measured:
                    page.evaluate(LEVEL)
                tall = min(TALLEST, page.evaluate("document.scrollingElement.scrollHeight"))
        return explorer

    return open_view


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", VIEWS)
def test_it_looks_as_it_did_and_nothing_is_wrong(name, device, look, snapshots):
    view = VIEWS[name]
    explorer = look(name, device)
    page = explorer.page
    found = read(page)
    wrong = faults(found, physical=name == "units")
    wrong += snapshots.check_data(f"{name}.{device}", data(found, view.irregular, view.measured, device == "phone"))
    page.evaluate(AXE)
    for scheme in SCHEMES:
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        explorer.settle()
        picture = steady(page, measured=view.measured)
        wrong += snapshots.check_picture(f"{name}.{device}-{scheme}", picture, bool(view.irregular))
        wrong += [f"{scheme}: {fault}" for fault in serious(page)]
    assert wrong == []


def test_every_baseline_is_asked_for(snapshots):
    data_files = {f"{name}.{device}.json" for name in VIEWS for device in DEVICES}
    pictures = {f"{name}.{device}-{scheme}.webp" for name in VIEWS for device in DEVICES for scheme in SCHEMES}
    assert snapshots.check_files(data_files | pictures) == []
    assert data_files | pictures <= {path.name for path in FOLDER.iterdir()}


def steady(page, measured=False):
    """A screenshot that comes out the same twice; times are greyed out."""
    options = {"animations": "disabled", "caret": "hide", "mask": [page.locator(".chip dd")], "mask_color": "#8795a3"}
    if measured:
        page.evaluate(LEVEL)
        options["mask"].append(page.locator(".bk-Figure"))
    page.evaluate(AFRESH)
    last = page.screenshot(**options)
    for _ in range(20):
        page.wait_for_timeout(100)
        now = page.screenshot(**options)
        if now == last:
            return now
        last = now
    raise AssertionError("the page does not come to rest")


# Measured numbers are of unequal length, and so are the lines that hold them.
LEVEL = """() => {
  const walk = (node) => {
    if (node.matches?.(".statements p")) node.textContent = "measured";
    for (const child of [...(node.shadowRoot?.children ?? []), ...node.children]) walk(child);
  };
  walk(document.body);
}"""


# -- each fault, once ----------------------------------------------------------

FIGURE = "const plot = Bokeh.documents[0].get_model_by_name('displacement'); const here = {sync: false};"
BREAKS = {  # what is said: how it is brought about, how it is mended
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
        "window.kept = plot.title.text; plot.title.setv({text: 'displacements '.repeat(30)}, here)",
        "plot.title.setv({text: window.kept}, here)",
    ),
}


def test_an_empty_figure_a_lost_unit_and_texts_over_each_other_are_found(look):
    explorer = look("units", "desk")
    page = explorer.page
    assert faults(read(page), physical=True) == []
    before = data(read(page))
    for said, (broken, mended) in BREAKS.items():
        page.evaluate(f"{{ {FIGURE} {broken} }}")
        explorer.settle()
        found = read(page)
        told = faults(found, physical=True)
        assert any(said in fault for fault in told), (said, told)
        page.evaluate(f"{{ {FIGURE} {mended} }}")
        explorer.settle()
        assert faults(read(page), physical=True) == [], said
    assert list(compare(before, data(read(page)))) == []
    page.evaluate(
        "() => document.querySelector('body').append(Object.assign(document.createElement('p'), "
        "{textContent: 'in the way', style: 'position: fixed; margin: 0; top: 14px; left: 20px'}))"
    )
    assert any("in the way" in fault for fault in faults(read(page), physical=True))


# -- the comparison itself -----------------------------------------------------

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


def test_one_shade_fails_where_all_is_the_same_and_passes_elsewhere(folder):
    Snapshots(True, HERE).check_picture("x", picture((200, 0, 0)))
    assert Snapshots(False, HERE).check_picture("x", picture((200, 0, 0))) == []
    assert "200 pixels differ, by up to 1" in Snapshots(False, HERE).check_picture("x", picture((201, 0, 0)))[0]
    for other in ({"browser": "2"}, {"letters": "b"}):
        elsewhere = Snapshots(False, HERE | other)
        assert elsewhere.check_picture("x", picture((202, 0, 0))) == []
        assert "pixels differ" in elsewhere.check_picture("x", picture((0, 200, 0)))[0]
    arithmetic = Snapshots(False, HERE | {"numbers": "1"})
    assert arithmetic.check_picture("x", picture((201, 0, 0))) != []
    assert arithmetic.check_picture("x", picture((201, 0, 0)), irregular=True) == []


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
