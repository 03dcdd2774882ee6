"""What `make check` leaves out: tests that start a process, and those that take long by the list in ``tests/long.txt``.

The list is written by ``make long``, on a machine that does nothing else: the functions whose cases together, and what
they share with other tests, take longer than LONG. A new test is quick until then.
"""

import subprocess
import time
from collections import Counter
from pathlib import Path

import pytest

LIST = Path(__file__).with_name("long.txt")
LONG = 0.25  # seconds, set-up included
_seconds = Counter()  # of each function, by its address without the case
_before = Counter()  # of what stood already of its fixtures
_fixtures = {}  # seconds of each fixture of more than one test, by the place where it is known and its name


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


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef):
    begun = time.perf_counter()
    try:
        return (yield)
    finally:
        if fixturedef.scope != "function":
            _fixtures[fixturedef.baseid, fixturedef.argname] = time.perf_counter() - begun


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Tell what earlier tests have set up for this one, too: left alone it would."""
    names = set(item.fixturenames)
    stood = [each for (place, name), each in _fixtures.items() if name in names and item.nodeid.startswith(place)]
    item.user_properties.append(("seconds before", sum(stood)))


def pytest_runtest_logreport(report):
    function = _function(report.nodeid)
    _seconds[function] += report.duration
    _before[function] = max(_before[function], dict(report.user_properties).get("seconds before", 0.0))


def pytest_sessionfinish(session):
    """Write the list, in the process that has all reports; what did not run stays as it was."""
    if session.config.getoption("--write-long") and not hasattr(session.config, "workerinput"):
        long = {name for name, seconds in _seconds.items() if seconds + _before[name] > LONG}
        kept = {name for name in LIST.read_text().split() if name not in _seconds}
        LIST.write_text("".join(f"{name}\n" for name in sorted(long | kept)))


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
