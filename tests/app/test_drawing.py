"""The PNG, SVG, PDF and script of a figure show what the page shows, and say what it is."""

import base64
import io
import re
import runpy
import threading
import xml.etree.ElementTree as ET
import zlib

import matplotlib as mpl
import numpy as np
import pytest
from bokeh.models import Range1d
from bokeh.plotting import figure
from PIL import Image
from vibroscope.app.export.drawing import Call, Drawing, Size, plot_script, write_picture
from vibroscope.app.export.formats import program
from vibroscope.app.page.explore.drawn import body_drawing
from vibroscope.app.page.shared.declared import Key, declared
from vibroscope.app.page.shared.figure import BLUE, DARK, legend, make_figure
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.take_away import TakeAway, file_writer, offered_figures

from tests.app.fakes import QueueingHost
from tests.app.filled_tabs import ADDRESS, SETTING, filled  # noqa: F401 - a fixture
from tests.share import every

PATH = "{http://www.w3.org/2000/svg}path"
LABEL = {"title": "T", "description": "D"}
KEYS = ["explore", "bifurcation", "plane", "basin", "step", "speed", "paper", "peaks", "load", "impact", "code"]
IN_KEY = dict.fromkeys(("plane_penalty", "plane_exact"), ("below 1 %", "above 100 %", "blown up"))
IN_KEY |= dict.fromkeys(("basin_reference", "basin_penalty"), ("Motion:", "motion 1 (period 1)"))
IN_KEY["bifurcation_strip"] = ("period 1", "artefact of the time step", "chaotic", "ended early")


# As the browser writes down what it has drawn; of what is none of the page's nothing is drawn.
BODIES = (
    "view_0_0_260_190*base.rail_10_6_250_6*base.plate_60_10_200_10_200_20_60_20*base.pivot_110_26_3.5*"
    "base.pivot_150_26_3.5*reference.rod_110_26_100_160*reference.rod_150_26_160_160*reference.bob_100_160_15*"
    "reference.bob_160_160_15*penalty.rod_110_26_90_160*penalty.bob_90_160_15*sun_1_2_3*base.post_nan_0_1_1*base.post_1_2_3_4_5"
)


def taken(tab, what, query="width=85&height=90&page=http://localhost/x"):
    file = file_writer(tab, f"{what}?{query}&bodies={BODIES}", SETTING, ADDRESS)()
    return base64.b64decode(file["bytes"]) if "bytes" in file else file["text"]


def words(svg):
    """The texts of an SVG, lines of one text joined."""
    return " ".join("".join(text.itertext()) for text in ET.fromstring(svg).iterfind(".//{*}text"))


