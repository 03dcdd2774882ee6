"""The present instant: its marks in all figures, and the animation."""

import re

import pytest
from vibroscope.app.explorer.link import print_address
from vibroscope.app.explorer.presets import shelf

from tests.ui.explorer import PAPER
from tests.waiting import wait_until


def mark(explorer, name):
    """Position of a mark of the present instant: in the data of its figure, and on the page."""
    return explorer.page.locator(f"[data-mark={name}]").evaluate("""element => {
        const { left, top } = element.getBoundingClientRect();
        return { x: Number(element.dataset.x), y: Number(element.dataset.y), left, top };
    }""")


def test_marks_follow_a_zoom_and_leave_with_it(kept):
    explorer = kept(PAPER)
    at = {n: mark(explorer, f"reference{n}") for n in "12"}
    for n in "12":
        box = explorer.figure(f"phase{n}")
        (x0, x1), (y0, y1), frame = box["x"], box["y"], box["frame"]
        assert abs(at[n]["left"] + 5.5 - frame["x"] - frame["width"] * (at[n]["x"] - x0) / (x1 - x0)) < 1
        assert abs(at[n]["top"] + 5.5 - frame["y"] - frame["height"] * (y1 - at[n]["y"]) / (y1 - y0)) < 1
    explorer.zoom("displacement", 0.5, 0.9, 0.3, 0.9)  # below the legend
    line = explorer.page.locator("[data-mark=now-displacement]")
    assert line.is_visible()  # where the pointer was last
    explorer.page.locator(".player input").fill("0")
    wait_until(lambda: not line.is_visible(), what="the line at τ = 0 gone from a view that begins later")


def test_a_time_under_the_pointer_is_marked_in_every_figure(kept):
    explorer = kept()
    frame = explorer.figure("force")["frame"]
    explorer.page.mouse.move(frame["x"] + 0.25 * frame["width"], frame["y"] + 0.5 * frame["height"])
    wait_until(lambda: abs(mark(explorer, "now-displacement")["x"] - 0.5) < 0.005, what="a mark at half a period")
    line = mark(explorer, "now-displacement")
    time = line["x"]
    for name in ("strip", "force"):
        assert mark(explorer, f"now-{name}") == line | {"top": mark(explorer, f"now-{name}")["top"]}
    assert abs(line["left"] - (frame["x"] + 0.25 * frame["width"])) < 2
    columns = explorer.source("displacements")
    nearest = min(range(len(columns["t"])), key=lambda i: abs(columns["t"][i] - time))
    for solver in ("reference", "penalty"):
        for n in "12":
            state = mark(explorer, f"{solver}{n}")
            assert abs(state["x"] - columns[f"{solver}{n}"][nearest]) < 0.05
            assert abs(state["y"] - columns[f"{solver}_v{n}"][nearest]) < 0.1
    assert explorer.page.locator(".readout").text_content() == f"time {time:.3f} T"
    explorer.page.mouse.move(5, 5)
    explorer.settle()
    relative = mark(explorer, "reference1")["x"]
    explorer.unfold("Display")
    explorer.moved(lambda: explorer.page.get_by_text("absolute", exact=True).click())
    wait_until(lambda: explorer.page.evaluate("Bokeh.documents[0].is_idle"))
    assert abs(mark(explorer, "reference1")["x"] - relative) < 1e-3  # to the base, although the curves are not


def test_of_a_free_vibration_the_instant_goes_through_all_periods_to_the_second_contact(kept):
    """Where a period is short beside a flight."""
    thrown = shelf()["thrown"].setting
    short = thrown._replace(eta=4 * thrown.eta, units="none")
    explorer = kept.anew(f"?{print_address(short)}").explained()
    window = int(re.search(r"in the first (\d+) periods T", explorer.page.locator(".lines").text_content())[1])
    assert window > 2
    assert explorer.figure("displacement")["x"] == [0, window]
    slider = explorer.page.get_by_label("Phase τ/T in the periods that are shown")
    wait_until(lambda: slider.get_attribute("max") == str(window), what="a slider over the window")
    slider.fill(str(window - 0.5))
    wait_until(lambda: mark(explorer, "now-force")["x"] == pytest.approx(window - 0.5), what="a mark near the end")
    columns = explorer.source("displacements")
    nearest = min(range(len(columns["t"])), key=lambda i: abs(columns["t"][i] - (window - 0.5)))
    assert mark(explorer, "reference1")["x"] == pytest.approx(columns["reference1"][nearest], rel=0.01)
    explorer.moved(lambda: explorer.scene("A"))
    wait_until(lambda: slider.get_attribute("max") == "2", what="a slider over two periods")
    assert explorer.figure("displacement")["x"] == [0, 2]


