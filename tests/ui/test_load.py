"""Pulse or record in a browser: a pulse, a file that is chosen or dropped, units, what is wrong with a file."""

import pytest

from tests.ui.test_measurement import DROP
from tests.ui.test_peaks import cells
from tests.ui.test_studies import complete, panel
from tests.waiting import wait_until

QUERY = "?view=load&eta=1.08&K=2500&D=8&steps=2000"
RECORD = "time [s], a [g]\n" + "".join(f"{0.01 * i:.2f}, {0.1 * (-1) ** (i // 20)}\n" for i in range(100))


def said(explorer):
    return panel(explorer).locator(".statements").inner_text()


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_a_pulse_shows_both_motions_their_peaks_and_the_shock_response(kept, width, height):
    explorer = complete(kept(QUERY).resized(width, height))
    assert "They differ by 14 % of the reference" in said(explorer)
    assert "Half-sine of the acceleration of the base, peak 3; it ends at 3, the run at 28." in said(explorer)
    name, reference, penalty, off = cells(explorer, "closing speed")
    assert name == "closing speed / (Aω₁)"
    assert off == f"{'+' if float(penalty) > float(reference) else '−'}{off[1:]}"
    force = explorer.source("load_force_penalty")
    assert max(force["y"]) == pytest.approx(float(cells(explorer, "contact force")[2]), rel=1e-3)
    assert len(explorer.source("load_shock_without")["x"]) == 41


def test_a_record_is_chosen_or_dropped_and_stays_out_of_explore(kept, tmp_path):
    explorer = complete(kept(QUERY).at(units="si", omega1="10"))
    panel(explorer).locator("select").first.select_option("record")
    wait_until(lambda: "Choose the file of a record" in said(explorer), what="why there is nothing")
    file = tmp_path / "quake.csv"
    file.write_text(RECORD)
    explorer.page.set_input_files("section.study input[type=file]", file)
    wait_until(lambda: "Record of the acceleration of the base, peak 0.9807 m/s²" in said(explorer), what="the record")
    complete(explorer)
    explorer.page.evaluate(DROP, ["other.csv", RECORD.replace("0.1\n", "0.2\n")])
    wait_until(lambda: "peak 1.961 m/s²" in said(explorer), what="the record that was dropped")
    explorer.page.evaluate(DROP, ["bad.csv", "x, y, z\n1, 2, 3\n"])
    wait_until(lambda: "Line 1: columns 'x', 'y', 'z'; give one named time" in said(explorer), what="what is wrong")
    explorer.open_tab("Explore")
    assert explorer.page.locator(".measurement-card").locator("visible=true").count() == 0


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_typed_numbers_of_a_load_are_seen_whole(kept, width, height):
    explorer = kept(QUERY).open_view("load").at(units="si", omega1="158.113883").resized(width, height)
    panel(explorer).locator("select").first.select_option("sweep")
    fields = panel(explorer).locator(".numbers input:visible")
    wait_until(lambda: fields.count() == 5, what="the numbers of a sweep")
    grid = panel(explorer).locator(".numbers").evaluate("(grid) => [grid.scrollWidth, grid.clientWidth]")
    assert grid[0] <= grid[1]
    seen = fields.evaluate_all("all => all.map((each) => [each.value, each.scrollWidth, each.clientWidth])")
    assert all(value and text <= place for value, text, place in seen), seen
