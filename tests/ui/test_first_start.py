"""A first start, in a browser: the solvers are not compiled, and the page shows a figure all the same, at once."""

import time

from tests.served import Served

from .explorer import Explorer

WITHIN = 3.0  # s from the command to the first figure, on a machine that does nothing else


def first_figure(browser, log, **settings):
    """Start a server, open its page, and return both with the seconds that it took; the caller stops the server."""
    begin = time.monotonic()
    server = Served(log, **settings).wait()
    explorer = Explorer(browser.new_page(viewport={"width": 1440, "height": 900}), server.url).open()
    return server, explorer, time.monotonic() - begin


def test_a_first_start_shows_the_shipped_result_at_once_and_a_bar(browser, tmp_path):
    server, explorer, seconds = first_figure(browser, tmp_path / "log", VIBROSCOPE_CACHE_DIR=str(tmp_path / "empty"))
    try:
        page = explorer.page
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
        explorer.page.close()
        begin = time.monotonic()
        assert server.stop() == 0
        assert time.monotonic() - begin < 10  # what waits for the compilation holds nobody up
    assert "compiling what=reference" in server.log.read_text()
    if seconds > WITHIN:  # a busy machine: then about as soon as where everything is compiled
        server, explorer, usual = first_figure(browser, tmp_path / "log")
        explorer.page.close()
        server.stop()
        assert seconds < 3 * usual, (seconds, usual)
