"""Peaks and spectra in a browser: the table of both solutions, their spectra, units, a choice, a diverged run."""

import pytest

from tests.ui.test_studies import complete
from tests.waiting import wait_until

SETTING = "?view=peaks&eta=2.76&K=12000&D=18&steps=2000"


def cells(explorer, name):
    row = explorer.page.locator("section.branches-list tr").locator("visible=true").filter(has_text=name)
    return row.locator("td").all_inner_texts()


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_both_solutions_stand_beside_each_other_with_their_difference(kept, width, height):
    explorer = complete(kept(SETTING).resized(width, height))
    name, reference, penalty, off = cells(explorer, "penetration")
    assert name == "penetration / base amplitude"
    assert (reference, off) == ("0", "–")
    assert float(penalty) > 0
    _, reference, penalty, off = cells(explorer, "closing speed")
    exact = float(penalty) / float(reference) - 1
    assert exact > 0
    assert off.startswith("+")
    assert float(off[1:].removesuffix(" %")) == pytest.approx(100 * exact, rel=0.05)
    _, reference, penalty, off = cells(explorer, "contact force")
    assert (reference, off) == ("–", "–")  # of impacts without duration
    for picture in ("motion", "force"):
        for solver in ("reference", "penalty"):
            source = explorer.source(f"spectrum_{picture}_{solver}")
            assert len(source["order"]) == 321


def test_a_choice_draws_another_spectrum_and_stands_in_the_address(kept):
    explorer = complete(kept(SETTING))
    before = explorer.source("spectrum_motion_reference")["amplitude"]
    explorer.page.locator("select").filter(has_text="acceleration of body 2").select_option("acceleration2")
    explorer.wait_for_address(choice="quantity:acceleration2")
    wait_until(lambda: explorer.source("spectrum_motion_reference")["amplitude"] != before, what="another spectrum")
    assert "acceleration of body 2" in str(explorer.figure("spectrum_motion"))


def test_more_of_the_findings_leads_to_them(kept):
    explorer = kept(SETTING).open_view("explore").explained()
    peaks = explorer.page.get_by_role("button", name="Largest values and spectra of both")
    assert not peaks.is_visible()  # the first screen asks for little
    explorer.page.locator("details.further summary").click()
    peaks.click()
    explorer.wait_for_address(view="peaks")
    complete(explorer)
    assert float(cells(explorer, "displacement, body 1")[1]) > 1


def test_units_stand_in_the_table_and_a_run_that_ends_says_why(kept):
    explorer = complete(kept(SETTING).at(units="si"))
    wait_until(lambda: cells(explorer, "contact force")[0] == "contact force / N", what="the table with units")
    explorer.at(D="0", steps="200", beta="0")
    wait_until(lambda: cells(explorer, "closing speed")[2:] == ["–", "–"], what="the table of the other run")
    complete(explorer)
    assert explorer.source("spectrum_motion_penalty")["order"] == []
    said = explorer.page.locator("section.study").locator("visible=true").inner_text()
    assert "ended as diverged" in said
