"""A first start, in a browser: the solvers are not compiled, and the page shows a figure all the same."""

import time

from tests.served import Served
from tests.ui.explorer import Explorer


def test_a_first_start_shows_the_shipped_result_before_the_solvers_are_compiled_and_a_bar(browser, tmp_path):
    server = Served(tmp_path / "log", VIBROSCOPE_CACHE_DIR=str(tmp_path / "empty")).wait()
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    try:
        explorer = Explorer(page, server.url).open()
        assert len(explorer.source("displacements")["t"]) > 100
        assert "computing" not in explorer.line("verdict")
        assert page.get_by_text("Shipped result", exact=True).is_visible()
        line = page.locator(".compiling")
        assert "the solvers are being compiled" in line.text_content()
        assert 0 <= line.locator("progress").evaluate("bar => bar.value") < 1
        explorer.type("K", "1000")  # waits for the solvers, and says so
        page.get_by_text("computing …", exact=True).first.wait_for()
        assert page.get_by_text("Shipped result", exact=True).is_visible()
        assert explorer.complaints == []
    finally:
        page.close()
        begin = time.monotonic()
        assert server.stop() == 0
        assert time.monotonic() - begin < 30  # what waits for the compilation holds nobody up
    assert "compiling what=reference" in server.log.read_text()
