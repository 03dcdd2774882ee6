"""What `make check` leaves out: tests that start a process, and those that take long by the list in ``tests/long.txt``.

The list is written by ``make long``, on a machine that does nothing else: the functions whose cases together take
longer than LONG. A new test is quick until then.
"""

import subprocess
from collections import Counter
from pathlib import Path

import pytest

LIST = Path(__file__).with_name("long.txt")
LONG = 0.25  # seconds, set-up included
_seconds = Counter()  # of each function, by its address without the case


def pytest_addoption(parser):
    parser.addoption("--quick", action="store_true", help="leave out tests that take long or start a process")
    parser.addoption("--write-long", action="store_true", help=f"list the tests that take longer than {LONG} s")


def _function(nodeid):
    return nodeid.partition("[")[0]


def pytest_collection_modifyitems(config, items):
    """With ``--quick`` leave out the tests that are listed."""
    if config.getoption("--quick"):
        long = set(LIST.read_text().split())
        config.hook.pytest_deselected(items=[item for item in items if _function(item.nodeid) in long])
        items[:] = [item for item in items if _function(item.nodeid) not in long]


def pytest_runtest_logreport(report):
    _seconds[_function(report.nodeid)] += report.duration


def pytest_sessionfinish(session):
    """Write the list, in the process that has all reports."""
    if session.config.getoption("--write-long") and not hasattr(session.config, "workerinput"):
        long = sorted(name for name, seconds in _seconds.items() if seconds > LONG)
        LIST.write_text("".join(f"{name}\n" for name in long))


@pytest.fixture(scope="session", autouse=True)
def _processes(request):
    """With ``--quick`` a test ends, as skipped, where it would start a process."""
    if not request.config.getoption("--quick"):
        yield
        return

    def skip(*_, **__):
        pytest.skip("starts a process: run by `make test`")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subprocess.Popen, "__init__", skip)
        yield
