"""Speed against error in a browser: shipped, measured for the setting, ringed, put into words, silent while hidden."""

from tests.ui.test_studies import complete, opened, panel
from tests.waiting import wait_until


def test_speed_is_measured_at_the_setting_and_again_where_it_moves_and_sends_nothing_while_hidden(visit):
    explorer = opened(visit, "speed")
    explorer.page.locator("img.figure").evaluate("async image => { await image.decode(); return image.naturalWidth; }")
    with explorer.page.context.expect_page() as figure:
        explorer.page.get_by_role("link", name="Open the figure by itself").click()
    figure.value.wait_for_load_state()
    assert figure.value.locator("svg text", has_text="Vibroscope").count() > 0
    figure.value.close()
    assert "medians of 15 runs" in explorer.figure("speed")["title"]
    ringed = explorer.source("speed_present")
    assert ringed["cost"][0] in explorer.source("speed_fixed")["cost"]
    assert ringed["cost"][1] in explorer.source("speed_plain")["cost"]
    assert "solves per period beside 2000" in panel(explorer).locator(".statements").text_content()
    explorer.moved(lambda: explorer.type("steps", "400"))
    wait_until(lambda: ": T/400 errs by" in explorer.figure("speed")["title"], what="the figure of T/400")
    complete(explorer)
    assert sorted(explorer.source("speed_located")["n"]) == [100, 200, 400, 800, 1600]
    explorer.moved(lambda: explorer.type("steps", "32000"))
    explorer.open_tab("Help")
    explorer.settle()
    received = explorer.count_messages()
    explorer.page.wait_for_timeout(1500)  # long enough for what must not come
    assert received() < 500