def shown_in_pdf(content):
    """The Latin letters of its texts, in their order, without spaces."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, re.DOTALL)
    pages = [drawn for drawn in map(unpacked, streams) if b" Tf" in drawn]
    strings = b"".join(re.findall(rb"\(((?:[^()\\]|\\.)*)\)", b"".join(pages), re.DOTALL))
    return strings.replace(b"\0", b"").replace(b"\\", b"").replace(b" ", b"")


def unpacked(stream):
    try:
        return zlib.decompress(stream)
    except zlib.error:
        return b""


@pytest.mark.parametrize("key", every(KEYS))
def test_each_figure_is_drawn_in_each_kind_and_says_what_it_is(filled, key):  # noqa: F811
    tab = filled(key)
    names = {name: title for name, title, drawn, _ in offered_figures(tab) if drawn}
    for name, title in names.items():
        plot = tab.host.doc.get_model_by_name(name)
        svg = taken(tab, f"svg:{name}")
        root, shown = ET.fromstring(svg), words(svg)
        assert root.findtext("{*}title") == f"Vibroscope, {tab.title}: {title}"
        about = " ".join(root.find(".//{*}description").itertext())
        assert f"Made by {program()}" in about
        assert f"The page: http://localhost/x{ADDRESS}" in about
        assert key == "paper" or "η = 2.76, K = 12000, D = 18, T/Δτ = 200" in about
        if plot is not None:
            said = [axis.axis_label for axis in plot.axis if axis.visible and axis.axis_label]
            said += [plot.title.text] if plot.title.visible else []
            assert plot.title.text in about
            said += [item.label.value for legend in plot.legend for item in legend.items if item.visible]
            for text in said:
                assert text.split(" (click")[0].replace(" ", "") in shown.replace(" ", ""), name
        assert all(text in shown for text in IN_KEY.get(name, ()))
        assert len(list(root.iter(PATH))) > 5


@pytest.mark.parametrize("key", every(["explore", "plane", "bifurcation"]))
def test_png_and_pdf_have_the_size_that_was_asked_for(filled, key):  # noqa: F811
    tab = filled(key)
    for name in [name for name, _, drawn, _ in offered_figures(tab) if drawn][:2]:
        with Image.open(io.BytesIO(taken(tab, f"png:{name}", "width=85&height=70&dpi=200"))) as picture:
            assert picture.size == pytest.approx((85 / 25.4 * 200, 70 / 25.4 * 200), abs=1)
            assert picture.info["dpi"] == pytest.approx((200, 200), abs=0.1)
            assert picture.text["Title"].startswith(f"Vibroscope, {tab.title}")
            assert "η = 2.76" in picture.text["Description"]
            assert len(picture.convert("RGB").getcolors(1_000_000)) > 10
        paper = taken(tab, f"pdf:{name}", "width=85&height=70")
        [box] = re.findall(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", paper)
        assert [float(side) for side in box] == pytest.approx([85 / 25.4 * 72, 70 / 25.4 * 72], abs=0.1)
        said = f"Vibroscope, {tab.title}"
        assert said.encode() in paper or said.encode("utf-16-be") in paper
        plot = tab.host.doc.get_model_by_name(name)
        for item in plot.legend[0].items if plot and plot.legend else ():
            if item.visible and item.label.value.isascii():
                assert item.label.value.replace(" ", "").encode() in shown_in_pdf(paper)


@pytest.mark.parametrize("name", ["phase1", "force", "strip", "mechanism"])
def test_the_script_draws_the_same_picture(filled, name, tmp_path):  # noqa: F811
    tab, query = filled("explore"), "width=85&height=60&dpi=120"
    file = tmp_path / "figure.py"
    file.write_text(taken(tab, f"plot:{name}", query), encoding="utf-8")
    before = dict(mpl.rcParams)
    runpy.run_path(str(file))
    assert dict(mpl.rcParams) == before
    ours, its = (
        np.asarray(Image.open(source).convert("RGB"), int)
        for source in (io.BytesIO(taken(tab, f"png:{name}", query)), file.with_suffix(".png"))
    )
    assert ours.shape == its.shape
    assert (abs(ours - its).max(axis=2) > 40).mean() < 0.002  # numbers in the script are rounded to their digits
    assert file.with_suffix(".pdf").read_bytes().startswith(b"%PDF-")


def test_the_legend_is_below_a_figure_that_stays_as_high_as_on_the_page():
    curves = [Call("axes", "plot", ([0, 1], [0, k]), {"label": name}) for k, name in enumerate(("one", "another"))]
    heights = []
    for calls in ([], curves):
        script = plot_script("x", Drawing((300, 200), "", {"x": "time"}, calls, {}), Size(), LABEL)
        heights.append(float(re.search(r"HEIGHT, DPI = [\d.]+, ([\d.]+)", script)[1]))
    assert heights == pytest.approx([200 / 96 * 25.4, 215 / 96 * 25.4], abs=0.1)


def test_the_bodies_are_drawn_as_the_browser_has_drawn_them():
    drawing = body_drawing(BODIES, dark=False)
    kinds = [call.method for call in drawing.calls]
    assert (kinds.count("plot"), kinds.count("fill"), kinds.count("text")) == (4, 6, 2)
    first = next(call for call in drawing.calls if call.options.get("edgecolor") == BLUE)
    across, down = first.given
    assert (np.ptp(across), np.ptp(down)) == pytest.approx((30, 30), rel=1e-3)
    assert (across.mean(), down.mean()) == pytest.approx((100, 160))
    for text in ("", "view_0_0_1e99_5*reference.bob_1e99_1_1", "view_0_0_nan_5", "view_1", "*_*"):
        empty = body_drawing(text, dark=True)
        assert empty.size == (260, 190)
        assert not {"plot", "fill", "text"} & {call.method for call in empty.calls}


def line(**more):
    """A figure with one curve."""
    plot = make_figure("Curve", "time τ", "force λ", name="line", x_range=Range1d(0, 10), y_range=Range1d(0, 4))
    renderer = plot.line([0.0, 5.0, 10.0], [1.0, 2.0, 3.0], line_color=BLUE, **more)
    plot.add_layout(legend([("reference", [renderer])]))
    return plot, renderer


def slope(svg, colour):
    """The slope of the longest curve of a colour; None where there is none."""
    drawn = [each.get("d") for each in ET.fromstring(svg).iter(PATH) if f"stroke: {colour.lower()}" in str(each.attrib)]
    points = [np.array(re.findall(r"[ML] ([\d.-]+) ([\d.-]+)", path), float) for path in drawn]
    across, down = max((np.ptp(each, axis=0) for each in points), key=lambda size: size[0], default=(1.0, None))
    return None if down is None else down / across


def curve(plot, **more):
    return write_picture(declared(plot, **more), "svg", Size(100, 80), LABEL)


def test_a_zoom_a_hidden_curve_and_the_dark_page_are_in_the_file():
    plot, renderer = line()
    whole = slope(curve(plot), BLUE)
    plot.x_range.update(start=2.5, end=7.5)
    assert slope(curve(plot), BLUE) == pytest.approx(whole / 2, rel=0.02)
    dark = curve(plot, dark=True)
    assert slope(dark, DARK[BLUE]) == pytest.approx(whole / 2, rel=0.02)
    assert f"fill: {DARK['#FFFFFF'].lower()}" in dark.decode()
    assert slope(dark, BLUE) is None
    renderer.visible = False
    assert slope(curve(plot), BLUE) is None
    assert "reference" not in words(curve(plot))


def test_an_axis_in_units_has_the_numbers_of_its_unit():
    plot, _ = line()
    owned = OwnedRange(0, 10)
    plot.x_range = owned.range
    UnitAxis(owned, "x", plot).show("time t / s", 100.0)
    drawing = declared(plot)
    (call,) = [call for call in drawing.calls if call.method == "plot"]
    assert call.given[0].tolist() == [0, 500, 1000]
    assert Call("axes", "set_xlim", (0.0, 1000.0)) in drawing.calls
    assert "time t / s" in words(curve(plot))


def test_the_key_of_the_colours_stands_below_with_its_hatches():
    plot, _ = line()
    key = Key("Period", [["#BBD7EE", "one", ""], ["#009E73", "two", "lines"], ["#F5F5F5", "few", "veil"]])
    plain, keyed = curve(plot), curve(plot, key=key)
    assert "Period: one two few" in words(keyed)
    assert keyed.count(b"<pattern") - plain.count(b"<pattern") == 2
    without, higher = (write_picture(declared(plot, each), "png", Size(), LABEL) for each in (Key(), key))
    heights = [Image.open(io.BytesIO(each)).height for each in (without, higher)]
    assert heights[1] >= heights[0]


def test_a_glyph_that_no_file_can_have_is_named():
    plot = figure()
    plot.wedge(0, 0, 1, 0, 1)
    with pytest.raises(TypeError, match="no file can be made of Wedge"):
        declared(plot)


@pytest.mark.parametrize(
    ("query", "why"),
    [
        ("width=5", "width = 5: give mm from 20 to 500, or nothing for the width on the page"),
        ("height=1e9", "height = 1e9: give mm from 20 to 500"),
        ("width=nan", "width = nan: give mm"),
        ("dpi=5000", "dpi = 5000: give 50 to 1200 dots per inch, or nothing for 300"),
        ("dpi=many", "dpi = many: give 50 to 1200"),
        ("width=500&height=500&dpi=1200", "it would have 558 million pixels, and may have 20: take a smaller width"),
    ],
)
def test_a_size_out_of_its_range_is_refused_in_words(query, why, filled):  # noqa: F811
    host, view = QueueingHost(), filled("explore")
    TakeAway(host, lambda *_: None).request(f"png:force?{query}", view, SETTING, ADDRESS)
    host.catch_up()
    (error,) = host.errors
    assert error.startswith(f"This file was not written: {why}")


def test_what_the_browser_says_of_its_page_is_not_believed(filled):  # noqa: F811
    for page in ("javascript:alert(1)", 'http://x/"><script>', "http://" + "x" * 400):
        report = taken(filled("explore"), "report", f"page={page}&dark=yes")
        assert "<a href" not in report
        assert "<script" not in report


def test_files_are_drawn_one_at_a_time_in_a_style_of_their_own(monkeypatch):
    """matplotlib's style is global: what runs beside must neither change a file nor be changed."""
    drawing = Drawing((300, 200), "", {}, [Call("axes", "plot", ([0, 1], [0, 1]))], {"lines.linewidth": 3.0})
    alone = write_picture(drawing, "svg", Size(), LABEL)
    monkeypatch.setitem(mpl.rcParams, "font.size", 20.0)
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(write_picture(drawing, "svg", Size(), LABEL))) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(found) == {alone}
    assert mpl.rcParams["font.size"] == 20


def test_texts_are_shown_as_they_are():
    odd = r"a$b_2$ \alpha"
    drawing = Drawing((300, 200), odd, {"x": odd}, [Call("axes", "plot", ([0, 1], [0, 1]), {"label": odd})], {})
    assert words(write_picture(drawing, "svg", Size(), LABEL)).count("a$b_2$") == 3
    label = {"title": 'Force """', "description": "A \\ caption."}
    compile(plot_script("force", drawing, Size(), label), "script", "exec")
