"""Pictures and data of the page: every tab and scene on a desktop, what is laid out in another way on a phone.

The colours of the dark page are those of a map (`tests/app/test_colours.py`), so three of its pictures are enough.

Each is compared with its baseline (`snapshots.py`), and searched for faults (`snapshots_page.py`) and barriers (axe).
Of a desktop's views nothing is cut at other sizes of the window either (`test_sizes.py`).
"""

import hashlib
from typing import NamedTuple

import numpy as np
import pytest
from vibroscope.app.explorer.presets import scenes
from vibroscope.engine import Cells, Newmark, System, run_cells, simulate

from tests.share import every
from tests.ui.axe import AXE, serious
from tests.ui.conftest import LOOSE
from tests.ui.explorer import PHONE
from tests.ui.snapshots import FOLDER, Snapshots
from tests.ui.snapshots_page import AFRESH, data, faults, read
from tests.ui.test_sizes import SIZES, TABS, check, tried
from tests.ui.test_studies import complete
from tests.waiting import wait_until

STUDY = "eta=2.76&K=12000&D=18&steps=2000"


class View(NamedTuple):
    """One state of the page."""

    query: str
    irregular: str = ""  # columns of chaotic motions, as a pattern of "figure/source.column"
    measured: bool = False  # it shows measured times
    height: int = 900  # of a desktop window in which all of it is visible
    before: str = ""  # what Explore has explained before, which the view then says
    searches: tuple[str, ...] = ()  # heads of what the panel says of each search once it is over


# Scenes whose penalty motion is chaotic, and what else is set in two of the scenes.
SCATTERED = ("10C", "14A", "14B", "14C")
MORE = {"C": "&frame=absolute", "D": "&joint_damping=derived&coordinate=xi1"}


def of_scenes():
    """Each scene, except those that set the same numbers as an earlier one."""
    views, seen = {}, set()
    for key, scene in scenes().items():
        query = f"?eta={scene.setting.eta:g}&K={scene.setting.K:g}&D={scene.setting.D:g}&steps={scene.setting.steps}"
        if query not in seen:
            irregular = "." if key == "B" else "penalty" if key in SCATTERED else ""
            views[f"scene-{key.lower()}"] = View(query + MORE.get(key, ""), irregular)
        seen.add(query)
    return views


VIEWS = of_scenes() | {
    "units": View("?eta=1.08&K=2500&D=8&steps=2000&units=si&omega1=20&m1=3&amplitude=2.5"),
    "diverged": View("?eta=2.76&K=100000&D=100&steps=100"),
    "refused": View("?eta=nan"),
    # A system that no other test sweeps, since other directions that were computed before are drawn in grey.
    "bifurcation": View(f"?view=bifurcation&{STUDY}&d1=0.0034", r"\.value|_periods"),
    "branches": View(
        "?view=bifurcation&eta=1.42&K=12000&D=18&steps=2000&zoom=eta:1.3,1.5&choice=branches:both;count:60;transient:200",
        r"\.value|_periods",
        searches=("Branches of the reference", "Branches of the exact penalty"),
    ),
    "plane": View(f"?view=plane&{STUDY}", r"\.image|_diverged", before=f"?{STUDY}"),
    "curves": View(
        "?view=plane&eta=2&K=1000&D=5&steps=2000&zoom=K:100,10000;D:1,50&choice=curves:on",
        r"\.image|_diverged|plane_curves",
        searches=("Curves of bifurcations",),
    ),
    "basin": View("?view=basin&eta=3.2&K=12000&D=18&steps=2000", r"\.(image|motion|period)"),
    "step": View(f"?view=step&{STUDY}", r"_fixed\.(xi2|v2|size)|spread_located\.size"),
    "code": View(
        "?view=code&eta=1.08&K=2500&D=8&steps=2000&integrator=hht&status=end&without_solution=halve"
        "&choice=code:calculix",
        height=3200,
    ),
    "load": View("?view=load&eta=1.08&K=2500&D=8&steps=2000"),
    "peaks": View("?view=peaks&eta=1.08&K=2500&D=8&steps=2000"),
    "impact": View("?view=impact&eta=2.76&K=2500&D=8&steps=500"),
    "speed": View(f"?view=speed&{STUDY}", measured=True),
    "paper": View("?view=paper", r"paper(3|4B|6B|10C|11|12|13.|14[ABC])/", height=3700),
    "help": View("?view=help", height=2200),
}
DEVICES = {"desktop": {"width": 1440}, "phone": PHONE}
DARK = (("scene-a", "desktop"), ("plane", "desktop"), ("code", "phone"))
# Of what has the layout of the first scene, and of phones a share is looked at.
SCENES = [(name, "desktop") for name in VIEWS if name.startswith("scene") and name != "scene-a"]
LIKE_SCENES = [("diverged", "desktop"), ("refused", "desktop")]
ALWAYS = [(name, "desktop") for name in VIEWS if (name, "desktop") not in SCENES + LIKE_SCENES]
ALWAYS += [("scene-a", "phone"), ("code", "phone")]
SHARED = [*SCENES, *((name, "phone") for name, _ in (*ALWAYS, *LIKE_SCENES) if (name, "phone") not in ALWAYS)]
SHARED += LIKE_SCENES
LOOKS = ALWAYS + SHARED
TALLEST = 4000  # px of a picture
# η and T/Δτ of chaotic motions. The last bits of their numbers depend on the processor: the compiler decides where it
# fuses a product with a sum, and numpy has an exponential function for each kind of processor.
CHAOTIC = ((1.7, 8000), (2.76, 2000), (2.76, 4000), (2.76, 6000))


