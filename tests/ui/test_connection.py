"""A page that loses its connection, and one whose session the server ends."""

from tests.ui.explorer import Explorer
from tests.waiting import wait_until

SOCKETS = """window.sockets = [];
window.WebSocket = class extends WebSocket {
  constructor(...given) { super(...given); window.sockets.push(this); }
}"""


def test_a_lost_connection_comes_back_to_its_view_and_a_session_that_the_server_ends_says_why(windows, server):
    page = windows().new_page()
    page.add_init_script(SOCKETS)
    explorer = Explorer(page, server).open()
    explorer.moved(lambda: explorer.type("K", "9000"))
    now = page.evaluate("performance.now()")
    explorer.until(f"performance.now() > {now + 5000}")  # earlier, a page does not reload: it might do so for ever
    failed = []
    page.on("requestfailed", lambda request: failed.append(request))
    page.route("**/*", lambda route: route.abort())  # a browser that is offline may hold back the end of a socket, too
    page.evaluate("sockets.at(-1).close()")
    assert "The connection to the server is lost" in page.locator(".lost [role=alert]").text_content()
    wait_until(lambda: page.evaluate("true") and len(failed) > 1, what="attempts to reload")
    assert explorer.typed("K").input_value() == "9000"  # what is shown stays
    with page.expect_navigation():
        page.unroute("**/*")
    explorer.settle(update=1)
    assert explorer.typed("K").input_value() == "9000"
    assert page.locator(".lost").count() == 0
    explorer.moved(lambda: explorer.type("K", "9001"))
    page.evaluate("sockets.at(-1).send('nonsense'); sockets.at(-1).send('nonsense'); sockets.at(-1).send('nonsense')")
    page.locator(".lost").wait_for()
    assert "The server has ended this session: " in page.locator(".lost [role=alert]").text_content()
    with page.expect_navigation():
        page.get_by_role("link", name="Load the page again").click()
    explorer.settle(update=1)
    page.close()
