"""Options and fixtures that all tests share."""

import gc
import os
import subprocess

import hypothesis
import pytest

# The same examples in every run, so that what passed passes again; VIBROSCOPE_FUZZ=1 looks for new ones.
# No example has a deadline: a busy machine is no fault of the code.
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
if not os.environ.get("VIBROSCOPE_FUZZ"):
    hypothesis.settings.load_profile("repeatable")


def pytest_addoption(parser):
    parser.addoption(
        "--renew-snapshots",
        action="store_true",
        help="write what the page shows now as what it should show (look at the difference before you commit it)",
    )
    parser.addoption("--in-process", action="store_true", help="skip each test that starts a process")


def pytest_collection_finish():
    """Leave what is imported and collected out of collections of garbage, which visit millions of objects otherwise."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _processes(request):
    """With ``--in-process`` a test ends, as skipped, where it would start a process."""
    if not request.config.getoption("--in-process"):
        yield
        return

    def skip(*_, **__):
        pytest.skip("starts a process: run by `make test`")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subprocess.Popen, "__init__", skip)
        yield
