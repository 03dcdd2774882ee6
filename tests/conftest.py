"""Options and fixtures that all tests share."""

import gc
import os
import re

import hypothesis
import pytest

from tests import share
from tests.served import ROOT, served

pytest_plugins = ["tests.quick"]


def pytest_addoption(parser):
    parser.addoption(
        "--renew-snapshots",
        action="store_true",
        help="write what the page shows now as what it should show (look at the difference before you commit it)",
    )
    parser.addoption(
        "--all-examples",
        action="store_true",
        help="try all of many like examples, not one in seven",
    )


def pytest_configure(config):
    """Settle how many examples are tried, before tests are imported.

    They are the same in every run, so that what passed passes again; VIBROSCOPE_FUZZ=1 looks for new ones. No example
    has a deadline: a busy machine is no fault of the code.
    """
    gc.disable()  # a collection of garbage visits millions of objects, and imports leave hardly any garbage
    if config.getoption("--all-examples"):
        share.divisor = 1
    fixed = not os.environ.get("VIBROSCOPE_FUZZ")
    hypothesis.settings.register_profile("vibroscope", derandomize=fixed, deadline=None, max_examples=share.share(100))
    hypothesis.settings.load_profile("vibroscope")


def pytest_collection_finish():
    """Leave out of collections of garbage what is imported and collected.

    Tests leave little in comparison, so few collections are enough.
    """
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


@pytest.fixture(scope="session")
def plain_server(tmp_path_factory):
    """A server as it is by default: to start one takes seconds of processor."""
    with served(tmp_path_factory.mktemp("server") / "log.txt") as server:
        yield server
    log = server.log.read_text()
    # A traceback without a line of ours is the library's way of noticing that a page was closed.
    ours = re.search(rf'File "{re.escape(str(ROOT))}/(app|engine)/|not computed', log)
    assert ours is None, log[max(0, ours.start() - 3000) : ours.end() + 3000]