@pytest.fixture(scope="session")
def snapshots(request, browser):
    found = Snapshots(request.config.getoption("--renew-snapshots"), drawn_by(browser))
    request.config.stash[LOOSE] = found.loose
    return found


def drawn_by(browser):
    """What pictures depend on beside the page: the browser, its letters, and the last bits of chaotic numbers."""
    page = browser.new_page(device_scale_factor=1)
    page.set_content("<p style='font: 15px Arial, sans-serif'>ξ₂′ Vibroscope</p><b style='font: 13px serif'>η 2.76</b>")
    letters = page.screenshot()
    page.close()
    return {"browser": browser.version, "letters": short(letters), "numbers": short(chaotic_numbers())}


def chaotic_numbers():
    """Numbers that differ in another arithmetic: of single runs, and of cells over K and D as in the plane."""
    sections = [
        simulate(System(), eta, Newmark(stiffness=12000, damping=18, steps=steps)).section for eta, steps in CHAOTIC
    ]
    axes = (np.exp(np.linspace(*np.log(ends), 32)) for ends in ((10, 1e5), (0.1, 100)))
    K, D = (grid.ravel() for grid in np.meshgrid(*axes))
    cells = Cells(System(), np.full(K.size, 2.76), Newmark(1.0, 1.0, 2000), stiffness=K, damping=D)
    ends = run_cells(cells, transient=200, sample=20).section
    return np.concatenate([*map(np.ravel, sections), K, D, ends.ravel()])


def short(content):
    return hashlib.sha256(content).hexdigest()[:16]


def at_rest(explorer, view):
    """Wait until everything has come that comes without an action of the user."""
    page = explorer.page
    page.mouse.move(0, 0)
    if "view=paper" in view.query:
        wait_until(lambda: page.evaluate(CLAIMS_UNDER_WAY) == 0, 200, "the claims in view")
    elif "view=" not in view.query:
        explorer.until(DIAGRAM_FITS)
        explorer.explained().judged()
    elif "view=help" not in view.query:
        complete(explorer, 200)
        for head in view.searches:
            explorer.page.locator(".statements h2").filter(has_text=head).wait_for(timeout=200_000)
    explorer.settle()
    return explorer


# The picture has the size of its frame; it is drawn again when that changes.
DIAGRAM_FITS = """(() => {
  const plot = Bokeh.documents[0].get_model_by_name("diagram");
  const [height, width] = plot.renderers[0].data_source.get_column("image")[0].shape;
  return height === plot.inner_height && width === plot.inner_width;
})()"""
# Cards in view that are not answered yet; -1 while there is no card.
CLAIMS_UNDER_WAY = """() => {
  const cards = [];
  const walk = (node) => {
    if (node.matches?.("article.claim")) cards.push(node);
    for (const child of [...(node.shadowRoot?.children ?? []), ...node.children]) walk(child);
  };
  walk(document.body);
  const busy = (card) => card.getAttribute("aria-busy") === "true"
    && card.getBoundingClientRect().top < innerHeight + 120;
  return cards.length ? cards.filter(busy).length : -1;
}"""