def test_playing_moves_the_pendulums_without_the_server(visit):
    explorer = visit()  # where no phase waits to be sent
    sent = explorer.keep_sent()
    bob = explorer.page.locator(".reference .bob").first
    before = bob.get_attribute("cx")
    explorer.page.get_by_role("button", name="Play").click()
    wait_until(lambda: bob.get_attribute("cx") != before, what="motion")
    wait_until(lambda: mark(explorer, "now-force")["x"] > 0.05, what="a line that moves along")
    assert sent() == []
    explorer.page.get_by_role("button", name="Pause").click()  # the link then holds the phase


FRAMES = """(player, speed) => {
  const [button, select, slider] = ["button", "select", "input"].map((name) => player.querySelector(name));
  const ask = requestAnimationFrame, waiting = [];
  window.requestAnimationFrame = (act) => waiting.push(act);
  select.value = speed;
  button.click();
  const before = Number(slider.value);
  for (const now of [1000, 1050, 1100, 1150, 1200]) waiting.splice(0).forEach((act) => act(now));
  button.click();
  waiting.splice(0).forEach((act) => act(1250)); // so that no frame is waited for any more
  window.requestAnimationFrame = ask;
  return Number(slider.value) - before;
}"""


def test_an_impact_flashes_at_once_and_the_speed_is_the_chosen_one_and_the_link_holds_the_phase(kept, visit):
    explorer = kept(PAPER)
    page, slider = explorer.page, explorer.page.locator(".player input")
    flash = page.locator(".mechanism .reference .flash")
    strip, period = explorer.source("strip_reference"), explorer.source("displacements")["t"][-1] / 2
    begins, ends = strip["left"][0] / period, strip["right"][0] / period
    later = min(left for left in [*strip["left"], 2 * period] if left > strip["left"][0]) / period
    for time, low, high in ((begins + 0.006, 0.7, 1), ((ends + later) / 2, 0, 0.4), (later - 0.006, 0, 0.1)):
        slider.fill(str(round(time / 0.005) * 0.005))
        assert low <= float(flash.get_attribute("opacity")) <= high, (time, begins, ends, later)
    speeds = page.locator(".player select option").evaluate_all("all => all.map((one) => one.value)")
    for speed in speeds:
        slider.fill("0.1")
        assert abs(page.locator(".player").evaluate(FRAMES, speed) - 0.2 * float(speed)) < 0.006, speed
    slider.fill("0.35")
    wait_until(lambda: "choice=phase:0.35" in explorer.query(), what="the phase in the address")
    again = visit(explorer.query())
    assert again.page.locator(".readout").text_content() == "time 0.350 T"
    again.page.get_by_role("button", name="Play").click()
    wait_until(lambda: "phase" not in again.query(), what="no phase while the pendulums swing")


RAW = """(places) => {
  const { el, canvas_view } = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("force").id);
  const { left, top, width, height } = canvas_view.el.getBoundingClientRect();
  const line = canvas_view.overlays_el.querySelector("[data-mark=now-force]");
  return places.map(([type, share]) => {
    el.dispatchEvent(new PointerEvent(type, { clientX: left + share * width, clientY: top + height / 2 }));
    return line.dataset.x;
  });
}"""


def test_a_move_is_marked_ahead_of_its_frame_and_the_last_one_of_the_frame_in_it(kept):
    """The browser holds "pointermove" back until it begins a frame."""
    explorer = kept()
    early, same, skipped, last = explorer.page.evaluate(
        RAW, [("pointerrawupdate", 0.4), ("pointermove", 0.4), ("pointerrawupdate", 0.5), ("pointermove", 0.6)]
    )
    assert early == same == skipped != last
    assert abs(float(early) - 2 * 0.4) < 0.3
    assert float(last) > float(early) + 0.2


def test_the_instant_that_was_pointed_at_stays_and_is_in_the_link(kept):
    explorer = kept.anew("?eta=2.76&K=12000&D=18&steps=8000")
    frame = explorer.figure("force")["frame"]
    explorer.page.mouse.move(frame["x"] + 0.25 * frame["width"], frame["y"] + 20)
    explorer.page.mouse.move(5, 5)
    assert explorer.page.locator(".readout").text_content().startswith("time 0.5")
    wait_until(lambda: explorer.address().get("choice", "").startswith("phase:0.5"), what="the phase in the link")


@pytest.mark.parametrize(
    ("system", "drawn"),
    [("bodies=two", [True, True]), ("bodies=two&spring1=0", [False, True]), ("bodies=two&kappa=0", [True, False])],
)
def test_a_body_without_a_spring_is_drawn_without_one(kept, system, drawn):
    page = kept.anew(f"?{system}").page
    rods = page.locator(".mechanism .reference .rod")
    assert [rods.nth(i).is_visible() for i in range(rods.count())] == drawn
