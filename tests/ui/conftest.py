"""A server in a process of its own, a browser, and pages that complain about anything unexpected."""

import json
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from tests.ui.explorer import Explorer, is_setting
from tests.waiting import PATIENCE
from tools.browser import find

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--process-per-site",  # a process for each page would parse and compile the scripts anew
    "--disable-background-networking",
    "--font-render-hinting=none",
    "--disable-font-subpixel-positioning",
    "--force-color-profile=srgb",
    "--force-device-scale-factor=1",
    "--hide-scrollbars",
    # A part of a tile that is redrawn has other edges than the whole: pictures must not depend on the history.
    "--disable-partial-raster",
    "--disable-lcd-text",
]


LOOSE = pytest.StashKey[list[str]]()  # pictures that were compared loosely
AS_MANY = {"test_walk": 8, "test_symbols": 5, "test_first_minute": 3, "test_settings": 2, "test_documentation": 2}


def pytest_terminal_summary(terminalreporter, config):
    if loose := config.stash.get(LOOSE, []):
        terminalreporter.section("snapshots that were compared loosely")
        terminalreporter.write_line("Another browser, other letters or another arithmetic than in drawn-by.json:")
        terminalreporter.write_line(", ".join(loose))


def pytest_collection_modifyitems(items):
    ours = [item for item in items if Path(__file__).parent in item.path.parents]
    for item in ours:
        item.add_marker(pytest.mark.ui)
    # They come last, file by file: those that take long come first, lest one process wait for the other at the end.
    lengths = Counter(item.path for item in ours for _ in range(AS_MANY.get(item.path.stem, 1)))
    items[:] = [item for item in items if item.path not in lengths] + sorted(ours, key=lambda item: -lengths[item.path])


@pytest.fixture(scope="session")
def server(plain_server):
    """Address of a running explorer."""
    return plain_server.url


@pytest.fixture(scope="session")
def playwright():
    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="session")
def browser(playwright):
    """A Chromium that keeps nothing."""
    chromium = playwright.chromium.launch(executable_path=find(), args=ARGUMENTS)
    yield chromium
    chromium.close()


# Every page keeps its sockets and what it has sent, for `Explorer.count_messages` and `Explorer.count_sent`.
SOCKETS = """
  window.sockets = [];
  window.sent = [];
  const Plain = WebSocket;
  window.WebSocket = class extends Plain {
    constructor(...all) { super(...all); window.sockets.push(this); }
    send(data) { window.sent.push(data); super.send(data); }
  };
"""


class Window:
    """A browser of a person, the size that its pages have, and whether they are opened light or dark.

    It keeps on disk what it has fetched and compiled, as that of a person does, so that a page opens sooner.
    """

    def __init__(self, context, viewport, scheme):
        self.context = context
        self.viewport = viewport
        self.scheme = scheme

    def new_page(self):
        page = self.context.new_page()
        page.set_viewport_size(self.viewport)
        page.emulate_media(color_scheme=self.scheme, reduced_motion="reduce")
        return page


@pytest.fixture(scope="session")
def windows(playwright, tmp_path_factory):
    """Windows by their size and options; those of one person (``whose``) with the same options are one browser."""
    contexts = {}

    def window(width=1440, height=900, whose="", scheme="light", **options):
        key = json.dumps([whose, options], sort_keys=True)
        if key not in contexts:
            contexts[key] = playwright.chromium.launch_persistent_context(
                tmp_path_factory.mktemp("browser"),
                executable_path=find(),
                args=ARGUMENTS,
                reduced_motion="reduce",
                locale="en-GB",
                timezone_id="UTC",
                device_scale_factor=1,
                viewport={"width": width, "height": height},
                **options,
            )
            contexts[key].set_default_timeout(1000 * PATIENCE)
            contexts[key].add_init_script(SOCKETS)
        return Window(contexts[key], {"width": width, "height": height}, scheme)

    yield window
    for context in contexts.values():
        context.close()


@contextmanager
def visits(windows, server):
    """Opens the explorer in new sessions; at the end, the browser must not have complained."""
    opened = []

    def open_page(query="", *size, **options):
        explorer = Explorer(windows(*size, **options).new_page(), server)
        opened.append(explorer)
        return explorer.open(query)

    yield open_page
    complaints = [complaint for explorer in opened for complaint in explorer.complaints]
    for explorer in opened:
        explorer.page.close()
    assert complaints == []


@pytest.fixture
def visit(windows, server):
    """Open the explorer in a new session, which ends with the test."""
    with visits(windows, server) as open_page:
        yield open_page


class Kept:
    """One page for each size and kind of window, for all tests of a file that care not what others have set.

    A short test spends most of its time, some four seconds of processor, on opening its page.
    """

    def __init__(self, open_page, session):
        self._open, self._session = open_page, session
        self._pages = {}  # by window: the page, what was asked for, and how many tests had failed

    def __call__(self, query="", width=1440, height=900, anew=False, **options):
        """The page that was opened with ``query``, as the test before has left it or, ``anew``, as it was opened."""
        window = str(options) + ("" if is_setting(query) else query)
        explorer, shown, failed = self._pages.get(window, (None, "", 0))
        known = explorer is not None and failed == self._session.testsfailed
        if known and ((shown == query and not anew) or explorer.again(query)):
            explorer.resized(width, height)
        else:
            if explorer is not None:
                explorer.page.close()
            explorer = self._open(query, width, height, **options)
        self._pages[window] = explorer, query, self._session.testsfailed
        return explorer

    def anew(self, query="", *size, **options):
        """The page that tests share, as if it had just been opened with a link to a setting."""
        return self(query, *size, anew=True, **options)


@pytest.fixture(scope="module")
def kept(windows, server, request):
    """As `visit`, but a page that tests of a file share (`Kept`)."""
    with visits(windows, server) as open_page:
        yield Kept(open_page, request.session)