@pytest.fixture
def look(visit):
    """Open a view and wait until it is complete; on a phone, in a window as tall as the page."""

    def open_view(name, device):
        view = VIEWS[name]
        options = {"height": view.height} | DEVICES[device]
        explorer = visit(view.before or view.query, **options)
        if view.before:
            at_rest(explorer, View(view.before)).open_view(name)
        at_rest(explorer, view)
        if device == "phone":
            high, tall = 0, options["height"]
            while high < tall:  # the height of the page grows with that of the window
                high, page = tall, explorer.page
                page.set_viewport_size({"width": options["width"], "height": high})
                at_rest(explorer, view)
                if view.measured:
                    page.evaluate(LEVEL)
                tall = min(TALLEST, page.evaluate("document.scrollingElement.scrollHeight"))
        return explorer

    return open_view


def schemes(name, device):
    return ("light", "dark") if (name, device) in DARK else ("light",)


@pytest.mark.parametrize(("name", "device"), ALWAYS + every(SHARED))
def test_a_view_equals_its_baseline_and_has_no_fault_and_nothing_is_cut_at_any_size(name, device, look, snapshots):
    view = VIEWS[name]
    explorer = look(name, device)
    page = explorer.page
    found = read(page)
    wrong = faults(found, physical=name == "units")
    wrong += snapshots.check_data(f"{name}.{device}", data(found, view.irregular, view.measured, device == "phone"))
    page.evaluate(AXE)
    for scheme in schemes(name, device):
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        explorer.settle()
        picture = steady(page, measured=view.measured)
        wrong += snapshots.check_picture(f"{name}.{device}-{scheme}", picture, bool(view.irregular))
        wrong += [f"{scheme}: {fault}" for fault in serious(page)]
    assert wrong == []
    if device == "desktop" and name in TABS and not view.measured:  # of these the words were covered
        check(explorer, tried(TABS, SIZES)[name], TABS[name])


def test_every_baseline_is_used(snapshots):
    data_files = {f"{name}.{device}.json" for name, device in LOOKS}
    pictures = {f"{name}.{device}-{scheme}.webp" for name, device in LOOKS for scheme in schemes(name, device)}
    assert snapshots.check_files(data_files | pictures) == []
    assert data_files | pictures <= {path.name for path in FOLDER.iterdir()}


COVER = "#8795a3"


def steady(page, measured=False):
    """A screenshot that is the same twice; measured times are covered."""
    chips = page.locator(".chip dd").filter(visible=True)  # what is folded has a box, too, where something else is
    options = {"animations": "disabled", "caret": "hide", "mask": [chips], "mask_color": COVER}
    # Else digits show through the edge of the mask, and their width moves what stands beside them.
    fixed = "display: inline-block; width: 40px; overflow: hidden; white-space: nowrap; color: transparent"
    page.locator(".chip dd").evaluate_all("(each, fixed) => each.forEach(dd => { dd.style.cssText = fixed; })", fixed)
    if measured:
        page.evaluate(LEVEL)
        options["mask"].append(page.locator(".bk-Figure"))
    page.evaluate(AFRESH)
    last = page.screenshot(**options)
    for _ in range(20):
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        now = page.screenshot(**options)
        if now == last:
            page.locator(".chip dd").evaluate_all("each => each.forEach(dd => dd.removeAttribute('style'))")
            return now
        last = now
    raise AssertionError("the page does not come to rest")


# Texts with measured numbers have varying lengths.
LEVEL = """() => {
  const walk = (node) => {
    if (node.matches?.(".statements p")) node.textContent = "measured";
    for (const child of [...(node.shadowRoot?.children ?? []), ...node.children]) walk(child);
  };
  walk(document.body);
}"""
