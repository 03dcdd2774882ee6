"""A visitor whose session is refused reads why; the page is never empty."""

import pytest

from tests.served import served
from tests.waiting import wait_until


@pytest.fixture(scope="module")
def narrow(tmp_path_factory):
    """A server with room for one."""
    with served(tmp_path_factory.mktemp("narrow") / "log.txt", VIBROSCOPE_SESSIONS="1") as server:
        yield server


@pytest.fixture
def page(browser):
    context = browser.new_context()
    yield context.new_page()
    context.close()


def message(page):
    alert = page.get_by_role("alert")
    alert.wait_for()
    assert page.get_by_role("link", name="Load the page again").is_visible()
    return alert.inner_text()


def test_the_page_says_that_the_server_is_full(narrow, page):
    held = []
    page.add_init_script("""window.WebSocket = class extends WebSocket {
      constructor(...given) { if (!window.Bokeh) throw Error("not before the scripts"); super(...given); } };""")
    page.route("**/bokeh.min.js*", lambda route: held.append(route))
    with page.expect_request("**/bokeh.min.js*"):
        page.goto(narrow.url, wait_until="commit")  # there is room when the page is requested
    first = page.context.new_page()
    first.goto(narrow.url)
    first.locator("form.panel").wait_for(state="attached")
    held[0].continue_()
    assert "as many sessions as it can" in message(page)


def test_a_session_is_opened_and_its_document_fetched_while_the_scripts_are_on_their_way(server, page):
    held, sockets, received, sent = [], [], [], []

    def listen(socket):
        sockets.append(socket)
        socket.on("framereceived", lambda frame: received.append(str(frame)))
        socket.on("framesent", lambda frame: sent.append(str(frame)))

    page.on("websocket", listen)
    page.route("**/bokeh.min.js*", lambda route: held.append(route))
    page.goto(server, wait_until="commit")
    wait_until(
        lambda: page.evaluate("1") and any(frame.startswith('{"doc"') for frame in received), what="the page's document"
    )
    assert page.evaluate("window.Bokeh === undefined")
    held[0].continue_()
    page.locator("form.panel[data-update='1']").wait_for(state="attached")
    assert len(sockets) == 1  # Bokeh goes on with the connection that there is
    assert sum("PULL-DOC-REQ" in frame for frame in sent) == 1  # and with the document


def test_the_page_says_that_the_server_no_longer_knows_it(server, page):
    stale = "window.WebSocket = class extends WebSocket { constructor(url) { super(url, ['bokeh', 'stale']); } };"
    page.add_init_script(stale)
    page.goto(server)
    assert "waited too long" in message(page)
